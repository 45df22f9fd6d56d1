"""Time against size: every pass and whole frames, from a quarter of a megapixel to 33.

A panel's size is the same headset with finer pixels (``resized``), one at a time; what one
size took is given back before the next. Beside each time stands the least that any
implementation could take on this device: its bytes at the speed of a plain copy, or its texels
at the speed of fetches from the nearest cache, whichever is longer (``limits``, ``workloads``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from itertools import groupby
from pathlib import Path
from typing import Any, Final

from rich import box
from rich.table import Table

from vrlf.errors import DeviceError, InputError
from vrlf.gpu import Device
from vrlf.model import DEFAULT_RIG, Rig, load_rig
from vrlf.renderer import check_rays
from vrlf.studies.bench import Schedule, SizePx, Timing, figure, resized
from vrlf.studies.limits import Limits, measured_limits
from vrlf.studies.steps import Step
from vrlf.studies.workloads import GROUPS, Stage, Tools, stage_of, tools_of

SIZES_PX: Final[tuple[SizePx, ...]] = (
    (667, 375),
    (1334, 750),
    (1920, 1080),
    (2560, 1440),
    (3840, 2160),
    (7680, 4320),
)
# What software GL does in some minutes.
SOFTWARE_MEGAPIXELS: Final = 1.1
# Of one step at one size: software GL needs as long for a single solve, which is then run once.
_STEP_S: Final = 3.0


@dataclass(frozen=True)
class Speed:
    """How long one step took at one size, and how that compares with the device's limit.

    Attributes
    ----------
    timing : Timing
        Its ``ms`` is the median.
    megapixels : float
    least_ms : float or None
        What the least bytes and fetches take at the device's best; None where tables are made.
    bound_by : "copy", "fetch" or None
        Which of the two is the longer.
    """

    timing: Timing
    megapixels: float
    least_ms: float | None
    bound_by: str | None

    @property
    def ns_per_px(self) -> float:
        """Nanoseconds for each pixel of the panel."""
        return self.timing.ms / self.megapixels

    @property
    def share_of_limit(self) -> float | None:
        """1 where nothing could be faster."""
        if self.least_ms is None or self.timing.ms <= 0.0:
            return None
        return self.least_ms / self.timing.ms

    def to_json(self) -> dict[str, Any]:
        """One of the report's ``results``."""
        return {
            **asdict(self.timing),
            "megapixels": self.megapixels,
            "ns_per_px": self.ns_per_px,
            "least_ms": self.least_ms,
            "bound_by": self.bound_by,
            "share_of_limit": self.share_of_limit,
        }


@dataclass(frozen=True)
class SpeedReport:
    """The device, its limits, all timings in their order, and what was left out and why."""

    device: str
    limits: Limits
    results: tuple[Speed, ...]
    left_out: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """For ``vrlf bench speed --json``."""
        return {
            "device": self.device,
            "limits": asdict(self.limits),
            "results": [each.to_json() for each in self.results],
            "left_out": list(self.left_out),
        }


def default_megapixels(device: Device) -> float | None:
    """The largest panel that is measured unless more is asked for; None on a GPU: all."""
    return SOFTWARE_MEGAPIXELS if device.info.is_software else None


def run_speed(
    device: Device,
    *,
    rig: str | Path | Rig = DEFAULT_RIG,
    sizes: Sequence[SizePx] = SIZES_PX,
    max_megapixels: float | None = None,
    rays: int = 64,
    runs: int = 9,
    progress: Callable[[str], None] | None = None,
) -> SpeedReport:
    """Time every pass and whole frames at every panel size, the smallest first.

    Parameters
    ----------
    device : Device
        It is left as it was found.
    rig : str, Path or Rig
        As for ``load_rig``.
    sizes : sequence of (width, height)
        In pixels.
    max_megapixels : float, optional
        Larger sizes are left out.
    rays : int
        Rays for each retinal pixel in ``perceive``.
    runs : int
        Timed runs of each step at most; fewer where they take long, one where it takes seconds.
    progress : callable, optional
        Is told of each timing, and of each size that does not fit, in a line.

    Raises
    ------
    InputError
        If no size is left, or a number means nothing.
    RigError
        If there is no such rig, or a panel cannot have such a size.
    """
    given = rig if isinstance(rig, Rig) else load_rig(rig)
    check_rays(rays)
    if runs < 1:
        raise InputError(f"runs: found {runs}, wanted a whole number of at least 1")
    rigs = [resized(given, size) for size in _within(sizes, max_megapixels)]
    device.make_current()
    say = progress or (lambda _: None)
    left_out: list[str] = []

    def leave_out(reason: str) -> None:
        left_out.append(reason)
        say(f"left out: {reason}")

    with ExitStack() as whole:
        limits = measured_limits(device)
        tools = tools_of(device, whole)
        schedule = Schedule(runs, _STEP_S, say, fewest=1)
        results = [
            speed
            for each in rigs
            for speed in _at_one_size(tools, each, rays, limits, schedule, leave_out)
        ]
    return SpeedReport(device.info.renderer, limits, tuple(results), tuple(left_out))


