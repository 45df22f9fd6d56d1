"""How good each frame of a moving picture is, solved from the last frame or from the start.

Frame after frame of a still, of pans and of a cut is prefiltered with a few steps, perceived
with a quadrature of its own and compared with what it should be. A pan moves by fractions of a
pixel, and each frame of it is the exact area mean of the picture: nothing but the solver makes
one frame worse than the next.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from math import inf
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from rich import box
from rich.table import Table

from vrlf.errors import InputError
from vrlf.evaluation.measure import border_px, likeness
from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.optics.viewport import SIDES, viewport
from vrlf.passes import Perceive, PerceiveTables
from vrlf.renderer import Image, check_rays, exposure_factor
from vrlf.solve import Memory, Optimal, OptimalTables

FRAMES: Final = 12
STEPS: Final = (1, 2, 4)
JUDGING_RAYS: Final = 256
# The right eye sees another part of the picture.
_PARALLAX_PX: Final = 37.0
# More picture than a viewport shows, so that a pan meets something new.
_WIDER: Final = 1.4
Start = Literal["cold", "warm"]


@dataclass(frozen=True)
class Motion:
    """What the picture does: moves by so much a frame, or gives way to another half-way."""

    name: str
    px_per_frame: tuple[float, float] = (0.0, 0.0)
    is_cut: bool = False


MOTIONS: Final = (
    Motion("still"),
    Motion("drift 0.3 px", (0.25, 0.17)),
    Motion("pan 1.4 px", (1.2, -0.7)),
    Motion("pan 10 px", (9.1, 4.3)),
    Motion("cut", is_cut=True),
)


@dataclass(frozen=True)
class Frames:
    """One rig, motion, number of steps and way to start.

    Attributes
    ----------
    start : "cold" or "warm"
        Each frame from nothing, or from the last one.
    psnr_db : tuple of float
        Frame by frame, of the worse eye.
    flicker_db : float
        How still the error stands from one frame to the next: the PSNR of its change, the mean
        over all but the frame of a cut; infinite where nothing changes.
    """

    rig: str
    motion: str
    steps: int
    start: Start
    psnr_db: tuple[float, ...]
    flicker_db: float


@dataclass(frozen=True)
class FramesReport:
    """All results, in the order in which they were measured."""

    device: str
    rays: int
    results: tuple[Frames, ...]

    def to_json(self) -> dict[str, Any]:
        """For ``vrlf bench frames --json``; an infinite figure is null there."""
        results = [asdict(each) for each in self.results]
        for each in results:
            each["psnr_db"] = [_finite(db) for db in each["psnr_db"]]
            each["flicker_db"] = _finite(each["flicker_db"])
        return {"device": self.device, "rays": self.rays, "results": results}


def _finite(db: float) -> float | None:
    return db if np.isfinite(db) else None


def run_frames(
    device: Device,
    rigs: Mapping[str, Rig],
    pictures: tuple[Image, Image],
    *,
    motions: Sequence[Motion] = MOTIONS,
    steps: Sequence[int] = STEPS,
    frames: int = FRAMES,
    rays: int = JUDGING_RAYS,
    progress: Callable[[str], None] | None = None,
) -> FramesReport:
    """Measure each motion with each number of steps a frame, cold and warm.

    Parameters
    ----------
    pictures : pair of ndarray (H, W, 3)
        Linear light of any size: what is shown, and what a cut goes over to.

    Raises
    ------
    InputError
        If a viewport is all border, or a number means nothing.
    """
    check_rays(rays)
    if frames < 2:
        raise InputError(f"frames: found {frames}, wanted 2 or more")
    if any(count < 0 for count in steps):
        raise InputError(f"steps: found {min(steps)}, wanted 0 or more")
    results: list[Frames] = []
    for name, rig in rigs.items():
        with ExitStack() as by:
            bench = _Bench(device, rig, rays, by)
            for motion in motions:
                targets = list(moving(rig, pictures, motion, frames))
                for count in steps:
                    if progress is not None:
                        progress(f"{name}: {motion.name}, {count} steps a frame")
                    for start in ("cold", "warm"):
                        psnr_db, flicker_db = bench.measured(targets, count, start, motion.is_cut)
                        results.append(Frames(name, motion.name, count, start, psnr_db, flicker_db))
    return FramesReport(device.info.renderer, rays, tuple(results))


class _Bench:
    """Programs, tables and pictures of one rig, all released with ``by``."""

    def __init__(self, device: Device, rig: Rig, rays: int, by: ExitStack) -> None:
        def owned(item: Any) -> Any:
            by.callback(item.release)
            return item

        self._rig, size = rig, (rig.panel.width_px, rig.panel.height_px)
        self._optimal, self._perceive = owned(Optimal(device)), owned(Perceive(device))
        self._tables = owned(OptimalTables(device, rig, self._optimal.builder))
        self._rays = owned(PerceiveTables(device, rig, rays))
        self._memory = owned(Memory(device))
        names = ("target", "panel image", "perceived image")
        self._target, self._shown, self._seen = (
            owned(Texture(device, size, label=name)) for name in names
        )

    def measured(
        self, targets: Sequence[Image], steps: int, start: Start, is_cut: bool
    ) -> tuple[tuple[float, ...], float]:
        """PSNR frame by frame, and how still the error stands."""
        self._memory.forget()
        psnr_db, changes, last = [], [], None
        for number, target in enumerate(targets):
            if start == "cold":
                self._memory.forget()
            seen = self._frame(target, steps)
            alike = [likeness(seen, target, self._rig, side).psnr_db for side in SIDES]
            psnr_db.append(min(alike))
            error = self._inner(seen - target)
            if last is not None and not (is_cut and number == len(targets) // 2):
                changes.append(float(np.mean((error - last) ** 2)))
            last = error
        change = float(np.mean(changes)) if changes else 0.0
        return tuple(psnr_db), inf if change == 0.0 else float(-10.0 * np.log10(change))

    def _frame(self, target: Image, steps: int) -> Image:
        self._target.write(target)
        self._optimal.frame(self._memory, self._tables, self._target, self._shown, steps=steps)
        exposure = exposure_factor(self._rig, "auto")
        self._perceive.run(self._rays, self._shown, self._seen, exposure=exposure)
        return np.ascontiguousarray(self._seen.read()[..., :3], dtype=np.float32)

    def _inner(self, error: Image) -> NDArray[np.float64]:
        """What lies inside the border of both eyes."""
        parts = []
        for side in SIDES:
            view, border = viewport(self._rig, side), border_px(self._rig, side)
            half = error[border : view.height_px - border, view.columns]
            parts.append(half[:, border : view.width_px - border].astype(np.float64).ravel())
        return np.concatenate(parts)


def moving(rig: Rig, pictures: tuple[Image, Image], motion: Motion, frames: int) -> Iterator[Image]:
    """The targets of a motion, (H, W, 3) on the panel's raster."""
    for number in range(frames):
        picture = pictures[int(motion.is_cut and number >= frames // 2)]
        target = np.zeros((rig.panel.height_px, rig.panel.width_px, 3), np.float32)
        for eye, side in enumerate(SIDES):
            view = viewport(rig, side)
            x, y = (number * step for step in motion.px_per_frame)
            size = (view.width_px, view.height_px)
            target[:, view.columns] = part_of(picture, size, (x + eye * _PARALLAX_PX, y))
        yield target


def part_of(picture: Image, size_px: tuple[int, int], at_px: tuple[float, float]) -> Image:
    """A part of a picture, each pixel the exact mean over its area; beyond its edges, mirrored.

    Parameters
    ----------
    size_px : (width, height)
        Of the part; the picture is as much larger as ``_WIDER`` says.
    at_px : (x, y)
        Where the part begins, in its own pixels.
    """
    samples_per_px = min(picture.shape[1] / size_px[0], picture.shape[0] / size_px[1]) / _WIDER
    part = picture.astype(np.float64)
    for axis, (count, at) in enumerate(zip(size_px, at_px, strict=True)):
        edges = (at + np.arange(count + 1)) * samples_per_px
        part = _means(part, edges, 1 - axis)
    return part.astype(np.float32)


def _means(values: NDArray[np.float64], edges: NDArray[np.float64], axis: int) -> Any:
    """Means between edges along an axis of samples that repeat, mirrored."""
    along = np.moveaxis(values, axis, 0)
    both = np.concatenate([along, along[::-1]])
    sums = np.concatenate([np.zeros_like(both[:1]), np.cumsum(both, axis=0)])
    turns, rest = np.divmod(edges, len(both))
    low = np.minimum(rest.astype(int), len(both) - 1)
    share = (rest - low)[:, None, None]
    until = turns[:, None, None] * sums[-1] + (1.0 - share) * sums[low] + share * sums[low + 1]
    return np.moveaxis(np.diff(until, axis=0) / np.diff(edges)[:, None, None], 0, axis)


def frames_table(report: FramesReport) -> Table:
    """A row for each rig, motion, steps and start; PSNR of some frames, and the flicker."""
    title = f"PSNR in dB by frame number, the worse eye; {report.device}"
    table = Table(title=title, box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for heading in ("rig", "motion", "steps", "start"):
        table.add_column(heading)
    count = max((len(each.psnr_db) for each in report.results), default=0)
    shown = sorted({0, 1, 3, count // 2, count // 2 + 1, count - 1} & set(range(count)))
    for number in shown:
        table.add_column(str(number + 1), justify="right")
    table.add_column("flicker", justify="right")
    for each in report.results:
        cells = [f"{each.psnr_db[number]:.1f}" for number in shown]
        flicker = "none" if each.flicker_db == inf else f"{each.flicker_db:.1f}"
        table.add_row(each.rig, each.motion, str(each.steps), each.start, *cells, flicker)
    return table
