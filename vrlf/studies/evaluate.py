"""Every source, rig and method: what each eye perceives, in all metrics, case by case.

A case is one source, rig and method. Its panel image is judged by what is perceived of it
through the rig; ``none`` is the bare target on a panel without an array. Letters and an edge
(see ``evaluate_charts``) are a case of their own for each rig and method, whatever the sources.
Cases that an earlier run has finished are taken from the folder (see ``evaluate_store``).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vrlf.errors import InputError, OutputError, OutputPathError, VrlfError
from vrlf.evaluation.measure import require_room
from vrlf.evaluation.metrics import METRICS
from vrlf.files import make_folder
from vrlf.images import write_encoded
from vrlf.model import Rig
from vrlf.optics.viewport import SIDES, Side, viewport
from vrlf.renderer import GpuRenderer, Image, check_rays
from vrlf.studies.evaluate_charts import CHART_METRICS, CHART_RAYS, chart_rig, read_charts
from vrlf.studies.evaluate_judge import judge, method_rig, shown_and_seen
from vrlf.studies.evaluate_store import (
    CaseFound,
    EyeFound,
    case_folder,
    key_of,
    load_case,
    picture_digest,
    store_case,
    target_folder,
)
from vrlf.studies.quality import JUDGING_RAYS

METHODS: Final = ("none", "forward", "optimal")
METRIC_NAMES: Final = (*METRICS, *CHART_METRICS)
# Stands for a source where letters and an edge are shown.
CHARTS: Final = "<letters and edge>"
# Targets kept between the first look at all of them and their cases.
_MOST_KEPT_BYTES: Final = 2**28
Pictures = Mapping[str, Callable[[Rig], Image]]


@dataclass(frozen=True)
class Question:
    """What is asked of every source and rig.

    Attributes
    ----------
    methods : sequence of str
        Of ``METHODS``.
    metrics : sequence of str
        Of ``METRIC_NAMES``.
    rays : int
        For each retinal pixel, of the judge.
    versions : mapping
        Of everything that the numbers depend on; with others a case is computed anew.
    """

    methods: Sequence[str]
    metrics: Sequence[str]
    rays: int = JUDGING_RAYS
    versions: Mapping[str, str] | None = None

    def check(self) -> None:
        """Refuse what nobody can answer.

        Raises
        ------
        InputError
            An unknown method or metric, or none, or a number of rays that means nothing.
        """
        for what, names, known in (
            ("method", self.methods, METHODS),
            ("metric", self.metrics, METRIC_NAMES),
        ):
            if not names:
                raise InputError(f"{what}: found none, wanted one or more of {', '.join(known)}")
            for name in names:
                if name not in known:
                    raise InputError(
                        f"{what}: found {name[:40]!r}, wanted one of {', '.join(known)}"
                    )
        check_rays(self.rays)


@dataclass(frozen=True)
class Failure:
    """A case that could not be computed."""

    source: str
    rig: str
    method: str
    reason: str


@dataclass(frozen=True)
class Evaluation:
    """All cases, in the order in which they were asked for.

    Attributes
    ----------
    cases : tuple of CaseFound
    charts : tuple of CaseFound
        What each rig and method lets the eyes read and resolve.
    failures : tuple of Failure
    targets : mapping
        What each eye should perceive, PNG by eye, by source and rig.
    resumed : int
        How many cases an earlier run had finished.
    """

    cases: tuple[CaseFound, ...]
    charts: tuple[CaseFound, ...]
    failures: tuple[Failure, ...]
    targets: Mapping[tuple[str, str], Mapping[Side, bytes]]
    resumed: int


@dataclass(frozen=True)
class _Asked:
    """One case before it is computed."""

    source: str
    rig_name: str
    method: str
    key: str
    place: Path


def run_evaluation(
    renderer: GpuRenderer,
    pictures: Pictures,
    rigs: Mapping[str, Rig],
    question: Question,
    folder: Path,
    *,
    progress: Callable[[str], None] | None = None,
) -> Evaluation:
    """Compute every case that is not finished, and keep each in the folder as it is.

    Parameters
    ----------
    pictures : mapping
        Each source's target for a rig, (H, W, 3) linear light.
    folder : Path
        It is there already.

    Returns
    -------
    Evaluation
        A case that cannot be computed is among the failures; the others go on.

    Raises
    ------
    InputError
        Before anything is computed: no source or rig, a source that gives no target, a viewport
        that is all border, an unknown method or metric.
    OutputError, OutputPathError
        The folder cannot take a case: no other case would fare better.
    """
    question.check()
    _require_some(pictures, rigs)
    say = progress or (lambda _: None)
    targets = _Targets(pictures, rigs)
    pairs = [(source, name) for source in pictures for name in rigs]
    # All of them before anything is written: a source that cannot be read leaves no trace.
    digests = {pair: picture_digest(targets.get(*pair)) for pair in pairs}
    encoded, asked = {}, list[_Asked]()
    for source, name in pairs:
        digest, rig = digests[source, name], rigs[name]
        place = target_folder(folder, source, name, digest)
        encoded[source, name] = _keep_target(renderer, targets.get(source, name), rig, place)
        asked += _asked(renderer, source, name, rig, digest, question, folder)
    if any(name in CHART_METRICS for name in question.metrics):
        for name, rig in rigs.items():
            asked += _asked(renderer, CHARTS, name, rig, "", question, folder)
    done = {each: load_case(each.place, each.key) for each in asked}
    missing = [each for each in asked if done[each] is None]
    if len(missing) < len(asked):
        say(f"{len(asked) - len(missing)} of {len(asked)} cases are finished already")
    failures, clock = [], _Clock(len(missing))
    for each in _in_working_order(missing, rigs, question):
        say(f"{clock.place()} {each.source}, {each.rig_name}, {each.method}{clock.left()}")
        try:
            done[each] = _compute(renderer, each, rigs[each.rig_name], targets, question)
        except (OutputError, OutputPathError):
            raise
        except Exception as error:
            failures.append(_failure(each, error))
            say(f"failed: {failures[-1].reason}")
        clock.tick()
    found = [case for case in done.values() if case is not None]
    return Evaluation(
        cases=tuple(case for case in found if case.source != CHARTS),
        charts=tuple(case for case in found if case.source == CHARTS),
        failures=tuple(failures),
        targets=encoded,
        resumed=len(asked) - len(missing),
    )


def _in_working_order(
    cases: Sequence[_Asked], rigs: Mapping[str, Rig], question: Question
) -> list[_Asked]:
    """Rig by rig and method by method: their tables are then made once for all sources."""
    rig_place = {name: place for place, name in enumerate(rigs)}
    method_place = {name: place for place, name in enumerate(question.methods)}
    return sorted(
        cases, key=lambda c: (rig_place[c.rig_name], method_place[c.method], c.source != CHARTS)
    )


def _require_some(pictures: Pictures, rigs: Mapping[str, Rig]) -> None:
    for what, given in (("source", pictures), ("rig", rigs)):
        if not given:
            raise InputError(f"{what}: found none, wanted one or more")
    for name, rig in rigs.items():
        for side in SIDES:
            try:
                require_room(rig, side)
            except InputError as error:
                raise InputError(f"{name}: {error}") from None


def _failure(each: _Asked, error: Exception) -> Failure:
    reason = " ".join(str(error).split()) or type(error).__name__
    if not isinstance(error, VrlfError):
        reason = f"unexpected {type(error).__name__}: {reason}"
    return Failure(each.source, each.rig_name, each.method, reason)


def _keep_target(renderer: GpuRenderer, target: Image, rig: Rig, place: Path) -> dict[Side, bytes]:
    """Each eye's target as a PNG, which is kept in the folder."""
    make_folder(place)
    codes, files = renderer.encode(target), {}
    for side in SIDES:
        file = place / f"{side}.png"
        write_encoded(file, np.ascontiguousarray(codes[:, viewport(rig, side).columns]))
        files[side] = file.read_bytes()
    return files


