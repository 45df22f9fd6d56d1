"""How near each prefilter brings what an eye perceives to what it should.

A panel image is judged by what is perceived of it with a quadrature of its own, never by its
values: every method shows its picture through the same perception, and the numbers are those
of ``evaluation.measure``, each eye by itself; a table shows the worse eye's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from math import isfinite
from typing import Any, Final

import numpy as np
from rich import box
from rich.table import Table

from vrlf.errors import InputError
from vrlf.evaluation.measure import Likeness, likeness
from vrlf.model import Rig, rig_from_tables
from vrlf.optics.lateral import forward_changes
from vrlf.optics.viewport import SIDES
from vrlf.reference.converged import Matrices, converged, converging_matrices, require_small
from vrlf.renderer import GpuRenderer, Image, bare_rig, check_rays

ITERATIONS: Final = (1, 2, 4, 8, 16, 32)
# Finer than what the optimal prefilter's own tables are made with.
JUDGING_RAYS: Final = 1024
# Twice the judging rays: the converged picture is not fitted to the very rays that judge it.
CONVERGED_RAYS: Final = 2048
# 160 x 160 pixels for each eye inside a border of 30: -5 D, 6 mm of pupil.
CROP_PX: Final = (440, 220)
METHODS: Final = ("none", "forward", "forward + wiener", "optimal", "converged")
Pictures = Mapping[str, Callable[[Rig], Image]]


@dataclass(frozen=True)
class EyeQuality:
    """What one eye perceives against what it should.

    Attributes
    ----------
    psnr_db : float or None
        None where it sees the target itself.
    ssim : float or None
        None where the viewport leaves less than the window.
    """

    psnr_db: float | None
    ssim: float | None


@dataclass(frozen=True)
class Quality:
    """What both eyes perceive with one method, for one rig and picture.

    Attributes
    ----------
    method : str
        One of ``METHODS``. ``none`` is the bare target on the panel without its array;
        ``converged`` the float64 optimum.
    iterations : int or None
        Steps of ``optimal``.
    """

    rig: str
    picture: str
    method: str
    iterations: int | None
    left: EyeQuality
    right: EyeQuality

    @property
    def psnr_db(self) -> float | None:
        """Of the worse eye; None where both see the target itself."""
        return min((e.psnr_db for e in self._eyes if e.psnr_db is not None), default=None)

    @property
    def ssim(self) -> float | None:
        """Of the worse eye."""
        return min((e.ssim for e in self._eyes if e.ssim is not None), default=None)

    @property
    def _eyes(self) -> tuple[EyeQuality, EyeQuality]:
        return self.left, self.right

    def to_json(self) -> dict[str, Any]:
        """One of the report's ``results``."""
        return {**asdict(self), "psnr_db": self.psnr_db, "ssim": self.ssim}


@dataclass(frozen=True)
class QualityReport:
    """All results, in the order in which they were measured.

    Attributes
    ----------
    panel : str
        Width and height in pixels, as in ``440x220``; ``each rig's own`` where they differ.
    rays : int
        For each retinal pixel, of the judge.
    """

    device: str
    panel: str
    rays: int
    results: tuple[Quality, ...]

    def mean_psnr_db(self, rig: str) -> dict[tuple[str, int | None], float]:
        """The worse eye's PSNR for each method and its steps, mean over a rig's pictures."""
        values: dict[tuple[str, int | None], list[float]] = {}
        for each in self.results:
            if each.rig == rig and each.psnr_db is not None:
                values.setdefault((each.method, each.iterations), []).append(each.psnr_db)
        return {key: float(np.mean(some)) for key, some in values.items()}

    def to_json(self) -> dict[str, Any]:
        """For ``vrlf bench quality --json``."""
        results = [each.to_json() for each in self.results]
        return {"device": self.device, "panel": self.panel, "rays": self.rays, "results": results}


def cropped(rig: Rig, size_px: tuple[int, int]) -> Rig:
    """The middle of both viewports: a smaller panel of the same pixels before the same eyes.

    The axes meet the middles of the halves, so that what an eye sees there does not change.

    Raises
    ------
    RigError
        If a panel cannot have that size.
    """
    width_px, height_px = size_px
    tables = rig.model_dump(mode="json", by_alias=True)
    tables["panel"] |= {"width_px": width_px, "height_px": height_px}
    tables["headset"] |= {
        "lens_separation_mm": width_px * rig.panel.pixel_pitch_um / 2000.0,
        "lens_height_mm": 0.0,
    }
    return rig_from_tables(tables, source=f"panel of {width_px}x{height_px} pixels")


