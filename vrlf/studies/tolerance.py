"""What a tolerance gains where things are off, and what it costs where nothing is."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from rich import box
from rich.table import Table

from vrlf.errors import InputError
from vrlf.evaluation.measure import border_px
from vrlf.evaluation.shift import shifted_psnr_db
from vrlf.model import Rig, Tolerance
from vrlf.optics.tolerance import cases_of
from vrlf.optics.viewport import SIDES, viewport
from vrlf.renderer import GpuRenderer, Image
from vrlf.renderer.steps import bare_rig
from vrlf.studies.quality import with_method

# What a headset that is put on by hand is off by, if a rig does not say.
USUAL = Tolerance(array_um=15.0, pupil_shift_mm=1.0, pupil_mm=(4.0, 6.0), focus_d=0.25)
CASES, JUDGING_RAYS = 12, 256
# Where the cases that judge begin: none of those that were served is among them.
_OTHERS = 10_000


@dataclass(frozen=True)
class Served:
    """How sharp one method is over the cases; PSNR after the best shift, in dB, the worse eye.

    Attributes
    ----------
    rig, method : str
        ``bare``, ``plain`` (optimal without the tolerance) or ``tolerant``.
    nominal_db : float
        Where nothing is off.
    mean_db, worst_db : float
        Over the cases.
    ms : float or None
        Of solving a frame; None where nothing was solved.
    """

    rig: str
    method: str
    nominal_db: float
    mean_db: float
    worst_db: float
    ms: float | None


@dataclass(frozen=True)
class Gain:
    """What a rig's tolerance costs where nothing is off, and gains over the cases, in dB."""

    rig: str
    cost_db: float
    mean_db: float
    worst_db: float


@dataclass(frozen=True)
class ToleranceReport:
    """All that was measured."""

    device: str
    panel: str
    cases: int
    results: tuple[Served, ...]

    @property
    def gains(self) -> list[Gain]:
        """Tolerant against plain, a rig each."""
        by_method = {(each.rig, each.method): each for each in self.results}
        gains = []
        for rig in dict.fromkeys(each.rig for each in self.results):
            plain, tolerant = by_method[rig, "plain"], by_method[rig, "tolerant"]
            gains.append(
                Gain(
                    rig=rig,
                    cost_db=plain.nominal_db - tolerant.nominal_db,
                    mean_db=tolerant.mean_db - plain.mean_db,
                    worst_db=tolerant.worst_db - plain.worst_db,
                )
            )
        return gains

    def to_json(self) -> dict[str, Any]:
        """For ``vrlf bench tolerance --json``."""
        return {**asdict(self), "gains": [asdict(each) for each in self.gains]}


def run_tolerance(
    renderer: GpuRenderer,
    rigs: Mapping[str, Rig],
    picture: Callable[[Rig], Image],
    *,
    iterations: int,
    cases: int = CASES,
    rays: int = JUDGING_RAYS,
    progress: Callable[[str], None] | None = None,
) -> ToleranceReport:
    """Judge ``optimal`` without and with each rig's tolerance, or the usual one.

    Raises
    ------
    InputError
        If the border leaves nothing of a viewport.
    """
    say, results = progress or (lambda _: None), []
    for name, rig in rigs.items():
        tolerant = rig if rig.tolerance is not None else rig.model_copy(update={"tolerance": USUAL})
        plain = rig.model_copy(update={"tolerance": None})
        judge = _Judge(renderer, tolerant, picture(rig), cases, rays)
        say(f"{name}: uncorrected")
        results.append(judge.served(name, "bare", bare_rig(tolerant), judge.target))
        for method, given in (("plain", plain), ("tolerant", tolerant)):
            say(f"{name}: {method}")
            solved = with_method(given, "optimal", iterations)
            results.append(judge.solved(name, method, solved))
    sizes = dict.fromkeys(f"{r.panel.width_px}x{r.panel.height_px}" for r in rigs.values())
    panel = next(iter(sizes)) if len(sizes) == 1 else "each rig's own"
    return ToleranceReport(renderer.device.info.renderer, panel, cases, tuple(results))


class _Judge:
    """Looks at panel images with a tolerance's other cases."""

    def __init__(
        self, renderer: GpuRenderer, rig: Rig, target: Image, cases: int, rays: int
    ) -> None:
        self._renderer, self._rig, self._rays = renderer, rig, rays
        self.target = target
        tolerance = rig.tolerance
        assert tolerance is not None
        drawn = tolerance.model_copy(update={"draws": max(2, cases)})
        drawn_rig = rig.model_copy(update={"tolerance": drawn})
        self._cases = [case.rig for case in cases_of(drawn_rig, first=_OTHERS)][:cases]
        self._border_px = max(border_px(rig, side) for side in SIDES)
        view = viewport(rig, "left")
        if 2 * self._border_px >= min(view.width_px, view.height_px):
            raise InputError(
                f"--panel: found viewports of {view.width_px}x{view.height_px} pixels, wanted "
                f"more than twice the border of {self._border_px} (blur radius and one lenslet)"
            )

    def solved(self, name: str, method: str, given: Rig) -> Served:
        """One of the two ways to solve; timed with its tables made."""
        panel = self._renderer.prefilter(self.target, given)
        started = time.perf_counter()
        self._renderer.prefilter(self.target, given)
        ms = 1e3 * (time.perf_counter() - started)
        return self.served(name, method, self._rig, panel, ms)

    def served(
        self, name: str, method: str, nominal: Rig, panel: Image, ms: float | None = None
    ) -> Served:
        """All cases of one method."""
        is_bare = nominal.array.kind == "none"
        cases = [bare_rig(case) if is_bare else case for case in self._cases]
        found = [self._psnr_db(panel, case) for case in cases]
        return Served(
            rig=name,
            method=method,
            nominal_db=self._psnr_db(panel, nominal),
            mean_db=float(np.mean(found)),
            worst_db=min(found),
            ms=ms,
        )

    def _psnr_db(self, panel: Image, seen_by: Rig) -> float:
        seen = self._renderer.perceive(panel, seen_by, rays=self._rays)
        border = self._border_px
        return min(shifted_psnr_db(seen, self.target, self._rig, side, border)[0] for side in SIDES)


def tolerance_table(report: ToleranceReport) -> Table:
    """A row for each rig and method."""
    table = Table(
        title=f"{report.device}, panel {report.panel}",
        caption="\n".join(
            [
                "PSNR in dB after the best shift, the worse eye; mean and worst of "
                f"{report.cases} cases that were not solved for.",
                *(_sentence(each) for each in report.gains),
            ]
        ),
        box=box.SIMPLE_HEAD,
        show_edge=False,
    )
    for column in ("rig", "method"):
        table.add_column(column, no_wrap=True)
    for column in ("nothing off", "mean", "worst", "ms a picture"):
        table.add_column(column, justify="right")
    for each in report.results:
        numbers = (each.nominal_db, each.mean_db, each.worst_db)
        ms = "-" if each.ms is None else f"{each.ms:.0f}"
        table.add_row(each.rig, each.method, *(f"{value:.1f}" for value in numbers), ms)
    return table


def _sentence(gain: Gain) -> str:
    return (
        f"{gain.rig}: the tolerance costs {gain.cost_db:.1f} dB where nothing is off; where things "
        f"are off it gains {gain.mean_db:.1f} dB on average and {gain.worst_db:.1f} at worst."
    )