class _Targets:
    """What should be perceived, by source and rig; as many are kept as there is room for."""

    def __init__(self, pictures: Pictures, rigs: Mapping[str, Rig]) -> None:
        self._pictures, self._rigs = pictures, rigs
        self._kept: dict[tuple[str, str], Image] = {}
        self._room_bytes = _MOST_KEPT_BYTES

    def get(self, source: str, rig_name: str) -> Image:
        """Make it, unless it was kept."""
        if (source, rig_name) in self._kept:
            return self._kept[source, rig_name]
        target = self._pictures[source](self._rigs[rig_name])
        if target.nbytes <= self._room_bytes:
            self._room_bytes -= target.nbytes
            self._kept[source, rig_name] = target
        return target


class _Clock:
    """Which case it is, and how long those to come will take at the pace so far."""

    def __init__(self, count: int) -> None:
        self._count, self._done, self._began = count, 0, time.monotonic()

    def place(self) -> str:
        return f"[{self._done + 1}/{self._count}]"

    def left(self) -> str:
        if not self._done:
            return ""
        seconds = (time.monotonic() - self._began) / self._done * (self._count - self._done)
        return f" (about {_duration(seconds)} left)"

    def tick(self) -> None:
        self._done += 1


def _duration(seconds: float) -> str:
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 6000.0 else f"{seconds / 3600.0:.1f} h"


