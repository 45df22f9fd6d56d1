"""Zernike wavefronts: orthonormal, in their known forms, and seen from the right side."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from optics_by_hand import unhurried, wavefront_um

from vrlf.model import Eye, Zernike
from vrlf.optics import polynomial
from vrlf.optics.eye import refraction_matrix_d, relaxed_wavefront_um
from vrlf.optics.refraction import transverse_aberration
from vrlf.optics.wavefront import zernike_polynomial, zernike_wavefront_um

TERMS = [(n, m) for n in range(9) for m in range(-n, n + 1, 2)]


def disc_quadrature() -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Points and weights that integrate polynomials of order 16 over the disc exactly."""
    # With r^2 as the variable the area element is even; 9 Gauss nodes carry order 17 in it,
    # 20 even angles carry frequencies up to 19.
    nodes, weights = np.polynomial.legendre.leggauss(9)
    radius = np.sqrt((nodes + 1.0) / 2.0)
    angle = 2.0 * np.pi * np.arange(20) / 20.0
    x = np.outer(radius, np.cos(angle)).ravel()
    y = np.outer(radius, np.sin(angle)).ravel()
    return x, y, np.repeat(weights / 2.0 / 20.0, 20)


def test_terms_are_orthonormal_over_the_disc() -> None:
    x, y, weights = disc_quadrature()
    values = np.array([polynomial.evaluate(zernike_polynomial(n, m), x, y) for n, m in TERMS])
    gram = (values * weights) @ values.T
    # The largest coefficient of order 8 is near 1000; rounding of its products stays below this.
    assert gram == pytest.approx(np.eye(len(TERMS)), abs=1e-11)


@pytest.mark.parametrize(
    ("term", "form"),
    [
        ((0, 0), lambda x, _: np.ones_like(x)),
        ((1, -1), lambda _, y: 2.0 * y),
        ((1, 1), lambda x, _: 2.0 * x),
        ((2, -2), lambda x, y: sqrt(6) * 2.0 * x * y),
        ((2, 0), lambda x, y: sqrt(3) * (2.0 * (x**2 + y**2) - 1.0)),
        ((2, 2), lambda x, y: sqrt(6) * (x**2 - y**2)),
        ((3, -3), lambda x, y: sqrt(8) * (3.0 * x**2 * y - y**3)),
        ((3, -1), lambda x, y: sqrt(8) * (3.0 * (x**2 + y**2) - 2.0) * y),
        ((3, 1), lambda x, y: sqrt(8) * (3.0 * (x**2 + y**2) - 2.0) * x),
        ((3, 3), lambda x, y: sqrt(8) * (x**3 - 3.0 * x * y**2)),
        (
            (4, 0),
            lambda x, y: sqrt(5) * (6.0 * (x**2 + y**2) ** 2 - 6.0 * (x**2 + y**2) + 1.0),
        ),
    ],
)
def test_known_forms(term: tuple[int, int], form) -> None:  # type: ignore[no-untyped-def]
    x, y = np.array([0.3, -0.6, 0.1, 0.9]), np.array([0.5, 0.2, -0.8, 0.1])
    value = polynomial.evaluate(zernike_polynomial(*term), x, y)
    assert value == pytest.approx(form(x, y), abs=1e-13)


@pytest.mark.parametrize("term", [(-1, 1), (2, 1), (2, 4), (3, -5)])
def test_no_such_term(term: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match=r"Zernike term"):
        zernike_polynomial(*term)


@unhurried
@given(
    st.dictionaries(st.sampled_from(TERMS), st.floats(-1.0, 1.0), max_size=8),
    st.floats(3.0, 8.0),
    st.floats(0.0, 1.0),
    st.floats(0.0, 6.28),
)
def test_wavefront_by_radius_and_angle(
    terms: dict[tuple[int, int], float], diameter_mm: float, rho: float, theta: float
) -> None:
    x, y = np.array([np.cos(theta), np.sin(theta)]) * rho * diameter_mm / 2.0
    value = polynomial.evaluate(zernike_wavefront_um(terms, diameter_mm), x, y)
    # The hand-made one takes the wearer's x; here both are the examiner's.
    by_hand = wavefront_um(terms, diameter_mm, np.array([-x, y]))
    assert value == pytest.approx(by_hand, abs=1e-10)


def measured(coefficients_um: dict[str, float], diameter_mm: float = 6.0) -> Eye:
    wavefront = Zernike(diameter_mm=diameter_mm, coefficients_um=coefficients_um)
    return Eye(pupil_mm=min(6.0, diameter_mm), zernike=wavefront)


def test_second_order_terms_as_a_refraction() -> None:
    """M = -4 sqrt(3) c20 / r^2, J0 = -2 sqrt(6) c22 / r^2, J45 = -2 sqrt(6) c2-2 / r^2."""
    r = 2.5
    matrix = refraction_matrix_d(measured({"2,0": 0.4, "2,2": -0.3, "2,-2": 0.2}, 2.0 * r))
    m = -4.0 * sqrt(3) * 0.4 / r**2
    j0 = -2.0 * sqrt(6) * -0.3 / r**2
    j45 = -2.0 * sqrt(6) * 0.2 / r**2
    # The wearer's x is mirrored: J45 turns its sign.
    wanted = np.array([[m + j0, -j45], [-j45, m - j0]])
    assert matrix == pytest.approx(wanted, abs=1e-12)


