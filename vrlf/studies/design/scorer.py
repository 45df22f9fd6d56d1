"""Candidates judged side by side on all cores; what that costs is counted."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, Final, Self

import numpy as np
from scipy.optimize import minimize

from vrlf.model import Rig
from vrlf.studies.design.score import Judging, score_db
from vrlf.studies.design.space import Point, Space, clipped

# What the limits do not allow is worse than all that they do.
NEVER_DB: Final = -100.0
# First steps of a polish, as shares of the axes.
_FIRST_STEP: Final = 0.03
_SMALLEST_STEP: Final = 2e-4


class Scorer:
    """Owns worker processes; with one worker all is done in this process."""

    def __init__(self, workers: int) -> None:
        self.cpu_s, self.count = 0.0, 0
        self._pool: ProcessPoolExecutor | None = None
        if workers > 1:
            # A process that holds a GPU context must not be forked.
            context = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(workers, mp_context=context)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)

    def scores_db(self, rigs: Sequence[Rig | None], judging: Judging) -> list[float]:
        """In their order; ``NEVER_DB`` for what is none."""
        given = [rig for rig in rigs if rig is not None]
        found = iter(self._mapped(_timed_score, [(rig, judging) for rig in given]))
        self.count += len(given)
        return [NEVER_DB if rig is None else next(found) for rig in rigs]

    def polished(
        self, space: Space, starts: Sequence[Point], judging: Judging, steps: int
    ) -> list[tuple[Point, float]]:
        """The best point near each start, and its score: Nelder & Mead's simplex."""
        jobs = [(space, start, judging, steps) for start in starts]
        found = self._mapped(_timed_polish, jobs)
        self.count += sum(count for _, _, count in found)
        return [(point, db) for point, db, _ in found]

    def _mapped(self, work: Callable[[Any], tuple[Any, float]], jobs: list[Any]) -> list[Any]:
        done = map(work, jobs) if self._pool is None else self._pool.map(work, jobs)
        results = []
        for result, cpu_s in done:
            results.append(result)
            self.cpu_s += cpu_s
        return results


def _timed_score(job: tuple[Rig, Judging]) -> tuple[float, float]:
    started = time.process_time()
    return score_db(*job), time.process_time() - started


def _timed_polish(job: tuple[Space, Point, Judging, int]) -> tuple[Any, float]:
    started = time.process_time()
    return _polish(*job), time.process_time() - started


def _polish(space: Space, start: Point, judging: Judging, steps: int) -> tuple[Point, float, int]:
    """Along the axes that are ranges; a choice stays as it is."""
    free = [k for k, axis in enumerate(space.axes) if not axis.choices and not axis.is_fixed]
    best: list[Any] = [start, NEVER_DB, 0]

    def error(places: Any) -> float:
        moved = list(start)
        for axis, place in zip(free, places, strict=True):
            moved[axis] = float(place)
        point = clipped(moved)
        rig = space.rig_at(point)
        db = NEVER_DB if rig is None else score_db(rig, judging)
        best[2] += 1
        if db > best[1]:
            best[:2] = point, db
        return -db

    at = np.array([start[axis] for axis in free])
    steps_at = np.where(at > 0.5, -_FIRST_STEP, _FIRST_STEP)
    simplex = np.vstack([at, at + np.diag(steps_at)])
    options: Any = {
        "initial_simplex": simplex,
        "maxfev": steps,
        "xatol": _SMALLEST_STEP,
        "fatol": 0.01,
    }
    minimize(error, at, method="Nelder-Mead", options=options)
    return best[0], best[1], best[2]
