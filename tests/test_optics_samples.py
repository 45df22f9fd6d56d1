"""The two reduced maps against the design's steps, and against each other."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from optics_by_hand import (
    PITCH_MM,
    aberration,
    backward,
    chief,
    inverse,
    points_mm,
    rig,
    rigs,
    sides,
    slope_distance_mm,
    unhurried,
)

from vrlf.model import Rig
from vrlf.optics import polynomial
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import aberration_at, eye_optics
from vrlf.optics.inverse import crossing_shift_mm, inverse_map
from vrlf.optics.lattice import cell_coordinates, lattice_of, nearest_cell
from vrlf.optics.samples import (
    MAX_POINTS,
    footprint_pixels,
    footprint_scale,
    point_count,
    pupil_points,
    ray_table,
    ray_tables,
    uses_area_means,
)
from vrlf.optics.viewport import Side, viewport
from vrlf.reference.forward import retinal_points
from vrlf.reference.perceive import trace

# Slopes of hand-made wavefronts are central differences, good to 1e-9; m makes 1e-7 mm of it.
BY_DIFFERENCES_MM = 1e-6

HOLES = {"kind": "pinhole", "pitch_um": 390.0, "gap_mm": 6.0, "aperture_um": 120.0}


def away_from_borders(given_rig: Rig, side: Side, y: np.ndarray) -> np.ndarray:
    """Place of y in its cell, in cells; examples on a border are put aside."""
    lattice = lattice_of(given_rig)
    assert lattice is not None
    axis = np.array(viewport(given_rig, side).axis_mm)
    q = cell_coordinates(lattice, y + axis)
    t = q - nearest_cell(lattice, q)
    assume(np.abs(lattice.normals @ t).max() < 0.5 - 1e-6)
    return np.asarray(t)


@unhurried
@given(rigs(), sides, points_mm(8.0))
def test_reduced_rays_are_the_backward_rays(given_rig: Rig, side: Side, X: np.ndarray) -> None:
    """y = a X + phi(u), x = X + psi(u) - (g / f) (y - c), for every pupil point."""
    bench, lattice, optics = bench_of(given_rig), lattice_of(given_rig), eye_optics(given_rig, side)
    assert lattice is not None
    eye = given_rig.left if side == "left" else given_rig.right
    rays = 3
    at = pupil_points(given_rig, optics, rays)
    table = ray_table(given_rig, bench, lattice, optics, 0, rays)
    for i in range(rays):
        u, from_centre = at.u_mm[i], at.from_centre_mm[i]
        assert u - from_centre == pytest.approx(eye.pupil_offset_mm, abs=1e-12)
        ray = backward(given_rig, side, X, u, aberration(eye, from_centre))
        phi_mm = lattice.panel_from_cell @ table.array_cells[i]
        y = bench.array_from_panel * X + phi_mm
        assert y == pytest.approx(ray.array_mm, abs=BY_DIFFERENCES_MM)
        away_from_borders(given_rig, side, y)
        psi_mm = table.landing_px[i] * [PITCH_MM, -PITCH_MM]
        x = X + psi_mm - bench.bend * (y - ray.centre_mm)
        # A lenslet of short focus multiplies what y is off.
        assert x == pytest.approx(ray.panel_mm, abs=BY_DIFFERENCES_MM * (1.0 + bench.bend))


@unhurried
@given(rigs(("none",)), sides, points_mm(8.0))
def test_reduced_rays_of_a_bare_panel(given_rig: Rig, side: Side, X: np.ndarray) -> None:
    optics = eye_optics(given_rig, side)
    eye = given_rig.left if side == "left" else given_rig.right
    at = pupil_points(given_rig, optics, 1)
    table = ray_table(given_rig, bench_of(given_rig), None, optics, 0, 1)
    ray = backward(given_rig, side, X, at.u_mm[0], aberration(eye, at.from_centre_mm[0]))
    psi_mm = table.landing_px[0] * [PITCH_MM, -PITCH_MM]
    assert X + psi_mm == pytest.approx(ray.panel_mm, abs=BY_DIFFERENCES_MM)
    assert not table.array_cells.any()
    assert not table.within_cells.any()


@unhurried
@given(rigs(), sides, points_mm(8.0))
def test_traced_rays_are_the_backward_rays(given_rig: Rig, side: Side, X: np.ndarray) -> None:
    """The twin's own steps, at two points of a pupil."""
    bench, lattice, view = bench_of(given_rig), lattice_of(given_rig), viewport(given_rig, side)
    optics = eye_optics(given_rig, side)
    at = pupil_points(given_rig, optics, 2)
    slope = aberration_at(optics.aberration[0], at.from_centre_mm)
    landing = trace(bench, lattice, view, X, at.u_mm, slope)
    for i in range(2):
        ray = backward(given_rig, side, X, at.u_mm[i], slope[i])
        away_from_borders(given_rig, side, ray.array_mm)
        assert landing.array_mm[i] == pytest.approx(ray.array_mm, abs=1e-10)
        assert landing.panel_mm[i] == pytest.approx(ray.panel_mm, abs=1e-8)


