"""How near each prefilter brings what an eye perceives to what it should.

A panel image is judged by what is perceived of it with a quadrature of its own, never by its
values: every method shows its picture through the same perception, and the PSNR is that of
``evaluation.measure``, the worse eye counting.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from math import inf, isfinite
from typing import Any, Final

from rich import box
from rich.table import Table

from vrlf.errors import InputError
from vrlf.evaluation.measure import likeness
from vrlf.model import Rig
from vrlf.optics.viewport import SIDES
from vrlf.renderer import GpuRenderer, Image, check_rays

ITERATIONS: Final = (1, 2, 4, 8, 16, 32)
# Finer than what the optimal prefilter's own tables are made with.
JUDGING_RAYS: Final = 1024
Pictures = Mapping[str, Callable[[Rig], Image]]


@dataclass(frozen=True)
class Quality:
    """The PSNR of one method for one rig and picture.

    Attributes
    ----------
    method : str
        ``none`` is the bare target on the panel without its array.
    iterations : int or None
        Steps of ``optimal``.
    psnr_db : float or None
        Of the worse eye; None where it sees the target itself.
    """

    rig: str
    picture: str
    method: str
    iterations: int | None
    psnr_db: float | None


@dataclass(frozen=True)
class QualityReport:
    """All results, in the order in which they were measured."""

    device: str
    rays: int
    results: tuple[Quality, ...]

    def to_json(self) -> dict[str, Any]:
        """For ``vrlf bench quality --json``."""
        results = [asdict(each) for each in self.results]
        return {"device": self.device, "rays": self.rays, "results": results}


def run_quality(
    renderer: GpuRenderer,
    rigs: Mapping[str, Rig],
    pictures: Pictures,
    *,
    iterations: Sequence[int] = ITERATIONS,
    rays: int = JUDGING_RAYS,
    progress: Callable[[str], None] | None = None,
) -> QualityReport:
    """Measure every method for every rig and picture.

    Parameters
    ----------
    pictures : mapping
        Each name's target for a rig, (H, W, 3) linear light.
    iterations : sequence of int
        Steps after which ``optimal`` is judged, each time from a cold start.

    Raises
    ------
    InputError
        If a viewport is all border, or a number means nothing.
    """
    check_rays(rays)
    if any(count < 0 for count in iterations):
        raise InputError(f"iterations: found {min(iterations)}, wanted 0 or more")
    results: list[Quality] = []
    for rig_name, rig in rigs.items():
        for picture_name, picture in pictures.items():
            if progress is not None:
                progress(f"{rig_name}: {picture_name}")
            for method, count, psnr_db in _methods(renderer, rig, picture(rig), iterations, rays):
                results.append(Quality(rig_name, picture_name, method, count, psnr_db))
    return QualityReport(renderer.device.info.renderer, rays, tuple(results))


def _methods(
    renderer: GpuRenderer, rig: Rig, target: Image, iterations: Sequence[int], rays: int
) -> Iterator[tuple[str, int | None, float | None]]:
    """Method, iterations and PSNR, for all that a rig allows."""

    def judged(seen_by: Rig, panel: Image) -> float | None:
        seen = renderer.perceive(panel, seen_by, rays=rays)
        worse = min((likeness(seen, target, rig, side).psnr_db for side in SIDES), default=inf)
        return worse if isfinite(worse) else None

    bare = rig.model_copy(update={"array": rig.array.model_copy(update={"kind": "none"})})
    yield "none", None, judged(bare, target)
    if rig.array.kind != "none":
        yield "forward", None, judged(rig, renderer.prefilter(target, with_method(rig, "forward")))
    if rig.array.kind != "none" and rig.array.barriers == "perpendicular":
        return  # optimal has no table for them
    for count in iterations:
        panel = renderer.prefilter(target, with_method(rig, "optimal", count))
        yield "optimal", count, judged(rig, panel)


def with_method(rig: Rig, method: str, iterations: int = 0) -> Rig:
    """The rig with another prefilter, no time limit."""
    update = {"method": method, "iterations": iterations, "budget_ms": None}
    return rig.model_copy(update={"prefilter": rig.prefilter.model_copy(update=update)})


def quality_table(report: QualityReport) -> Table:
    """A row for each rig and picture, a column for each method; decibels."""
    columns = list(dict.fromkeys((each.method, each.iterations) for each in report.results))
    title = f"PSNR in dB of what is perceived, the worse eye; {report.device}"
    table = Table(title=title, box=box.SIMPLE)
    table.add_column("rig")
    table.add_column("picture")
    for method, count in columns:
        table.add_column(method if count is None else f"optimal {count}", justify="right")
    cells = {(q.rig, q.picture, q.method, q.iterations): q.psnr_db for q in report.results}
    for rig, picture in dict.fromkeys((q.rig, q.picture) for q in report.results):
        row = [_cell(cells, (rig, picture, *column)) for column in columns]
        table.add_row(rig, picture, *row)
    return table


def _cell(cells: Mapping[Any, float | None], key: tuple[Any, ...]) -> str:
    if key not in cells:
        return "-"
    value = cells[key]
    return "equal" if value is None else f"{value:.1f}"
