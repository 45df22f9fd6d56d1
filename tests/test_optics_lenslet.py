"""The lenslet's own optics against closed forms: first order, exact rays, aberrations, foci."""

from __future__ import annotations

from dataclasses import replace
from math import atan, inf, isnan, sqrt, tan

import numpy as np
import pytest

from vrlf.errors import InputError
from vrlf.optics.glass import C_LINE_NM, D_LINE_NM, F_LINE_NM, cauchy_index, index_at
from vrlf.optics.lenslet.focus import chromatic_focus_mm, field_curves, foci
from vrlf.optics.lenslet.paraxial import cardinal, power_per_mm, system_matrix
from vrlf.optics.lenslet.spots import best_distance_mm, spot
from vrlf.optics.lenslet.surfaces import Lens, Medium, Surface, cemented, plano_convex
from vrlf.optics.lenslet.trace import Beam, aperture_points, landing, trace

N15 = Medium(index=1.5)
PMMA = Medium("pmma")
THESIS = plano_convex(2.961, 0.5, PMMA, 0.39)
# A lens with nothing symmetric about it: two conics, thick, into a spacer.
ODD = Lens(
    (
        Surface(1.0 / 3.1, Medium("polycarbonate"), 0.7, -0.6),
        Surface(-1.0 / 7.3, Medium(index=1.33), 0.4, 0.8),
        Surface(1.0 / 9.0, Medium(index=1.2)),
    ),
    1.1,
    square=False,
)


# Glasses of two numbers


def test_cauchy_goes_through_index_and_abbe_number() -> None:
    d, f, c = (cauchy_index(1.65, 45.0, nm) for nm in (D_LINE_NM, F_LINE_NM, C_LINE_NM))
    assert d == 1.65
    assert (d - 1.0) / (f - c) == pytest.approx(45.0, rel=1e-12)
    assert cauchy_index(1.65, None, 400.0) == 1.65


@pytest.mark.parametrize("name", ["n-bk7", "pmma", "polycarbonate", "polystyrene"])
def test_cauchy_between_f_and_c_is_as_good_as_it_says(name: str) -> None:
    d, f, c = (index_at(name, nm) for nm in (D_LINE_NM, F_LINE_NM, C_LINE_NM))
    for nm in np.linspace(F_LINE_NM, C_LINE_NM, 30):
        assert cauchy_index(d, (d - 1.0) / (f - c), nm) == pytest.approx(
            index_at(name, nm), abs=5e-4
        )


# First order


def test_lensmaker() -> None:
    """1 / f = (n - 1) (1 / r1 - 1 / r2) without thickness."""
    lens = cemented((3.0, -5.0), (1e-12,), (N15,), 1.0)
    assert power_per_mm(lens, 550.0) == pytest.approx(0.5 * (1 / 3.0 + 1 / 5.0), rel=1e-11)


def test_thick_lens() -> None:
    """1 / f = (n - 1) (1 / r1 - 1 / r2 + (n - 1) t / (n r1 r2)), and its planes (Hecht, 6.1)."""
    r1, r2, t, n = 4.0, -7.0, 1.5, 1.6
    lens = cemented((r1, r2), (t,), (Medium(index=n),), 1.0)
    power = (n - 1) * (1 / r1 - 1 / r2 + (n - 1) * t / (n * r1 * r2))
    found = cardinal(lens, 550.0)
    assert found.focal_mm == pytest.approx(1.0 / power, rel=1e-12)
    assert found.front_principal_mm == pytest.approx(-(n - 1) * t / (power * r2 * n), rel=1e-12)
    assert found.back_principal_mm == pytest.approx(-(n - 1) * t / (power * r1 * n), rel=1e-12)
    assert found.back_focus_mm == pytest.approx(1.0 / power + found.back_principal_mm, rel=1e-12)
    assert np.linalg.det(system_matrix(lens, 550.0)) == pytest.approx(1.0, rel=1e-12)