def _within(sizes: Sequence[SizePx], max_megapixels: float | None) -> list[SizePx]:
    """The sizes that are not too large, the smallest first, each once."""
    kept = [
        size
        for size in dict.fromkeys(sizes)
        if max_megapixels is None or size[0] * size[1] <= 1e6 * max_megapixels
    ]
    if not kept:
        smallest = min((w * h for w, h in sizes), default=0) / 1e6
        raise InputError(
            f"sizes: found none within {max_megapixels or 0:g} megapixels, wanted at least one "
            f"(the smallest has {smallest:.2g})"
        )
    return sorted(kept, key=lambda size: size[0] * size[1])


def _at_one_size(
    tools: Tools,
    rig: Rig,
    rays: int,
    limits: Limits,
    schedule: Schedule,
    leave_out: Callable[[str], None],
) -> Iterator[Speed]:
    """All groups of steps; one that the device has no room for is left out with its reason."""
    panel = f"{rig.panel.width_px}x{rig.panel.height_px}"
    with ExitStack() as at_this_size:
        try:
            tools.device.require_texture_size(rig.panel.width_px, rig.panel.height_px, "panel")
            stage = stage_of(tools, rig, rays, at_this_size)
        except (DeviceError, InputError) as error:
            leave_out(f"{panel}: {error}")
            return
        for group in GROUPS:
            with ExitStack() as by:
                try:
                    for step in group(stage, by):
                        yield from _timed(stage, step, limits, schedule)
                except (DeviceError, InputError) as error:
                    leave_out(f"{panel} {group.__name__.replace('_', ' ')}: {error}")


def _timed(stage: Stage, step: Step, limits: Limits, schedule: Schedule) -> Iterator[Speed]:
    copied = limits.least_ms(step.least_bytes)
    least = limits.least_ms(step.least_bytes, step.least_fetches)
    for timing in schedule.timings(stage.rig, [step]):
        yield Speed(
            timing,
            stage.pixels / 1e6,
            least if step.least_bytes else None,
            ("fetch" if least > copied else "copy") if step.least_bytes else None,
        )


def speed_table(report: SpeedReport) -> Table:
    """The report for a terminal of 80 columns."""
    limits = report.limits
    table = Table(
        title=f"{report.device}: copies {figure(limits.copy_gb_per_s)} GB/s, fetches "
        f"{figure(limits.fetch_g_per_s)} G texels/s",
        caption="Both eyes. ms: median. limit: the share of the time that the least bytes at the "
        "speed of a copy, or the least fetches (f), would take.",
        box=box.SIMPLE_HEAD,
        show_edge=False,
        pad_edge=False,
    )
    for heading in ("panel", "step"):
        table.add_column(heading, no_wrap=True)
    for heading in ("ms", "p95 ms", "runs", "ns/px", "limit"):
        table.add_column(heading, justify="right", no_wrap=True)
    for panel, speeds in groupby(report.results, key=lambda each: each.timing.panel):
        for row, each in enumerate(speeds):
            table.add_row("" if row else panel, *_cells(each))
        table.add_section()
    return table


def _cells(each: Speed) -> tuple[str, ...]:
    share = each.share_of_limit
    mark = " f" if each.bound_by == "fetch" else ""
    return (
        each.timing.name,
        figure(each.timing.ms),
        figure(each.timing.p95_ms),
        str(each.timing.runs),
        figure(each.ns_per_px),
        "" if share is None else f"{figure(100.0 * share)} %{mark}",
    )
