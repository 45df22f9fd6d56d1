"""Rays sorted by where they cross the mask, so that only those under a hole are visited.

Blind pupil sampling loses most rays to a pinhole mask (96 in 100 behind 75 um holes at
390 um). Where a ray crosses, relative to the retinal pixel, is the same for every pixel;
sorted into a grid of bins once, the rays under a hole are a few stretches of the table.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vrlf.optics.polynomial import Float

# A hole covers about this many bins across: finer wastes less at its edges, coarser loops less.
BINS_PER_HOLE = 8
MAX_BINS = 256


@dataclass(frozen=True)
class BinGrid:
    """A grid over the crossings of all tables of one dispatch.

    Attributes
    ----------
    origin, size : ndarray (2,)
        Corner of the grid and of one bin, in cells.
    count : (columns, rows)
    """

    origin: Float
    size: Float
    count: tuple[int, int]


def grid_over(crossings: list[Float], hole_reach: Float) -> BinGrid:
    """The common grid of several sets of crossings, each (n, 2) in cells, behind holes of a reach.

    ``hole_reach`` is a hole's from its centre in both cell coordinates, (2,).
    """
    low = np.min([c.min(axis=0) for c in crossings], axis=0)
    high = np.max([c.max(axis=0) for c in crossings], axis=0)
    # A margin, so that rounding to 32 bits puts no ray outside.
    margin = 1e-4 * (1.0 + high - low)
    low, extent = low - margin, high - low + 2.0 * margin
    wanted = extent / (2.0 * hole_reach / BINS_PER_HOLE)
    count = np.clip(np.ceil(wanted), 1, MAX_BINS).astype(int)
    return BinGrid(low, extent / count, (int(count[0]), int(count[1])))


def sort_into(grid: BinGrid, crossings: Float) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """The order of the rays, and where each bin begins in it.

    Returns
    -------
    order : ndarray (n,)
    starts : ndarray (columns * rows + 1,)
        Bins row by row; the last entry is n.
    """
    place = np.floor((crossings - grid.origin) / grid.size).astype(np.int64)
    place = np.clip(place, 0, np.array(grid.count) - 1)
    number = place[:, 1] * grid.count[0] + place[:, 0]
    order = np.argsort(number, kind="stable")
    starts = np.searchsorted(number[order], np.arange(grid.count[0] * grid.count[1] + 1))
    return order, starts.astype(np.int32)


def visits_per_ray(hole_reach: Float, least_pitch: float) -> int:
    """How often a search may meet a ray, at most: a bin may lie under four wide holes."""
    return 4 if 2.0 * float(hole_reach.max()) * (1.0 + 2.0 / BINS_PER_HOLE) > least_pitch else 1


def loop_turns(grid: BinGrid, hole_reach: Float, least_pitch: float) -> float:
    """Turns that a search of the bins under all holes of the grid takes, at most."""
    holes = (grid.size * grid.count + 2.0 * hole_reach) / least_pitch + 1.0
    lines = 2.0 * hole_reach[1] / grid.size[1] + 2.0
    return float(np.prod(holes) * (1.0 + lines))