@unhurried
@given(rigs(), sides, points_mm(8.0))
def test_reduced_inverse_is_the_inverse(given_rig: Rig, side: Side, x: np.ndarray) -> None:
    """Pupil point and retinal point from the place where the chief ray crosses its cell."""
    bench, lattice, optics = bench_of(given_rig), lattice_of(given_rig), eye_optics(given_rig, side)
    assert lattice is not None
    eye = given_rig.left if side == "left" else given_rig.right
    offset = np.array(eye.pupil_offset_mm)
    ray = chief(given_rig, side, x, offset)
    t = away_from_borders(given_rig, side, ray.array_mm)
    crossing = bench.array_from_panel * x + crossing_shift_mm(bench, optics)
    assert crossing == pytest.approx(ray.array_mm, abs=1e-9)

    reduced = inverse_map(given_rig, bench, lattice, optics, 0)
    u, alpha = inverse(given_rig, x, ray.centre_mm)
    radii = reduced.pupil_radii_per_cell @ t
    assert radii == pytest.approx((u - offset) / (eye.pupil_mm / 2.0), abs=1e-8)

    # Far outside the pupil the wavefront's polynomial has no meaning, and may be enormous.
    assume(np.hypot(*radii) < 1.2)
    seen = slope_distance_mm(given_rig) * (alpha - aberration(eye, u - offset))
    moved_mm = [polynomial.evaluate(p, *t) * PITCH_MM for p in reduced.displacement_px]
    assert x[0] + moved_mm[0] == pytest.approx(seen[0], abs=BY_DIFFERENCES_MM)
    assert x[1] - moved_mm[1] == pytest.approx(seen[1], abs=BY_DIFFERENCES_MM)


@unhurried
@given(rigs(), sides, points_mm(8.0))
def test_inverse_and_backward_rays_are_one(given_rig: Rig, side: Side, x: np.ndarray) -> None:
    """From x through the lenslet's centre to X, and from X through the same u back to x."""
    bench, lattice, view = bench_of(given_rig), lattice_of(given_rig), viewport(given_rig, side)
    assert lattice is not None
    optics = eye_optics(given_rig, side)
    eye = given_rig.left if side == "left" else given_rig.right
    offset = np.array(eye.pupil_offset_mm)
    ray = chief(given_rig, side, x, offset)
    away_from_borders(given_rig, side, ray.array_mm)
    u, _ = inverse(given_rig, x, ray.centre_mm)
    assume(np.hypot(*(u - offset)) < eye.pupil_mm * 0.6)
    seen, meets = retinal_points(x[None], bench, lattice, view, optics, 0)
    if abs(np.hypot(*(u - offset)) - eye.pupil_mm / 2.0) > 1e-9:
        assert bool(meets[0]) == (np.hypot(*(u - offset)) <= eye.pupil_mm / 2.0)
    slope = aberration_at(optics.aberration[0], u - offset)
    back = trace(bench, lattice, view, seen[0], u, slope)
    # Slopes through a gap of 1 mm spread rounding over the bench a hundredfold.
    assert back.array_mm == pytest.approx(ray.centre_mm, abs=1e-9)
    assert back.panel_mm == pytest.approx(x, abs=1e-8)


