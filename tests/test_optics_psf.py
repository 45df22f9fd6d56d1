"""Point spreads against closed forms, against each other and against what is perceived."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from optics_by_hand import PITCH_MM, Points, rig
from scipy.special import j0, j1

from vrlf.errors import InputError
from vrlf.optics import polynomial
from vrlf.optics.bench import bench_of
from vrlf.optics.polynomial import Float
from vrlf.optics.psf import (
    Cells,
    PointSpread,
    apodisation,
    cell_shares,
    fraunhofer,
    geometric_half_light_slope,
    geometric_shares,
    half_light_slope,
    modulation,
    perfect_modulation,
    rays_through,
    strehl_ratio,
)
from vrlf.optics.pupil import seen_wavefront, spot_slopes, widest_slope
from vrlf.optics.refraction import quadratic_wavefront_um
from vrlf.reference.perceive import perceive

FLAT = np.zeros((1, 1))
GREEN_NM = 555.0
WIDTH = GREEN_NM * 1e-6 / 3.0  # lambda / D of a 3 mm pupil

# Nothing in these is symmetric; each has something of another kind.
ABERRATIONS = {
    "coma": {"3,1": 0.9, "3,-1": 0.4},
    "trefoil": {"3,3": 0.7, "3,-3": -0.5, "2,0": 0.3},
    "oblique astigmatism": {"2,-2": 0.8, "2,2": 0.3, "2,0": 0.5, "3,1": 0.3},
    "all": {"2,-2": 0.4, "2,0": -0.5, "3,-1": -0.5, "3,3": 0.3, "4,0": 0.2, "4,-2": 0.1},
}


def wavefront_of(terms: dict[str, float], pupil_mm: float = 6.0) -> Float:
    zernike = {"diameter_mm": 6.0, "coefficients_um": terms}
    seen = seen_wavefront(rig(left={"pupil_mm": pupil_mm, "zernike": zernike}), "left")
    return seen.reference_um


def density(psf: PointSpread, at_slope: float, count: int) -> tuple[Float, Float]:
    """Light per squared slope on ``count`` cells from -at to at, and their centres."""
    cells = Cells(count, 2.0 * at_slope / (count - 1))
    return cell_shares(psf, cells) / cells.step_slope**2, cells.centres_slope


# Diffraction alone


def airy(radius_slope: Float) -> Float:
    """(2 J1(v) / v)^2, Airy 1835."""
    v = np.maximum(np.pi * radius_slope / WIDTH, 1e-9)
    return np.asarray((2.0 * j1(v) / v) ** 2)


def test_a_perfect_pupil_of_3_mm_gives_the_airy_pattern() -> None:
    psf = fraunhofer(FLAT, 3.0, GREEN_NM)
    found, x = density(psf, 5.0 * WIDTH, 801)
    wanted = airy(np.hypot(x[None, :], x[:, None]))
    # The integral of the pattern over all slopes is 4 / pi (lambda / D)^2.
    peak = np.pi / 4.0 / WIDTH**2
    # 1 % is asked for. A rim that is smoothed over one of 256 samples lacks 2/3 of a sample's
    # width of energy, 0.26 %, which all else seems to have more of; the pattern itself is exact.
    assert np.abs(found / peak - wanted).max() < 0.003
    assert np.abs(found / found.max() - wanted).max() < 1e-4


def test_the_first_dark_ring_is_at_1_22() -> None:
    found, x = density(fraunhofer(FLAT, 3.0, GREEN_NM), 2.0 * WIDTH, 1601)
    across = found[800, 800:]
    inner = across[: int(1.6 / 2.0 * 800)]  # the second ring is at 2.23, its light begins there
    assert x[800 + int(np.argmin(inner))] / WIDTH == pytest.approx(1.2197, rel=0.01)


def test_modulation_of_a_perfect_pupil_is_the_closed_form() -> None:
    psf = fraunhofer(FLAT, 3.0, GREEN_NM)
    share = np.linspace(0.001, 1.2, 100)
    limit = np.where(share < 1.0, np.arccos(np.minimum(share, 1.0)), 0.0)
    limit = 2.0 / np.pi * (limit - share * np.sqrt(np.maximum(1.0 - share**2, 0.0)))
    for angle in (0.0, 0.3, np.pi / 2.0, 2.5):
        vectors = share[:, None] / WIDTH * np.array([np.cos(angle), np.sin(angle)])
        # 256 samples stand for the round rim to a few thousandths at the very cutoff.
        assert modulation(psf, vectors) == pytest.approx(limit, abs=3e-3)
    assert perfect_modulation(share / WIDTH, 3.0, GREEN_NM) == pytest.approx(limit, abs=1e-12)


@pytest.mark.parametrize("name", ABERRATIONS)
def test_no_light_is_lost(name: str) -> None:
    """Parseval: the samples sum to 1, and so do the cells of any grid over the period."""
    psf = fraunhofer(wavefront_of(ABERRATIONS[name]), 6.0, 545.0)
    assert psf.share.sum() == pytest.approx(1.0, abs=1e-12)
    cells = Cells(301, psf.period_slope / 301)
    assert cell_shares(psf, cells).sum() == pytest.approx(1.0, abs=1e-12)
    wider = Cells(301, 2.0 * psf.period_slope / 301)  # no light twice
    # The period's border runs through the cells at the rim, where hardly any light is.
    assert cell_shares(psf, wider).sum() == pytest.approx(1.0, abs=1e-3)


def test_it_is_fraunhofers_integral() -> None:
    """Against a sum in rings and angles, at directions that no grid shares."""
    wavefront = wavefront_of(ABERRATIONS["all"])
    psf = fraunhofer(wavefront, 6.0, 610.0)
    node, weight = np.polynomial.legendre.leggauss(100)
    radius = 3.0 * np.sqrt((node[:, None] + 1.0) / 2.0)
    angle = np.arange(240) * 2.0 * np.pi / 240
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    heights = polynomial.evaluate(wavefront, x, y) * 1e-3
    cells, area = Cells(9, 3.1e-4), np.pi * 9.0
    found = cell_shares(psf, Cells(9, 3.1e-4)) / cells.step_slope**2
    fine = np.linspace(-0.5, 0.5, 8, endpoint=False) + 1.0 / 16.0  # a cell is a mean
    for row, column in ((2, 6), (4, 4), (7, 1), (5, 3)):
        centre = cells.centres_slope[[column, row]]
        total = 0.0
        for dx, dy in np.stack(np.meshgrid(fine, fine), axis=-1).reshape(-1, 2):
            p, q = centre + cells.step_slope * np.array([dx, dy])
            field = np.exp(2j * np.pi * (heights - p * x - q * y) / 610e-6)
            total += abs(weight @ field.mean(axis=1) / 2.0) ** 2 * area / 610e-6**2
        # The smoothed rim of a sampled pupil, against the brightest cell.
        assert found[row, column] == pytest.approx(total / 64.0, abs=5e-3 * found.max())


def test_strehl_of_defocus_is_the_closed_form() -> None:
    """(sin(pi w) / (pi w))^2 for w waves at the rim, on the axis; Goodman 6.4."""
    for waves in (0.0, 0.1, 0.25, 0.5):
        power_d = 2.0 * waves * GREEN_NM * 1e-3 / 1.5**2
        psf = fraunhofer(quadratic_wavefront_um(power_d * np.eye(2)), 3.0, GREEN_NM)
        assert strehl_ratio(psf) == pytest.approx(np.sinc(waves) ** 2, abs=1e-4)


def test_strehl_of_small_aberrations_is_marechals() -> None:
    """exp(-(2 pi rms / lambda)^2), good to a few per cent above 0.8 (Mahajan 1982)."""
    wavefront = wavefront_of({"3,1": 0.02, "3,-3": 0.015})
    psf = fraunhofer(wavefront, 6.0, GREEN_NM)
    variance = (2.0 * np.pi * np.hypot(0.02, 0.015) / 0.555) ** 2
    assert strehl_ratio(psf) == pytest.approx(np.exp(-variance), rel=0.01)


def test_half_the_light_of_a_perfect_pupil() -> None:
    """1 - J0^2 - J1^2 = 1/2, Rayleigh 1881."""
    v = np.linspace(1.0, 2.5, 15001)
    inside = 1.0 - j0(v) ** 2 - j1(v) ** 2
    wanted = 2.0 * v[np.argmin(np.abs(inside - 0.5))] / np.pi * WIDTH
    found = half_light_slope(fraunhofer(FLAT, 3.0, GREEN_NM), Cells(241, 10.0 * WIDTH / 241))
    # The circle's border runs through cells of 1/100 of its width.
    assert found == pytest.approx(wanted, rel=0.015)


# Diffraction and geometry


def moments(shares: Float, x: Float, y: Float) -> Points:
    """Mean, then second and third moments about it."""
    shares = shares / shares.sum()
    mean = np.array([(shares * x).sum(), (shares * y).sum()])
    p, q = x - mean[0], y - mean[1]
    higher = [p * p, p * q, q * q, p**3, p * p * q, p * q * q, q**3]
    return np.array([*mean, *((shares * each).sum() for each in higher)])


@pytest.mark.parametrize("name", ABERRATIONS)
def test_both_point_spreads_lie_the_same_way(name: str) -> None:
    """Mean, second and third moments, in a pupil whose rim lets nothing through.

    A sharp rim scatters so much light that the moments diverge. Without one the means agree
    exactly (Ehrenfest's theorem in the pupil) and the second moments but for the amplitude's
    own, (lambda / 2 pi)^2 <|grad A|^2>, which is taken off.
    """
    rho = 0.6  # 10^(-5.4) at the rim
    wavefront = wavefront_of({key: 4.0 * um for key, um in ABERRATIONS[name].items()})
    psf = fraunhofer(wavefront, 6.0, 545.0, stiles_crawford_per_mm2=rho)
    x, y = psf.slopes[None, :], psf.slopes[:, None]
    found = moments(psf.share, x, y)
    rays = rays_through(wavefront, 6.0, stiles_crawford_per_mm2=rho)
    wanted = moments(rays.weights, *rays.slopes.T)
    # A^2 = exp(-2 r^2 / w^2): <|dA/dx|^2> = 1 / w^2.
    own = (545e-6 / 2.0 / np.pi) ** 2 * rho * np.log(10.0) / 2.0
    found[[2, 4]] -= own
    width = np.sqrt(wanted[2] + wanted[4])
    scale = width ** np.array([1, 1, 2, 2, 2, 3, 3, 3, 3])
    # In the third moments, too, the amplitude has a part: lambda^2 over the spread's square.
    assert (found - wanted) / scale == pytest.approx(np.zeros(9), abs=3e-3)
    assert np.abs(wanted[5:] / scale[5:]).max() > 0.1  # not symmetric: mirrors would be seen


@pytest.mark.parametrize("name", ABERRATIONS)
def test_both_point_spreads_have_the_same_outline(name: str) -> None:
    """In an open pupil: on cells wider than the fringes the two are nearly one picture."""
    wavefront = wavefront_of({key: 3.0 * um for key, um in ABERRATIONS[name].items()})
    cells = Cells(25, 2.2 * widest_slope(wavefront, 6.0) / 25)
    rays = geometric_shares(rays_through(wavefront, 6.0), cells)
    seen = cell_shares(fraunhofer(wavefront, 6.0, 465.0), cells)

    def alike(other: Float) -> float:
        return float(np.corrcoef(rays.ravel(), other.ravel())[0, 1])

    others = [alike(each) for each in (seen[::-1], seen[:, ::-1], seen[::-1, ::-1], seen.T)]
    assert alike(seen) > 0.99
    assert 1.0 - alike(seen) < (1.0 - max(others)) / 3.0


def test_defocus_blurs_over_the_pupil_times_its_power() -> None:
    """0.25 D in 6 mm: 1.5 mrad, 5.2 arcmin.

    By rays the spot is that disc. With diffraction the modulation of a disc of diameter B has
    its first zero at 1.22 / B; of the pupil only what overlaps itself, lambda f shifted, counts:
    a disc narrower by 1 - lambda f / D.
    """
    blur = 6.0 * 0.25 / 1000.0
    wavefront = quadratic_wavefront_um(-0.25 * np.eye(2))
    cells = Cells(401, 1.2 * blur / 401)
    rays = rays_through(wavefront, 6.0)
    lit = geometric_shares(rays, cells) > 0.0
    # To a cell on either side.
    assert np.ptp(cells.centres_slope[lit.any(axis=0)]) == pytest.approx(blur, abs=0.008 * blur)
    assert geometric_half_light_slope(rays) == pytest.approx(blur / np.sqrt(2.0), rel=1e-3)
    cycles = np.linspace(0.6, 1.5, 2001) * 1.2197 / blur
    psf = fraunhofer(wavefront, 6.0, GREEN_NM)
    zero = cycles[np.argmin(modulation(psf, np.stack([cycles, 0.0 * cycles], axis=-1)))]
    # The overlap is a lens and no disc: a per cent at two waves.
    overlap = 1.0 - zero * GREEN_NM * 1e-6 / 6.0
    assert zero * overlap == pytest.approx(1.2197 / blur, rel=0.02)


def test_rays_show_what_the_wearer_perceives() -> None:
    """One white pixel before the bare panel, by the reference's perception: the same spot."""
    zernike: dict[str, Any] = {
        "diameter_mm": 5.0,
        "coefficients_um": {"3,1": 1.2, "3,-1": 0.5, "3,3": -0.4, "2,-2": 1.0},
    }
    eye = {"pupil_mm": 5.0, "zernike": zernike, "sphere_d": -1.0, "prism_pd": [0.2, -0.1]}
    given = rig(left=eye | {"vertex_mm": 0.0})
    panel = np.zeros((30, 60, 3))
    panel[15, 14] = 1.0  # column, row: half a pixel left of and below the axis
    seen = perceive(panel, given, 1024)[:, :30, 1]
    per_pixel = PITCH_MM / bench_of(given).panel_per_slope_mm
    x = (np.arange(30) + 0.5 - 15.0 + 0.5)[None, :] * per_pixel
    y = (15.0 - np.arange(30) - 0.5 + 0.5)[:, None] * per_pixel
    found = moments(seen, x, y)
    # A pixel of the panel, seen on pixels: twice a square's own variance.
    found[[2, 4]] -= 2.0 * per_pixel**2 / 12.0
    wavefront = seen_wavefront(given, "left")
    rays = rays_through(wavefront.reference_um, 5.0)
    wanted = moments(rays.weights, *(rays.slopes + np.array(wavefront.shift_slope)).T)
    scale = np.sqrt(wanted[2] + wanted[4]) ** np.array([1, 1, 2, 2, 2, 3, 3, 3, 3])
    # 1024 rays give the third moments to a few thousandths.
    assert (found - wanted) / scale == pytest.approx(np.zeros(9), abs=1e-2)
    assert np.abs(wanted[5:] / scale[5:]).max() > 0.1


def test_rays_are_counted_in_their_cells() -> None:
    """Tilted defocus of a half pupil's worth: cells hold their share, far ones are left out."""
    wavefront = quadratic_wavefront_um(np.diag([-2.0, 1.0]))
    rays = rays_through(wavefront, 4.0, count=1 << 16)
    shares = geometric_shares(rays, Cells(3, 0.002))
    ellipse = np.pi * 4e-3 * 2e-3
    # The middle cell lies wholly in the ellipse of 8 by 4 mrad.
    assert shares[1, 1] == pytest.approx(0.002**2 / ellipse, rel=0.01)
    inside = np.abs(rays.slopes).max(axis=1) < 0.003
    assert shares.sum() == pytest.approx(inside.mean(), abs=1e-12)
    assert spot_slopes(wavefront, np.array([1.0, 1.0])) == pytest.approx([0.002, -0.001])


# What is asked of it


def test_stiles_and_crawford() -> None:
    assert apodisation(np.array([0.0, 3.0]), 0.05) == pytest.approx([1.0, 10.0**-0.45])
    open_pupil, weighed = (
        half_light_slope(
            fraunhofer(FLAT, 6.0, 545.0, stiles_crawford_per_mm2=rho), Cells(241, 4e-6)
        )
        for rho in (0.0, 0.5)
    )
    assert weighed > 1.05 * open_pupil  # a narrower pupil diffracts more


@pytest.mark.parametrize("pupil_mm", [2.0, 4.0, 8.0])
def test_a_blur_too_wide_is_refused_with_the_widest(pupil_mm: float) -> None:
    def defocused(slope: float) -> PointSpread:
        power_d = slope * 1000.0 / pupil_mm
        return fraunhofer(quadratic_wavefront_um(power_d * np.eye(2)), pupil_mm, 545.0)

    with pytest.raises(InputError, match="wanted at most") as refused:
        defocused(0.6)
    words = str(refused.value).split()
    most_arcmin = float(words[words.index("most") + 1])
    assert most_arcmin / (180.0 * 60.0 / np.pi) == pytest.approx(
        (2048 - 64) / 1.25 * 545e-6 / pupil_mm, rel=1e-3
    )
