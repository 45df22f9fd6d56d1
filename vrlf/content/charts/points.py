"""Point sources: single pixels, far enough apart that their blurs can be told apart."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from vrlf.content.charts.model import BLACK, BLUE, GREEN, RED, WHITE, Chart, Viewport
from vrlf.content.charts.raster import blank

SPACING_DEG: Final = 2.0
_MIN_SPACING_PX: Final = 5
COLOURS: Final = MappingProxyType({"white": WHITE, "red": RED, "green": GREEN, "blue": BLUE})
# Each row starts two colours further, so that neighbours differ and a lattice of
# two by two shows all four.
ROW_SHIFT: Final = 2


def draw_points(viewport: Viewport) -> Chart:
    """Draw single full pixels on black, on a square lattice of odd spacing.

    The spacing is odd because a lenslet often covers an even number of pixels:
    the points then fall on different places under their lenslets.
    """
    spacing_px = _spacing_px(viewport)
    columns = _places(viewport.width_px, spacing_px)
    rows = _places(viewport.height_px, spacing_px)
    picture = blank(viewport, BLACK)
    colours = tuple(COLOURS.values())
    for j, row in enumerate(rows):
        for i, column in enumerate(columns):
            picture[row, column] = colours[(i + ROW_SHIFT * j) % len(colours)]
    notes = (
        f"{len(columns)} x {len(rows)} single pixels, {spacing_px} px "
        f"({spacing_px / viewport.pixels_per_degree:.3g} degrees) apart",
        f"the first at column {columns[0]}, row {rows[0]} (0 is the left column, the top row)",
        f"colours in turn along a row: {', '.join(COLOURS)}; "
        f"each row starts {ROW_SHIFT} colours further",
    )
    return Chart(picture, notes)


def _spacing_px(viewport: Viewport) -> int:
    """The odd number nearest to two degrees that leaves at least two points a side."""
    wanted = 2 * round((SPACING_DEG * viewport.pixels_per_degree - 1.0) / 2.0) + 1
    largest = viewport.shorter_side_px // 2
    return max(_MIN_SPACING_PX, min(wanted, largest - 1 + largest % 2))


def _places(count_px: int, spacing_px: int) -> range:
    points = count_px // spacing_px
    first = (count_px - 1 - (points - 1) * spacing_px) // 2
    return range(first, first + points * spacing_px, spacing_px)
