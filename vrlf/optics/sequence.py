"""Well-spread points: Sobol's sequence, scrambled so that no structure of its own shows.

Any count gives a usable set; powers of two give the best.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vrlf.optics.polynomial import Float

UInt = NDArray[np.uint32]
# Which half of the points, or all of them.
Half = Literal["all", "first", "second"]

_BITS = 32
# Primitive polynomials and initial direction numbers of dimensions 2 to 4: degree, the inner
# coefficients, m_1.. (Joe & Kuo 2008, new-joe-kuo-6).
_JOE_KUO = ((1, 0, (1,)), (2, 1, (1, 3)), (3, 1, (1, 3, 1)))
# One fixed scramble for each dimension; any four different odd numbers serve.
_SEEDS = (0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D, 0x27D4EB2F)


def points(count: int) -> Float:
    """The first ``count`` points, shape (count, 4), in [0, 1).

    Owen-scrambled Sobol points: Sobol 1967; Burley 2020, "Practical Hash-based Owen
    Scrambling". Integer arithmetic throughout, so the same everywhere.
    """
    index = np.arange(count, dtype=np.uint32)
    columns = [
        _owen_scramble(_sobol(index, dimension), seed) for dimension, seed in enumerate(_SEEDS)
    ]
    # Half a step of the finest grid keeps points off 0 and centres them in their boxes.
    return (np.stack(columns, axis=-1).astype(np.float64) + 0.5) / 2.0**_BITS


def _sobol(index: UInt, dimension: int) -> UInt:
    value = np.zeros_like(index)
    for bit, direction in enumerate(_directions(dimension)):
        value ^= np.where((index >> np.uint32(bit)) & np.uint32(1), np.uint32(direction), 0).astype(
            np.uint32
        )
    return value


def _directions(dimension: int) -> list[int]:
    if dimension == 0:
        return [1 << (_BITS - 1 - bit) for bit in range(_BITS)]
    degree, inner, initial = _JOE_KUO[dimension - 1]
    m = list(initial)
    for k in range(degree, _BITS):
        value = m[k - degree] ^ (m[k - degree] << degree)
        for i in range(1, degree):
            if (inner >> (degree - 1 - i)) & 1:
                value ^= m[k - i] << i
        m.append(value)
    return [value << (_BITS - 1 - bit) for bit, value in enumerate(m)]


def _reverse_bits(x: UInt) -> UInt:
    for shift, mask in ((1, 0x55555555), (2, 0x33333333), (4, 0x0F0F0F0F), (8, 0x00FF00FF)):
        s, keep = np.uint32(shift), np.uint32(mask)
        x = ((x >> s) & keep) | ((x & keep) << s)
    return (x >> np.uint32(16)) | (x << np.uint32(16))


def _owen_scramble(x: UInt, seed: int) -> UInt:
    """Nested uniform scramble by hashing: each bit is flipped by a hash of those above it."""
    with np.errstate(over="ignore"):
        x = _reverse_bits(x)
        x ^= x * np.uint32(0x3D20ADEA)
        x += np.uint32(seed & 0xFFFFFFFF)
        x *= np.uint32((seed >> 16) | 1)
        x ^= x * np.uint32(0x05526C56)
        x ^= x * np.uint32(0x53A22864)
    return _reverse_bits(x)


def to_disc(square: Float) -> Float:
    """Points of the unit square to the unit disc, areas kept; shape (..., 2) in and out.

    Shirley & Chiu 1997, "A Low Distortion Map Between Disk and Square".
    """
    x, y = 2.0 * square[..., 0] - 1.0, 2.0 * square[..., 1] - 1.0
    wide = np.abs(x) > np.abs(y)
    radius = np.where(wide, x, y)
    other = np.where(wide, y, x)
    ratio = np.divide(other, radius, out=np.zeros_like(other), where=radius != 0.0)
    angle = np.where(wide, np.pi / 4.0 * ratio, np.pi / 2.0 - np.pi / 4.0 * ratio)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)


def half_of(values: Float, half: Half) -> Float:
    """One of two halves of well-spread points, each as well spread as so few can be."""
    middle = len(values) // 2
    return {"all": values, "first": values[:middle], "second": values[middle:]}[half]
