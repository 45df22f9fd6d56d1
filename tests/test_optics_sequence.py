"""The sampling points: well spread, in range, the same everywhere."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from optics_by_hand import unhurried

from vrlf.optics.sequence import points, to_disc

SHA256 = "d618234c874c28d74f2c3b5e9d21d934acd0d57d65788fcf3f1104482a0611e2"


def test_points_are_these() -> None:
    """Integer arithmetic: the same bytes on every machine. A change breaks stored pictures."""
    first = [
        [0.56552283, 0.96107208, 0.58944097, 0.69474551],
        [0.20682452, 0.35477202, 0.06577358, 0.42762759],
        [0.83529206, 0.13630551, 0.29107495, 0.15293748],
        [0.42738219, 0.53315051, 0.78508112, 0.80265937],
    ]
    assert points(4) == pytest.approx(np.array(first), abs=5e-9)
    whole = (points(1024) * 2.0**32).astype("<u4").tobytes()
    assert hashlib.sha256(whole).hexdigest() == SHA256


def test_fewer_points_are_the_first_of_more() -> None:
    assert (points(100) == points(256)[:100]).all()
    assert (points(256) == points(256)).all()
    assert points(0).shape == (0, 4)


def test_range() -> None:
    many = points(1 << 14)
    assert many.shape == (1 << 14, 4)
    assert many.min() > 0.0
    assert many.max() < 1.0


def intervals_are_even(pair: np.ndarray, t: int) -> None:
    """Every elementary interval of 2^(t-k) of the square holds 2^t of 2^k points."""
    k = int(np.log2(len(pair)))
    for split in range(k - t + 1):
        shape = (2**split, 2 ** (k - t - split))
        column, row = (pair * shape).astype(int).T
        held = np.bincount(column * shape[1] + row, minlength=shape[0] * shape[1])
        assert (held == 2**t).all(), shape


@pytest.mark.parametrize("k", range(1, 13))
def test_pupil_points_are_a_0_2_sequence(k: int) -> None:
    """Dimensions 0 and 1 (polynomials 1 and x + 1) have t = 0, Sobol 1967; Owen keeps it."""
    intervals_are_even(points(1 << k)[:, :2], 0)


@pytest.mark.parametrize("k", range(3, 13))
def test_pixel_points_are_a_3_2_sequence(k: int) -> None:
    """Dimensions 2 and 3: t is at most the sum of their polynomials' degrees less one.

    With x^2 + x + 1 and x^3 + x + 1 that is 1 + 2 (Niederreiter 1992).
    """
    intervals_are_even(points(1 << k)[:, 2:], 3)


@pytest.mark.parametrize("column", range(4))
def test_each_dimension_is_stratified(column: int) -> None:
    held, _ = np.histogram(points(512)[:, column], bins=512, range=(0, 1))
    assert (held == 1).all()


def test_four_dimensions_together() -> None:
    """All 16 quarters of the 4-cube hold the same share: t is at most 0 + 0 + 1 + 2 = 3."""
    halves = (points(1 << 7) >= 0.5) @ [1, 2, 4, 8]
    assert (np.bincount(halves, minlength=16) == 8).all()


def test_disc_points_have_the_discs_moments() -> None:
    """E r^2 = 1/2, E r^4 = 1/3, E x^2 = 1/4, E x^4 = 1/8, E x^2 y^2 = 1/24, odd ones 0."""
    x, y = to_disc(points(4096)[:, :2]).T
    r2 = x**2 + y**2
    assert r2.max() <= 1.0
    found = [r2.mean(), (r2**2).mean(), (x**2).mean(), (x**4).mean(), (x * x * y * y).mean()]
    odd = [x.mean(), y.mean(), (x * y).mean(), (x**3).mean(), (x * y**2).mean()]
    # 4096 random points would be off by 0.005; these are by less than a tenth of it.
    assert found == pytest.approx([1 / 2, 1 / 3, 1 / 4, 1 / 8, 1 / 24], abs=5e-4)
    assert odd == pytest.approx([0.0] * 5, abs=5e-4)


@unhurried
@given(st.floats(0.01, 0.99), st.floats(0.01, 0.99))
def test_disc_map_keeps_areas(x: float, y: float) -> None:
    """Its Jacobian is pi everywhere but on the seams: the disc's area over the square's."""
    step = 1e-6
    seam = min(abs(abs(2 * x - 1) - abs(2 * y - 1)), abs(2 * x - 1), abs(2 * y - 1))
    if seam < 1e-3:
        return
    square, right, up = np.array([x, y]), np.array([step, 0.0]), np.array([0.0, step])
    by_x = (to_disc(square + right) - to_disc(square - right)) / (2 * step)
    by_y = (to_disc(square + up) - to_disc(square - up)) / (2 * step)
    # Central differences; near the centre the map's curvature costs a few 1e-6.
    assert abs(by_x[0] * by_y[1] - by_x[1] * by_y[0]) == pytest.approx(np.pi, abs=1e-4)


def test_disc_map_at_known_points() -> None:
    square = np.array([[0.5, 0.5], [1.0, 0.5], [0.5, 1.0], [0.0, 0.5], [1.0, 1.0], [0.75, 0.5]])
    half = 0.5**0.5
    wanted = np.array([[0, 0], [1, 0], [0, 1], [-1, 0], [half, half], [0.5, 0]])
    assert to_disc(square) == pytest.approx(wanted, abs=1e-15)
