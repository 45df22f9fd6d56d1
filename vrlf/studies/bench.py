"""How long each pass takes, both eyes, at several panel sizes, and its float64 twin for scale.

Passes are timed by the GPU's clock on textures that are there already; uploads and readbacks
are not in it. ``tables ...`` is what a change of prescription costs: wall time until the new
tables are on the GPU and given back. ``float64 ...`` is the twin of the step of that name,
wall time, at the smallest panel.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from itertools import groupby
from pathlib import Path
from typing import Any, Final

import numpy as np
from rich import box
from rich.table import Table

from vrlf.errors import InputError
from vrlf.gpu import Device
from vrlf.model import DEFAULT_RIG, Rig, load_rig, rig_from_tables
from vrlf.renderer import check_rays
from vrlf.studies.steps import TWIN, TWIN_RAYS, Step, gpu_steps, passes_of, twin_steps

SizePx = tuple[int, int]

PANEL_SIZES_PX: Final[tuple[SizePx, ...]] = ((1334, 750), (2560, 1440), (3840, 2160))
FEWEST_RUNS: Final = 3
# On a GPU the twins alone use their share. On software GL, where three runs of everything
# take over a minute, it leaves the fast steps all their runs and the slow ones the fewest.
DEFAULT_BUDGET_S: Final = 40.0
# A run this long warms itself: caches and clocks are up within its first part.
_SELF_WARMING_MS = 1000.0


@dataclass(frozen=True)
class Timing:
    """How long one step took.

    Attributes
    ----------
    name : str
        ``prepare``, ``forward``, ``perceive`` or ``encode``; ``tables ...`` for the making of
        tables, ``float64 ...`` for a twin.
    panel : str
        Width and height in pixels, as in ``1334x750``.
    ms, p95_ms : float
        Median and 95th percentile over the runs, linear between the two nearest runs.
    runs : int
    rays : int or None
        Rays for each retinal pixel, where any are traced.
    """

    name: str
    panel: str
    ms: float
    p95_ms: float
    runs: int
    rays: int | None = None


@dataclass(frozen=True)
class BenchReport:
    """The GPU's name and all timings, in the order in which they were taken."""

    device: str
    results: tuple[Timing, ...]

    def speed_up(self, timing: Timing) -> float | None:
        """How many times faster than its twin at equal work; None where none was timed."""
        twin = (TWIN + timing.name, timing.panel, timing.rays)
        for other in self.results:
            if (other.name, other.panel, other.rays) == twin and timing.ms > 0.0:
                return other.ms / timing.ms
        return None

    def to_json(self) -> dict[str, Any]:
        """For ``vrlf bench --json``."""
        rows = [{**asdict(timing), "speed_up": self.speed_up(timing)} for timing in self.results]
        return {"device": self.device, "results": rows}


def run_bench(
    device: Device,
    *,
    sizes: Sequence[SizePx] = PANEL_SIZES_PX,
    rays: int = 64,
    runs: int = 9,
    budget_s: float = DEFAULT_BUDGET_S,
    progress: Callable[[str], None] | None = None,
    rig: str | Path | Rig = DEFAULT_RIG,
) -> BenchReport:
    """Time every pass at every panel size, and the float64 twins at the smallest.

    All panels belong to the same headset: see ``resized``. A rig without an array has no
    forward pass, so none is timed.

    Parameters
    ----------
    device : Device
        The GPU; it is left as it was found.
    sizes : sequence of (width, height)
        In pixels.
    rays : int
        Rays for each retinal pixel in ``perceive``.
    runs : int
        Timed runs of each step, after two to warm up. A run of a second or more needs no
        warming and is counted from the first.
    budget_s : float
        Wall time for the whole. It is shared out evenly, and a step that has used up its
        share stops at three runs; so it is exceeded where three runs take longer.
    progress : callable, optional
        Is told of each timing in a line.
    rig : str, Path or Rig
        As for ``load_rig``.

    Raises
    ------
    InputError
        If there are no sizes, fewer than three runs, no usable number of rays, or a panel
        larger than the GPU can hold.
    RigError
        If there is no such rig, or a panel's size is none that a rig can have.
    """
    given = rig if isinstance(rig, Rig) else load_rig(rig)
    _check(sizes, rays, runs)
    rigs = [resized(given, size) for size in sizes]
    for each in rigs:
        device.require_texture_size(each.panel.width_px, each.panel.height_px, "panel")
    device.make_current()
    smallest = min(rigs, key=lambda each: each.panel.width_px * each.panel.height_px)
    schedule = Schedule(runs, budget_s / (len(rigs) + 1), progress or (lambda _: None))
    results: list[Timing] = []
    with ExitStack() as whole:
        passes = passes_of(device, whole)
        for each in rigs:
            ray_counts = (rays, TWIN_RAYS) if each is smallest else (rays,)
            with ExitStack() as panel:
                steps = gpu_steps(passes, each, ray_counts, panel)
                if each is rigs[0]:
                    # Programs are compiled at their first run, and serve all panels.
                    for step in steps:
                        step.once_ms()
                results += schedule.timings(each, steps)
    results += schedule.timings(smallest, twin_steps(smallest))
    return BenchReport(device.info.renderer, tuple(results))