def test_chief_ray_by_the_designs_formula() -> None:
    """y = (x (e + s_a (1 - e F)) + g o) / m, by hand.

    e 10, F 1/46, s_a 42, g 4/1.49: 1 - e F = 36/46, d = 44.684564, m = 44.970528;
    array per slope 10 + 42 * 36/46 = 42.869565. x = 3, o = 0.5.
    """
    acrylic = {"kind": "microlens", "pitch_um": 330.0, "gap_mm": 4.0, "gap_index": 1.49}
    eye = {"pupil_offset_mm": [0.5, 0.4]}
    solid = rig(headset={"eye_relief_mm": 10.0}, array=acrylic | {"focal_mm": 3.0}, right=eye)
    bench, optics = bench_of(solid), eye_optics(solid, "right")
    y = bench.array_from_panel * np.array([3.0, 0.0]) + crossing_shift_mm(bench, optics)
    assert y == pytest.approx([2.889693, 0.0238785], abs=2e-6)


def test_ray_count_makes_up_for_what_holes_stop() -> None:
    holes = lattice_of(rig(array=HOLES))
    assert point_count(100, None) == 100
    # 100 / (120/390)^2 = 1056.25.
    assert point_count(100, holes) == 1057
    assert point_count(10**9, holes) == MAX_POINTS


def test_pupil_points_fill_the_pupil_and_the_pixel() -> None:
    eye = {"pupil_mm": 4.0, "pupil_offset_mm": [0.8, -0.3]}
    moved = rig(left=eye)
    at = pupil_points(moved, eye_optics(moved, "left"), 1024)
    radius = np.hypot(*at.from_centre_mm.T)
    assert 1.95 < radius.max() <= 2.0
    # The mean of 1024 well-spread points is far nearer the centre than 0.03 radii of chance.
    assert at.u_mm.mean(axis=0) == pytest.approx([0.8, -0.3], abs=0.01)
    assert np.abs(at.within_pixel_mm).max() <= PITCH_MM / 2.0
    assert np.ptp(at.within_pixel_mm, axis=0) == pytest.approx([PITCH_MM] * 2, rel=0.01)


def test_chromatic_eyes_have_three_tables() -> None:
    both = rig(left={"chromatic": True, "sphere_d": -2.0}, right={"sphere_d": -2.0})
    red, green, blue = ray_tables(both, "left", 16)
    (single,) = ray_tables(both, "right", 16)
    size = [np.ptp(table.landing_px[:, 0]) for table in (red, green, blue)]
    assert size[0] < size[1] < size[2]
    # The same pupil points: what each colour spreads over is as large as its defocus.
    defocus_d = -2.0 * np.array(size) / np.ptp(single.landing_px[:, 0])
    assert defocus_d == pytest.approx([-1.91037, -2.22468, -2.83507], abs=2e-5)


def test_footprint_of_a_retinal_pixel() -> None:
    """1 - (g/f) a: gap 3 at 46 mm, a = 43/46, f 1.95 -> 1 - 1.43813 = -0.43813."""
    array = {"kind": "microlens", "pitch_um": 390.0, "gap_mm": 3.0, "focal_mm": 1.95}
    lenses = rig(array=array)
    bench, lattice = bench_of(lenses), lattice_of(lenses)
    assert footprint_scale(bench, lattice) == pytest.approx(-0.438127, abs=1e-6)
    assert uses_area_means(bench, lattice)
    assert footprint_scale(bench, None) == 1.0
    assert uses_area_means(bench, None)
    # More power: the footprint is wider than a pixel; much more, and it is not averaged.
    strong = rig(array=array | {"focal_mm": 1.3})
    assert footprint_scale(bench_of(strong), lattice_of(strong)) == pytest.approx(
        -1.15719, abs=1e-5
    )
    assert footprint_pixels(bench_of(strong), lattice_of(strong)) == 3
    assert uses_area_means(bench_of(strong), lattice_of(strong))
    strongest = rig(array=array | {"focal_mm": 0.3})
    assert not uses_area_means(bench_of(strongest), lattice_of(strongest))
    assert not uses_area_means(bench, lattice_of(rig(array=HOLES)))
