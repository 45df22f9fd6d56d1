"""Every source, rig and method: what each eye perceives, in all metrics, case by case.

A case is one source, rig and method. Its panel image is judged by what is perceived of it
through the rig; ``none`` is the bare target on a panel without an array. Cases that an earlier
run has finished are taken from the folder (see ``evaluate_store``).
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
from vrlf.evaluation.measure import compared, require_room
from vrlf.evaluation.metrics import METRICS, Scores, Viewing, false_colour, score
from vrlf.files import make_folder
from vrlf.images import write_encoded
from vrlf.model import Rig
from vrlf.optics.inspect import display_numbers
from vrlf.optics.viewport import SIDES, Side, viewport
from vrlf.renderer import GpuRenderer, Image, bare_rig, check_rays
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
# What a map shows where nothing is judged: middle grey, no colour of a map.
_UNJUDGED: Final = 128
# S of HDR-VDP-2 has no end, so no scale of colours.
_UNSHOWN_MAPS: Final = frozenset({"S"})
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
        Of ``evaluation.metrics.METRICS``.
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
            ("metric", self.metrics, tuple(METRICS)),
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
    failures : tuple of Failure
    targets : mapping
        What each eye should perceive, PNG by eye, by source and rig.
    resumed : int
        How many cases an earlier run had finished.
    """

    cases: tuple[CaseFound, ...]
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


def rig_viewing(rig: Rig) -> Viewing:
    """True pixels per degree on the axis, and the panel's luminance."""
    ppd = display_numbers(rig)["pixels_per_degree"]
    assert ppd is not None
    return Viewing(ppd, rig.panel.peak_nit)


def method_rig(rig: Rig, method: str) -> Rig:
    """The rig with that prefilter, all its other settings kept."""
    return rig.model_copy(update={"prefilter": rig.prefilter.model_copy(update={"method": method})})


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
    targets = _Targets(pictures, rigs)
    say, encoded = progress or (lambda _: None), {}
    asked = []
    for source in pictures:
        for name in rigs:
            target = targets.get(source, name)
            encoded[source, name] = _keep_target(renderer, source, name, rigs[name], target, folder)
            asked += list(_asked(renderer, source, name, rigs[name], target, question, folder))
    done = {each: load_case(each.place, each.key) for each in asked}
    resumed = sum(each is not None for each in done.values())
    if resumed:
        say(f"{resumed} of {len(asked)} cases are finished already")
    cases, failures, clock = [], [], _Clock(len(asked) - resumed)
    for each in asked:
        found = done[each]
        if found is None:
            say(f"{clock.place()} {each.source}, {each.rig_name}, {each.method}{clock.left()}")
            try:
                target, rig = targets.get(each.source, each.rig_name), rigs[each.rig_name]
                found = _compute(renderer, each, rig, target, question)
            except (OutputError, OutputPathError):
                raise
            except Exception as error:
                failures.append(_failure(each, error))
                say(f"failed: {failures[-1].reason}")
            clock.tick()
        if found is not None:
            cases.append(found)
    return Evaluation(tuple(cases), tuple(failures), encoded, resumed)


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


def _keep_target(
    renderer: GpuRenderer, source: str, rig_name: str, rig: Rig, target: Image, folder: Path
) -> dict[Side, bytes]:
    """Each eye's target as a PNG, which is kept in the folder."""
    place = make_folder(target_folder(folder, source, rig_name, picture_digest(target)))
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
    target: Image,
    question: Question,
    folder: Path,
) -> Iterator[_Asked]:
    """The cases of one source and rig, with their keys."""
    shared = {
        "source": source,
        "rig_name": rig_name,
        "rig": rig.model_dump(mode="json", by_alias=True),
        "target": picture_digest(target),
        "metrics": list(question.metrics),
        "rays": question.rays,
        "renderer": renderer.device.info.renderer,
        "versions": dict(question.versions or {}),
    }
    for method in question.methods:
        key = key_of({**shared, "method": method})
        place = case_folder(folder, source, rig_name, method, key)
        yield _Asked(source, rig_name, method, key, place)


def _compute(
    renderer: GpuRenderer, asked: _Asked, rig: Rig, target: Image, question: Question
) -> CaseFound:
    """Prefilter, perceive, judge, and keep."""
    filtered = method_rig(rig, asked.method)
    panel = renderer.prefilter(target, filtered)
    seen_by = bare_rig(rig) if asked.method == "none" else filtered
    seen = renderer.perceive(panel, seen_by, rays=question.rays)
    pictures: dict[str, NDArray[np.uint8]] = {}
    eyes: dict[Side, EyeFound] = {}
    codes = {"panel": renderer.encode(panel), "seen": renderer.encode(seen)}
    for side in SIDES:
        columns = viewport(rig, side).columns
        pictures |= {f"{side}-{name}.png": each[:, columns] for name, each in codes.items()}
        eyes[side], maps = judge(seen, target, filtered, side, question.metrics)
        pictures |= maps
    found = CaseFound(
        asked.key, asked.source, asked.rig_name, asked.method, eyes["left"], eyes["right"], {}
    )
    return store_case(asked.place, found, pictures)


def judge(
    seen: Image, target: Image, rig: Rig, side: Side, metrics: Sequence[str]
) -> tuple[EyeFound, dict[str, NDArray[np.uint8]]]:
    """What one eye perceives against what it should: numbers, and maps as pictures.

    Parameters
    ----------
    seen, target : ndarray (H, W, 3)
        Linear light on the panel's raster.
    rig : Rig
        Whose method made the panel image: ``optimal`` alone raises the black level.
    """
    black = rig.prefilter.black_level if rig.prefilter.method == "optimal" else 0.0
    pair = compared(seen, target, rig, side, black_level=black)
    scores = score(metrics, pair.target, pair.seen, rig_viewing(rig))
    view = viewport(rig, side)
    pictures: dict[str, NDArray[np.uint8]] = {}
    named: dict[str, str] = {}
    for title, values in _shown_maps(scores):
        framed = np.full((view.height_px, view.width_px, 3), _UNJUDGED, np.uint8)
        framed[pair.inner] = false_colour(values)
        named[title] = f"{side}-{title}.png"
        pictures[named[title]] = framed
    values_by_name = {**scores.values, "gain": pair.gain}
    return EyeFound(values_by_name, scores.reasons, scores.failed, named), pictures


def _shown_maps(scores: Scores) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Each map that ends at 1, by its metric's name."""
    for metric, maps in scores.maps.items():
        for name, values in maps.items():
            if name not in _UNSHOWN_MAPS:
                yield metric, values