def _check(sizes: Sequence[SizePx], rays: int, runs: int) -> None:
    check_rays(rays)
    if not sizes:
        raise InputError("sizes: found none, wanted at least one panel size")
    if runs < FEWEST_RUNS:
        raise InputError(f"runs: found {runs}, wanted a whole number of at least {FEWEST_RUNS}")


def resized(rig: Rig, size_px: SizePx) -> Rig:
    """The same headset with finer or coarser pixels: the panel keeps its width in millimetres.

    Raises
    ------
    RigError
        If a panel cannot have that size.
    """
    width_px, height_px = size_px
    tables = rig.model_dump(mode="json", by_alias=True)
    tables["panel"] |= {
        "width_px": width_px,
        "height_px": height_px,
        "pixel_pitch_um": rig.panel.pixel_pitch_um * (rig.panel.width_px / max(width_px, 1)),
    }
    return rig_from_tables(tables, source=f"panel of {width_px}x{height_px} pixels")


@dataclass(frozen=True)
class Schedule:
    """How often a step is run, and whom to tell."""

    runs: int
    panel_share_s: float
    progress: Callable[[str], None]
    fewest: int = FEWEST_RUNS

    def timings(self, rig: Rig, steps: Sequence[Step]) -> Iterator[Timing]:
        """Time the steps of a panel one after the other, with equal shares of its time."""
        panel = f"{rig.panel.width_px}x{rig.panel.height_px}"
        for step in steps:
            times_ms = self._times_ms(step, self.panel_share_s / len(steps))
            median_ms, p95_ms = (float(p) for p in np.percentile(times_ms, [50.0, 95.0]))
            self.progress(f"{panel} {step.name}: {figure(median_ms)} ms, {len(times_ms)} runs")
            yield Timing(step.name, panel, median_ms, p95_ms, len(times_ms), step.rays)

    def _times_ms(self, step: Step, share_s: float) -> list[float]:
        started = time.perf_counter()
        times_ms = [step.once_ms()]
        if times_ms[0] < _SELF_WARMING_MS:
            times_ms.clear()
            step.once_ms()
        while len(times_ms) < self.fewest or (
            len(times_ms) < self.runs and time.perf_counter() - started < share_s
        ):
            times_ms.append(step.once_ms())
        return times_ms


def bench_table(report: BenchReport) -> Table:
    """The report for a terminal of 80 columns."""
    table = Table(
        title=report.device,
        caption="Both eyes. ms: median. faster: than the float64 twin of the same step.",
        box=box.SIMPLE_HEAD,
        show_edge=False,
        pad_edge=False,
    )
    for heading in ("panel", "step"):
        table.add_column(heading, no_wrap=True)
    for heading in ("rays", "ms", "p95 ms", "runs", "faster"):
        table.add_column(heading, justify="right", no_wrap=True)
    for panel, timings in groupby(report.results, key=lambda timing: timing.panel):
        for row, timing in enumerate(timings):
            table.add_row("" if row else panel, *_cells(report, timing))
        table.add_section()
    return table


def _cells(report: BenchReport, timing: Timing) -> tuple[str, ...]:
    speed_up = report.speed_up(timing)
    return (
        timing.name,
        "" if timing.rays is None else str(timing.rays),
        figure(timing.ms),
        figure(timing.p95_ms),
        str(timing.runs),
        "" if speed_up is None else f"{figure(speed_up)}x",
    )


def figure(value: float) -> str:
    """A number as tables show it: three digits, or all before the point."""
    for least, decimals in ((100.0, 0), (10.0, 1), (1.0, 2)):
        if value >= least:
            return f"{value:.{decimals}f}"
    return f"{value:.3f}"