def test_plano_convex_either_way_round() -> None:
    """f = r / (n - 1); the plane t / n inside the flat face, or in the curved one's vertex."""
    n = index_at("pmma", D_LINE_NM)
    to_eye = cardinal(THESIS, D_LINE_NM)
    to_panel = cardinal(plano_convex(2.961, 0.5, PMMA, 0.39, facing="panel"), D_LINE_NM)
    for each in (to_eye, to_panel):
        assert each.focal_mm == pytest.approx(2.961 / (n - 1.0), rel=1e-12)
    assert to_eye.back_principal_mm == pytest.approx(-0.5 / n, rel=1e-12)
    assert to_eye.front_principal_mm == pytest.approx(0.0, abs=1e-12)
    assert to_panel.back_principal_mm == pytest.approx(0.0, abs=1e-12)
    assert to_panel.front_principal_mm == pytest.approx(0.5 / n, rel=1e-12)


def test_images() -> None:
    found = cardinal(THESIS, D_LINE_NM)
    f, back = found.focal_mm, found.back_principal_mm
    assert found.image_mm(inf) == found.back_focus_mm
    assert found.image_mm(2.0 * f) == pytest.approx(2.0 * f + back, rel=1e-12)
    assert found.image_mm(-f) == pytest.approx(f / 2.0 + back, rel=1e-12)
    assert found.image_mm(f) == inf


def test_a_plate_is_no_lens() -> None:
    with pytest.raises(InputError, match="found surfaces that focus nothing, wanted a lens"):
        cardinal(plano_convex(0.0, 1.0, N15, 1.0), 550.0)


def test_focal_length_of_each_colour_follows_the_index() -> None:
    """f (n - 1) is the radius, whatever the colour."""
    for nm in (610.0, 545.0, 465.0):
        assert 1.0 / power_per_mm(THESIS, nm) == pytest.approx(
            2.961 / (index_at("pmma", nm) - 1.0), rel=1e-12
        )
    foci_mm = chromatic_focus_mm(THESIS, (610.0, 545.0, 465.0))
    assert foci_mm[0] > foci_mm[1] > foci_mm[2]


# Exact rays


@pytest.mark.parametrize("wanted", ["hyperbola", "ellipse"])
def test_stigmatic_conics_have_no_spot(wanted: str) -> None:
    """A plano-hyperbolic lens (k = -n^2), an ellipsoid into glass (k = -1 / n^2): F / 2, exact."""
    if wanted == "hyperbola":
        lens = plano_convex(1.0, 0.5, N15, 1.0, facing="panel", conic=-(1.5**2))
        distance_mm = cardinal(lens, 550.0).back_focus_mm
    else:
        lens = Lens((Surface(1.0, N15, conic=-1.0 / 1.5**2),), 1.0, square=False)
        distance_mm = 1.5 * cardinal(lens, 550.0).back_focus_mm
    assert spot(lens, Beam(550.0), distance_mm).rms_mm < 1e-15
    spherical = replace(lens, surfaces=tuple(replace(s, conic=0.0) for s in lens.surfaces))
    assert spot(spherical, Beam(550.0), distance_mm).rms_mm > 1e-3


def test_aplanatic_points_of_a_sphere() -> None:
    """Light toward R (1 + n) behind a sphere's vertex meets at R (1 + 1 / n), exactly."""
    sphere = Lens((Surface(1.0, N15),), 1.0)
    beam = Beam(550.0, object_mm=-2.5)
    assert spot(sphere, beam, 1.0 + 1.0 / 1.5).rms_mm < 1e-15


@pytest.mark.parametrize("facing", ["eye", "panel"])
@pytest.mark.parametrize("object_mm", [inf, 60.0])
def test_spherical_aberration_of_a_thin_lens(facing: str, object_mm: float) -> None:
    """1 / s'_h - 1 / s' of third order, of shape q and position p (Jenkins & White 1976, 9.7)."""
    n, radius, h = 1.5, 10.0, 0.1
    lens = plano_convex(radius, 0.0, N15, 1.0, facing=facing)  # type: ignore[arg-type]
    f = radius / (n - 1.0)
    image_mm = cardinal(lens, 550.0).image_mm(object_mm)
    p = -1.0 if object_mm == inf else (image_mm - object_mm) / (image_mm + object_mm)
    q = 1.0 if facing == "eye" else -1.0
    shape = (n + 2) / (n - 1) * q**2 + 4 * (n + 1) * p * q + (3 * n + 2) * (n - 1) * p**2
    wanted = h**2 / (8 * f**3 * n * (n - 1)) * (shape + n**3 / (n - 1))
    ray = trace(lens, Beam(550.0, object_mm=object_mm), np.array([[0.0, h]]))
    (_, y, z), (_, m, k) = ray.points_mm[0], ray.directions[0]
    # The next order is (h / f)^2 = 2.5e-5 of it, times some ten.
    assert 1.0 / (z - y * k / m) - 1.0 / image_mm == pytest.approx(wanted, rel=5e-4)


