"""Rows of the normal equations of many rigs at once, each a little off.

With P_k the operator of case k (``vrlf/optics/tolerance.py``), P their mean and t the target,

    sum_k w_k || P_k l - t ||^2  =  || P l - t ||^2 + l'V l + ...,  V = sum_k w_k P_k'P_k - P'P

so that down is P'(P l - t) + V l: the mean operator is solved as any other, and V, small and
symmetric, takes light from what the cases do not agree on. All three are tabulated by the place
in a cell where a pixel's own chief ray crosses the array. A step reads three tables, however many
cases there are. (P_k'P_k alone, in one table, would do too; but what its phases and its cut leave
out falsifies the picture itself, here it changes a small term.)

V has entries of both signs; one more bit of an entry's offset says which.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import closing
from dataclasses import replace
from math import isqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vrlf.model import Rig
from vrlf.optics.lattice import lattice_of
from vrlf.optics.polynomial import Float
from vrlf.optics.subpixels import layout
from vrlf.optics.tolerance import Case, cases_of
from vrlf.optics.viewport import Side
from vrlf.passes.phases import Ints, Rows, joined, phases_per_offset
from vrlf.passes.tabulate import RowBuilder, lit

# What is blurred over cases changes less from phase to phase than one case does.
MOST_PHASES = 80
# All cases' rays of a row together, about: each case alone may be noisy.
_RAYS, _FEWEST_RAYS = 4096, 128
# Products of two entries, and places of a window, in a piece of work: some 10 ms.
_PRODUCTS, _PIECE_PLACES = 1 << 18, 1 << 18
# What an eye's dense window of G may take; wide ones get fewer phases.
_WINDOW_BYTES, _PLACE_BYTES = 3 << 27, 12
_NEGLIGIBLE = 1e-6
# Entries of V below this share of a row's largest, in size, are left out.
_FAINT = 0.02
# How far rows reach is tried with so few of them; others reach a little farther.
_TRIAL_PHASES, _TRIAL_MARGIN_PX = 6, 2


class TolerantRows(NamedTuple):
    """Rows by phase of a pixel: P of a retinal one, P' and V of a panel pixel."""

    mean: Rows
    adjoint: Rows
    variance: Rows


class Spread(NamedTuple):
    """How far any case's rows read from their own pixel, and how far apart; (right, down)."""

    reach_px: Ints
    apart_px: Ints


def spread_of_cases(
    rig: Rig, side: Side, builder: RowBuilder, view_px: tuple[int, int]
) -> Generator[None, None, Spread]:
    """From a few rows of each case."""
    reach, apart = np.zeros(2, np.int64), np.zeros(2, np.int64)
    for case in cases_of(rig):
        rows = builder.rows(case.rig, side, _TRIAL_PHASES, view_px, rays=_FEWEST_RAYS)
        with closing(rows) as tracing:
            for stretch in tracing:
                if stretch is not None and len(stretch.rows.row):
                    offsets = stretch.rows.offsets
                    reach = np.maximum(reach, np.abs(offsets).max(axis=0))
                    apart = np.maximum(apart, np.ptp(offsets, axis=0))
                yield
    return Spread(reach + _TRIAL_MARGIN_PX, apart + _TRIAL_MARGIN_PX)


def tolerant_phases(rig: Rig, phases: int, spread: Spread) -> int:
    """Phases along each side of a cell for many cases' rows: fewer where windows are wide."""
    place_bytes = _PLACE_BYTES * layout(rig.panel.subpixels).places
    held = _WINDOW_BYTES // (place_bytes * int(np.prod(2 * spread.apart_px + 1)))
    return max(1, min(phases, MOST_PHASES, isqrt(held)))


