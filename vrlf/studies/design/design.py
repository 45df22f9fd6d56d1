"""``run_design``: a search, the best of it looked at more closely, checked by the whole chain."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, Literal

import numpy as np
from scipy.stats import spearmanr

from vrlf.errors import InputError
from vrlf.evaluation.measure import border_px, likeness
from vrlf.model import Rig, Tolerance
from vrlf.model.searching import SearchLimits
from vrlf.optics.lattice import lattice_of
from vrlf.optics.viewport import SIDES
from vrlf.renderer import GpuRenderer, Image, bare_rig
from vrlf.studies.design.report import Checked, DesignReport, Maps, Ranked
from vrlf.studies.design.score import Judging, Method, judging_of
from vrlf.studies.design.scorer import NEVER_DB, Scorer
from vrlf.studies.design.search import Effort, Scored, Search
from vrlf.studies.design.sensitivity import (
    brightest_that_serves,
    brightness_curve,
    curves,
    with_brightness,
)
from vrlf.studies.design.space import Space
from vrlf.studies.quality import cropped, with_method
from vrlf.studies.tolerance import USUAL

# Of the searched patch, of the larger one that ranks, and of the panel that is checked on.
_JUDGED_PX: Final = 80
_FINE_PX: Final = 112
_FINE_RAYS: Final = 384
_FINE_SEEDS: Final = (21, 22, 23)
CHECK_PX: Final = (440, 220)
CHECK_RAYS: Final = 512
# How much sharper than the brightest a dimmer picture must be, to be taken.
_DIMMER_DB: Final = 0.2
_STEPS: Final = 16

Robust = Literal["none", "mean", "worst"]
Say = Callable[[str], None]


@dataclass(frozen=True)
class Task:
    """What is asked for.

    Attributes
    ----------
    kind : "microlens" or "pinhole"
    robust : "none", "mean" or "worst"
        Over cases of the rig's tolerance, or of what is usual.
    best : int
        How many are reported.
    judged_px : int
        Side of the patch that is searched with.
    """

    limits: SearchLimits = field(default_factory=SearchLimits)
    kind: Literal["microlens", "pinhole"] = "microlens"
    method: Method = "optimal"
    robust: Robust = "none"
    cases: int = 4
    effort: Effort = field(default_factory=Effort)
    seed: int = 1
    best: int = 10
    judged_px: int = _JUDGED_PX
    fine_px: int = _FINE_PX


@dataclass(frozen=True)
class Picture:
    """What the best are checked with: its name, its target for a rig, the panel's size."""

    name: str
    target: Callable[[Rig], Image]
    size_px: tuple[int, int] = CHECK_PX


def run_design(
    rig: Rig,
    task: Task,
    *,
    workers: int,
    renderer: GpuRenderer | None = None,
    picture: Picture | None = None,
    say: Say = lambda _: None,
) -> DesignReport:
    """Search an array for a rig's eyes, headset and panel.

    Parameters
    ----------
    renderer, picture : optional
        With them the best go through the whole chain, too.

    Raises
    ------
    InputError
        If the limits leave nothing, or the panel's size no room inside the border.
    """
    started, cpu = time.perf_counter(), time.process_time()
    with Scorer(workers) as scorer:
        made = _searched(rig, task, scorer, say)
        # With one worker all was done in this process, and is counted there.
        elsewhere = scorer.cpu_s if workers > 1 else 0.0
    if renderer is not None and picture is not None:
        best = [
            replace(each, checked=_check(renderer, each.rig, picture, f"best {n}", say))
            for n, each in enumerate(made.best, 1)
        ]
        before = {
            name: replace(each, checked=_check(renderer, each.rig, picture, name, say))
            for name, each in made.before.items()
        }
        correlation = _correlation([*best, *before.values()])
        made = replace(
            made,
            best=tuple(best),
            before=before,
            picture=picture.name,
            rank_correlation=correlation,
        )
    cpu_s = time.process_time() - cpu + elsewhere
    return replace(made, wall_s=time.perf_counter() - started, cpu_s=cpu_s)


def _searched(rig: Rig, task: Task, scorer: Scorer, say: Say) -> DesignReport:
    """All but the check; without the times."""
    asked = _asked(rig, task)
    space = Space(asked, task.kind, task.limits)
    judging, fine = _judgings(asked, space, task)
    search = Search(space, scorer, judging, say)
    search.run(task.effort, task.seed)
    found = search.best(2 * task.best)
    if not found:
        raise InputError("limits: found that they allow no array at all, wanted wider ones")
    say(f"ranking the best {len(found)} on a larger patch")
    best = _ranked(space, found, fine, scorer)[: task.best]
    curve = brightness_curve(best[0].rig, task.limits.brightness, fine, scorer)
    wanted = task.limits.brightness[1]
    if curve is not None:
        wanted = brightest_that_serves(curve, _DIMMER_DB)
    best = [replace(each, rig=with_brightness(each.rig, wanted)) for each in best]
    say("sensitivity of the best")
    return DesignReport(
        method=task.method,
        seed=task.seed,
        robust=task.robust,
        picture=None,
        stages=tuple(search.stages),
        best=tuple(best),
        before=_before(rig, asked, judging, fine, scorer),
        maps=maps_of(space, search.scored),
        curves=curves(best[0].rig, judging, scorer),
        brightness=curve,
        rank_correlation=None,
        wall_s=0.0,
        cpu_s=0.0,
    )


