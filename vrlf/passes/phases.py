"""A sparse operator by phase: how it is sampled, its adjoint, and the table that is read.

A phase is the place in its cell where a pixel's chief ray crosses the array. Rows are sampled
at the corners of a grid over the cell, N x N of them (the cell's opposite borders are the
same phase), and read bilinearly: a row changes smoothly with its phase, because a retinal
pixel has an area.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.lattice import Lattice, is_open, nearest_cell
from vrlf.optics.polynomial import Float
from vrlf.optics.raster import cells_per_pixel, pixels_per_cell
from vrlf.optics.samples import ray_tables
from vrlf.optics.subpixels import layout
from vrlf.optics.viewport import SIDES, Side, pitch_mm

Ints = NDArray[np.int64]
# Panel pixels that a ray's landing may move from one sampled phase to the next: this many where
# a row holds few pixels, and more where its light is spread and a row changes less.
_STEP_PX, _FEW_PIXELS = 0.15, 25
_FEWEST, _MOST = 32, 128
# Where a row holds so many pixels it hardly differs from its neighbours, and the nearest phase
# serves: an entry is then 12 bytes, not 32, and a row holds no more than it sees. Measured
# (astronaut, converged, dB below the bilinear table of 32 phases) with 32, 64, 96 nearest:
# thesis's array 0.02, 0.01, 0.02; Table 8.1 0.06, 0.00, 0.00; but matched-microlens, 11 pixels,
# 5.8, 2.3, 1.0 below its 85 bilinear ones.
_MANY_PIXELS = 75
# What one eye's table may cost, and what a row needs at least and can use at most.
_RAYS_AN_EYE = 1 << 24
_FEWEST_RAYS, _MOST_RAYS = 1024, 8192
# Entries that are turned about, or put side by side, in a piece of work: 2 to 5 ms.
_BAND_ENTRIES = 1 << 14
_CORNERS = ((0, 0), (1, 0), (0, 1), (1, 1))  # right, down


@dataclass(frozen=True)
class Sampling:
    """How a rig's rows are sampled and read.

    Attributes
    ----------
    phases : (left, right)
        Along each side of a cell.
    is_nearest : bool
        Whether the nearest phase is read, not the four around.
    """

    phases: tuple[int, int]
    is_nearest: bool


def sampling_of(rig: Rig, lattice: Lattice | None) -> Sampling:
    """The coarsest sampling that keeps a row's error below its quadrature's.

    What a lenslet shows moves g / f cells while the crossing moves one; what a hole shows, or
    the edges between lenslets, about one. A bare panel has one phase.
    """
    if lattice is None:
        return Sampling((1, 1), is_nearest=True)
    seen = [_pixels_seen(rig, side, lattice) for side in SIDES]
    is_nearest = min(seen) >= _MANY_PIXELS
    left, right = (_phases_a_side(rig, lattice, each, is_nearest) for each in seen)
    return Sampling((left, right), is_nearest)


def _phases_a_side(rig: Rig, lattice: Lattice, seen: int, is_nearest: bool) -> int:
    moved_px = max(lattice.bend, 1.0) * lattice.pitch_mm / pitch_mm(rig)
    step_px = _STEP_PX * sqrt(max(1.0, seen / _FEW_PIXELS))
    phases = int(np.clip(ceil(moved_px / step_px), _FEWEST, _MOST))
    return phases + phases // 2 if is_nearest else phases


def _pixels_seen(rig: Rig, side: Side, lattice: Lattice) -> int:
    """How many panel pixels the pupil shows of the retinal pixel in the middle of a cell."""
    table = ray_tables(rig, side, _FEWEST_RAYS)[0]
    within = table.within_pixel
    moved = bench_of(rig).array_from_panel * within @ table.cells_per_px.T
    crossing = table.array_cells + moved
    in_cell = crossing - nearest_cell(crossing)
    open_rays = is_open(lattice, in_cell)
    bent = lattice.bend * in_cell @ pixels_per_cell(rig, lattice).T
    landing = table.landing_px + within - bent
    return len(np.unique(np.rint(landing[open_rays]), axis=0))


def table_rays(rows: int, colours: int) -> int:
    """How many rays each row is made of: few rows leave time for many.

    ``colours`` is how many of them are traced, 1 or 3.
    """
    rays = _RAYS_AN_EYE // (rows * colours)
    return int(np.clip(rays, _FEWEST_RAYS, _MOST_RAYS))


@dataclass(frozen=True)
class Rows:
    """Entries of many rows, none twice, in the order of their rows.

    Attributes
    ----------
    row : ndarray of int64 (n,)
        A phase (line times N plus column), or a pixel of a viewport (likewise).
    offsets : ndarray of int64 (n, 2)
        To the pixel that is read, right and down.
    weights : ndarray of float32 (n, 3)
        Of each colour.
    """

    row: Ints
    offsets: Ints
    weights: NDArray[np.float32]

    def take(self, kept: NDArray[Any] | slice) -> Rows:
        """Some of the entries."""
        return Rows(self.row[kept], self.offsets[kept], self.weights[kept])


def joined(parts: Sequence[Rows]) -> Rows:
    """All parts' entries, one part after the other."""
    return Rows(
        np.concatenate([part.row for part in parts]),
        np.concatenate([part.offsets for part in parts]),
        np.concatenate([part.weights for part in parts]),
    )


@dataclass(frozen=True)
class PatchRows:
    """Rows of patches: the r-th has the entries ``starts[r]`` to ``starts[r + 1]``.

    Attributes
    ----------
    starts : ndarray of int64 (patches + 1,)
    offsets : ndarray of int64 (n, 2)
    weights : ndarray of float32 (n, 3, 4)
        Of each colour at each corner: upper left, upper right, lower left, lower right.
    """

    starts: Ints
    offsets: Ints
    weights: NDArray[np.float32]


