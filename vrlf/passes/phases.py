"""A sparse operator by phase: its adjoint, and the table that the shaders read.

A phase is the place in its cell where a pixel's chief ray crosses the array. Rows are sampled
at the corners of a grid over the cell, N x N of them (the cell's opposite borders are the
same phase), and read bilinearly: a row changes smoothly with its phase, because a retinal
pixel has an area.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, sqrt

import numpy as np
from numpy.typing import NDArray

from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.lattice import Lattice, is_open, nearest_cell
from vrlf.optics.polynomial import Float
from vrlf.optics.raster import cells_per_pixel, pixels_per_cell
from vrlf.optics.samples import ray_tables
from vrlf.optics.viewport import Side, pitch_mm

Ints = NDArray[np.int64]
# Panel pixels that a ray's landing may move from one sampled phase to the next: this many where
# a row holds few pixels, and more where its light is spread and a row changes less.
_STEP_PX, _FEW_PIXELS = 0.15, 25
_FEWEST, _MOST = 32, 128
# What one eye's table may cost, and what a row needs at least and can use at most.
_RAYS_AN_EYE = 1 << 24
_FEWEST_RAYS, _MOST_RAYS = 1024, 8192
_CORNERS = ((0, 0), (1, 0), (0, 1), (1, 1))  # right, down


def phases_a_side(rig: Rig, side: Side, lattice: Lattice | None) -> int:
    """How many phases along each side of a cell keep a row's error below its quadrature's.

    What a lenslet shows moves g / f cells while the crossing moves one; what a hole shows, or
    the edges between lenslets, about one. A bare panel has one phase.
    """
    if lattice is None:
        return 1
    moved_px = max(lattice.bend, 1.0) * lattice.pitch_mm / pitch_mm(rig)
    step_px = _STEP_PX * sqrt(max(1.0, _pixels_seen(rig, side, lattice) / _FEW_PIXELS))
    return int(np.clip(ceil(moved_px / step_px), _FEWEST, _MOST))


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


def table_rays(phases: int, colours: int) -> int:
    """How many rays each row is made of: few phases leave time for many.

    ``colours`` is how many of them are traced, 1 or 3.
    """
    rays = _RAYS_AN_EYE // (phases**2 * colours)
    return int(np.clip(rays, _FEWEST_RAYS, _MOST_RAYS))


@dataclass(frozen=True)
class PhaseRows:
    """Entries of the rows of all sampled phases, none twice.

    Attributes
    ----------
    phase : ndarray of int64 (n,)
        Line times N plus column.
    offsets : ndarray of int64 (n, 2)
        To the pixel that is read, right and down.
    weights : ndarray of float32 (n, 3)
        Of each colour.
    """

    phase: Ints
    offsets: Ints
    weights: NDArray[np.float32]


@dataclass(frozen=True)
class PatchRows:
    """Rows of all patches: patch r has the entries ``starts[r]`` to ``starts[r + 1]``.

    Attributes
    ----------
    starts : ndarray of int64 (N * N + 1,)
    offsets : ndarray of int64 (n, 2)
    weights : ndarray of float32 (n, 3, 4)
        Of each colour at each corner: upper left, upper right, lower left, lower right.
    """

    starts: Ints
    offsets: Ints
    weights: NDArray[np.float32]


def phases_per_offset(rig: Rig, lattice: Lattice | None, phases: int) -> Float:
    """How many phases (right, down) lie between a pixel and its neighbours; shape (2, 2)."""
    if lattice is None:
        return np.zeros((2, 2))
    return bench_of(rig).array_from_panel * cells_per_pixel(rig, lattice) * phases


def transposed(rows: PhaseRows, per_offset: Float, phases: int) -> PhaseRows:
    """The adjoint's rows: each entry at the phase of the pixel that it reads, turned about.

    That phase lies between sampled ones; the entry is shared among the four around it.
    """
    moved = rows.offsets @ per_offset.T
    low = np.floor(moved).astype(np.int64)
    column, line = rows.phase % phases + low[:, 0], rows.phase // phases + low[:, 1]
    right, down = (moved - low).T
    parts = []
    for dx, dy in _CORNERS:
        share = (right if dx else 1.0 - right) * (down if dy else 1.0 - down)
        parts.append((_index(column + dx, line + dy, phases), rows.weights * share[:, None]))
    phase = np.concatenate([index for index, _ in parts])
    weights = np.concatenate([weight for _, weight in parts]).astype(np.float32)
    offsets = np.tile(-rows.offsets, (4, 1))
    order, first = _grouped(phase, offsets)
    begins = np.flatnonzero(first)
    kept = order[begins]
    return PhaseRows(phase[kept], offsets[kept], np.add.reduceat(weights[order], begins, axis=0))


def patched(rows: PhaseRows, phases: int) -> PatchRows:
    """Each entry in the four patches that its phase is a corner of."""
    column, line = rows.phase % phases, rows.phase // phases
    patch = np.concatenate([_index(column - dx, line - dy, phases) for dx, dy in _CORNERS])
    corner = np.repeat(np.arange(4), len(rows.phase))
    offsets = np.tile(rows.offsets, (4, 1))
    order, first = _grouped(patch, offsets)
    entry = np.cumsum(first) - 1
    weights = np.zeros((int(first.sum()), 3, 4), np.float32)
    weights[entry, :, corner[order]] = np.tile(rows.weights, (4, 1))[order]
    kept = order[first]
    starts = np.searchsorted(patch[kept], np.arange(phases**2 + 1))
    return PatchRows(starts, offsets[kept], weights)


def packed(rows: PatchRows) -> NDArray[np.uint32]:
    """Entries as the shader unpacks them, (n, 8): two 16-bit offsets, twelve half floats."""
    words = np.zeros((len(rows.offsets), 8), np.uint32)
    halves = np.ascontiguousarray(rows.weights, np.float16).reshape(-1, 12)
    words[:, 0] = rows.offsets.astype(np.int16).view(np.uint32)[:, 0]
    words[:, 1:7] = halves.view(np.uint32)
    return words


def _index(column: Ints, line: Ints, phases: int) -> Ints:
    return np.asarray((line % phases) * phases + column % phases)


def _grouped(place: Ints, offsets: Ints) -> tuple[Ints, NDArray[np.bool_]]:
    """An order that brings equal places and offsets together, and where each group begins."""
    low = offsets.min(axis=0, initial=0)
    width, height = offsets.max(axis=0, initial=0) - low + 1
    key = (place * height + offsets[:, 1] - low[1]) * width + offsets[:, 0] - low[0]
    order = np.argsort(key, kind="stable")
    return order, np.diff(key[order], prepend=-1) != 0