def _asked(rig: Rig, task: Task) -> Rig:
    """The rig as it is searched: the method, and a tolerance where one is asked for."""
    if task.robust != "none" and "perpendicular" in task.limits.barriers:
        raise InputError(
            f'--barriers: found "perpendicular" beside --robust {task.robust}, wanted "converging" '
            'or "none": behind such walls no panel image can serve many cases'
        )
    made = with_method(rig, task.method, rig.prefilter.iterations or _STEPS)
    made = with_brightness(made, task.limits.brightness[1])
    if task.robust == "none":
        return made.model_copy(update={"tolerance": None})
    return made if rig.tolerance is not None else made.model_copy(update={"tolerance": served()})


def served() -> Tolerance:
    """What a headset that is put on by hand is off by, with few cases: they cost one by one."""
    return USUAL.model_copy(update={"draws": 4})


def _judgings(rig: Rig, space: Space, task: Task) -> tuple[Judging, Judging]:
    """What is searched with, and the finer one that ranks."""
    judging = judging_of(rig, space.widest_um, task.judged_px, task.method)
    fine = judging_of(rig, space.widest_um, task.fine_px, task.method)
    fine = replace(fine, rays=_FINE_RAYS, seeds=_FINE_SEEDS)
    if task.robust == "none":
        return judging, fine
    cases, over = task.cases, task.robust
    judging = replace(judging, cases=cases, over_cases=over)
    return judging, replace(fine, cases=cases, over_cases=over)


def _ranked(
    space: Space, found: Sequence[Scored], judging: Judging, scorer: Scorer
) -> list[Ranked]:
    rigs = [space.rig_at(each.point) for each in found]
    fine = scorer.scores_db(rigs, judging)
    ranked = [
        Ranked(rig, space.part_at(each.point), each.db, db)
        for each, rig, db in zip(found, rigs, fine, strict=True)
        if rig is not None
    ]
    return sorted(ranked, key=lambda each: -each.fine_db)


def _before(
    given: Rig, asked: Rig, judging: Judging, fine: Judging, scorer: Scorer
) -> dict[str, Ranked]:
    """What the best are to be better than: the bare panel, and the array that was given."""
    rigs = {"bare": bare_rig(asked)}
    # A patch knows of even pitches alone.
    if lattice_of(given) is not None and not given.array.varies:
        rigs["given"] = with_brightness(asked, given.prefilter.brightness)
    patch = scorer.scores_db(list(rigs.values()), judging)
    finer = scorer.scores_db(list(rigs.values()), fine)
    rows = zip(rigs.items(), patch, finer, strict=True)
    return {name: Ranked(rig, "", db, fine_db) for (name, rig), db, fine_db in rows}


def _check(renderer: GpuRenderer, rig: Rig, picture: Picture, name: str, say: Say) -> Checked:
    """The whole chain, on a panel of the picture's size."""
    say(f"the whole chain: {name}")
    small = cropped(rig, picture.size_px)
    side_px = min(small.panel.width_px // 2, small.panel.height_px)
    border = max(border_px(small, side) for side in SIDES)
    if 2 * border >= side_px:
        raise InputError(
            f"--panel: found viewports of {side_px} pixels, wanted more than twice the border of "
            f"{border} (blur radius and one lenslet)"
        )
    target = picture.target(small)
    is_bare = lattice_of(small) is None
    shown = target if is_bare else renderer.prefilter(target, small)
    seen = renderer.perceive(shown, small, rays=CHECK_RAYS)
    likes = [likeness(seen, target, small, side) for side in SIDES]
    psnr_db = min(each.psnr_db for each in likes)
    ssims = [each.ssim for each in likes if each.ssim is not None]
    return Checked(psnr_db if np.isfinite(psnr_db) else None, min(ssims, default=None))


def _correlation(ranked: Sequence[Ranked]) -> float | None:
    """Spearman's, between the fine patch and the whole chain."""
    pairs = [
        (each.fine_db, each.checked.psnr_db)
        for each in ranked
        if each.checked is not None and each.checked.psnr_db is not None
    ]
    if len(pairs) < 3:
        return None
    value = float(spearmanr([a for a, _ in pairs], [b for _, b in pairs]).statistic)
    return value if np.isfinite(value) else None


def maps_of(space: Space, scored: Sequence[Scored]) -> Maps:
    """The best of each pitch and gap of the grid, over all else that it tried."""
    best: dict[tuple[float, float], float] = {}
    for each in scored:
        array = space.array(each.point)
        if each.stage == "grid" and array is not None:
            key = (array.pitch_um, array.gap_mm)
            best[key] = max(best.get(key, NEVER_DB), each.db)
    pitches = sorted({pitch for pitch, _ in best})
    gaps = sorted({gap for _, gap in best})
    rows = tuple(tuple(best.get((pitch, gap)) for pitch in pitches) for gap in gaps)
    return Maps(tuple(pitches), tuple(gaps), rows)
