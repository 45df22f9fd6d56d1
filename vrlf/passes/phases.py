"""A sparse operator by phase: how it is sampled, its adjoint, and the table that is read.

A phase is the place in its cell where a pixel's chief ray crosses the array. Rows are sampled
on a grid over the cell, N x N of them (the cell's opposite borders are the same phase), and the
nearest one is read. Where a layout's emission has a period of several pixels, each place of it has
rows by phase of its own, one place's after the other's.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from math import ceil, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.model import Rig
from vrlf.optics.bench import bench_of, colour_benches, widest_bend
from vrlf.optics.lattice import Lattice, is_open, nearest_cell
from vrlf.optics.polynomial import Float
from vrlf.optics.raster import cells_per_pixel, pixels_per_cell
from vrlf.optics.samples import ray_tables
from vrlf.optics.viewport import SIDES, Side, pitch_mm

Ints = NDArray[np.int64]
# Panel pixels that a ray's landing may move from one sampled phase to the next: this many where
# a row holds few pixels, and more where its light is spread and a row changes less. Measured
# (440 x 220, astronaut and coffee, dB below 85 phases read bilinearly after 16 steps):
# matched-microlens with 128, 192, 256 phases 0.2, 0.06, 0.02; matched-wide with 192, 256
# 0.02, 0.00; thesis's array (32 bilinear ones) with 32, 64, 96 0.02, 0.01, 0.02.
_STEP_PX, _FEW_PIXELS = 0.06, 25
_FEWEST, _MOST = 48, 256
# What one eye's table may cost, and what a row needs at least and can use at most. Of 256 phases
# 1024 rays a row lose 0.02 dB against 2048, 512 0.06, 256 0.15.
_RAYS_AN_EYE = 1 << 25
_FEWEST_RAYS, _MOST_RAYS = 512, 8192
# Makes an offset a positive number of 16 bits.
_MIDDLE = 1 << 15
# Entries that are turned about in a piece of work: 2 to 5 ms.
_BAND_ENTRIES = 1 << 14


def sampling_of(rig: Rig, lattice: Lattice | None) -> tuple[int, int]:
    """Phases along each side of a cell, of the left and the right eye: as few as lose little.

    What a lenslet shows moves g / f cells while the crossing moves one; what a hole shows, or
    the edges between lenslets, about one. A bare panel has one phase.
    """
    if lattice is None:
        return 1, 1
    left, right = (_phases_a_side(rig, lattice, _pixels_seen(rig, s, lattice)) for s in SIDES)
    return left, right


def _phases_a_side(rig: Rig, lattice: Lattice, seen: int) -> int:
    moved_px = max(widest_bend(rig), 1.0) * lattice.pitch_mm / pitch_mm(rig)
    # What a hole shows is as sharp as the hole, however many others are seen.
    spread = 1.0 if lattice.kind == "pinhole" else sqrt(max(1.0, seen / _FEW_PIXELS))
    step_px = _STEP_PX * spread
    return int(np.clip(ceil(moved_px / step_px), _FEWEST, _MOST))


def _pixels_seen(rig: Rig, side: Side, lattice: Lattice) -> int:
    """How many panel pixels the pupil shows of the retinal pixel in the middle of a cell."""
    table = ray_tables(rig, side, _FEWEST_RAYS)[0]
    crossing = table.array_cells + table.within_cells
    in_cell = crossing - nearest_cell(lattice, crossing)
    open_rays = is_open(lattice, in_cell)
    bent = colour_benches(rig)[0].bend * in_cell @ pixels_per_cell(rig, lattice).T
    landing = table.landing_px + table.within_landing_px - bent
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
        A phase (line times N plus column; N N of them for each place of a layout's period), or
        a pixel of a viewport (likewise).
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

    def between(self, rows: range) -> Rows:
        """The entries of some rows, of which there are none between."""
        first, end = np.searchsorted(self.row, (rows.start, rows.stop))
        return self.take(slice(int(first), int(end)))


def joined(parts: Sequence[Rows]) -> Rows:
    """All parts' entries, one part after the other."""
    return Rows(
        np.concatenate([part.row for part in parts]),
        np.concatenate([part.offsets for part in parts]),
        np.concatenate([part.weights for part in parts]),
    )


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

    That phase lies between sampled ones; the entry goes to the nearest. Which place of the
    layout's ``period`` (columns, rows) the pixel has is known.
    """

    def __init__(self, per_offset: Float, phases: int, period: tuple[int, int] = (1, 1)) -> None:
        self._per_offset, self._phases, self._period = per_offset, phases, period
        self._keys: list[Ints] = []
        self._weights: list[NDArray[np.float32]] = []

    def take(self, rows: Rows) -> None:
        """More rows of the operator."""
        n, moved = self._phases, np.rint(rows.offsets @ self._per_offset.T).astype(np.int64)
        line, column = rows.row // n + moved[:, 1], rows.row % n + moved[:, 0]
        # One number that sorts by row, then as its pixels lie on the panel.
        place, back = line % n * n + column % n, _MIDDLE - rows.offsets
        if self._period != (1, 1):
            place += self._place_read(rows) * n * n
        self._keys.append((place << 32) | (back[:, 1] << 16) | back[:, 0])
        self._weights.append(rows.weights)

    def _place_read(self, rows: Rows) -> Ints:
        """Which place of the period the pixels have that are read."""
        columns, lines = self._period
        own = rows.row // self._phases**2
        right = (own % columns + rows.offsets[:, 0]) % columns
        return np.asarray((own // columns + rows.offsets[:, 1]) % lines * columns + right)

    def join(self) -> Generator[None, None, int]:
        """End taking; the number of entries."""
        self._keys = [np.concatenate(self._keys)]
        yield
        self._weights = [np.concatenate(self._weights)]
        return len(self._keys[0])

    def lines(self, band: range) -> Rows:
        """The rows of some lines of phases, each in the order of its pixels on the panel."""
        (keys,), (weights,) = self._keys, self._weights
        low, high = ((line * self._phases) << 32 for line in (band.start, band.stop))
        kept = np.flatnonzero((keys >= low) & (keys < high))
        kept = kept[np.argsort(keys[kept])]
        found = keys[kept]
        offsets = np.stack([found & 0xFFFF, (found >> 16) & 0xFFFF], axis=-1) - _MIDDLE
        return Rows(found >> 32, offsets, weights[kept])


# The bit of an offset to the right that turns an entry's sign, where a table has signs; so far to
# the right or left no entry reads.
SIGN_BIT = 15
_FARTHEST_RANGE = 1 << SIGN_BIT


def signed(rows: Rows) -> Rows:
    """Entries of both signs as entries of none, the sign in `SIGN_BIT` of the offset.

    An entry whose colours differ in sign becomes two.
    """
    parts = []
    for negative in (0, 1):
        weights = np.maximum(-rows.weights if negative else rows.weights, np.float32(0.0))
        kept = weights.max(axis=1) > 0.0
        right = (rows.offsets[kept, 0] % _FARTHEST_RANGE) | (negative << SIGN_BIT)
        # As a 16-bit number with a sign, which is what is packed.
        right = np.where(right >= 1 << 15, right - (1 << 16), right)
        offsets = np.stack([right, rows.offsets[kept, 1]], axis=-1)
        parts.append(Rows(rows.row[kept], offsets, weights[kept]))
    both = joined(parts)
    return both.take(np.argsort(both.row, kind="stable"))


def packed(rows: Rows) -> NDArray[np.uint32]:
    """Entries as the shader unpacks them, (n, 2) words.

    First the offset, right in the lower half of the word, down in the upper; then the weights
    as RGB9E5 (EXT_texture_shared_exponent): nine bits a colour, relative to the largest.
    """
    words = np.empty((len(rows.row), 2), np.uint32)
    words[:, 0] = rows.offsets.astype(np.int16).view(np.uint32)[:, 0]
    words[:, 1] = shared_exponent(rows.weights)
    return words


def shared_exponent(colours: NDArray[np.float32]) -> NDArray[np.uint32]:
    """Three numbers from 0 to 65408 as one word; what is below 2^-25 becomes 0."""
    _, exponent = np.frexp(colours.max(axis=1))
    biased = np.maximum(exponent, -15) + 15
    scale = np.ldexp(1.0, 24 - biased)
    # The largest may round up to the next power of two.
    biased += np.rint(colours.max(axis=1) * scale) == 512
    scale = np.ldexp(1.0, 24 - biased)
    words: NDArray[np.uint32] = biased.astype(np.uint32) << 27
    for place, colour in enumerate(colours.T):
        words |= np.rint(colour * scale).astype(np.uint32) << 9 * place
    return words
