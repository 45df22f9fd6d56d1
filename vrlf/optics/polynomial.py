"""Polynomials in the two pupil coordinates, as plain coefficient arrays.

``c[i, j]`` is the coefficient of ``x**i * y**j``. Wavefronts and the rays' aberrations
are both of this kind, which makes sphere, cylinder, prism, Zernike terms and
accommodation one and the same thing to everything downstream.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]


def add(a: Float, b: Float) -> Float:
    """Sum of two polynomials of any sizes; the result has the larger size."""
    rows, columns = (max(m, n) for m, n in zip(a.shape, b.shape, strict=True))
    total = np.zeros((rows, columns))
    total[: a.shape[0], : a.shape[1]] += a
    total[: b.shape[0], : b.shape[1]] += b
    return total


def multiply(a: Float, b: Float) -> Float:
    """Product of two polynomials."""
    product = np.zeros((a.shape[0] + b.shape[0] - 1, a.shape[1] + b.shape[1] - 1))
    for (i, j), value in np.ndenumerate(a):
        product[i : i + b.shape[0], j : j + b.shape[1]] += value * b
    return product


def derivative(c: Float, axis: int) -> Float:
    """Partial derivative along x (axis 0) or y (axis 1)."""
    powers = np.arange(1, c.shape[axis], dtype=np.float64)
    if not len(powers):
        return np.zeros((1, 1))
    shape = (-1, 1) if axis == 0 else (1, -1)
    kept = c[1:, :] if axis == 0 else c[:, 1:]
    return np.asarray(kept * powers.reshape(shape))


def evaluate(c: Float, x: Float, y: Float) -> Float:
    """Value at points; ``x`` and ``y`` broadcast."""
    return np.asarray(np.polynomial.polynomial.polyval2d(x, y, c))


def on_grid(c: Float, x: Float, y: Float) -> Float:
    """Value at every x with every y: (n,) and (m,) in, (m, n) out, a row for each y."""
    powers_x = np.polynomial.polynomial.polyvander(x, c.shape[0] - 1)
    powers_y = np.polynomial.polynomial.polyvander(y, c.shape[1] - 1)
    return np.asarray(powers_y @ c.T @ powers_x.T)


def scale(c: Float, factor: float) -> Float:
    """The polynomial in ``factor * (x, y)``: what was c(x, y) becomes c(factor x, factor y)."""
    powers = np.add.outer(np.arange(c.shape[0]), np.arange(c.shape[1]))
    return np.asarray(c * factor**powers)


def mirror_x(c: Float) -> Float:
    """The polynomial in ``(-x, y)``."""
    return np.asarray(c * (-1.0) ** np.arange(c.shape[0])[:, None])


def degree(c: Float) -> int:
    """Largest total power with a coefficient that is not zero; 0 for a constant."""
    i, j = np.nonzero(c)
    return int((i + j).max()) if len(i) else 0


def compose_linear(c: Float, matrix: Float) -> Float:
    """The polynomial in ``matrix @ (x, y)``: same total degree, in the new coordinates."""
    size = degree(c) + 1
    x = np.array([[0.0, matrix[0, 1]], [matrix[0, 0], 0.0]])
    y = np.array([[0.0, matrix[1, 1]], [matrix[1, 0], 0.0]])
    x_powers, y_powers = [np.ones((1, 1))], [np.ones((1, 1))]
    for _ in range(size - 1):
        x_powers.append(multiply(x_powers[-1], x))
        y_powers.append(multiply(y_powers[-1], y))
    total = np.zeros((size, size))
    for (i, j), value in np.ndenumerate(c):
        if value:
            term = value * multiply(x_powers[i], y_powers[j])
            total = add(total, term[:size, :size])
    return total


def padded(c: Float, size: int) -> Float:
    """The same polynomial in a (size, size) array."""
    result = np.zeros((size, size))
    kept = c[:size, :size]
    result[: kept.shape[0], : kept.shape[1]] = kept
    return result
