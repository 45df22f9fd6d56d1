"""Float64 twin of ``shaders/show.comp``: what a rectangle of a window shows."""

from __future__ import annotations

from math import ceil, floor

import numpy as np
from numpy.typing import NDArray

from vrlf.model import Rig
from vrlf.optics.polynomial import Float
from vrlf.optics.subpixels import layout
from vrlf.optics.tile import BACKGROUND_CODE, GREY_CODE, LINE_CODE, Tile
from vrlf.optics.viewport import SIDES, viewport
from vrlf.reference.encode import encode


def show_tile(
    rig: Rig,
    tile: Tile,
    first: Float,
    *,
    second: Float | None = None,
    divider_px: int | None = None,
    subpixels: bool = False,
    fade: float = 0.0,
) -> NDArray[np.uint8]:
    """Codes of a tile, shape (tile height, tile width, 3), row 0 at the top.

    See ``vrlf.passes.show.Show.run``; ``first`` and ``second`` have the panel's size, and are
    filled in where they are not whole yet (``on_grid``).
    """
    first = _level(first)
    second = None if second is None else _level(second)
    if second is not None and divider_px is None:
        first, second = np.abs(first - second), None
    codes = np.full((tile.window_px[3], tile.window_px[2], 3), BACKGROUND_CODE, np.uint8)
    for row in range(codes.shape[0]):
        for column in range(codes.shape[1]):
            window_column = tile.window_px[0] + column
            picture = first
            if divider_px is not None and second is not None and window_column >= divider_px:
                picture = second
            light = _light(rig, tile, picture, (column, row), subpixels)
            if light is None:
                continue
            codes[row, column] = encode(light[None, None])[0, 0]
            if divider_px is not None and abs(window_column - divider_px) <= 1:
                codes[row, column] = LINE_CODE
    return np.floor(codes + fade * (GREY_CODE - codes.astype(np.float64)) + 0.5).astype(np.uint8)


def _level(light: Float) -> Float:
    """As far as a panel can show it; what is no number is dark."""
    return np.clip(np.nan_to_num(light, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)


def on_grid(rig: Rig, picture: Float, stride: int) -> Float:
    """Each pixel as the nearest one of a grid in its own viewport, of two the later one."""
    filled = np.array(picture)
    for side in SIDES:
        view = viewport(rig, side)
        own = slice(view.first_column, view.first_column + view.width_px)
        rows, columns = (
            np.minimum((np.arange(n) + stride // 2) // stride, (n - 1) // stride) * stride
            for n in (view.height_px, view.width_px)
        )
        filled[:, own] = picture[:, own][rows][:, columns]
    return filled


def _light(
    rig: Rig, tile: Tile, picture: Float, in_tile: tuple[int, int], subpixels: bool
) -> Float | None:
    """Light of one window pixel, None beside the crop."""
    low = [start + tile.scale * place for start, place in zip(tile.start_px, in_tile, strict=True)]
    middle = [place + 0.5 * tile.scale for place in low]
    x, y = (floor(place) for place in middle)
    x0, y0, width, height = tile.crop_px
    if not (x0 <= x < x0 + width and y0 <= y < y0 + height):
        return None
    light = picture[y, x].copy() if tile.scale <= 1.0 else _mean(tile, picture, low)
    if subpixels:
        within = (middle[0] - x, middle[1] - y)
        for colour, (left, top, right, bottom) in enumerate(layout(rig.panel.subpixels).at(x, y)):
            if not (left <= within[0] < right and top <= within[1] < bottom):
                light[colour] = 0.0
    return light


def _mean(tile: Tile, picture: Float, low: list[float]) -> Float:
    """Mean over what a window pixel covers of the crop."""
    weights = []
    for axis in (0, 1):
        first, length = tile.crop_px[axis], tile.crop_px[axis + 2]
        start, end = low[axis], low[axis] + tile.scale
        pixels = range(max(floor(start), first), min(ceil(end), first + length))
        weights.append((pixels, [min(end, p + 1) - max(start, p) for p in pixels]))
    (columns, across), (rows, along) = weights
    part = picture[rows.start : rows.stop, columns.start : columns.stop]
    weight = np.outer(along, across)
    return np.asarray((part * weight[..., None]).sum(axis=(0, 1)) / weight.sum())
