"""What a worker keeps: one thread with one GL context, whatever threads Dask runs jobs on.

A context belongs to the thread that made it. So the bench has a thread of its own; jobs wait
for it, and it gives the context back when the worker leaves or the sweep is over.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from typing import Any

from vrlf import __version__
from vrlf.errors import DeviceError, VrlfError
from vrlf.renderer import GpuRenderer
from vrlf.studies.sweep.jobs import (
    Kit,
    Outcome,
    WorkerUnfitError,
    outcome_of,
    require_unchanged,
)
from vrlf.studies.sweep.plan import Job


class Bench:
    """Does jobs one after another, on its own thread. Release it."""

    def __init__(self, kit: Kit) -> None:
        self._kit = kit
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="vrlf-gl")
        self._renderer: GpuRenderer | None = None
        self._known: set[str] = set()

    @property
    def contexts(self) -> int:
        """How many GL contexts it holds: one at most."""
        return int(self._renderer is not None)

    def do(self, job: Job) -> Outcome:
        """A job's outcome.

        Raises
        ------
        WorkerUnfitError
            If no job of the sweep can be done here.
        """
        return self._thread.submit(self._do, job).result()

    def release(self) -> None:
        """Give the context back, on its own thread, and end that."""
        self._thread.submit(self._let_go).result()
        self._thread.shutdown()

    def _do(self, job: Job) -> Outcome:
        if self._kit.version != __version__:
            raise WorkerUnfitError(
                f"worker: found vrlf {__version__}, wanted {self._kit.version}, which the sweep "
                "began with"
            )
        if job.source not in self._known:
            try:
                require_unchanged(self._kit.sources[job.source])
            except VrlfError as error:
                raise WorkerUnfitError(f"worker: {error}") from None
            self._known.add(job.source)
        outcome = outcome_of(self._kit, job, self._gpu)
        if outcome.is_device_fault:
            self._let_go()  # a context that a fault may have hurt serves no further job
        return outcome

    def _gpu(self) -> GpuRenderer:
        if self._renderer is None:
            try:
                self._renderer = GpuRenderer()
            except DeviceError as error:
                raise WorkerUnfitError(f"worker: {error}") from None
        return self._renderer

    def _let_go(self) -> None:
        renderer, self._renderer = self._renderer, None
        if renderer is not None:
            renderer.release()


def worker_plugin(kit: Kit) -> Any:
    """What Dask gives to each worker, also to those that come later or again."""
    distributed: Any = import_module("distributed")

    class SweepPlugin(distributed.WorkerPlugin):  # type: ignore[misc]
        def setup(self, worker: Any) -> None:
            del worker
            self.bench = Bench(kit)

        def teardown(self, worker: Any) -> None:
            del worker
            self.bench.release()

    return SweepPlugin()


def do_job(run: str, job: Job) -> Outcome:
    """A job, by the bench that this worker has for a run."""
    distributed: Any = import_module("distributed")
    outcome: Outcome = distributed.get_worker().plugins[run].bench.do(job)
    return outcome
