"""One job: what both eyes perceive of a source, by one method, against what they should."""

from __future__ import annotations

import contextlib
import hashlib
import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isnan
from pathlib import Path
from typing import Any, Final

from vrlf.errors import DeviceError, InputError, VrlfError
from vrlf.evaluation.measure import compared as pair_of
from vrlf.evaluation.metrics import METRICS as EVERY_METRIC
from vrlf.evaluation.metrics import score
from vrlf.files import shown
from vrlf.model import Rig
from vrlf.model.reading import rig_with
from vrlf.optics.viewport import SIDES, Side
from vrlf.renderer import GpuRenderer, Image, bare_rig
from vrlf.studies.evaluate_judge import light_of, rig_viewing
from vrlf.studies.quality import cropped
from vrlf.studies.sweep.plan import Job, Plan, SourceFile
from vrlf.studies.sweep.rows import Row, signed

METRICS: Final = tuple(EVERY_METRIC)
_LIGHT: Final = "light"


class WorkerUnfitError(VrlfError):
    """A worker can do none of the jobs: no GPU context, another vrlf, another picture."""


# A source's picture for a rig; a function of a module, so that a worker can find it.
TargetOf = Callable[[str, Rig, GpuRenderer], Image]
Scores = dict[str, float | None]


@dataclass(frozen=True)
class Kit:
    """What every job of a sweep needs; it travels to each worker once.

    Attributes
    ----------
    name : str
        Of the sweep.
    version : str
        Of the vrlf that began it.
    rigs : mapping
        Each base rig's whole tables.
    sources : mapping of str to SourceFile
    panel_px : (int, int) or None
    rays : int
    metrics : tuple of str
    judge : callable
        Kit, job and what gives a renderer to each value of the job's row.
    target_of : callable
    """

    name: str
    version: str
    rigs: Mapping[str, Mapping[str, Any]]
    sources: Mapping[str, SourceFile]
    panel_px: tuple[int, int] | None
    rays: int
    metrics: tuple[str, ...]
    judge: Callable[[Kit, Job, Callable[[], GpuRenderer]], Scores]
    target_of: TargetOf


@dataclass(frozen=True)
class Outcome:
    """A job's row, or why there is none.

    Attributes
    ----------
    row : dict or None
        With its checksum.
    reason : str or None
        One line.
    is_device_fault : bool
        Whether it was the GPU's.
    """

    row: Row | None = None
    reason: str | None = None
    is_device_fault: bool = False


def kit_of(plan: Plan, target_of: TargetOf) -> Kit:
    """What the jobs of a plan need.

    Raises
    ------
    InputError
        If there is no such metric.
    """
    for name in plan.spec.metrics:
        if name not in METRICS:
            raise InputError(f"metrics: found {shown(name)!r}, wanted some of {', '.join(METRICS)}")
    told = plan.told()
    sources = {each.name: each for each in plan.sources}
    spec = plan.spec
    return Kit(
        plan.name, told["vrlf"], plan.rigs, sources, plan.panel_px, spec.rays, spec.metrics,
        judged, target_of,
    )  # fmt: skip


def outcome_of(kit: Kit, job: Job, renderer: Callable[[], GpuRenderer]) -> Outcome:
    """Do a job; what goes wrong in it is its own matter and no other's.

    Raises
    ------
    WorkerUnfitError
        If it is the worker's.
    """
    try:
        with contextlib.redirect_stderr(io.StringIO()):  # what a source is taken for, each time
            scores = kit.judge(kit, job, renderer)
    except WorkerUnfitError:
        raise
    except VrlfError as error:
        return Outcome(reason=str(error), is_device_fault=isinstance(error, DeviceError))
    except Exception as error:
        return Outcome(reason=" ".join(f"unexpected {type(error).__name__}: {error}".split()))
    return Outcome(row=signed(job.values | scores))


def judged(kit: Kit, job: Job, renderer: Callable[[], GpuRenderer]) -> Scores:
    """Both eyes' metrics, in linear light, as ``vrlf bench quality`` takes them.

    ``none`` is the bare target on the panel without its array.

    Raises
    ------
    VrlfError
        If the changes make no rig, or nothing of a viewport is left to compare.
    """
    rig = rig_of(kit, job)
    target = kit.target_of(kit.sources[job.source].place, rig, renderer())
    seen = _perceived(renderer(), rig, target, job.method, kit.rays)
    scores: Scores = {}
    for side in SIDES:
        for name, value in compared(kit.metrics, seen, target, rig, side).items():
            scores[f"{side}_{name}"] = value
    return scores


def rig_of(kit: Kit, job: Job) -> Rig:
    """The job's rig, its panel cut; no limit on time, which would make rows depend on haste."""
    rig = rig_with(kit.rigs[job.rig], job.changes, source=job.rig)
    update = {"method": job.method, "budget_ms": None}
    rig = rig.model_copy(update={"prefilter": rig.prefilter.model_copy(update=update)})
    return rig if kit.panel_px is None else cropped(rig, kit.panel_px)


def _perceived(renderer: GpuRenderer, rig: Rig, target: Image, method: str, rays: int) -> Image:
    if method == "none":
        return renderer.perceive(target, bare_rig(rig), rays=rays)
    return renderer.perceive(renderer.prefilter(target, rig), rig, rays=rays)


def compared(
    metrics: Sequence[str], seen: Image, target: Image, rig: Rig, side: Side
) -> dict[str, float | None]:
    """The metrics of one eye by name; None where one has no value.

    Both pictures are compared without what `optimal` made of black, after one least-squares gain,
    inside the rig's own border.
    """
    black = rig.prefilter.black_level if rig.prefilter.method == "optimal" else 0.0
    pair = pair_of(seen, target, rig, side, black_level=black)
    names = [name for name in metrics if name != _LIGHT]
    found = dict(score(names, pair.target, pair.seen, rig_viewing(rig)).values)
    if _LIGHT in metrics:
        found[_LIGHT] = light_of(seen, pair, rig, side)
    return _named({name: found.get(name) for name in metrics})


def _named(values: Mapping[str, Any]) -> dict[str, float | None]:
    """Each number by its name; of several of one metric, each by the metric's and its own."""
    flat: dict[str, float | None] = {}
    for name, value in values.items():
        if isinstance(value, Mapping):
            flat |= _named({f"{name}.{each}": number for each, number in value.items()})
        else:
            flat[name] = None if value is None or isnan(value) else float(value)
    return flat


def require_unchanged(source: SourceFile) -> None:
    """Refuse a picture whose file is not what the sweep began with.

    Raises
    ------
    InputError
    """
    if source.sha256 is None:
        return
    try:
        with Path(source.place).open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        digest = error.strerror or "nothing"
    if digest != source.sha256:
        raise InputError(
            f"{shown(source.name)}: found another file than the sweep began with, wanted the same"
        )
