"""Zernike wavefronts (OSA/ANSI Z80.28) as polynomials in millimetres of the pupil.

The standard's frame is the examiner's; ``frames`` turns the result once.
"""

from __future__ import annotations

from math import comb, factorial, sqrt

import numpy as np

from vrlf.optics import polynomial
from vrlf.optics.polynomial import Float


def zernike_polynomial(n: int, m: int) -> Float:
    """Normalised Zernike polynomial over the unit disc, in the examiner's frame.

    Parameters
    ----------
    n, m : int
        Radial order and signed azimuthal frequency; ``m < 0`` are the sine terms.

    Returns
    -------
    ndarray, shape (n + 1, n + 1)
        Coefficients of x**i y**j; its mean square over the disc is 1.

    Notes
    -----
    Thibos, Applegate, Schwiegerling & Webb 2002, "Standards for reporting the optical
    aberrations of eyes", equations 1 to 3.
    """
    k = abs(m)
    if n < 0 or k > n or (n - k) % 2:
        raise ValueError(f"Zernike term ({n}, {m}): wanted |m| <= n and n - m even")
    angular = _angular_polynomial(k, sine=m < 0)
    total = np.zeros((1, 1))
    for s in range((n - k) // 2 + 1):
        weight = (-1.0) ** s * factorial(n - s)
        weight /= factorial(s) * factorial((n + k) // 2 - s) * factorial((n - k) // 2 - s)
        # rho^(n-2s) carries rho^k in the angular part; what is left is a power of x^2 + y^2.
        radial = _radius_squared_power((n - k) // 2 - s)
        total = polynomial.add(total, weight * polynomial.multiply(radial, angular))
    norm = sqrt((2.0 - (m == 0)) * (n + 1))
    result = np.zeros((n + 1, n + 1))
    result[: total.shape[0], : total.shape[1]] = norm * total
    return result


def _angular_polynomial(k: int, *, sine: bool) -> Float:
    """rho^k cos(k theta), or sin: the real or imaginary part of (x + iy)^k."""
    c = np.zeros((k + 1, k + 1))
    for j in range(k + 1):
        if j % 2 == int(sine):
            c[k - j, j] = comb(k, j) * (-1.0) ** (j // 2)
    return c


def _radius_squared_power(power: int) -> Float:
    """(x^2 + y^2)^power."""
    c = np.zeros((2 * power + 1, 2 * power + 1))
    for j in range(power + 1):
        c[2 * (power - j), 2 * j] = comb(power, j)
    return c


def zernike_wavefront_um(
    coefficients_um: dict[tuple[int, int], float], diameter_mm: float, *, order: int | None = None
) -> Float:
    """Wavefront of a set of Zernike terms.

    Parameters
    ----------
    coefficients_um : dict
        ``{(n, m): micrometres}``, normalised.
    diameter_mm : float
        The pupil over which the coefficients hold.
    order : int, optional
        Keep only terms of this radial order.

    Returns
    -------
    ndarray, shape (k, k), micrometre
        Polynomial in the pupil coordinates in millimetres, examiner's frame.
    """
    total = np.zeros((1, 1))
    for (n, m), value in sorted(coefficients_um.items()):
        if order is None or n == order:
            total = polynomial.add(total, value * zernike_polynomial(n, m))
    return polynomial.scale(total, 2.0 / diameter_mm)
