"""Painting on a picture in linear light: each pixel takes the ink that covers it.

Pixel coordinates: x to the right, y *down* from the picture's upper left corner,
pixel (column i, row j) being the square from (i, j) to (i + 1, j + 1). Whatever
reaches beyond the picture is cut off.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vrlf.content.charts.model import Colour, Image, Viewport
from vrlf.content.charts.shapes import Floats, Shape

# Samples along each side of a pixel: an edge is placed to within 1/16 pixel.
SUBSAMPLES: Final = 8
# A large letter is sampled in bands of rows, so that memory stays bounded.
_SAMPLES_PER_BAND: Final = 1 << 20


class Box(NamedTuple):
    """An upright rectangle in pixel coordinates; edges may lie inside pixels."""

    left_px: float
    top_px: float
    width_px: float
    height_px: float


def blank(viewport: Viewport, colour: Colour) -> Image:
    """A picture of one colour, (height, width, 3)."""
    shape = (viewport.height_px, viewport.width_px, 3)
    return np.broadcast_to(np.array(colour, np.float32), shape).copy()


def blend(picture: Image, coverage: NDArray[np.floating], colour: Colour) -> None:
    """Lay ``colour`` over ``picture`` (H, W, 3), in place, by ``coverage`` (H, W) in [0, 1]."""
    share = coverage.astype(np.float32)[..., np.newaxis]
    picture *= 1.0 - share
    picture += share * np.array(colour, np.float32)


def paint_rectangle(picture: Image, box: Box, colour: Colour) -> None:
    """Paint an upright rectangle; the coverage of its edge pixels is exact."""
    rows = _overlap(box.top_px, box.height_px, picture.shape[0])
    columns = _overlap(box.left_px, box.width_px, picture.shape[1])
    row_slice, column_slice = _touched(box, picture)
    coverage = rows[row_slice, np.newaxis] * columns[np.newaxis, column_slice]
    blend(picture[row_slice, column_slice], coverage, colour)


def paint_shape(
    picture: Image, shape: Shape, box: Box, colour: Colour, *, design_side: float
) -> None:
    """Paint a shape whose design square, (0, 0) to (side, side) with y up, fills ``box``.

    Coverage is the share of 8 x 8 samples of a pixel that lie in the shape.
    """
    rows, columns = _touched(box, picture)
    width = columns.stop - columns.start
    x = (_sample_places(columns.start, width) - box.left_px) * (design_side / box.width_px)
    rows_per_band = max(1, _SAMPLES_PER_BAND // max(1, width * SUBSAMPLES**2))
    for first in range(rows.start, rows.stop, rows_per_band):
        last = min(first + rows_per_band, rows.stop)
        down = _sample_places(first, last - first) - box.top_px
        y = design_side - down * (design_side / box.height_px)
        inside = shape(x[np.newaxis, :], y[:, np.newaxis])
        tiles = inside.reshape(last - first, SUBSAMPLES, width, SUBSAMPLES)
        blend(picture[first:last, columns], tiles.mean(axis=(1, 3)), colour)


def pixel_offsets(viewport: Viewport, centre: tuple[float, float]) -> tuple[Floats, Floats]:
    """Offsets of all pixel centres from a point: x right (1, W) and y up (H, 1)."""
    x: Floats = np.arange(viewport.width_px, dtype=np.float64) + (0.5 - centre[0])
    y: Floats = (centre[1] - 0.5) - np.arange(viewport.height_px, dtype=np.float64)
    return x[np.newaxis, :], y[:, np.newaxis]


def _overlap(start_px: float, length_px: float, count: int) -> Floats:
    """Length of each of ``count`` unit cells that [start, start + length] covers."""
    cell = np.arange(count)
    end_px = start_px + length_px
    covered: Floats = np.minimum(cell + 1.0, end_px) - np.maximum(cell, start_px)
    return covered.clip(0.0, 1.0)


def _touched(box: Box, picture: Image) -> tuple[slice, slice]:
    """Rows and columns of the picture that the box reaches into."""
    return (
        _cells(box.top_px, box.height_px, picture.shape[0]),
        _cells(box.left_px, box.width_px, picture.shape[1]),
    )


def _cells(start_px: float, length_px: float, count: int) -> slice:
    first = min(max(math.floor(start_px), 0), count)
    last = min(max(math.ceil(start_px + length_px), first), count)
    return slice(first, last)


def _sample_places(first_px: int, count: int) -> Floats:
    return first_px + (np.arange(count * SUBSAMPLES) + 0.5) / SUBSAMPLES