def test_spherical_aberration_is_no_refraction() -> None:
    assert refraction_matrix_d(measured({"4,0": 1.0})) == pytest.approx(np.zeros((2, 2)))


def test_wavefront_adds_to_the_prescription() -> None:
    eye = Eye(
        sphere_d=-3.0,
        vertex_mm=0.0,
        pupil_mm=4.0,
        zernike=Zernike(diameter_mm=4.0, coefficients_um={"2,0": 0.5}),
    )
    m = -3.0 - 4.0 * sqrt(3) * 0.5 / 4.0
    assert refraction_matrix_d(eye) == pytest.approx(m * np.eye(2), abs=1e-12)


def wearer_slope(coefficients_um: dict[str, float], u: tuple[float, float]) -> tuple[float, float]:
    tx, ty = transverse_aberration(relaxed_wavefront_um(measured(coefficients_um)))
    x, y = np.array(u[0]), np.array(u[1])
    return float(polynomial.evaluate(tx, x, y)), float(polynomial.evaluate(ty, x, y))


def test_vertical_coma_is_seen_alike_from_both_sides() -> None:
    """W = c sqrt(8) (3 rho^2 - 2) y/r has no odd power of x: the mirror leaves it.

    At the pupil's upper edge dW/dy = c sqrt(8) (9 - 2) / r, so T points down for c > 0.
    """
    wanted = -0.4 * sqrt(8) * 7.0 / 3.0 / 1000.0
    assert wearer_slope({"3,-1": 0.4}, (0.0, 3.0)) == pytest.approx((0.0, wanted), abs=1e-12)


def test_horizontal_coma_is_mirrored() -> None:
    """The examiner's W = c sqrt(8) (3 rho^2 - 2) x/r is minus that for the wearer.

    At the wearer's right edge of the pupil dW/dx = -c sqrt(8) (9 - 2) / r, so T points
    right for c > 0 where the unmirrored formula has it point left.
    """
    wanted = 0.4 * sqrt(8) * 7.0 / 3.0 / 1000.0
    assert wearer_slope({"3,1": 0.4}, (3.0, 0.0)) == pytest.approx((wanted, 0.0), abs=1e-12)


def test_tilt_is_a_prism() -> None:
    """W = 2 c x/r (examiner) is -2 c x/r for the wearer: T = (+2 c / r, 0) / 1000."""
    assert wearer_slope({"1,1": 0.3}, (1.1, -0.7)) == pytest.approx((0.2e-3, 0.0), abs=1e-15)
    assert wearer_slope({"1,-1": 0.3}, (1.1, -0.7)) == pytest.approx((0.0, -0.2e-3), abs=1e-15)
    assert wearer_slope({"0,0": 0.3}, (1.1, -0.7)) == (0.0, 0.0)


coefficients = st.lists(st.floats(-2.0, 2.0), min_size=16, max_size=16).map(
    lambda values: np.array(values).reshape(4, 4)
)
matrices = st.lists(st.floats(-3.0, 3.0), min_size=4, max_size=4).map(
    lambda values: np.array(values).reshape(2, 2)
)


@unhurried
@given(coefficients, matrices, st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_composed_polynomial_is_the_polynomial_of_turned_points(
    c: NDArray[np.float64], matrix: NDArray[np.float64], x: float, y: float
) -> None:
    point = np.array([x, y])
    composed = polynomial.evaluate(polynomial.compose_linear(c, matrix), *point)
    # Up to order 6 in values up to 6: the terms reach 1e5.
    assert composed == pytest.approx(polynomial.evaluate(c, *(matrix @ point)), abs=1e-8)


@unhurried
@given(coefficients, coefficients, st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_sums_products_and_mirrors(
    a: NDArray[np.float64], b: NDArray[np.float64], x: float, y: float
) -> None:
    def at(c: NDArray[np.float64], px: float = x) -> float:
        return float(polynomial.evaluate(c, np.array(px), np.array(y)))

    small = b[:2, :3]
    assert at(polynomial.add(a, small)) == pytest.approx(at(a) + at(small), abs=1e-11)
    assert at(polynomial.multiply(a, small)) == pytest.approx(at(a) * at(small), abs=1e-9)
    assert at(polynomial.mirror_x(a)) == pytest.approx(at(a, -x), abs=1e-11)
    assert at(polynomial.padded(small, 6)) == pytest.approx(at(small), abs=1e-11)


def test_derivatives_and_degree() -> None:
    # 3 + 2 x y^2 - x^2: d/dx = 2 y^2 - 2 x, d/dy = 4 x y.
    c = np.zeros((3, 3))
    c[0, 0], c[1, 2], c[2, 0] = 3.0, 2.0, -1.0
    x, y = np.array(0.7), np.array(-0.4)
    along_x = polynomial.evaluate(polynomial.derivative(c, 0), x, y)
    along_y = polynomial.evaluate(polynomial.derivative(c, 1), x, y)
    assert along_x == pytest.approx(2.0 * 0.16 - 1.4, abs=1e-14)
    assert along_y == pytest.approx(4.0 * 0.7 * -0.4, abs=1e-14)
    assert polynomial.degree(c) == 3
    assert polynomial.degree(np.zeros((4, 4))) == 0
