"""Diffraction as a map of rays, against closed forms and waves propagated by themselves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import fresnel as fresnel_integrals
from scipy.special import j0, j1, sici

from vrlf.optics.fresnel import EDGE, residual, spread_of

Values = NDArray[Any]

NM = 545.0
GAP_MM = 6.0
# What the table's 16 rows per unit of sqrt N and 512 places misplace of the light.
TABLE = 1.5e-3


def spread_evenly(number: float, count: int, *, is_round: bool = False) -> Values:
    """Where rays end that fill half a slit or a disc evenly, in lambda g / w, ascending."""
    share = (np.arange(count) + 0.5) / count
    rho = np.sqrt(share) if is_round else share
    moved = residual(spread_of(is_round), rho, np.full(count, number))
    return number * rho / 2.0 + moved


def held(places: Values, within: Values) -> Values:
    """The share of the rays that end within these distances."""
    return np.searchsorted(np.sort(places), within) / len(places)


def test_far_away_a_slit_makes_sinc_squared() -> None:
    xi = np.array([0.2, 0.44295, 0.7, 1.0, 1.5, 2.3, 5.7, 20.0])
    wanted = 2.0 / np.pi * sici(2.0 * np.pi * xi)[0] - 2.0 * np.sin(np.pi * xi) ** 2 / (
        np.pi**2 * xi
    )
    assert held(spread_evenly(0.0, 20000), xi) == pytest.approx(wanted, abs=TABLE)


def test_far_away_a_disc_makes_airys_pattern() -> None:
    xi = np.array([0.3, 0.53, 0.9, 1.22, 1.7, 2.233, 6.0, 20.0])
    wanted = 1.0 - j0(np.pi * xi) ** 2 - j1(np.pi * xi) ** 2
    assert held(spread_evenly(0.0, 20000, is_round=True), xi) == pytest.approx(wanted, abs=TABLE)


@pytest.mark.parametrize("number", [0.6, 2.0, 3.7, 17.0, 90.0, 400.0])
def test_a_slit_makes_fresnels_pattern(number: float) -> None:
    # Both edges by Fresnel integrals: u = (2 s N - 2 xi) / sqrt(2 N) at s = -1/2, 1/2.
    top = number / 2.0 + 300.0
    xi = np.linspace(0.0, top, 400_001)
    sine, cosine = fresnel_integrals(
        (np.array([[-1.0], [1.0]]) * number - 2.0 * xi) / np.sqrt(2.0 * number)
    )
    light = ((cosine[1] - cosine[0]) ** 2 + (sine[1] - sine[0]) ** 2) / (2.0 * number)
    share = 2.0 * np.concatenate([[0.0], np.cumsum(light[1:] + light[:-1])]) * (xi[1] / 2.0)
    within = np.linspace(0.05, 1.3, 30) * max(number / 2.0, 1.0)
    wanted = np.interp(within, xi, share)
    # Beyond the table (N > 144) the edges are taken to spread by themselves: 1/(pi sqrt(2 N)).
    assert held(spread_evenly(number, 20000), within) == pytest.approx(
        wanted, abs=TABLE if number < 144.0 else 5e-3
    )


def test_a_disc_makes_fresnels_pattern() -> None:
    # Hankel's integral, ring by ring.
    number, rings = 5.3, 4000
    s = (np.arange(rings) + 0.5) / rings / 2.0
    xi = np.arange(0.0, 8.0, 0.01) + 0.005
    weight = np.exp(1j * np.pi * number * s**2) * 2.0 * np.pi * s * (0.5 / rings)
    light = np.abs(j0(2.0 * np.pi * xi[:, None] * s) @ weight) ** 2
    share = np.cumsum(light * 2.0 * np.pi * xi) * 0.01 / (np.pi / 4.0)
    within = xi[20::60] + 0.005
    got = held(spread_evenly(number, 20000, is_round=True), within)
    assert got == pytest.approx(share[20::60], abs=TABLE)


def propagated(amplitude: Values, step_mm: float, nm: float, distance_mm: float) -> Values:
    """Light behind an aperture: Fresnel's propagation, as a product with its spectrum's phase."""
    per_mm = np.fft.fftfreq(len(amplitude), step_mm)
    turned = np.exp(-1j * np.pi * nm * 1e-6 * distance_mm * per_mm**2)
    return np.abs(np.fft.ifft(np.fft.fft(amplitude) * turned)) ** 2


@pytest.mark.parametrize(
    ("width_mm", "index", "source_mm"),
    [(0.08, 1.0, np.inf), (0.13, 1.49, np.inf), (0.06, 1.0, 2.6), (0.2, 1.3, -11.0)],
)
def test_waves_through_a_slit_end_where_the_rays_do(
    width_mm: float, index: float, source_mm: float
) -> None:
    """A wave from a point (or toward one) before the slit, then through a spacer of an index."""
    count, step_mm = 1 << 16, 1e-4
    x = (np.arange(count) - count // 2) * step_mm
    phase = np.pi * x**2 / (NM * 1e-6 * source_mm)
    inside = np.clip((width_mm / 2.0 - np.abs(x)) / step_mm + 0.5, 0.0, 1.0)
    thickness_mm = index * GAP_MM
    light = propagated(inside * np.exp(1j * phase), step_mm, NM / index, thickness_mm)
    middle = count // 2
    share = np.cumsum(light[middle:] + light[middle:0:-1][: count - middle])
    share = (share - light[middle]) / light.sum()
    scale = 1.0 + GAP_MM / source_mm
    unit_mm = NM * 1e-6 * GAP_MM / width_mm
    number = width_mm**2 * abs(scale) / (NM * 1e-6 * GAP_MM)
    rays_mm = unit_mm * spread_evenly(number, 20000)
    within = np.arange(10, 1500, 40)
    got = held(rays_mm, (within + 0.5) * step_mm)
    # What the wave's tail folds over the grid's 6.6 mm, and samples of the slit's edge.
    assert got == pytest.approx(share[within], abs=3e-3)


def test_an_oblique_cylinder_is_exact_along_each_axis() -> None:
    """Light along x behind a square, summed over y: the slit's, moved by the rays' own place."""
    side, n_xx, n_xy, n_yy = 128, 2.1, 0.9, -0.7
    s = (np.arange(side) + 0.5) / side - 0.5
    form = n_xx * s[None, :] ** 2 + 2.0 * n_xy * s[None, :] * s[:, None] + n_yy * s[:, None] ** 2
    light = np.abs(np.fft.fft2(np.exp(1j * np.pi * form), (16 * side, 16 * side))) ** 2
    along = np.fft.fftshift(light.sum(axis=0))
    xi = np.fft.fftshift(np.fft.fftfreq(16 * side, 1.0 / side))
    share = np.cumsum(along) / along.sum()
    places = spread_evenly(n_xx, 2000)
    places = (np.concatenate([-places, places])[:, None] + n_xy * s).ravel()
    within = np.linspace(-3.0, 3.0, 25)
    # 128 samples a side fold tails of a percent over.
    got = held(places, within)
    assert got == pytest.approx(np.interp(within, xi + 1.0 / 32.0, share), abs=4e-3)


def test_shadows_of_wide_openings_keep_their_middle() -> None:
    rho = np.linspace(0.0, 0.9, 50)
    for is_round in (False, True):
        moved = residual(spread_of(is_round), rho, np.full(50, 1e6))
        # 0.1 of half a width from the border is 50 of the edge's widths sqrt(N), of 1000.
        assert np.abs(moved).max() <= 1e-2 * 1000.0
        assert np.abs(moved[:5]).max() == 0.0


def test_no_ray_is_thrown_farther_than_the_tails_end() -> None:
    border = residual(spread_of(False), np.array([1.0, 1.0 + 1e-7]), np.zeros(2))
    assert border == pytest.approx(1.0 / (np.pi**2 * EDGE), rel=0.01)
