"""A picture to judge arrays by that is no one's photograph: dead leaves.

Discs that hide each other, their radii r drawn as r^-3, have the statistics of natural pictures:
sharp edges, and the same at every scale (Lee, Mumford & Huang 2001, "Occlusion models for natural
images").
"""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.ndimage import gaussian_filter

from vrlf.optics.polynomial import Float

_LEAST_PX: Final = 2.0
_MOST_PX: Final = 50.0
# Deviation of the blur that a camera and its pixels leave.
_BLUR_PX: Final = 0.7
# Each pixel is the mean over this many places a side.
_FINER: Final = 3
# Leaves until hardly a pixel is bare; those that are stay grey.
_LAYERS: Final = 12.0


def dead_leaves(size_px: int, seed: int) -> Float:
    """Linear light of dead leaves, three independent colours.

    Parameters
    ----------
    size_px : int
        Each side.
    seed : int

    Returns
    -------
    ndarray (size_px, size_px, 3)
        Within 0 and 1; brightness is even in sRGB, as photographs' are, nearly.
    """
    generator = np.random.default_rng(seed)
    return np.stack([_plane(size_px, generator) for _ in range(3)], axis=-1)


def _plane(size_px: int, generator: np.random.Generator) -> Float:
    fine = size_px * _FINER
    plane = np.full((fine, fine), np.nan)
    at = (np.arange(fine) + 0.5) / _FINER
    # Front to back: what is covered stays covered.
    for radius, x, y, value in _leaves(size_px, generator):
        rows = np.flatnonzero(np.abs(at - y) <= radius)
        columns = np.flatnonzero(np.abs(at - x) <= radius)
        if len(rows) and len(columns):
            part = plane[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
            disc = (at[rows, None] - y) ** 2 + (at[columns] - x) ** 2 <= radius**2
            part[disc & np.isnan(part)] = value
    plane = np.where(np.isnan(plane), 0.2, plane)
    pixels = plane.reshape(size_px, _FINER, size_px, _FINER).mean(axis=(1, 3))
    return np.asarray(gaussian_filter(pixels, _BLUR_PX, mode="nearest"))


def _leaves(size_px: int, generator: np.random.Generator) -> Float:
    """Radius, place and light of each leaf; (n, 4)."""
    low, high = _LEAST_PX**-2, _MOST_PX**-2
    span = size_px + 2.0 * _MOST_PX
    mean_area = 2.0 * np.pi * np.log(_MOST_PX / _LEAST_PX) / (low - high)
    count = int(_LAYERS * span**2 / mean_area)
    radius = (low + generator.random(count) * (high - low)) ** -0.5
    place = generator.random((count, 2)) * span - _MOST_PX
    light = generator.random(count) ** 2.2
    return np.column_stack([radius, place, light])
