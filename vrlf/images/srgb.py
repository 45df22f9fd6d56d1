"""The sRGB transfer function, exact, and its only home in Python.

OpenImageIO's own conversion differs from the standard by up to 2e-5; an
8 bit step is 4e-3, but a comparison of two renderers sees 2e-5.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

# IEC 61966-2-1:1999, with the thresholds as the standard prints them.
LINEAR_SLOPE: Final = 12.92
DECODE_THRESHOLD: Final = 0.04045
ENCODE_THRESHOLD: Final = 0.0031308
OFFSET: Final = 0.055
EXPONENT: Final = 2.4


def srgb_decode(encoded: ArrayLike) -> NDArray[np.float64]:
    """Linear light of sRGB values in [0, 1].

    Parameters
    ----------
    encoded : array_like
        sRGB values, 1 for full drive. Beyond [0, 1] the two branches go on.

    Returns
    -------
    ndarray of float64
        Linear light, of the same shape (IEC 61966-2-1:1999).
    """
    value = np.asarray(encoded, dtype=np.float64)
    # The power's base is held above the threshold, so that negatives raise no NaN.
    base = (np.maximum(value, DECODE_THRESHOLD) + OFFSET) / (1.0 + OFFSET)
    return np.where(value <= DECODE_THRESHOLD, value / LINEAR_SLOPE, base**EXPONENT)


def srgb_encode(linear: ArrayLike) -> NDArray[np.float64]:
    """sRGB values of linear light; the inverse of `srgb_decode`.

    Parameters
    ----------
    linear : array_like
        Linear light, 1 for full drive. Beyond [0, 1] the two branches go on.

    Returns
    -------
    ndarray of float64
        sRGB values, of the same shape (IEC 61966-2-1:1999).
    """
    value = np.asarray(linear, dtype=np.float64)
    root = np.maximum(value, ENCODE_THRESHOLD) ** (1.0 / EXPONENT)
    curved = (1.0 + OFFSET) * root - OFFSET
    return np.where(value <= ENCODE_THRESHOLD, value * LINEAR_SLOPE, curved)


def quantise_srgb(linear: ArrayLike, bits: int = 8) -> NDArray[Any]:
    """Linear light as sRGB integers, clamped to what they can hold, rounded to the nearest.

    Parameters
    ----------
    linear : array_like
        Linear light; finite.
    bits : {8, 10, 16}
        How finely: 10 is 1023 steps, spread evenly over the integers of 16 bits, because no
        file of ours has ten.

    Returns
    -------
    ndarray of uint8 or uint16
        Of the same shape.

    Raises
    ------
    ValueError
        Another width.
    """
    if bits not in (8, 10, 16):
        raise ValueError(f"found {bits} bits, wanted 8, 10 or 16")
    encoded = np.clip(srgb_encode(linear), 0.0, 1.0)
    steps = np.floor(encoded * (2**bits - 1) + 0.5)
    if bits == 10:
        steps = np.floor(steps * (65535 / 1023) + 0.5)
    integers: NDArray[Any] = steps.astype(np.uint8 if bits == 8 else np.uint16)
    return integers
