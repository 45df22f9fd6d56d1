"""Jobs in a bounded window: a few a worker are on their way, however many there are.

A worker that dies costs the time of what it was at. Dask hands a job of a dead worker to another
one; after some deaths it calls the job to account, be it to blame or not, and it is asked for
again here. One that has seen too many is noted as failed.

The scheduler forgets a job with its row, so that its memory does not grow with their number; but
Dask keeps the names of the last 100,000 (``key_split``'s cache), some 70 MB of them in all.
"""

from __future__ import annotations

import asyncio
import secrets
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from vrlf.errors import VrlfError
from vrlf.studies.sweep.bench import do_job
from vrlf.studies.sweep.cluster import (
    ALLOWED_FAILURES,
    Cluster,
    WorkersLostError,
    cluster_of,
    unlike,
)
from vrlf.studies.sweep.jobs import Kit, Outcome
from vrlf.studies.sweep.plan import Job, Plan
from vrlf.studies.sweep.store import Store

# Jobs on their way for each worker: one at work, one at hand, one on the road.
A_WORKER: Final = 3
# How often a job is asked for, each time until some workers have died at it.
ASKED: Final = 2
DEATHS: Final = ASKED * (ALLOWED_FAILURES + 1)
# So many jobs one after another that killed their workers, and none done: nothing can be.
MOST_KILLERS: Final = 3
NO_WORKER_HERE_S: Final = 60.0
NO_WORKER_THERE_S: Final = 600.0
_LOOK_S: Final = 1.0


@dataclass
class Progress:
    """How far a sweep is.

    Attributes
    ----------
    total, done, failed : int
    workers : int
    """

    total: int
    done: int
    failed: int
    workers: int = 0


Told = Callable[[Progress], None]


class JobKilledError(Exception):
    """A job's workers died, time and again."""


def run_sweep(
    plan: Plan,
    kit: Kit,
    store: Store,
    *,
    workers: int,
    scheduler: str | None = None,
    told: Told = lambda _: None,
) -> None:
    """Do the jobs that have no row yet.

    Parameters
    ----------
    workers : int
        How many to start on this machine, unless there is a scheduler.
    scheduler : str or None
        The address of a Dask scheduler.
    told : callable
        Hears of the progress, about once a second and at the end.

    Raises
    ------
    WorkersLostError
        Nobody is left to do the jobs.
    VrlfError
        A worker can do none of them, or the disk is full. What is done is kept.
    """
    if next(store.to_do(), None) is None:
        return
    asyncio.run(_Run(plan, store, told).all(kit, workers, scheduler))


class _Run:
    """One run: the window, and who is there."""

    def __init__(self, plan: Plan, store: Store, told: Told) -> None:
        self._plan, self._store, self._told = plan, store, told
        self._name = f"vrlf_sweep_{secrets.token_hex(4)}"
        self._killers = 0
        self._seen_s = self._said_s = time.monotonic()

    async def all(self, kit: Kit, workers: int, scheduler: str | None) -> None:
        """Every job without a row."""
        patience_s = NO_WORKER_HERE_S if scheduler is None else NO_WORKER_THERE_S
        async with cluster_of(kit, run=self._name, workers=workers, scheduler=scheduler) as cluster:
            self._seen_s = time.monotonic()
            await self._window(cluster, patience_s)
            self._say(cluster.workers)

    async def _window(self, cluster: Cluster, patience_s: float) -> None:
        indices = self._store.to_do()
        under_way: set[asyncio.Task[None]] = set()
        try:
            while True:
                present = cluster.workers
                self._look_after(cluster, present, patience_s)
                while len(under_way) < max(A_WORKER * present, 1):
                    index = next(indices, None)
                    if index is None:
                        break
                    job = self._plan.job(index)
                    under_way.add(asyncio.create_task(self._one(cluster.client, job)))
                if not under_way:
                    return
                ended, under_way = await asyncio.wait(
                    under_way, timeout=_LOOK_S, return_when=asyncio.FIRST_COMPLETED
                )
                # All are asked, so that none is left whose fault nobody has heard.
                faults = [fault for each in ended if (fault := each.exception()) is not None]
                if faults:
                    raise faults[0]
        finally:
            for each in under_way:
                each.cancel()
            await asyncio.gather(*under_way, return_exceptions=True)

    async def _one(self, client: Any, job: Job) -> None:
        try:
            outcome = await self._outcome(client, job)
        except JobKilledError:
            self._killers += 1
            if self._killers >= MOST_KILLERS:
                raise WorkersLostError(
                    f"workers: found that {self._killers} jobs one after another ended them, "
                    f"{DEATHS} times each, and that none was done; wanted workers that live; "
                    "out of memory? 'vrlf doctor' tells more"
                ) from None
            outcome = Outcome(reason=f"found that its workers died {DEATHS} times, wanted its row")
        else:
            self._killers = 0
        if outcome.row is not None:
            self._store.add(outcome.row)
        else:
            self._store.fail(job, outcome.reason or "found no row")

    async def _outcome(self, client: Any, job: Job) -> Outcome:
        from distributed import KilledWorker

        for attempt in range(ASKED):
            # Names of their own for each run and attempt: Dask hands out an old result otherwise.
            key = (self._name, job.index, attempt)
            future = client.submit(do_job, self._name, job, key=key, pure=False)
            try:
                return await _result(future)
            except KilledWorker:
                continue
            finally:
                future.release()
        raise JobKilledError

    def _look_after(self, cluster: Cluster, present: int, patience_s: float) -> None:
        """Say how far it is, and stop where nobody is left."""
        now = time.monotonic()
        if present:
            self._seen_s = now
        elif now - self._seen_s > patience_s:
            raise WorkersLostError(
                f"workers: found none for {patience_s:.0f} s, wanted at least one"
                + (f"; one said: {cluster.last_words[:300]}" if cluster.last_words else "")
            )
        if cluster.client.status not in ("running", "connecting"):
            raise _lost()
        if now - self._said_s >= _LOOK_S:
            self._say(present)

    def _say(self, present: int) -> None:
        self._said_s = time.monotonic()
        self._told(Progress(self._plan.count, self._store.done, self._store.failed, present))


async def _result(future: Any) -> Outcome:
    """What a task gave, in words of ours where Dask could not do it."""
    from distributed import KilledWorker
    from distributed.client import FutureCancelledError

    try:
        outcome = await future
    except (KilledWorker, VrlfError):
        raise
    except FutureCancelledError:
        raise _lost() from None
    except Exception as error:
        raise unlike(error) from None
    if not isinstance(outcome, Outcome):
        raise WorkersLostError("workers: found no row as a job's answer, wanted one")
    return outcome


def _lost() -> WorkersLostError:
    return WorkersLostError("scheduler: found the line to it cut, wanted it to live to the end")