def test_snell_at_a_plane() -> None:
    """sin I = n sin I', and the plate moves the ray by t (tan I - tan I')."""
    plate = Lens((Surface(0.0, N15, 2.0), Surface(0.0, Medium())), 1.0)
    lens = Lens((*plate.surfaces, Surface(1e-3, Medium(index=1.1))), 1.0)
    ray = trace(lens, Beam(550.0, (0.3, 0.4)), np.zeros((1, 2)))
    inside = np.sin(atan(0.5)) / 1.5
    wanted = 2.0 * tan(np.arcsin(inside))
    # The ray is aimed at the third surface's middle, paraxially: a little off it.
    off = np.hypot(*ray.points_mm[0, :2])
    assert off == pytest.approx(abs(2.0 * 0.5 / 1.5 - wanted), rel=1e-3)


def test_rays_keep_their_optical_path_at_a_focus() -> None:
    """Fermat: all paths to a stigmatic image are one, from near and from infinity."""
    lens = plano_convex(1.0, 0.5, N15, 1.0, facing="panel", conic=-(1.5**2))
    far = landing(trace(lens, Beam(550.0), aperture_points(lens, 9)), 2.0, 1.0)
    assert np.ptp(far.path_mm) < 1e-14
    sphere = Lens((Surface(1.0, N15),), 1.0)
    near = trace(sphere, Beam(550.0, object_mm=-2.5), aperture_points(sphere, 9))
    assert np.ptp(landing(near, 1.0 + 1.0 / 1.5, 1.5).path_mm) < 1e-14


def test_what_is_blocked() -> None:
    """At the neighbour's curved face; where a surface ends; where light is reflected totally."""
    to_panel = plano_convex(2.961, 0.5, PMMA, 0.39, facing="panel")
    oblique = Beam(D_LINE_NM, (0.0, 0.3))
    assert spot(THESIS, oblique, 5.0).transmitted == 1.0
    # Its stop is the curved face: aimed there, all come through but for the paraxial aim's error.
    assert 0.9 < spot(to_panel, oblique, 5.0).transmitted <= 1.0
    steep = plano_convex(0.15, 0.5, PMMA, 0.39)
    assert spot(steep, Beam(D_LINE_NM), 0.1).transmitted < 0.6
    total = plano_convex(0.21, 0.5, Medium(index=1.8), 0.39, facing="panel", square=False)
    rays = trace(total, Beam(D_LINE_NM), np.array([[0.0, 0.15], [0.0, 0.05]]))
    assert rays.open.tolist() == [False, True]  # sin 0.714 * 1.8 > 1
    assert not np.isnan(rays.directions).any()
    with pytest.raises(InputError, match="found no ray that comes through"):
        spot(total, Beam(D_LINE_NM, (0.0, 3.0)), 5.0)


def test_spots_fill_the_aperture_and_grow_with_defocus() -> None:
    """A beam of width a, d before its focus f, is a square of a d / f: its RMS that / sqrt 6."""
    lens = plano_convex(4.0, 0.3, N15, 0.4, facing="panel", conic=-(1.5**2))
    f = cardinal(lens, 550.0).back_focus_mm
    for d in (0.5, -1.0):
        found = spot(lens, Beam(550.0), f - d, side=64).rms_mm
        # 0.4 / 8 wide: cosines spread it by a part in a thousand.
        assert found == pytest.approx(abs(0.4 * d / f) / sqrt(6.0), rel=1e-3)
    disc = replace(lens, square=False)
    assert spot(disc, Beam(550.0), f - 0.5, side=64).rms_mm == pytest.approx(
        0.4 * 0.5 / f / sqrt(8.0),
        rel=5e-3,  # of a disc made of squares
    )


