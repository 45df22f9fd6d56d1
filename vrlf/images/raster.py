"""Cutting and scaling rasters in linear light, for sheets of pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.float32]


def crop(image: Picture, x_px: int, y_px: int, width_px: int, height_px: int) -> Picture:
    """Copy a rectangle out of a picture.

    Parameters
    ----------
    image : ndarray, shape (H, W, C)
        The picture.
    x_px, y_px : int
        Column and row of the rectangle's top left pixel.
    width_px, height_px : int
        Its size.

    Returns
    -------
    ndarray, shape (height_px, width_px, C)
        A copy of its own.

    Raises
    ------
    ValueError
        The rectangle is empty or does not lie inside the picture.
    """
    height, width = image.shape[:2]
    fits_x = 0 <= x_px < x_px + width_px <= width
    fits_y = 0 <= y_px < y_px + height_px <= height
    if not (fits_x and fits_y):
        raise ValueError(
            f"found a rectangle {width_px}x{height_px} at ({x_px}, {y_px}), "
            f"wanted one inside {width}x{height}"
        )
    return image[y_px : y_px + height_px, x_px : x_px + width_px].copy()


def resize_nearest(image: Picture, factor: int) -> Picture:
    """Show every pixel as a square of ``factor`` by ``factor`` pixels.

    Raises
    ------
    ValueError
        The factor is below 1.
    """
    if factor < 1:
        raise ValueError(f"found the factor {factor}, wanted at least 1")
    return image.repeat(factor, axis=0).repeat(factor, axis=1)


def resize_area(image: Picture, width_px: int, height_px: int) -> Picture:
    """Resize by exact averages over each new pixel's area, so that no light is lost or made.

    Parameters
    ----------
    image : ndarray of float32, shape (H, W, C)
        Linear light.
    width_px, height_px : int
        The new size, at least 1 each. Where it is larger, pixels become blocks.

    Returns
    -------
    ndarray of float32, shape (height_px, width_px, C)
        With the same mean as ``image``.

    Raises
    ------
    ValueError
        A size below 1.
    """
    if width_px < 1 or height_px < 1:
        raise ValueError(f"found {width_px}x{height_px} pixels, wanted at least 1x1")
    rows = _average_rows(image.astype(np.float64), height_px)
    columns = _average_rows(rows.swapaxes(0, 1), width_px)
    return np.ascontiguousarray(columns.swapaxes(0, 1), dtype=np.float32)


def _average_rows(values: NDArray[Any], count: int) -> NDArray[np.float64]:
    """Averages over ``count`` equal intervals of axis 0, by differences of the integral."""
    old = values.shape[0]
    edges = np.arange(count + 1) * (old / count)
    whole = np.minimum(edges.astype(int), old - 1)
    part = (edges - whole).reshape(-1, *(1,) * (values.ndim - 1))
    integral = np.concatenate([np.zeros_like(values[:1]), np.cumsum(values, axis=0)])
    at_edges = integral[whole] + part * values[whole]
    averages: NDArray[np.float64] = np.diff(at_edges, axis=0) * (count / old)
    return averages