def bands(lines: int, entries: int) -> list[range]:
    """The lines of a cell, or of a viewport, in bands that take a few milliseconds each."""
    step = max(1, lines * _BAND_ENTRIES // max(1, entries))
    return [range(first, min(first + step, lines)) for first in range(0, lines, step)]


def phases_per_offset(rig: Rig, lattice: Lattice | None, phases: int) -> Float:
    """How many phases (right, down) lie between a pixel and its neighbours; shape (2, 2)."""
    if lattice is None:
        return np.zeros((2, 2))
    return bench_of(rig).array_from_panel * cells_per_pixel(rig, lattice) * phases


class Turning:
    """The adjoint's rows: each entry at the phase of the pixel that it reads, turned about.

    That phase lies between sampled ones; the entry is shared among the four around it, or
    goes to the nearest.
    """

    def __init__(
        self, rows: Rows, per_offset: Float, phases: int, *, is_nearest: bool = False
    ) -> None:
        self._rows, self._phases = rows, phases
        self._corners = _CORNERS[:1] if is_nearest else _CORNERS
        moved = rows.offsets @ per_offset.T
        if is_nearest:
            moved = np.rint(moved)
        low = np.floor(moved)
        self._between = moved - low
        self._column = (rows.row % phases + low[:, 0].astype(np.int64)) % phases
        self._line = (rows.row // phases + low[:, 1].astype(np.int64)) % phases

    def lines(self, band: range) -> Rows:
        """The rows of some lines of phases."""
        n, parts = self._phases, []
        for dx, dy in self._corners:
            line = (self._line + dy) % n
            kept = np.flatnonzero((line >= band.start) & (line < band.stop))
            right, down = self._between[kept].T
            share = (right if dx else 1.0 - right) * (down if dy else 1.0 - down)
            place = line[kept] * n + (self._column[kept] + dx) % n
            weights = (self._rows.weights[kept] * share[:, None]).astype(np.float32)
            parts.append(Rows(place, -self._rows.offsets[kept], weights))
        return _merged(joined(parts))


def _merged(rows: Rows) -> Rows:
    """Equal rows and offsets added together, in order."""
    order, first = _grouped(rows.row, rows.offsets)
    begins = np.flatnonzero(first)
    kept = order[begins]
    if not len(kept):
        return rows
    weights = np.add.reduceat(rows.weights[order], begins, axis=0)
    return Rows(rows.row[kept], rows.offsets[kept], weights)


def patched(rows: Rows, phases: int, band: range | None = None) -> PatchRows:
    """Each entry in the four patches that its phase is a corner of; of some lines or all."""
    band = range(phases) if band is None else band
    edges = np.searchsorted(rows.row, np.arange(phases + 1) * phases)
    kept, patch, corner = [], [], []
    for number, (dx, dy) in enumerate(_CORNERS):
        for line in band:
            source = (line + dy) % phases
            here = np.arange(edges[source], edges[source + 1])
            kept.append(here)
            column = (rows.row[here] - dx) % phases
            patch.append((line - band.start) * phases + column)
            corner.append(np.full(len(here), number))
    return _patches(
        rows.take(np.concatenate(kept)),
        np.concatenate(patch),
        np.concatenate(corner),
        len(band) * phases,
    )


def _patches(rows: Rows, patch: Ints, corner: Ints, count: int) -> PatchRows:
    """Entries of equal patch and offset side by side, a corner each."""
    order, first = _grouped(patch, rows.offsets)
    entry = np.cumsum(first) - 1
    weights = np.zeros((int(first.sum()), 3, 4), np.float32)
    weights[entry, :, corner[order]] = rows.weights[order]
    kept = order[first]
    return PatchRows(
        np.searchsorted(patch[kept], np.arange(count + 1)), rows.offsets[kept], weights
    )


def packed_offsets(offsets: Ints) -> NDArray[np.uint32]:
    """Right in the lower half of a word, down in the upper."""
    return offsets.astype(np.int16).view(np.uint32)[:, 0]


def colours_apart(rig: Rig) -> bool:
    """Whether colours differ in their weights: on stripes, or in a chromatic eye."""
    boxes = layout(rig.panel.subpixels).rectangles
    if np.any(boxes != boxes[0]):
        return True
    return any(eye_optics(rig, side).is_chromatic for side in SIDES)


def packed(rows: PatchRows, apart: bool) -> NDArray[np.uint32]:
    """Entries as the shader unpacks them: two 16-bit offsets, then half floats.

    Twelve halves, (n, 8) words, where colours stand apart; four, (n, 4), where they don't.
    """
    count = 12 if apart else 4
    words = np.zeros((len(rows.offsets), 8 if apart else 4), np.uint32)
    halves = rows.weights.astype(np.float16).reshape(-1, 12)[:, :count]
    words[:, 0] = packed_offsets(rows.offsets)
    words[:, 1 : 1 + count // 2] = np.ascontiguousarray(halves).view(np.uint32)
    return words


def _grouped(place: Ints, offsets: Ints) -> tuple[Ints, NDArray[np.bool_]]:
    """An order that brings equal places and offsets together, and where each group begins."""
    low = offsets.min(axis=0, initial=0)
    width, height = offsets.max(axis=0, initial=0) - low + 1
    key = (place * height + offsets[:, 1] - low[1]) * width + offsets[:, 0] - low[0]
    order = np.argsort(key, kind="stable")
    return order, np.diff(key[order], prepend=-1) != 0
