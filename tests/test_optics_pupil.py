"""The wavefront a point of the panel is seen with: its rays, its RMS, what moves it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from optics_by_hand import (
    Points,
    aberration,
    backward,
    points_mm,
    rig,
    rigs,
    sides,
    slope_distance_mm,
    unhurried,
    wavefront_um,
)

from vrlf.model import Rig
from vrlf.optics import polynomial
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import chromatic_difference_d, eye_optics
from vrlf.optics.inspect import residual_matrix_d
from vrlf.optics.pupil import (
    disc_mean,
    looking_far,
    rms_um,
    seen_wavefront,
    spot_slopes,
    widest_slope,
    without_order,
)
from vrlf.optics.refraction import curvature_matrix_d
from vrlf.optics.viewport import Side

HIGH = {"diameter_mm": 6.0, "coefficients_um": {"3,-1": 0.3, "3,3": -0.2, "4,0": 0.1}}


@unhurried
@given(rigs(kinds=("none",)), sides, points_mm(1.0))
def test_its_rays_are_those_of_the_design(given: Rig, side: Side, at: Points) -> None:
    """A ray that leaves straight ahead for x is, turned about, how x is seen at -x."""
    eye = given.left if side == "left" else given.right
    v_mm = at * eye.pupil_mm / 2.0
    u_mm, slope = v_mm + np.array(eye.pupil_offset_mm), aberration(eye, v_mm)
    lands_mm = backward(given, side, np.zeros(2), u_mm, slope).panel_mm
    seen = seen_wavefront(given, side)
    found = spot_slopes(seen.reference_um, v_mm) + np.array(seen.shift_slope)
    # The wavefront by hand is differentiated numerically, to a millionth of its slopes.
    assert found == pytest.approx(-lands_mm / slope_distance_mm(given), abs=1e-7)


def test_means_over_the_disc_are_exact() -> None:
    rng = np.random.default_rng(4)
    c = rng.normal(size=(6, 6))
    # Gauss-Legendre in the squared radius and a ring of points: exact for these powers.
    node, weight = np.polynomial.legendre.leggauss(8)
    radius = 1.7 * np.sqrt((node[:, None] + 1.0) / 2.0)
    angle = np.arange(32) * 2.0 * np.pi / 32
    values = polynomial.evaluate(c, radius * np.cos(angle), radius * np.sin(angle))
    assert disc_mean(c, 3.4) == pytest.approx(float(weight @ values.mean(axis=1)) / 2.0, rel=1e-12)


def test_rms_is_the_root_of_the_squared_coefficients() -> None:
    """Over their own pupil; tilt is none of it, sphere and cylinder none of the higher orders."""
    terms = {"1,1": 3.0, "2,0": 0.5, "2,-2": -0.4, "3,-1": 0.3, "4,0": 0.12}
    zernike = {"diameter_mm": 5.0, "coefficients_um": terms}
    seen = seen_wavefront(rig(left={"zernike": zernike, "pupil_mm": 5.0}), "left")
    higher = without_order(seen.reference_um, 5.0, 2)
    assert rms_um(seen.reference_um, 5.0) == pytest.approx(np.sqrt(0.25 + 0.16 + 0.09 + 0.0144))
    assert rms_um(higher, 5.0) == pytest.approx(np.sqrt(0.09 + 0.0144))


def test_rms_in_a_smaller_pupil_is_that_of_what_is_left() -> None:
    seen = seen_wavefront(rig(left={"zernike": HIGH, "pupil_mm": 3.0}), "left")
    side = np.linspace(-1.5, 1.5, 1201)
    grid = np.stack(np.meshgrid(side, side), axis=-1)
    inside = np.hypot(grid[..., 0], grid[..., 1]) <= 1.5
    terms = {(3, -1): 0.3, (3, 3): -0.2, (4, 0): 0.1}
    heights, at = wavefront_um(terms, 6.0, grid)[inside], grid[inside]
    plane = np.column_stack([np.ones(len(at)), at])
    left = heights - plane @ np.linalg.lstsq(plane, heights)[0]
    # A raster of 1200 across a disc misses its rim by a thousandth.
    assert rms_um(seen.reference_um, 3.0) == pytest.approx(np.sqrt(np.mean(left**2)), rel=3e-3)


def test_prism_and_a_moved_pupil_move_the_spot() -> None:
    """A prism that moves the panel right shows it left; so does a pupil left of the axis, near.

    Without a lens a panel 50 mm off meets the eye with the vergence 1/50: what enters 1 mm to
    the right is seen 1/50 further left.
    """
    given = rig(
        headset={"lens_to_panel_mm": 50.0, "lens_power_d": 0.0},
        left={"prism_pd": [1.0, -0.5], "pupil_offset_mm": [0.5, 1.0]},
    )
    assert seen_wavefront(given, "left").shift_slope == pytest.approx(
        (-0.01 - 0.5 / 50.0, 0.005 - 1.0 / 50.0), abs=1e-15
    )
    assert seen_wavefront(given, "right").shift_slope == (0.0, 0.0)


@pytest.mark.parametrize(
    "eye",
    [
        {"sphere_d": -4.5, "cylinder_d": -1.75, "axis_deg": 30.0},
        {"sphere_d": 2.0, "cylinder_d": 1.0, "axis_deg": 110.0, "accommodation": "best"},
        {"sphere_d": 3.0, "accommodation": "best", "age_years": 58.0, "vertex_mm": 12.0},
    ],
)
def test_its_curvature_is_the_error_that_inspect_tells(eye: dict[str, Any]) -> None:
    given = rig(headset={"lens_to_panel_mm": 40.0, "lens_power_d": 18.0}, left=eye)
    wanted = residual_matrix_d(bench_of(given), eye_optics(given, "left"))
    found = curvature_matrix_d(seen_wavefront(given, "left").reference_um)
    assert found == pytest.approx(wanted, abs=1e-12)


def test_colours_differ_in_a_chromatic_eye_alone() -> None:
    plain = seen_wavefront(rig(), "left")
    assert all(each is plain.colours_um[0] for each in plain.colours_um)
    given = rig(left={"chromatic": True, "sphere_d": -1.0})
    seen = seen_wavefront(given, "left")
    for wavefront, nm in zip(seen.colours_um, given.panel.wavelengths_nm, strict=True):
        wanted = -1.0 + chromatic_difference_d(nm)
        assert curvature_matrix_d(wavefront) == pytest.approx(wanted * np.eye(2), abs=1e-12)


def test_looking_far_leaves_the_eye_alone() -> None:
    given = rig(
        headset={"lens_to_panel_mm": 40.0, "lens_power_d": 10.0, "eye_relief_mm": 12.0},
        array={"kind": "pinhole", "pitch_um": 400.0, "gap_mm": 4.0, "gap_index": 1.49},
        left={"sphere_d": -2.0, "cylinder_d": -1.0, "axis_deg": 20.0},
        right={"sphere_d": 1.5, "accommodation": "best"},
    )
    far = looking_far(given)
    left = curvature_matrix_d(seen_wavefront(far, "left").reference_um)
    assert np.linalg.eigvalsh(left) == pytest.approx([-3.0, -2.0], abs=1e-12)
    # A hyperope who accommodates has nothing left over at infinity.
    assert seen_wavefront(far, "right").reference_um == pytest.approx(np.zeros((3, 3)), abs=1e-12)


def test_the_widest_slope_holds_all_rays() -> None:
    seen = seen_wavefront(rig(left={"zernike": HIGH, "pupil_mm": 6.0}), "left")
    rng = np.random.default_rng(7)
    radius, angle = 3.0 * np.sqrt(rng.random(20000)), 2.0 * np.pi * rng.random(20000)
    v_mm = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    most = np.abs(spot_slopes(seen.reference_um, v_mm)).max()
    # The largest slope is at the rim, where a point stands every half degree.
    assert most <= widest_slope(seen.reference_um, 6.0) * (1.0 + 1e-4)
    assert most >= widest_slope(seen.reference_um, 6.0) * 0.97
