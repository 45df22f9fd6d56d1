"""Float64 twin of ``shaders/sharpen.comp``: a picture convolved eye by eye, tap by tap."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from vrlf.model import Rig
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import SIDES, viewport


def sharpen(target: Float, rig: Rig, taps: Float, shift_px: ArrayLike) -> Float:
    """The target as the forward prefilter shall take it.

    Parameters
    ----------
    target : ndarray (H, W, 3)
        Linear light on the panel's raster.
    rig : Rig
    taps : ndarray (2, 3, 2 r + 1, 2 r + 1)
        Eye, colour, row, column: what the target at pixel + (column - r, row - r) + shift
        counts in the sharpened pixel.
    shift_px : array_like (2, 2)
        Whole pixels right and down, for each eye.

    Returns
    -------
    ndarray, shape (H, W, 3)
        Within 0 and 1. Each viewport's edges are repeated beyond it; the middle column of an
        odd width is dark.
    """
    sharpened = np.zeros(target.shape)
    for eye, side in enumerate(SIDES):
        columns = viewport(rig, side).columns
        half = target[:, columns].astype(np.float64)
        sharpened[:, columns] = _convolved(half, taps[eye], np.asarray(shift_px)[eye])
    return np.clip(sharpened, 0.0, 1.0)


def _convolved(half: Float, taps: Float, shift_px: Float) -> Float:
    height, width = half.shape[:2]
    radius = taps.shape[-1] // 2
    reach = radius + int(np.abs(shift_px).max())
    padded = np.pad(half, ((reach, reach), (reach, reach), (0, 0)), mode="edge")
    total = np.zeros_like(half)
    for row, column in np.ndindex(taps.shape[1:]):
        x, y = np.array([column, row]) + reach - radius + shift_px
        total += taps[:, row, column] * padded[y : y + height, x : x + width]
    return total