def _asked(
    renderer: GpuRenderer,
    source: str,
    rig_name: str,
    rig: Rig,
    target_digest: str,
    question: Question,
    folder: Path,
) -> Iterator[_Asked]:
    """The cases of one source and rig, with their keys."""
    is_chart = source == CHARTS
    shared = {
        "source": source,
        "rig_name": rig_name,
        "rig": rig.model_dump(mode="json", by_alias=True),
        "target": target_digest,
        "metrics": [name for name in question.metrics if (name in CHART_METRICS) == is_chart],
        "rays": question.rays,
        "renderer": renderer.device.info.renderer,
        "versions": dict(question.versions or {}),
    }
    for method in question.methods:
        key = key_of({**shared, "method": method})
        place = case_folder(folder, source, rig_name, method, key)
        yield _Asked(source, rig_name, method, key, place)


def _compute(
    renderer: GpuRenderer, asked: _Asked, rig: Rig, targets: _Targets, question: Question
) -> CaseFound:
    """Prefilter, perceive, judge, and keep."""
    if asked.source == CHARTS:
        return _compute_charts(renderer, asked, rig, question)
    target = targets.get(asked.source, asked.rig_name)
    filtered = method_rig(rig, asked.method)
    panel, seen = shown_and_seen(renderer, target, filtered, question.rays)
    pictures: dict[str, NDArray[np.uint8]] = {}
    eyes: dict[Side, EyeFound] = {}
    codes = {"panel": renderer.encode(panel), "seen": renderer.encode(seen)}
    for side in SIDES:
        columns = viewport(rig, side).columns
        pictures |= {f"{side}-{name}.png": each[:, columns] for name, each in codes.items()}
        eyes[side], maps = judge(seen, target, filtered, side, question.metrics)
        pictures |= maps
    return _kept(asked, eyes, pictures)


def _compute_charts(
    renderer: GpuRenderer, asked: _Asked, rig: Rig, question: Question
) -> CaseFound:
    rays = min(question.rays, CHART_RAYS)
    eyes = read_charts(
        chart_rig(method_rig(rig, asked.method)),
        lambda target, shown_by: shown_and_seen(renderer, target, shown_by, rays)[1],
        question.metrics,
    )
    return _kept(asked, eyes, {})


def _kept(
    asked: _Asked, eyes: Mapping[Side, EyeFound], pictures: Mapping[str, NDArray[np.uint8]]
) -> CaseFound:
    found = CaseFound(
        asked.key, asked.source, asked.rig_name, asked.method, eyes["left"], eyes["right"], {}
    )
    return store_case(asked.place, found, pictures)
