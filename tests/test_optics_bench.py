"""The headset's distances, and the closed forms that follow from them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from optics_by_hand import (
    axis_mm,
    lengths_mm,
    points_mm,
    rig,
    rigs,
    sides,
    slope_distance_mm,
    unhurried,
)

from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import aberration_at, eye_optics
from vrlf.optics.lattice import lattice_of
from vrlf.optics.samples import ray_table
from vrlf.optics.viewport import Side, viewport
from vrlf.reference.perceive import trace

RAYS = 64


def holes(gap_mm: float, **more: object) -> dict[str, object]:
    return {"kind": "pinhole", "pitch_um": 390.0, "aperture_um": 390.0, "gap_mm": gap_mm, **more}


def spread_at_array_mm(given_rig: Rig, side: Side = "left") -> float:
    """How far the rays of one retinal point lie apart where the array stands, in mm."""
    bench, lattice = bench_of(given_rig), lattice_of(given_rig)
    table = ray_table(given_rig, bench, lattice, eye_optics(given_rig, side), 0, RAYS)
    return float(np.ptp(table.array_cells, axis=0).max()) * 0.39


def test_plane_of_focus_of_the_thesis() -> None:
    """T 8.4: -5 D before a panel at 46 mm focus at 46 / (1 + 0.23) = 37.398 mm."""
    eye = {"sphere_d": -5.0, "vertex_mm": 0.0}
    at_focus = rig(array=holes(46.0 - 46.0 / 1.23), left=eye)
    # Rays of a 6 mm pupil meet there within rounding; 1 mm off they are 0.16 mm apart.
    assert spread_at_array_mm(at_focus) < 1e-12
    assert spread_at_array_mm(rig(array=holes(46.0 - 36.398), left=eye)) > 0.1
    # Table 8.1's 33 mm is not it.
    assert spread_at_array_mm(rig(array=holes(13.0), left=eye)) > 0.5


def test_46_and_33_mm_belong_to_minus_8_56_dioptres() -> None:
    """1/0.046 - 1/0.033 = -8.564 D."""
    eye = {"sphere_d": 1000.0 / 46.0 - 1000.0 / 33.0, "vertex_mm": 0.0}
    assert eye["sphere_d"] == pytest.approx(-8.56, abs=0.005)
    assert spread_at_array_mm(rig(array=holes(13.0), left=eye)) < 1e-12


def test_plane_of_focus_with_relief_and_a_lens_of_its_own() -> None:
    """1 / (F - R/(1 + e R)): F = 0.02, e = 15, R = -0.004 -> 1 / (0.02 + 0.004/0.94) = 41.23."""
    focus_mm = 1.0 / (0.02 + 0.004 / 0.94)
    eye = {"sphere_d": -4.0, "vertex_mm": 0.0, "pupil_offset_mm": [0.7, -0.4]}
    headset = {"lens_power_d": 20.0, "eye_relief_mm": 15.0, "lens_to_panel_mm": 50.0}
    sharp = rig(headset=headset, array=holes(50.0 - focus_mm), left=eye)
    assert spread_at_array_mm(sharp) < 1e-12


def test_matched_lenslets_image_the_panel_onto_the_plane_of_focus() -> None:
    """1/f = 1/g + 1/(s_a - d_f): all rays of a retinal point through one lenslet meet."""
    d_f = 46.0 / 1.23
    gap_mm = 3.0
    focal_mm = 1.0 / (1.0 / gap_mm + 1.0 / (43.0 - d_f))
    array = {"kind": "microlens", "pitch_um": 390.0, "gap_mm": gap_mm, "focal_mm": focal_mm}
    matched = rig(array=array, left={"sphere_d": -5.0, "vertex_mm": 0.0})
    bench, lattice, view = bench_of(matched), lattice_of(matched), viewport(matched, "left")
    optics = eye_optics(matched, "left")
    # Pupil points 0.4 mm about the centre spread over 0.05 mm of the 0.39 mm cell.
    u = np.random.default_rng(1).uniform(-0.4, 0.4, (50, 2))
    slope = aberration_at(optics.aberration[0], u)
    # The axis lies in cell -3 (-1.17 / 0.39): (0, 0) is that lenslet's centre.
    landing = trace(bench, lattice, view, np.zeros((50, 2)), u, slope)
    assert np.ptp(landing.cell, axis=0).max() == 0.0
    assert np.ptp(landing.array_mm, axis=0).max() > 0.05
    assert np.ptp(landing.panel_mm, axis=0).max() < 1e-12


def test_solid_spacers_are_reduced() -> None:
    acrylic = bench_of(rig(array=holes(4.0, gap_index=1.49)))
    assert acrylic.reduced_gap_mm == pytest.approx(2.684564, abs=1e-6)
    # The array stands where the metal stands; the panel looks nearer.
    assert acrylic.lens_to_array_mm == 42.0
    assert acrylic.lens_to_panel_mm == pytest.approx(44.684564, abs=1e-6)
    # F stays 1/46: the panel is no longer at the focus. 1 - 44.684564/46.
    assert acrylic.defocus_factor == pytest.approx(0.0285964, abs=1e-7)
    thesis = bench_of(rig(array=holes(6.0, gap_index=1.49)))
    assert thesis.reduced_gap_mm == pytest.approx(4.03, abs=0.005)


def test_bare_panel_ignores_the_array_table() -> None:
    array = {"kind": "none", "pitch_um": 390.0, "gap_mm": 6.0, "gap_index": 1.49}
    bench = bench_of(rig(array=array))
    assert not bench.has_array
    assert bench.lens_to_panel_mm == 46.0
    assert bench.reduced_gap_mm == 0.0


def test_bare_panel_ignores_even_an_impossible_index() -> None:
    assert bench_of(rig(array={"kind": "none", "gap_index": 0.0})).lens_to_panel_mm == 46.0


def test_relief_and_lens_power_by_hand() -> None:
    """e 14, F 20 D, d 46: m = 14 + 46 - 46 * 14 * 0.02 = 47.12; 1 - d F = 0.08."""
    bench = bench_of(rig(headset={"eye_relief_mm": 14.0, "lens_power_d": 20.0}))
    assert bench.panel_per_slope_mm == pytest.approx(47.12, abs=1e-12)
    assert bench.defocus_factor == pytest.approx(0.08, abs=1e-12)
    assert bench.relief_factor == pytest.approx(0.72, abs=1e-12)


def test_no_lens_at_all() -> None:
    """Without a lens slopes reach the panel over e + d, and a parallel ray stays where it is."""
    bench = bench_of(rig(headset={"eye_relief_mm": 14.0, "lens_power_d": 0.0}))
    assert bench.panel_per_slope_mm == 60.0
    assert bench.defocus_factor == 1.0


@unhurried
@given(rigs(("microlens", "pinhole", "none")))
def test_all_distances_by_hand(given_rig: Rig) -> None:
    bench = bench_of(given_rig)
    e, power, s_a, g = lengths_mm(given_rig)
    m = slope_distance_mm(given_rig)
    near = pytest.approx
    assert (bench.relief_mm, bench.lens_to_array_mm) == near((e, s_a), abs=1e-12)
    assert (bench.lens_power_per_mm, bench.reduced_gap_mm) == near((power, g), abs=1e-12)
    assert bench.panel_per_slope_mm == near(m, abs=1e-11)
    assert bench.array_per_slope_mm == near(e + s_a * (1.0 - e * power), abs=1e-11)
    assert bench.array_from_panel == near((e + s_a * (1.0 - e * power)) / m, abs=1e-12)
    assert bench.array_defocus_factor == near(1.0 - s_a * power, abs=1e-12)


@unhurried
@given(rigs(("none",)), sides, points_mm(1.0))
def test_spread_of_one_retinal_point_on_the_bare_panel(
    given_rig: Rig, side: Side, from_centre: np.ndarray
) -> None:
    """dx = ((1 - d F) I + m R / 1000) du for an eye of second order alone."""
    eye = getattr(given_rig, side).model_copy(update={"zernike": None})
    plain = given_rig.model_copy(update={side: eye})
    optics, view = eye_optics(plain, side), viewport(plain, side)
    offset = np.array(optics.pupil_offset_mm)
    u = offset + np.stack([from_centre, np.zeros(2)])
    slope = aberration_at(optics.aberration[0], u - offset)
    landing = trace(bench_of(plain), None, view, np.array([1.0, -2.0]), u, slope).panel_mm
    e, power, s_a, _ = lengths_mm(plain)
    m = slope_distance_mm(plain)
    spread = (1.0 - s_a * power) * np.eye(2) + m * optics.matrix_d / 1000.0
    assert landing[0] - landing[1] == pytest.approx(spread @ from_centre, abs=1e-12)
    # And the chief ray X + o (1 - d F), moved by m times the prism.
    chief = np.array([1.0, -2.0]) + offset * (1.0 - s_a * power)
    chief += m * np.array(eye.prism_pd) / 100.0
    assert landing[1] == pytest.approx(chief, abs=1e-11)
    assert e >= 0.0


@unhurried
@given(rigs(), sides)
def test_axes_of_the_eyes(given_rig: Rig, side: Side) -> None:
    assert viewport(given_rig, side).axis_mm == pytest.approx(axis_mm(given_rig, side))
