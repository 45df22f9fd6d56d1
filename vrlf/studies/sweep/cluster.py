"""Workers: processes on this machine, or those that a Dask scheduler has.

Workers here are processes of their own with one thread each (``keepers``), beside a scheduler in
this process; all talk over the loopback alone, and there is no dashboard.
"""

from __future__ import annotations

import asyncio
import contextlib
import importlib.util
import logging
import os
from collections.abc import AsyncIterator, Iterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Final

from vrlf.errors import InputError, VrlfError
from vrlf.studies.sweep.bench import worker_plugin
from vrlf.studies.sweep.jobs import Kit
from vrlf.studies.sweep.keepers import Keepers

LIBRARIES: Final = ("dask", "distributed", "pyarrow")
INSTALL: Final = "pip install 'vrlf[sweep]'"
# A task that has seen this many workers die, and one more, comes back to be asked for again.
ALLOWED_FAILURES: Final = 2
_CONNECT_S: Final = 10.0
_CLOSE_S: Final = 10.0
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


@dataclass(frozen=True)
class Cluster:
    """A client and, where the workers are this machine's, their keepers."""

    client: Any
    keepers: Keepers | None

    @property
    def workers(self) -> int:
        """How many workers the scheduler has, as it last said."""
        told = self.client.scheduler_info()
        return int(told.get("n_workers", len(told.get("workers", {}))))

    @property
    def last_words(self) -> str:
        """What a worker of this machine said last on its standard error."""
        return "" if self.keepers is None else self.keepers.last_words


@asynccontextmanager
async def cluster_of(
    kit: Kit, *, run: str, workers: int, scheduler: str | None
) -> AsyncIterator[Cluster]:
    """Workers that know the sweep, and a client to them; what was started is ended.

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
        The workers there are none for a sweep.
    """
    settings = {
        "distributed.scheduler.allowed-failures": ALLOWED_FAILURES,
        "distributed.comm.timeouts.connect": f"{_CONNECT_S}s",
        "distributed.scheduler.http.routes": [],
    }
    async with AsyncExitStack() as owned:
        owned.enter_context(configured(settings))
        owned.enter_context(quiet())
        keepers = None
        if scheduler is None:
            here = await _scheduler_here()
            keepers = Keepers(here.address, workers)
            owned.push_async_callback(_all_home, here, keepers)
            scheduler = here.address
        client = await _connected(scheduler)
        owned.push_async_callback(_closed, client)
        await _taught(client, kit, run)
        if keepers is None:  # workers that go on living give their contexts back
            owned.push_async_callback(_forgotten, client, run)
        yield Cluster(client, keepers)


def require_scheduler(address: str) -> None:
    """Make sure that a scheduler answers, before anything is made for it.

    Raises
    ------
    InputError
    """

    async def ask() -> None:
        await _closed(await _connected(address))

    with configured({"distributed.comm.timeouts.connect": f"{_CONNECT_S}s"}), quiet():
        asyncio.run(ask())


async def _scheduler_here() -> Any:
    """A scheduler in this process, on the loopback, without a dashboard."""
    distributed: Any = import_module("distributed")
    return await distributed.Scheduler(
        host="127.0.0.1", port=0, dashboard=False, dashboard_address="127.0.0.1:0"
    )


async def _all_home(scheduler: Any, keepers: Keepers) -> None:
    """Send the workers home and see them off."""
    keepers.ending()
    with contextlib.suppress(Exception):
        await scheduler.close()
    await keepers.end()


async def _connected(where: str) -> Any:
    distributed: Any = import_module("distributed")
    options = {"asynchronous": True, "timeout": _CONNECT_S, "set_as_default": False}
    try:
        # A client that is given no address at all leaves loose ends that warn.
        import_module("distributed.comm").get_address_host_port(where)
        return await distributed.Client(where, **options)
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(
            f"--scheduler: found no answer from {where} ({reason[:200]}), wanted the address of a "
            "Dask scheduler that runs, such as tcp://host:8786"
        ) from None


async def _taught(client: Any, kit: Kit, run: str) -> None:
    """Have every worker, also each that comes later, know the sweep."""
    try:
        await client.register_plugin(worker_plugin(kit), name=run)
    except Exception as error:  # whatever a worker met while it read the plugin
        raise unlike(error) from None


def unlike(error: Exception) -> WorkersLostError:
    """What to say where a worker cannot even begin with a job."""
    reason = " ".join(f"{type(error).__name__}: {error}".split())
    return WorkersLostError(
        f"workers: found {reason[:300]}, wanted the same vrlf and Python there as here"
    )


async def _closed(client: Any) -> None:
    with contextlib.suppress(Exception):
        await client.close(timeout=_CLOSE_S)


async def _forgotten(client: Any, run: str) -> None:
    with contextlib.suppress(Exception):
        async with asyncio.timeout(_CLOSE_S):
            await client.unregister_worker_plugin(run)


@contextlib.contextmanager
def configured(settings: Mapping[str, Any]) -> Iterator[None]:
    """Dask's settings, for a while."""
    import_module("distributed")  # its defaults come first: they would go with ours otherwise
    dask: Any = import_module("dask")
    with dask.config.set(dict(settings)):
        yield


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Keep what Dask logs off standard error: what matters of it, a sweep says in its own words."""
    import_module("distributed")  # which gives its loggers levels of their own
    names = [n for n in logging.root.manager.loggerDict if n.partition(".")[0] in _LOGGERS]
    loggers = [logging.getLogger(name) for name in names]
    levels = [each.level for each in loggers]
    for each in loggers:
        each.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for each, level in zip(loggers, levels, strict=True):
            each.setLevel(level)
