"""The grid: lines about a degree apart show distortion, a circle shows roundness."""

from __future__ import annotations

from typing import Final

import numpy as np

from vrlf.content.charts.model import BLACK, RED, WHITE, YELLOW, Chart, Image, Viewport
from vrlf.content.charts.raster import Box, blank, blend, paint_rectangle, pixel_offsets

THICK_EVERY: Final = 5
THIN_PX: Final = 1
THICK_PX: Final = 3
CIRCLE_WIDTH_PX: Final = 2.0
CIRCLE_SHARE_OF_SIDE: Final = 0.45
_MIN_SPACING_PX: Final = 4
_MIN_LINES: Final = 4


def draw_grid(viewport: Viewport) -> Chart:
    """Draw white lines on black about the centre pixel, a red cross there, a yellow circle.

    The centre pixel is column ``width // 2``, row ``height // 2``; with an even
    side the viewport's own centre is that pixel's left or upper edge.
    """
    column, row = viewport.width_px // 2, viewport.height_px // 2
    spacing_px = _spacing_px(viewport)
    picture = blank(viewport, BLACK)
    # Thin lines first, so that no thin line cuts a thick one.
    for thick in (False, True):
        _draw_lines(picture, (column, row), spacing_px, thick=thick)
    radius_px = round(viewport.shorter_side_px * CIRCLE_SHARE_OF_SIDE)
    _draw_circle(picture, viewport, (column + 0.5, row + 0.5), radius_px)
    _draw_cross(picture, (column, row), spacing_px)
    degrees = spacing_px / viewport.pixels_per_degree
    notes = (
        f"lines each {spacing_px} px ({degrees:.3g} degrees), "
        f"{THIN_PX} px wide, every {THICK_EVERY}th {THICK_PX} px",
        f"centre cross at column {column}, row {row} (0 is the left column, the top row)",
        f"circle of radius {radius_px} px "
        f"({radius_px / viewport.pixels_per_degree:.3g} degrees) about the cross",
    )
    return Chart(picture, notes)


def _spacing_px(viewport: Viewport) -> int:
    """A degree in whole pixels, kept so that lines stay apart and several are seen."""
    return max(
        _MIN_SPACING_PX,
        min(round(viewport.pixels_per_degree), viewport.shorter_side_px // _MIN_LINES),
    )


def _draw_lines(picture: Image, centre: tuple[int, int], spacing_px: int, *, thick: bool) -> None:
    half_px = (THICK_PX if thick else THIN_PX) // 2
    column, row = centre
    for x in _line_places(column, spacing_px, picture.shape[1], thick=thick):
        picture[:, max(x - half_px, 0) : x + half_px + 1] = WHITE
    for y in _line_places(row, spacing_px, picture.shape[0], thick=thick):
        picture[max(y - half_px, 0) : y + half_px + 1, :] = WHITE


def _line_places(centre: int, spacing_px: int, count: int, *, thick: bool) -> list[int]:
    reach = count // spacing_px + 1
    numbers = [k for k in range(-reach, reach + 1) if (k % THICK_EVERY == 0) == thick]
    return [centre + k * spacing_px for k in numbers if 0 <= centre + k * spacing_px < count]


def _draw_circle(
    picture: Image, viewport: Viewport, centre_px: tuple[float, float], radius_px: float
) -> None:
    x, y = pixel_offsets(viewport, centre_px)
    off_circle_px = np.abs(np.hypot(x, y) - radius_px)
    blend(picture, np.clip(CIRCLE_WIDTH_PX / 2.0 + 0.5 - off_circle_px, 0.0, 1.0), YELLOW)


def _draw_cross(picture: Image, centre: tuple[int, int], arm_px: int) -> None:
    column, row = centre
    half_px = THICK_PX // 2
    length_px = 2 * arm_px + 1
    paint_rectangle(picture, Box(column - arm_px, row - half_px, length_px, THICK_PX), RED)
    paint_rectangle(picture, Box(column - half_px, row - arm_px, THICK_PX, length_px), RED)