def tolerant_rows(
    rig: Rig,
    side: Side,
    phases: int,
    spread: Spread,
    builder: RowBuilder,
    view_px: tuple[int, int],
) -> Generator[None, None, TolerantRows]:
    """The rows of one eye, a piece of work at a time."""
    cases = cases_of(rig)
    rays = max(_FEWEST_RAYS, _RAYS // len(cases))
    sums = _Sums(rig, phases, spread)
    for case in cases:
        parts = []
        with closing(builder.rows(case.rig, side, phases, view_px, rays=rays)) as tracing:
            for stretch in tracing:
                if stretch is not None:
                    parts.append(stretch.rows)
                yield
        yield from sums.take(case, joined(parts))
    return (yield from sums.rows())


Cut = Callable[[NDArray[np.float32]], tuple[Ints, NDArray[np.float32]]]


def _lit(dense: NDArray[np.float32]) -> tuple[Ints, NDArray[np.float32]]:
    return lit(dense, _NEGLIGIBLE)


def _nonzero(dense: NDArray[np.float32]) -> tuple[Ints, NDArray[np.float32]]:
    place = np.flatnonzero(dense.any(axis=2))
    return place, dense.reshape(-1, 3)[place]


def _varied(dense: NDArray[np.float32]) -> tuple[Ints, NDArray[np.float32]]:
    """What windows (rows, offsets, 3) hold of either sign, but for what is faint.

    What is left out is put into the middle: a flat field, which all cases show alike, keeps what
    it has.
    """
    largest = np.abs(dense).max(axis=(1, 2), keepdims=True)
    kept = (np.abs(dense) > np.maximum(_FAINT * largest, _NEGLIGIBLE)).any(axis=2)
    middle = dense.shape[1] // 2
    left_out = np.where(kept[..., None], 0.0, dense).sum(axis=1)
    dense = dense.copy()
    dense[:, middle] += np.where(kept[:, middle, None], 0.0, -dense[:, middle]) + left_out
    kept[:, middle] = True
    place = np.flatnonzero(kept)
    return place, dense.reshape(-1, 3)[place]


class _Window:
    """Sums by phase and offset, dense; offsets up to ``reach`` (right, down) each way."""

    def __init__(self, rows: int, reach: Ints) -> None:
        self.reach = reach
        self.size = 2 * reach + 1
        self.area = int(np.prod(self.size))
        self.sums = np.zeros((rows * self.area, 3), np.float32)

    def add(self, row: Ints, offsets: Ints, weights: NDArray[np.float32]) -> None:
        """Weights (n, 3) to where they belong; what lies beyond the window is left out."""
        at = offsets + self.reach
        held = np.all((at >= 0) & (at < self.size), axis=-1)
        place = row * self.area + at[:, 1] * self.size[0] + at[:, 0]
        for colour in range(3):
            np.add.at(self.sums[:, colour], place[held], weights[held, colour])

    def rows(self, cut: Cut) -> Generator[None, None, Rows]:
        """What ``cut`` leaves of the rows, some at a time."""
        count, found = len(self.sums) // self.area, []
        step = max(1, _PIECE_PLACES // self.area)
        for first in range(0, count, step):
            last = min(first + step, count)
            dense = self.sums[first * self.area : last * self.area].reshape(-1, self.area, 3)
            place, weights = cut(dense)
            row, within = np.divmod(place, self.area)
            offsets = np.stack([within % self.size[0], within // self.size[0]], axis=-1)
            found.append(Rows(row + first, offsets - self.reach, weights))
            yield
        return joined(found)


class _Sums:
    """All three tables of one eye, case by case."""

    def __init__(self, rig: Rig, phases: int, spread: Spread) -> None:
        self._phases, self._layout = phases, layout(rig.panel.subpixels)
        self._lattice = lattice_of(rig)
        self._per_offset = phases_per_offset(rig, self._lattice, phases)
        self._origin_mm = np.zeros(2) if self._lattice is None else self._lattice.origin_mm
        count = self._layout.places * phases**2
        self._adjoint, self._gram = _Window(count, spread.reach_px), _Window(count, spread.apart_px)
        self._mean = _Window(count, spread.reach_px)

    def take(self, case: Case, rows: Rows) -> Generator[None, None, None]:
        """One more case's operator."""
        moved = self._moved(case)
        # First to a row of the rig's own lattice, then on to the pixel that is read: all tables go
        # by the same rounding, or V would hold its differences.
        moved_row = self._phase_of(rows, moved, np.zeros_like(rows.offsets))
        at, weights = replace(rows, row=moved_row), np.float32(case.weight) * rows.weights
        own = self._phase_of(at, np.zeros(2), rows.offsets)
        self._adjoint.add(own, -rows.offsets, weights)
        yield
        self._mean.add(moved_row, rows.offsets, weights)
        yield
        for first, second in _pairs(rows.row):
            product = np.float32(case.weight) * rows.weights[first] * rows.weights[second]
            offsets = rows.offsets[second] - rows.offsets[first]
            self._gram.add(own[first], offsets, product)
            yield

    def _moved(self, case: Case) -> Float:
        """By how many phases this case's lattice lies off."""
        lattice = lattice_of(case.rig)
        if lattice is None:
            return np.zeros(2)
        by_mm = lattice.origin_mm - self._origin_mm
        return np.asarray(self._phases * lattice.cell_from_panel @ by_mm)

    def _phase_of(self, rows: Rows, moved: Float, offsets: Ints) -> Ints:
        """Row of the pixel that lies so far from each row's own."""
        n, (columns, lines) = self._phases, self._layout.period
        place, phase = np.divmod(rows.row, n * n)
        at = np.stack([phase % n, phase // n], axis=-1) + offsets @ self._per_offset.T + moved
        nearest = np.rint(at).astype(np.int64) % n
        right = (place % columns + offsets[:, 0]) % columns
        down = (place // columns + offsets[:, 1]) % lines
        return np.asarray(((down * columns + right) * n + nearest[:, 1]) * n + nearest[:, 0])

    def rows(self) -> Generator[None, None, TolerantRows]:
        """All tables."""
        mean = yield from self._mean.rows(_lit)
        adjoint = yield from self._adjoint.rows(_lit)
        # What the mean operator does by itself is not the cases' variance.
        whole = yield from self._mean.rows(_nonzero)
        own = self._phase_of(whole, np.zeros(2), whole.offsets)
        for first, second in _pairs(whole.row):
            product = -whole.weights[first] * whole.weights[second]
            self._gram.add(own[first], whole.offsets[second] - whole.offsets[first], product)
            yield
        variance = yield from self._gram.rows(_varied)
        return TolerantRows(mean, adjoint, variance)


def _pairs(row: Ints) -> Generator[tuple[Ints, Ints], None, None]:
    """All pairs of entries of one row, both ways and with themselves, in bounded pieces."""
    starts = np.flatnonzero(np.diff(row, prepend=-1))
    counts = np.diff(np.append(starts, len(row)))
    own_count, own_start = np.repeat(counts, counts), np.repeat(starts, counts)
    ends = np.cumsum(own_count)
    first = 0
    while first < len(row):
        # Entries whose partners fill one piece.
        limit = (ends[first - 1] if first else 0) + _PRODUCTS
        last = max(first + 1, int(np.searchsorted(ends, limit, side="right")))
        entries = np.arange(first, last)
        partners = own_count[first:last]
        begun = np.cumsum(partners) - partners
        within = np.arange(int(partners.sum())) - np.repeat(begun, partners)
        yield np.repeat(entries, partners), np.repeat(own_start[first:last], partners) + within
        first = last