def run_quality(
    renderer: GpuRenderer,
    rigs: Mapping[str, Rig],
    pictures: Pictures,
    *,
    iterations: Sequence[int] = ITERATIONS,
    rays: int = JUDGING_RAYS,
    with_converged: bool = False,
    progress: Callable[[str], None] | None = None,
) -> QualityReport:
    """Measure every method for every rig and picture.

    Parameters
    ----------
    pictures : mapping
        Each name's target for a rig, (H, W, 3) linear light.
    iterations : sequence of int
        Steps after which ``optimal`` is judged, each time from a cold start.
    with_converged : bool
        Solve in float64 too, until nothing is left to gain: for small panels (see
        ``reference.converged``).

    Raises
    ------
    InputError
        If a viewport is all border, a number means nothing, or a panel is too large for the
        converged solution.
    """
    check_rays(rays)
    if any(count < 0 for count in iterations):
        raise InputError(f"iterations: found {min(iterations)}, wanted 0 or more")
    for rig in rigs.values():
        if with_converged:
            require_small(rig)
    say = progress or (lambda _: None)
    results: list[Quality] = []
    for rig_name, rig in rigs.items():
        if with_converged:
            say(f"{rig_name}: tracing {CONVERGED_RAYS} rays a pixel in float64")
        matrices = converging_matrices(rig, CONVERGED_RAYS) if with_converged else None
        for picture_name, picture in pictures.items():
            say(f"{rig_name}: {picture_name}")
            target = picture(rig)
            panels = _panels(renderer, rig, target, iterations, matrices)
            for method, count, seen_by, panel in panels:
                left, right = _judged(renderer, rig, target, seen_by, panel, rays)
                results.append(Quality(rig_name, picture_name, method, count, left, right))
    sizes = dict.fromkeys(f"{r.panel.width_px}x{r.panel.height_px}" for r in rigs.values())
    panel_name = next(iter(sizes)) if len(sizes) == 1 else "each rig's own"
    return QualityReport(renderer.device.info.renderer, panel_name, rays, tuple(results))


def _panels(
    renderer: GpuRenderer,
    rig: Rig,
    target: Image,
    iterations: Sequence[int],
    matrices: Matrices | None,
) -> Iterator[tuple[str, int | None, Rig, Image]]:
    """Method, iterations, the rig to look through and the panel image, for all methods."""
    yield "none", None, bare_rig(rig), target
    if forward_changes(rig):
        yield "forward", None, rig, renderer.prefilter(target, with_method(rig, "forward"))
    sharpened = with_method(rig, "forward", wiener=True)
    yield "forward + wiener", None, rig, renderer.prefilter(target, sharpened)
    for count in iterations:
        panel = renderer.prefilter(target, with_method(rig, "optimal", count))
        yield "optimal", count, rig, panel
    if matrices is not None:
        solved = converged(target.astype(np.float64), rig, matrices)
        yield "converged", None, rig, solved.astype(np.float32)


def _judged(
    renderer: GpuRenderer, rig: Rig, target: Image, seen_by: Rig, panel: Image, rays: int
) -> tuple[EyeQuality, EyeQuality]:
    seen = renderer.perceive(panel, seen_by, rays=rays)
    # The border is the rig's own, so that all methods are judged by the same pixels.
    left, right = (_eye(likeness(seen, target, rig, side)) for side in SIDES)
    return left, right


def _eye(found: Likeness) -> EyeQuality:
    return EyeQuality(found.psnr_db if isfinite(found.psnr_db) else None, found.ssim)


def with_method(rig: Rig, method: str, iterations: int = 0, *, wiener: bool = False) -> Rig:
    """The rig with another prefilter, no time limit."""
    update = {"method": method, "iterations": iterations, "budget_ms": None, "wiener": wiener}
    return rig.model_copy(update={"prefilter": rig.prefilter.model_copy(update=update)})


def quality_table(report: QualityReport) -> Table:
    """A row for each method, a column for each rig and picture: PSNR in dB, then SSIM."""
    title = f"{report.device}, panel {report.panel}"
    caption = (
        "What is perceived, the worse eye: PSNR in dB / SSIM, linear light, after one gain. "
        f"Judged with {report.rays} rays a pixel."
    )
    table = Table(title=title, caption=caption, box=box.SIMPLE_HEAD, show_edge=False)
    table.add_column("method", no_wrap=True)
    columns = list(dict.fromkeys((each.rig, each.picture) for each in report.results))
    for rig, picture in columns:
        table.add_column(f"{rig}\n{picture}", justify="right")
    cells = {(q.rig, q.picture, q.method, q.iterations): q for q in report.results}
    for method, count in sorted(
        dict.fromkeys((each.method, each.iterations) for each in report.results), key=_place
    ):
        row = [_cell(cells.get((*column, method, count))) for column in columns]
        table.add_row(method if count is None else f"optimal, {_steps(count)}", *row)
    return table


def _place(method: tuple[str, int | None]) -> tuple[int, int]:
    name, count = method
    return METHODS.index(name), count or 0


def _steps(count: int) -> str:
    return "1 step" if count == 1 else f"{count} steps"


def _cell(each: Quality | None) -> str:
    if each is None:
        return "-"
    psnr = "equal" if each.psnr_db is None else f"{each.psnr_db:.1f}"
    return psnr if each.ssim is None else f"{psnr} / {each.ssim:.3f}"
