"""Plane shapes as functions: a shape answers, for points (x, y), which lie inside it.

x to the right, y up, in whatever unit the shape was drawn in. Arguments broadcast,
so a row of x and a column of y make a picture.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Bools: TypeAlias = NDArray[np.bool_]
Shape: TypeAlias = Callable[[Floats, Floats], Bools]
Point: TypeAlias = tuple[float, float]


def rectangle(left: float, bottom: float, right: float, top: float) -> Shape:
    """The upright rectangle between two corners."""
    return lambda x, y: (x >= left) & (x < right) & (y >= bottom) & (y < top)


def disc(centre: Point, radius: float) -> Shape:
    """All points within ``radius`` of ``centre``."""
    return lambda x, y: (x - centre[0]) ** 2 + (y - centre[1]) ** 2 <= radius**2


def annulus(centre: Point, inner_radius: float, outer_radius: float) -> Shape:
    """The ring between two circles about ``centre``."""
    return difference(disc(centre, outer_radius), disc(centre, inner_radius))


def half_plane(start: Point, end: Point) -> Shape:
    """All points to the left of the line from ``start`` to ``end``."""
    (x0, y0), (x1, y1) = start, end
    return lambda x, y: (x1 - x0) * (y - y0) >= (y1 - y0) * (x - x0)


def convex_polygon(*corners: Point) -> Shape:
    """The polygon with these corners, which must turn anticlockwise."""
    return intersection(*(half_plane(a, b) for a, b in pairwise((*corners, corners[0]))))


def union(*shapes: Shape) -> Shape:
    """What lies in any of the shapes."""
    return lambda x, y: reduce(np.logical_or, (shape(x, y) for shape in shapes))


def intersection(*shapes: Shape) -> Shape:
    """What lies in all of the shapes."""
    return lambda x, y: reduce(np.logical_and, (shape(x, y) for shape in shapes))


def difference(whole: Shape, removed: Shape) -> Shape:
    """What lies in the first shape but not in the second."""
    return lambda x, y: whole(x, y) & ~removed(x, y)
