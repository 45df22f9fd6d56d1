"""The Sloan letters as exact shapes on their 5 x 5 grid (Sloan 1959), and a few signs.

Every stroke is one unit wide; curves are arcs of circles. Slanted strokes are one
unit wide *across*: on the diagonals of N, R and Z that is a 3-4-5 triangle, so
their horizontal width is 5/4 exactly.
"""

from __future__ import annotations

import math
from types import MappingProxyType
from typing import Final

from vrlf.content.charts.model import Colour, Image
from vrlf.content.charts.raster import Box, paint_shape
from vrlf.content.charts.shapes import (
    Shape,
    annulus,
    convex_polygon,
    difference,
    intersection,
    rectangle,
    union,
)

LETTER_SIDE: Final = 5.0
SLOAN_LETTERS: Final = "CDHKNORSVZ"
UP_ARROW: Final = "↑"

_LEFT_STEM: Final = rectangle(0, 0, 1, 5)
_RIGHT_STEM: Final = rectangle(4, 0, 5, 5)
_TOP_BAR: Final = rectangle(0, 4, 5, 5)
_BOTTOM_BAR: Final = rectangle(0, 0, 5, 1)
_RING: Final = annulus((2.5, 2.5), 1.5, 2.5)


def _d() -> Shape:
    flats = union(rectangle(0, 4, 2.5, 5), rectangle(0, 0, 2.5, 1))
    right_half = intersection(_RING, rectangle(2.5, 0, 5, 5))
    return union(_LEFT_STEM, flats, right_half)


def _k() -> Shape:
    # Both limbs stand at 45 degrees; a unit across is sqrt(2) along the edges.
    w = math.sqrt(2.0)
    arm = convex_polygon((1, 1), (5, 5), (5 - w, 5), (1, 1 + w))
    leg = convex_polygon((5 - w, 0), (5, 0), (2.5, 2.5), (2.5 - w / 2, 2.5 - w / 2))
    return union(_LEFT_STEM, arm, leg)


def _n() -> Shape:
    return union(_LEFT_STEM, _RIGHT_STEM, convex_polygon((3.75, 0), (5, 0), (1.25, 5), (0, 5)))


def _p() -> Shape:
    flats = union(rectangle(0, 4, 3.5, 5), rectangle(0, 2, 3.5, 3))
    bowl = intersection(annulus((3.5, 3.5), 0.5, 1.5), rectangle(3.5, 2, 5, 5))
    return union(_LEFT_STEM, flats, bowl)


def _r() -> Shape:
    return union(_p(), convex_polygon((3.75, 0), (5, 0), (3.5, 2), (2.25, 2)))


def _s() -> Shape:
    upper, lower = (annulus((x, y), 0.5, 1.5) for x, y in ((1.5, 3.5), (3.5, 1.5)))
    upper_end, lower_end = (annulus((x, y), 0.5, 1.5) for x, y in ((3.5, 3.5), (1.5, 1.5)))
    return union(
        intersection(upper, rectangle(0, 2, 1.5, 5)),
        intersection(lower, rectangle(3.5, 0, 5, 3)),
        intersection(upper_end, rectangle(3.5, 3.5, 5, 5)),
        intersection(lower_end, rectangle(0, 0, 1.5, 1.5)),
        *(rectangle(1.5, bottom, 3.5, bottom + 1) for bottom in (0, 2, 4)),
    )


def _u() -> Shape:
    arch = intersection(_RING, rectangle(0, 0, 5, 2.5))
    return union(rectangle(0, 2.5, 1, 5), rectangle(4, 2.5, 5, 5), arch)


def _v() -> Shape:
    # Limbs from top corner to the flat foot, horizontal width w:
    # 5 w / hypot(5, 2.5 - w / 2) = 1 makes them one unit across.
    w = (math.sqrt(3100.0) - 2.5) / 49.5
    foot = ((2.5 - w / 2, 0.0), (2.5 + w / 2, 0.0))
    return union(convex_polygon(*foot, (w, 5), (0, 5)), convex_polygon(*foot, (5, 5), (5 - w, 5)))


def _z() -> Shape:
    return union(_TOP_BAR, _BOTTOM_BAR, convex_polygon((0, 0), (1.25, 0), (5, 5), (3.75, 5)))


def _arrow() -> Shape:
    return union(rectangle(1.9, 0, 3.1, 2.5), convex_polygon((0.5, 2.5), (4.5, 2.5), (2.5, 5)))


LETTER_SHAPES: Final = MappingProxyType[str, Shape](
    {
        "C": difference(_RING, rectangle(2.5, 2, 5, 3)),
        "D": _d(),
        "H": union(_LEFT_STEM, _RIGHT_STEM, rectangle(1, 2, 4, 3)),
        "K": _k(),
        "L": union(_LEFT_STEM, _BOTTOM_BAR),
        "N": _n(),
        "O": _RING,
        "P": _p(),
        "R": _r(),
        "S": _s(),
        "U": _u(),
        "V": _v(),
        "Z": _z(),
        UP_ARROW: _arrow(),
    }
)


def paint_letter(
    picture: Image, letter: str, *, left_px: float, top_px: float, height_px: float, colour: Colour
) -> None:
    """Paint one letter, as wide as it is high, in place."""
    box = Box(left_px, top_px, height_px, height_px)
    paint_shape(picture, LETTER_SHAPES[letter], box, colour, design_side=LETTER_SIDE)