def test_best_distance_is_the_least() -> None:
    beams = [Beam(610.0, (0.0, 0.02)), Beam(465.0, (0.03, 0.01), 40.0)]

    def size(distance_mm: float) -> float:
        return sum(spot(THESIS, beam, distance_mm).rms_mm ** 2 for beam in beams)

    best = best_distance_mm(THESIS, beams)
    assert size(best) < min(size(best - 1e-3), size(best + 1e-3))
    assert size(best - 0.1) == pytest.approx(size(best + 0.1), rel=1e-9)


# Foci over the field


@pytest.mark.parametrize("lens", [THESIS, ODD, plano_convex(2.0, 0.6, N15, 0.8, facing="panel")])
@pytest.mark.parametrize("object_mm", [inf, 12.0, -9.0])
def test_coddington_against_close_rays(lens: Lens, object_mm: float) -> None:
    eps = 1e-5
    beam = Beam(550.0, (0.0, 0.35), object_mm)
    found = foci(lens, beam)
    ends = np.array([[eps, 0.0], [-eps, 0.0], [0.0, eps], [0.0, -eps]])
    rays = trace(lens, beam, ends)
    (right, left, up, down), d = rays.points_mm, rays.directions
    beside = [p[2] - p[0] / k[0] * k[2] for p, k in ((right, d[0]), (left, d[1]))]
    # The mean of both sides is off by the square of their distance.
    assert found.sagittal_mm == pytest.approx(np.mean(beside), rel=1e-6)
    slope_up, slope_down = d[2, 1] / d[2, 2], d[3, 1] / d[3, 2]
    rise = (up[1] - slope_up * up[2]) - (down[1] - slope_down * down[2])
    assert found.tangential_mm == pytest.approx(rise / (slope_down - slope_up), rel=1e-6)


def test_field_curvature_of_a_thin_lens() -> None:
    """With the stop at a thin lens the foci bend by (1 + 1 / 2n) and (3 + 1 / 2n) of theta^2 f.

    Petzval's sum is 1 / (n f), astigmatism of a thin lens at the stop 1 / f whatever its shape
    (Welford 1986, sec. 11): sagittal f theta^2 (1 + 1 / n) / 2, tangential (3 + 1 / n) / 2.
    """
    n, theta = 1.5, 0.01
    lens = plano_convex(10.0, 1e-9, N15, 1.0)
    f = cardinal(lens, 550.0).focal_mm
    on, off = field_curves(lens, 550.0, (0.0, theta))
    assert on.sagittal_mm == pytest.approx(on.tangential_mm, rel=1e-12)
    # The next order is theta^2 of it, times a few.
    assert on.sagittal_mm - off.sagittal_mm == pytest.approx(
        f * theta**2 * (1 + 1 / n) / 2, rel=1e-3
    )
    assert on.tangential_mm - off.tangential_mm == pytest.approx(
        f * theta**2 * (3 + 1 / n) / 2, rel=1e-3
    )


def test_foci_on_the_axis_are_the_paraxial_ones() -> None:
    for object_mm in (inf, 15.0, -4.0):
        found = foci(ODD, Beam(500.0, object_mm=object_mm))
        # Behind the lens the medium has 1.2; first order counts reduced.
        wanted = 1.2 * cardinal(ODD, 500.0).image_mm(object_mm)
        assert found.sagittal_mm == pytest.approx(wanted, rel=1e-12)
        assert found.tangential_mm == pytest.approx(wanted, rel=1e-12)


def test_a_blocked_middle_has_no_foci() -> None:
    with pytest.raises(InputError, match="found its middle ray blocked"):
        foci(Lens((Surface(0.0, N15, 2.0), Surface(2.0, Medium())), 1.0), Beam(550.0, (0.0, 9.0)))


# What can be made


def test_lenses_that_cannot_be_made() -> None:
    with pytest.raises(InputError, match=r"radius 0\.2 mm, wanted one that reaches 0\.2"):
        plano_convex(0.2, 0.5, PMMA, 0.39).check()
    with pytest.raises(InputError, match="wanted it thick enough"):
        plano_convex(2.961, 0.01, PMMA, 0.39).check()
    with pytest.raises(InputError, match="found 2 radii, 2 thicknesses and 2 glasses"):
        cemented((1.0, 2.0), (1.0, 1.0), (N15, PMMA), 1.0)
    THESIS.check()
    assert THESIS.stop == 0
    assert not isnan(THESIS.surfaces[0].sag_mm(THESIS.reach_mm))
