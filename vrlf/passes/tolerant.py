"""Rows of the normal equations of many rigs at once, each a little off.

With P_k the operator of case k (``vrlf/optics/tolerance.py``), P their mean and t the target,

    sum_k w_k || P_k l - t ||^2  =  || P l - t ||^2 + l'V l + ...,  V = sum_k w_k P_k'P_k - P'P

so that down is P'(P l - t) + V l: the mean operator is solved as any other, and V, small and
symmetric, takes light from what the cases do not agree on. All three are tabulated by the place
in a cell where a pixel's own chief ray crosses the array; a case whose lattice lies off is traced
at the phases of the rig's own. A step reads three tables, however many cases there are. (P_k'P_k
alone, in one table, would do too; but what its phases and its cut leave out falsifies the picture
itself, here it changes a small term. So V has few phases and loses its faint entries.)

Entries a row that a step reads (matched-wide, 12 cases): P 9.2, P' 9.0, V 14.7, where one case's
P and P' have 8.9 and 8.6: 1.9 times as many. Cut at 0.02 of the largest instead of 0.05 V has half
as many more and gains 0.02 dB where things are off; at 0.1 it has a third less and loses 0.06.

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
from vrlf.optics.samples import ray_tables
from vrlf.optics.subpixels import layout
from vrlf.optics.tolerance import Case, cases_of
from vrlf.optics.viewport import SIDES, Side
from vrlf.passes.phases import Ints, Rows, joined, phases_per_offset, table_rays
from vrlf.passes.tabulate import RowBuilder, Stretch, lit

# What is blurred over cases changes less from phase to phase than one case does, and V least.
# Measured in float64 (matched-wide, a photograph, 16 cases, dB on average where things are off,
# below rows of every pixel's own): P of 48, 80, 160 phases loses 0.7, 0.28, 0.04, V of 48, 80 loses
# 0.02, 0.05; P of 128 rays a case 0.02, V of 128 none.
MOST_PHASES, MOST_VARIANCE_PHASES = 160, 48
# Rays of a row of each case.
_FEWEST_RAYS, _VARIANCE_RAYS = 64, 128
# Places of a window of P that are gathered at once: some 100 MB.
_BAND_PLACES = 1 << 23
# Products of two entries, and places of a window, in a piece of work: some 10 ms.
_PRODUCTS, _PIECE_PLACES = 1 << 18, 1 << 18
# What an eye's dense window of G may take; wide ones get fewer phases.
_WINDOW_BYTES, _PLACE_BYTES = 3 << 27, 12
_NEGLIGIBLE = 1e-6
# Entries of V below this share of a row's largest, in size, are left out.
_FAINT = 0.05
# How far rows reach is tried with so few of them; others reach a little farther.
_TRIAL_PHASES, _TRIAL_MARGIN_PX = 6, 2


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
        rows = builder.rows(case.rig, side, _TRIAL_PHASES, view_px, rays=_VARIANCE_RAYS)
        with closing(rows) as tracing:
            for stretch in tracing:
                if stretch is not None and len(stretch.rows.row):
                    offsets = stretch.rows.offsets
                    reach = np.maximum(reach, np.abs(offsets).max(axis=0))
                    apart = np.maximum(apart, np.ptp(offsets, axis=0))
                yield
    return Spread(reach + _TRIAL_MARGIN_PX, apart + _TRIAL_MARGIN_PX)


def mean_phases(left: int, right: int) -> tuple[int, int]:
    """Phases of P along each side of a cell, of both eyes, where one case has so many."""
    return min(left, MOST_PHASES), min(right, MOST_PHASES)


def mean_rows(
    rig: Rig,
    side: Side,
    phases: int,
    spread: Spread,
    builder: RowBuilder,
    view_px: tuple[int, int],
) -> Generator[Stretch | None, None, None]:
    """Rows of P of one eye, stretch by stretch; None is a rest within one.

    Every case is traced at the phases of the rig's own lattice.
    """
    cases = cases_of(rig)
    count = layout(rig.panel.subpixels).places * phases**2
    colours = max(len(ray_tables(rig, each, 1)) for each in SIDES)
    rays = max(_FEWEST_RAYS, table_rays(count, colours) // len(cases))
    step = max(1, _BAND_PLACES // int(np.prod(2 * spread.reach_px + 1)))
    for first in range(0, count, step):
        band = range(first, min(first + step, count))
        window = _Window(len(band), spread.reach_px)
        for case in cases:
            moved = _moved_cells(rig, case)
            tracing = builder.rows(
                case.rig, side, phases, view_px, rays=rays, span=band, moved_cells=moved
            )
            with closing(tracing):
                for stretch in tracing:
                    if stretch is not None:
                        own, weight = stretch.rows, np.float32(case.weight)
                        window.put(own.row - first, own.offsets, weight * own.weights)
                    yield None
        rows = yield from window.rows(_lit)
        yield Stretch(replace(rows, row=rows.row + first), (first, band.stop))


def variance_phases(rig: Rig, phases: int, spread: Spread) -> int:
    """Phases of V along each side of a cell: fewer where windows are wide."""
    place_bytes = _PLACE_BYTES * layout(rig.panel.subpixels).places
    held = _WINDOW_BYTES // (place_bytes * int(np.prod(2 * spread.apart_px + 1)))
    return max(1, min(phases, MOST_VARIANCE_PHASES, isqrt(held)))


def variance_rows(
    rig: Rig,
    side: Side,
    phases: int,
    spread: Spread,
    builder: RowBuilder,
    view_px: tuple[int, int],
) -> Generator[None, None, Rows]:
    """The rows of V of one eye, a piece of work at a time."""
    cases = cases_of(rig)
    sums = _Sums(rig, phases, spread)
    for case in cases:
        parts, moved = [], _moved_cells(rig, case)
        tracing = builder.rows(
            case.rig, side, phases, view_px, rays=_VARIANCE_RAYS, moved_cells=moved
        )
        with closing(tracing):
            for stretch in tracing:
                if stretch is not None:
                    parts.append(stretch.rows)
                yield
        yield from sums.take(case.weight, joined(parts))
    return (yield from sums.rows())


def _moved_cells(rig: Rig, case: Case) -> Float:
    """How far a case's lattice lies off the rig's own."""
    own, lattice = lattice_of(rig), lattice_of(case.rig)
    if own is None or lattice is None:
        return np.zeros(2)
    return np.asarray(own.cell_from_panel @ (lattice.origin_mm - own.origin_mm))


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

    def put(self, row: Ints, offsets: Ints, weights: NDArray[np.float32]) -> None:
        """Add weights (n, 3), no place's twice; what lies beyond the window is left out."""
        place, held = self._places(row, offsets)
        self.sums[place] += weights[held]

    def add(self, row: Ints, offsets: Ints, weights: NDArray[np.float32]) -> None:
        """The same, where places may come more than once."""
        place, held = self._places(row, offsets)
        for colour in range(3):
            np.add.at(self.sums[:, colour], place, weights[held, colour])

    def _places(self, row: Ints, offsets: Ints) -> tuple[Ints, NDArray[np.bool_]]:
        """Where what the window holds belongs, and what it holds."""
        at = offsets + self.reach
        held = np.all((at >= 0) & (at < self.size), axis=-1)
        place = row * self.area + at[:, 1] * self.size[0] + at[:, 0]
        return place[held], held

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
    """V of one eye, case by case."""

    def __init__(self, rig: Rig, phases: int, spread: Spread) -> None:
        self._phases, self._layout = phases, layout(rig.panel.subpixels)
        self._per_offset = phases_per_offset(rig, lattice_of(rig), phases)
        count = self._layout.places * phases**2
        self._mean = _Window(count, spread.reach_px)
        self._gram = _Window(count, spread.apart_px)

    def take(self, weight: float, rows: Rows) -> Generator[None, None, None]:
        """One more case's operator."""
        self._mean.put(rows.row, rows.offsets, np.float32(weight) * rows.weights)
        yield
        yield from self._add_gram(weight, rows)

    def _add_gram(self, factor: float, rows: Rows) -> Generator[None, None, None]:
        """``factor`` times R'R of rows R, by the phase of the pixel that each entry reads."""
        own = self._phase_read(rows)
        for first, second in _pairs(rows.row):
            product = np.float32(factor) * rows.weights[first] * rows.weights[second]
            offsets = rows.offsets[second] - rows.offsets[first]
            self._gram.add(own[first], offsets, product)
            yield

    def _phase_read(self, rows: Rows) -> Ints:
        """Row of the pixel that each entry reads."""
        n, (columns, lines) = self._phases, self._layout.period
        place, phase = np.divmod(rows.row, n * n)
        at = np.stack([phase % n, phase // n], axis=-1) + rows.offsets @ self._per_offset.T
        nearest = np.rint(at).astype(np.int64) % n
        right = (place % columns + rows.offsets[:, 0]) % columns
        down = (place // columns + rows.offsets[:, 1]) % lines
        return np.asarray(((down * columns + right) * n + nearest[:, 1]) * n + nearest[:, 0])

    def rows(self) -> Generator[None, None, Rows]:
        """All of it; what the mean operator does by itself is not the cases' variance."""
        mean = yield from self._mean.rows(_nonzero)
        yield from self._add_gram(-1.0, mean)
        return (yield from self._gram.rows(_varied))


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
