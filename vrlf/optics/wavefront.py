"""Zernike wavefronts (OSA/ANSI Z80.28) as polynomials in millimetres of the pupil.

The standard's frame is the examiner's; ``frames`` turns the result once.
"""

from __future__ import annotations

from math import comb, factorial, sqrt

import numpy as np

from vrlf.optics import polynomial
from vrlf.optics.polynomial import Float

Term = tuple[int, int]


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


def zernike_coefficients_um(wavefront_um: Float, diameter_mm: float) -> dict[Term, float]:
    """The Zernike terms over a pupil that a polynomial wavefront is made of, exactly.

    The terms up to an order and the monomials up to it span the same polynomials, so this is
    the inverse of ``zernike_wavefront_um`` for any diameter: a wavefront measured over one
    pupil comes out as one over another (Schwiegerling 2002; Campbell 2003 by other means).

    Parameters
    ----------
    wavefront_um : ndarray (k, k)
        Polynomial in millimetres of the pupil, examiner's frame.
    diameter_mm : float
        The pupil over which the coefficients are to hold.

    Returns
    -------
    dict
        ``{(n, m): micrometres}``, every term up to the polynomial's degree.
    """
    unit = polynomial.scale(wavefront_um, diameter_mm / 2.0)
    order = polynomial.degree(unit)
    size = order + 1
    powers = [(i, j) for i in range(size) for j in range(size - i)]
    terms = [(n, m) for n in range(size) for m in range(-n, n + 1, 2)]
    basis = [polynomial.padded(zernike_polynomial(*term), size) for term in terms]
    columns = np.array([[each[power] for each in basis] for power in powers])
    wanted = polynomial.padded(unit, size)
    solved = np.linalg.solve(columns, np.array([wanted[power] for power in powers]))
    return dict(zip(terms, (float(value) for value in solved), strict=True))


def rescaled_um(
    coefficients_um: dict[Term, float], diameter_mm: float, to_diameter_mm: float
) -> dict[Term, float]:
    """The same wavefront's coefficients over another pupil about the same centre."""
    wavefront = zernike_wavefront_um(coefficients_um, diameter_mm)
    return zernike_coefficients_um(wavefront, to_diameter_mm)


def power_vector_of_zernike_d(
    coefficients_um: dict[Term, float], diameter_mm: float, *, higher_orders: bool
) -> tuple[float, float, float]:
    """(M, J0, J45) in dioptres of a wavefront, of its second order or with all orders in.

    M = (-4 sqrt3 c20 + 12 sqrt5 c40 - 24 sqrt7 c60 + 40 sqrt9 c80) / r^2,
    J0 = (-2 sqrt6 c22 + 6 sqrt10 c42 - 12 sqrt14 c62 + 20 sqrt18 c82) / r^2, J45 likewise with
    c2-2 ...: the curvature in the pupil's centre (Thibos, Hong, Bradley & Applegate 2004,
    equations 3, 4). Pupil radius r in mm, coefficients in um; examiner's frame.
    """
    radius_mm = diameter_mm / 2.0

    def summed(m: int) -> float:
        total = 0.0
        for n in range(2, 9 if higher_orders else 3, 2):
            # 4, 12, 24, 40 of the round terms; half of that, and sqrt 2 in the norm, of the rest.
            weight = (-1.0) ** (n // 2) * n * (n + 2) / 2.0 * sqrt(n + 1.0)
            if m:
                weight *= sqrt(2.0) / 2.0
            total += weight * coefficients_um.get((n, m), 0.0)
        return total / radius_mm**2

    return summed(0), summed(2), summed(-2)


def zernike_of_power_vector_um(
    m_d: float, j0_d: float, j45_d: float, diameter_mm: float
) -> dict[Term, float]:
    """The second-order terms over a pupil that amount to a power vector; the way back."""
    squared = (diameter_mm / 2.0) ** 2
    return {
        (2, -2): -j45_d * squared / (2.0 * sqrt(6.0)),
        (2, 0): -m_d * squared / (4.0 * sqrt(3.0)),
        (2, 2): -j0_d * squared / (2.0 * sqrt(6.0)),
    }
