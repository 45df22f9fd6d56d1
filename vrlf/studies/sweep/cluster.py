"""Workers: processes on this machine, or those that a Dask scheduler has.

Workers here are spawned, one thread each, talk over the loopback alone, open no dashboard, and
are made anew by their nannies when they die.
"""

from __future__ import annotations

import asyncio
import contextlib
import importlib.util
import logging
import os
from collections.abc import AsyncIterator, Iterator
from contextlib import AsyncExitStack, asynccontextmanager
from importlib import import_module
from typing import Any, Final

from vrlf.errors import InputError, VrlfError
from vrlf.studies.sweep.bench import worker_plugin
from vrlf.studies.sweep.jobs import Kit

LIBRARIES: Final = ("dask", "distributed", "pyarrow")
INSTALL: Final = "pip install 'vrlf[sweep]'"
# A task that has seen this many workers die, and one more, comes back to be asked for again.
ALLOWED_FAILURES: Final = 2
_CONNECT_S: Final = 10.0
_START_S: Final = 120.0
_CLOSE_S: Final = 10.0
# llvmpipe would otherwise use all cores for each worker.
_WORKER_ENVIRONMENT: Final = {"LP_NUM_THREADS": "1", "DASK_LOGGING__DISTRIBUTED": "critical"}
_LOGGERS: Final = ("distributed", "tornado", "asyncio", "bokeh")


class WorkersLostError(VrlfError):
    """Nobody is left to do the jobs."""


def require_libraries() -> None:
    """Make sure that the extra is installed.

    Raises
    ------
    VrlfError
        One line with the command that installs it.
    """
    missing = [name for name in LIBRARIES if importlib.util.find_spec(name) is None]
    if missing:
        raise VrlfError(
            f"sweep: found no {' and no '.join(missing)}, wanted it to share out the jobs: "
            f"{INSTALL}"
        )


def worker_count() -> int:
    """The cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on this system
        return os.cpu_count() or 1


@asynccontextmanager
async def client_of(
    kit: Kit, *, run: str, workers: int, scheduler: str | None
) -> AsyncIterator[Any]:
    """A client whose workers know the sweep; what was started is ended.

    Parameters
    ----------
    run : str
        A name that no other sweep has at the same scheduler.
    workers : int
        How many to start here, unless there is a scheduler.
    scheduler : str or None
        The address of one.

    Raises
    ------
    InputError
        The scheduler does not answer.
    WorkersLostError
        No worker can be started.
    """
    dask: Any = import_module("dask")
    settings = {
        "distributed.scheduler.allowed-failures": ALLOWED_FAILURES,
        "distributed.comm.timeouts.connect": f"{_CONNECT_S}s",
        # Here and there a worker would rest at 80 % of its share of the memory, for ever.
        "distributed.worker.memory.pause": False,
        "distributed.nanny.pre-spawn-environ": {
            **dask.config.get("distributed.nanny.pre-spawn-environ", {}), **_WORKER_ENVIRONMENT,
        },
    }  # fmt: skip
    async with AsyncExitStack() as owned:
        owned.enter_context(dask.config.set(settings))
        owned.enter_context(quiet())
        if scheduler is None:
            where: Any = await owned.enter_async_context(_here(workers))
        else:
            where = scheduler
        client = await _connected(where)
        owned.push_async_callback(_closed, client)
        await client.register_plugin(worker_plugin(kit), name=run)
        if scheduler is not None:  # workers that go on living give their contexts back
            owned.push_async_callback(_forgotten, client, run)
        yield client


@asynccontextmanager
async def _here(workers: int) -> AsyncIterator[Any]:
    """A cluster on this machine."""
    distributed: Any = import_module("distributed")
    cluster = distributed.LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        processes=True,
        host="127.0.0.1",
        dashboard_address=None,
        memory_limit=0,
        silence_logs=logging.CRITICAL,
        asynchronous=True,
    )
    try:
        async with asyncio.timeout(_START_S):
            await cluster
    except Exception as error:
        with contextlib.suppress(Exception):
            await cluster.close(timeout=_CLOSE_S)
        reason = " ".join(f"{type(error).__name__} {error}".split())
        raise WorkersLostError(
            f"workers: found {reason}, wanted {workers} of them to start"
        ) from None
    try:
        yield cluster
    finally:
        with contextlib.suppress(Exception):
            await cluster.close(timeout=_CLOSE_S)


async def _connected(where: Any) -> Any:
    distributed: Any = import_module("distributed")
    options = {"asynchronous": True, "timeout": _CONNECT_S, "set_as_default": False}
    try:
        return await distributed.Client(where, **options)
    except Exception as error:
        if not isinstance(where, str):
            raise
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(
            f"--scheduler: found no answer from {where} ({reason[:200]}), wanted the address of a "
            "Dask scheduler that runs, such as tcp://host:8786"
        ) from None


async def _closed(client: Any) -> None:
    with contextlib.suppress(Exception):
        await client.close(timeout=_CLOSE_S)


async def _forgotten(client: Any, run: str) -> None:
    with contextlib.suppress(Exception):
        async with asyncio.timeout(_CLOSE_S):
            await client.unregister_worker_plugin(run)


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Keep what Dask logs off standard error: what matters of it, a sweep says in its own words."""
    loggers = [logging.getLogger(name) for name in _LOGGERS]
    levels = [each.level for each in loggers]
    for each in loggers:
        each.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for each, level in zip(loggers, levels, strict=True):
            each.setLevel(level)
