"""How sharp a picture is wherever it lies: its PSNR after the best shift of the whole.

Nobody in a headset sees that the whole picture lies a pixel elsewhere, so where array or pupil
are off, that is no loss of sharpness.
"""

from __future__ import annotations

from math import inf, log10

import numpy as np
from scipy import ndimage

from vrlf.model import Rig
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import Side, viewport
from vrlf.renderer import Image

# Steps of the search, in pixels; the last leaves 0.01 dB at most.
_STEPS_PX = (1.0, 0.5, 0.25, 0.1)
# A better place must be better by this share of the squared error, or the search goes on for ever.
_BETTER = 1e-5
# How far it looks at most.
_FARTHEST_PX = 8.0


def shifted_psnr_db(
    seen: Image, target: Image, rig: Rig, side: Side, border_px: int
) -> tuple[float, tuple[float, float]]:
    """PSNR of one eye's half after the shift and the gain that serve it best.

    Parameters
    ----------
    seen, target : ndarray (H, W, 3)
        Linear light on the panel's raster.
    border_px : int
        What is left out at each side.

    Returns
    -------
    psnr_db : float
        Peak 1, as ``likeness``.
    shift_px : (right, down)
        By which the perceived picture was moved.
    """
    view = viewport(rig, side)
    own = seen[:, view.columns].astype(np.float64)
    # Cubic splines: computed once, evaluated at every place that is tried.
    coefficients = np.stack([ndimage.spline_filter(own[..., c]) for c in range(3)])
    inner = (
        slice(border_px, view.height_px - border_px),
        slice(border_px, view.width_px - border_px),
    )
    wanted = target[:, view.columns][inner].astype(np.float64)
    tried: dict[tuple[float, float], float] = {}

    def error(shift: tuple[float, float]) -> float:
        if shift not in tried:
            moved = _moved(coefficients, shift)[inner]
            energy = float(np.sum(moved * moved))
            gain = float(np.sum(moved * wanted)) / energy if energy > 0.0 else 1.0
            tried[shift] = float(np.mean((gain * moved - wanted) ** 2))
        return tried[shift]

    best = (0.0, 0.0)
    for step in _STEPS_PX:
        while (nearby := min(_neighbours(best, step), key=error)) != best:
            if error(nearby) > error(best) * (1.0 - _BETTER):
                break
            best = nearby
    least = error(best)
    return (inf if least == 0.0 else -10.0 * log10(least)), best


def _moved(coefficients: Float, shift: tuple[float, float]) -> Float:
    planes = [
        ndimage.shift(plane, (shift[1], shift[0]), order=3, mode="nearest", prefilter=False)
        for plane in coefficients
    ]
    return np.stack(planes, axis=-1)


def _neighbours(at: tuple[float, float], step: float) -> list[tuple[float, float]]:
    x, y = at
    around = [(x, y), (x + step, y), (x - step, y), (x, y + step), (x, y - step)]
    return [each for each in around if max(map(abs, each)) <= _FARTHEST_PX]
