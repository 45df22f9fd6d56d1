"""What an eye perceives of single points of the target, measured on a rig's own chain.

White pixels on black go through ``forward`` and perception on a small panel of the same rig,
so far apart that their light does not meet, at places spread over the array's cells. The chain
is linear, so their mean is the convolution that comes nearest to it; what they differ by is
the array's own noise. Without an array all places are alike, and one is enough, unless
neighbouring pixels emit differently.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from math import ceil, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.optics.bench import bench_of, widest_bend
from vrlf.optics.eye import eye_optics
from vrlf.optics.lateral import forward_changes
from vrlf.optics.lattice import lattice_of
from vrlf.optics.limits import barrier_field_mm
from vrlf.optics.polynomial import Float
from vrlf.optics.raster import half_cell_px, pixels_per_cell
from vrlf.optics.samples import ray_tables
from vrlf.optics.sequence import points
from vrlf.optics.subpixels import layout
from vrlf.optics.viewport import SIDES, pitch_mm
from vrlf.passes.forward import Forward, forward_tables
from vrlf.passes.perceive import Perceive
from vrlf.passes.rays import PerceiveTables

Light = NDArray[np.float32]

# Rays that a measured pixel's light is gathered from.
SPREAD_RAYS = 64
# Point spreads that are measured, about: they must meet an array's cells in many places.
_SPOTS = 64
# Width of the small panel's viewport, about; wide spreads take more.
_VIEW_PX = 224
# Light farther out than this is left out of account: a blur of 100 pixels has no detail.
_MOST_REACH_PX = 55
_MOST_JITTER_PX = 32
# Below this gain an eye sees nothing, and nothing can be sharpened.
_LEAST_GAIN = 1e-6


@dataclass(frozen=True)
class Spots:
    """Single white pixels on a small panel of the same rig, and where their light may arrive.

    Attributes
    ----------
    rig : Rig
        With the small panel.
    places : ndarray (shots, n, 2)
        Column and row of each, in either viewport.
    reach_px : int
        Light arrives at most this far from the place, moved by ``shift_px``.
    shift_px : ndarray (2, 2)
        Whole pixels right and down by which each eye sees the panel displaced, uncorrected.
    """

    rig: Rig
    places: NDArray[np.int_]
    reach_px: int
    shift_px: NDArray[np.int_]

    def target(self, shot: int) -> Light:
        """The small panel's target, black but for the spots."""
        width, height = self.rig.panel.width_px, self.rig.panel.height_px
        light = np.zeros((height, width, 3), np.float32)
        columns, rows = self.places[shot].T
        light[rows, columns] = light[rows, columns + width // 2] = 1.0
        return light

    def spreads(self, shot: int, seen: Light) -> Light:
        """What became of each spot, shape (n, 2, 3, side, side): eye, colour, row, column."""
        width, reach = self.rig.panel.width_px, self.reach_px
        cut = []
        for column, row in self.places[shot]:
            for eye, (right, down) in enumerate(self.shift_px):
                x, y = column + right - reach + eye * (width // 2), row + down - reach
                cut.append(seen[y : y + 2 * reach + 1, x : x + 2 * reach + 1])
        stacked = np.moveaxis(np.stack(cut), -1, 1)
        return stacked.reshape(len(self.places[shot]), 2, *stacked.shape[1:])


@dataclass(frozen=True)
class PointSpread:
    """What eyes see of a point, on the mean over the places that it may have in a cell.

    Attributes
    ----------
    mean : ndarray (2, 3, side, side)
        Eye, colour, row, column; sum 1.
    scatter : ndarray (2, 3)
        Energy of the spreads' deviations from their mean: noise, for a white target of energy 1.
    shift_px : ndarray (2, 2)
        Where its middle lies from the point, right and down, for each eye.
    """

    mean: Float
    scatter: Float
    shift_px: NDArray[np.int_]


def spots_of(rig: Rig) -> Spots:
    """Where to measure a rig's point spreads, the same in each call."""
    reach, shift = _reach_px(rig)
    # Without an array all places are alike, but for those of a layout's period.
    jitter, wanted = (0, 1) if layout(rig.panel.subpixels).places == 1 else (1, _SPOTS)
    lattice = lattice_of(rig)
    if lattice is not None:
        cell_px = float(np.linalg.norm(pixels_per_cell(rig, lattice), axis=0).max())
        jitter, wanted = min(_MOST_JITTER_PX, ceil(cell_px)), _SPOTS
    spacing, margin = 2 * reach + 1 + jitter, int(np.abs(shift).max())
    a_side = max(1, min(_VIEW_PX // spacing, ceil(sqrt(wanted))))
    shots = ceil(wanted / a_side**2)
    side = a_side * spacing + 2 * margin
    corners = np.indices((a_side, a_side)).reshape(2, -1).T * spacing
    moved = np.floor(points(shots * a_side**2)[:, :2] * (jitter + 1)).astype(int)
    places = corners + moved.reshape(shots, -1, 2) + reach + margin
    return Spots(_small(rig, side), _within_field(rig, places, side), reach, shift)


def _small(rig: Rig, side_px: int) -> Rig:
    """The rig with square viewports about both axes."""
    panel = rig.panel.model_copy(update={"width_px": 2 * side_px, "height_px": side_px})
    headset = rig.headset.model_copy(
        update={"lens_separation_mm": side_px * pitch_mm(rig), "lens_height_mm": 0.0}
    )
    return rig.model_copy(update={"panel": panel, "headset": headset})


def _reach_px(rig: Rig) -> tuple[int, NDArray[np.int_]]:
    """How far a point's light spreads, and by how much it is displaced.

    A pixel that the array shows through one place of the pupil may be seen through any other:
    its light then arrives as far off as the blur is wide, and half a lenslet's bend beside
    that. Without an array only half the blur counts, about its middle.
    """
    lattice = lattice_of(rig)
    landing = [
        np.concatenate([t.landing_px for t in ray_tables(rig, side, SPREAD_RAYS)]) for side in SIDES
    ]
    if lattice is None:
        shift = np.array([-np.rint(each.mean(axis=0)) for each in landing]).astype(int)
        spread = max(float(np.abs(p + s).max()) for p, s in zip(landing, shift, strict=True))
    else:
        shift = np.zeros((2, 2), int)
        widest = lattice.widest_pitch * half_cell_px(rig, lattice).max()
        bend_px = widest_bend(rig) * widest
        spread = max(float(np.ptp(each, axis=0).max()) for each in landing) + float(bend_px)
    return min(_MOST_REACH_PX, ceil(spread) + 2), shift


def _within_field(rig: Rig, places: NDArray[np.int_], side_px: int) -> NDArray[np.int_]:
    """Only the places of which perpendicular walls leave something to see; one at least."""
    lattice, bench = lattice_of(rig), bench_of(rig)
    if lattice is None or lattice.barriers != "perpendicular":
        return places
    field_mm = min(barrier_field_mm(bench, lattice, eye_optics(rig, side)) for side in SIDES)
    field_px = field_mm / abs(bench.array_from_panel) / pitch_mm(rig)
    off_px = np.abs(places - (side_px - 1) / 2.0).max(axis=(0, 2))
    kept = off_px <= max(field_px, float(off_px.min()))
    return places[:, kept]


def spread_of(spots: Spots, spreads: Light) -> PointSpread:
    """Mean and scatter of point spreads, shape (n, 2, 3, side, side)."""
    each = spreads.astype(np.float64)
    mean = each.mean(axis=0)
    energy = (each**2).sum(axis=(-1, -2)).mean(axis=0)
    scatter = (energy - (mean**2).sum(axis=(-1, -2))) * len(each) / max(1, len(each) - 1)
    gain = mean.sum(axis=(-1, -2))
    dark = gain < _LEAST_GAIN
    middle = np.zeros(mean.shape[-2:])
    middle[spots.reach_px, spots.reach_px] = 1.0
    gain = np.where(dark, 1.0, gain)
    mean = np.where(dark[..., None, None], middle, mean / gain[..., None, None])
    return PointSpread(mean, np.where(dark, 0.0, scatter / gain**2), spots.shift_px)


def point_spread(rig: Rig, chain: Callable[[Light, Rig], Light]) -> PointSpread:
    """The point spread of a rig's own forward prefilter and eyes.

    Parameters
    ----------
    chain : callable
        What is perceived of a target by the eyes of a rig; both (H, W, 3) on its panel.
    """
    spots = spots_of(rig)
    shots = range(len(spots.places))
    spreads = [spots.spreads(i, chain(spots.target(i), spots.rig)) for i in shots]
    return spread_of(spots, np.concatenate(spreads))


def spread_pieces(
    device: Device, rig: Rig, forward: Forward, perceive: Perceive
) -> Generator[None, None, PointSpread]:
    """Measure a rig's point spread on the GPU, resting after each shot."""
    spots = spots_of(rig)
    chain = _GpuChain(device, spots.rig, forward, perceive)
    spreads = []
    try:
        for shot in range(len(spots.places)):
            spreads.append(spots.spreads(shot, chain.seen(spots.target(shot))))
            yield
    finally:
        chain.release()
    return spread_of(spots, np.concatenate(spreads))


class _GpuChain:
    """Owns the small panel's tables and pictures while a rig is measured."""

    def __init__(self, device: Device, rig: Rig, forward: Forward, perceive: Perceive) -> None:
        self._forward, self._perceive = forward, perceive
        self._owned: list[Any] = []
        try:
            self._rays = self._own(PerceiveTables(device, rig, SPREAD_RAYS))
            self._cells = None
            if forward_changes(rig):
                self._cells = self._own(forward_tables(device, rig))
            size = (rig.panel.width_px, rig.panel.height_px)
            self._target, self._shown, self._seen = (
                self._own(Texture(device, size, label=f"measured {name}"))
                for name in ("target", "panel image", "view")
            )
        except BaseException:
            self.release()
            raise

    def _own(self, item: Any) -> Any:
        self._owned.append(item)
        return item

    def seen(self, target: Light) -> Light:
        """What is perceived of a target."""
        self._target.write(target)
        shown = self._target
        if self._cells is not None:
            shown = self._shown
            self._forward.run(self._cells, self._target, shown)
        self._perceive.run(self._rays, shown, self._seen)
        return np.ascontiguousarray(self._seen.read()[..., :3], dtype=np.float32)

    def release(self) -> None:
        """Give tables and pictures back."""
        for each in self._owned:
            each.release()
        self._owned.clear()
