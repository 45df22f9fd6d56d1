"""The search: a coarse grid about the matched focus, Optuna, all turns, then a simplex.

How good a turn of the lattice is changes within a degree or two, and so ruggedly that an
optimiser of smooth functions misses the best: the best few arrays are tried at every degree.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Final

import numpy as np

from vrlf.studies.design.score import Judging
from vrlf.studies.design.scorer import NEVER_DB, Scorer
from vrlf.studies.design.space import Point, Space

# Proposed at a time, whatever the number of workers, so that this changes no result.
_BATCH: Final = 8
# Off the matched focus and shares of the turns that the grid tries.
_OFF_FOCUS: Final = (0.0, -0.15)
_TURNS: Final = (0.22, 0.51)
_HOLES: Final = (0.15, 0.4, 0.75)
# How near two candidates are one: shares of the axes.
_SAME: Final = 0.02
_TURN_DEG: Final = 1.0


@dataclass(frozen=True)
class Effort:
    """How much is tried.

    Attributes
    ----------
    grid : int
        Pitches and gaps, each.
    trials : int
        Of Optuna.
    turned, polished : int
        How many of the best are turned to every degree, and polished.
    steps : int
        Of each polish.
    """

    grid: int = 7
    trials: int = 320
    turned: int = 4
    polished: int = 4
    steps: int = 60


@dataclass(frozen=True)
class Scored:
    """A point and what it came to on the patch."""

    point: Point
    db: float
    stage: str


@dataclass(frozen=True)
class Stage:
    """What a stage of the search took."""

    name: str
    candidates: int
    best_db: float
    wall_s: float
    cpu_s: float


class Search:
    """Keeps all that was scored."""

    def __init__(
        self, space: Space, scorer: Scorer, judging: Judging, say: Callable[[str], None]
    ) -> None:
        self.space, self.scored = space, list[Scored]()
        self.stages: list[Stage] = []
        self._scorer, self._judging, self._say = scorer, judging, say

    def run(self, effort: Effort, seed: int) -> None:
        """All stages."""
        self._stage("grid", lambda: self._grid(effort.grid))
        if effort.trials:
            self._stage("optuna", lambda: self._optuna(effort.trials, seed))
        if effort.turned:
            self._stage("turns", lambda: self._try(self._turns(effort.turned), "turns"))
        if effort.polished:
            self._stage("polish", lambda: self._polish(effort))

    def best(self, count: int) -> list[Scored]:
        """The best that differ."""
        return distinct(self.scored, count, _SAME)

    def _stage(self, name: str, work: Callable[[], None]) -> None:
        wall, cpu, before = time.perf_counter(), self._scorer.cpu_s, self._scorer.count
        work()
        found = max((each.db for each in self.scored), default=NEVER_DB)
        done = self._scorer.count - before
        seconds = time.perf_counter() - wall
        self.stages.append(Stage(name, done, found, seconds, self._scorer.cpu_s - cpu))
        self._say(f"{name}: {done} candidates in {seconds:.0f} s, the best {found:.2f} dB")

    def _try(self, points: Iterable[Point], stage: str) -> None:
        listed = list(points)
        rigs = [self.space.rig_at(point) for point in listed]
        found = self._scorer.scores_db(rigs, self._judging)
        self.scored += [Scored(p, db, stage) for p, db in zip(listed, found, strict=True)]

    def _grid(self, count: int) -> None:
        self._try(grid(self.space, count), "grid")
        own = self.space.place_of(self.space.rig.array)
        if own is not None:
            self._try([own], "given")

    def _optuna(self, trials: int, seed: int) -> None:
        """Tree-structured Parzen estimators (Bergstra et al. 2011) from the grid's best on."""
        import optuna

        optuna.logging.set_verbosity(optuna.logging.ERROR)
        free = [axis for axis in self.space.axes if not axis.is_fixed]
        if not free:
            return
        kinds: dict[str, Any] = {
            axis.name: optuna.distributions.CategoricalDistribution(range(axis.choices))
            if axis.choices
            else optuna.distributions.FloatDistribution(0.0, 1.0)
            for axis in free
        }
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that some of its options may change
            sampler = optuna.samplers.TPESampler(
                seed=seed, multivariate=True, n_startup_trials=0, constant_liar=True
            )
            study = optuna.create_study(direction="maximize", sampler=sampler)
            for each in sorted(self.scored, key=lambda s: -s.db)[:40]:
                params = self._parameters(each.point)
                study.add_trial(
                    optuna.trial.create_trial(params=params, distributions=kinds, value=each.db)
                )
            for _ in range(0, trials, _BATCH):
                asked = [study.ask(kinds) for _ in range(_BATCH)]
                self._try([self._point(trial.params) for trial in asked], "optuna")
                for trial, each in zip(asked, self.scored[-_BATCH:], strict=True):
                    study.tell(trial, each.db)

    def _parameters(self, point: Point) -> dict[str, Any]:
        pairs = zip(self.space.axes, point, strict=True)
        return {
            axis.name: int(axis.value(place)) if axis.choices else place
            for axis, place in pairs
            if not axis.is_fixed
        }

    def _point(self, parameters: dict[str, Any]) -> Point:
        return tuple(
            0.5
            if axis.is_fixed
            else axis.place(parameters[axis.name])
            if axis.choices
            else float(parameters[axis.name])
            for axis in self.space.axes
        )

    def _turns(self, count: int) -> list[Point]:
        """The best few, that differ in more than their turn, at every degree."""
        index = self.space.index_of("rotation_deg")
        assert index is not None
        axis = self.space.axes[index]
        if axis.is_fixed:
            return []
        span = int((axis.high - axis.low) / _TURN_DEG)
        places = [axis.place(axis.low + k * _TURN_DEG) for k in range(span + 1)]
        flat = [replace(each, point=_without(each.point, index)) for each in self.scored]
        best = distinct(flat, count, 2.0 * _SAME)
        return [(*p.point[:index], at, *p.point[index:]) for p in best for at in places]

    def _polish(self, effort: Effort) -> None:
        starts = [each.point for each in distinct(self.scored, effort.polished, 2.0 * _SAME)]
        found = self._scorer.polished(self.space, starts, self._judging, effort.steps)
        self.scored += [Scored(point, db, "polish") for point, db in found]


def _without(point: Point, index: int) -> Point:
    return (*point[:index], *point[index + 1 :])


def distinct(scored: Sequence[Scored], count: int, apart: float) -> list[Scored]:
    """The best so many of which no two are nearer than ``apart`` along every axis."""
    kept: list[Scored] = []
    for each in sorted(scored, key=lambda s: (-s.db, s.point)):
        if each.db <= NEVER_DB or len(kept) == count:
            break
        at = np.array(each.point)
        if all(np.abs(at - np.array(other.point)).max() > apart for other in kept):
            kept.append(each)
    return kept


def grid(space: Space, count: int) -> list[Point]:
    """Pitches and gaps evenly, each about the matched focus and at a few turns."""
    places = []
    for axis in space.axes:
        if axis.is_fixed:
            places.append([0.5])
        elif axis.choices:
            places.append([axis.place(k) for k in range(axis.choices)])
        elif axis.name == "off_focus":
            places.append([axis.place(off) for off in _OFF_FOCUS])
        elif axis.name == "rotation_deg":
            places.append(list(_TURNS))
        elif axis.name == "aperture_um":
            places.append(list(_HOLES))
        else:
            places.append([float(place) for place in np.linspace(0.0, 1.0, count)])
    return list(product(*places))
