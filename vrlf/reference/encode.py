"""Float64 twin of ``shaders/encode.comp``: linear light to 8-bit sRGB."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vrlf.images import srgb_decode, srgb_encode
from vrlf.optics.polynomial import Float

_LARGEST = 255


def encode(light: Float, *, dither: bool = False) -> NDArray[np.uint8]:
    """Codes of linear light, (H, W, 3); what is no number is shown dark.

    With ``dither`` a code above or below is chosen by fixed noise, in proportion to how near
    the value is to it in linear light, so that the mean light is kept.
    """
    value = np.clip(np.nan_to_num(light.astype(np.float64), nan=0.0, posinf=1.0), 0.0, 1.0)
    code = srgb_encode(value) * _LARGEST
    if not dither:
        return np.floor(code + 0.5).astype(np.uint8)
    below = np.clip(np.floor(code), 0, _LARGEST - 1)
    start, end = srgb_decode(below / _LARGEST), srgb_decode((below + 1) / _LARGEST)
    part = (value - start) / (end - start)
    return np.asarray(below + (part > noise(light.shape)), dtype=np.uint8)


def noise(shape: tuple[int, ...]) -> Float:
    """Uniform in [0, 1), fixed for row, column and channel; shape (H, W, 3)."""
    rows, columns, channels = np.meshgrid(*(np.arange(n) for n in shape), indexing="ij")
    hashed = _pcg(columns + _pcg(rows + _pcg(channels)))
    return np.asarray((hashed >> 8) / 2.0**24)


def _pcg(value: NDArray[np.int_]) -> NDArray[np.int_]:
    """O'Neill 2014, PCG-RXS-M-XS, on 32 bits."""
    v = value.astype(np.uint32)
    with np.errstate(over="ignore"):
        state = v * np.uint32(747796405) + np.uint32(2891336453)
        word = ((state >> ((state >> np.uint32(28)) + np.uint32(4))) ^ state) * np.uint32(277803737)
    return np.asarray((word >> np.uint32(22)) ^ word, dtype=np.int64)
