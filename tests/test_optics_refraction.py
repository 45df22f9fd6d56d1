"""Prescriptions, power vectors and matrices, against published and hand-made numbers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from optics_by_hand import matrix_d, rig, unhurried

from vrlf.model import Eye
from vrlf.optics import frames, polynomial
from vrlf.optics.eye import eye_optics, refraction_matrix_d
from vrlf.optics.refraction import (
    SpheroCylinder,
    at_pupil,
    curvature_matrix_d,
    examiner_matrix_d,
    power_vector_d,
    quadratic_wavefront_um,
    sphero_cylinder,
    transverse_aberration,
)

# Sums and products of a few dioptres in float64.
ROUNDING = 1e-12

spheres = st.floats(-20.0, 8.0)
cylinders = st.floats(-6.0, 6.0)
axes = st.floats(0.0, 180.0)


@pytest.mark.parametrize(
    ("rx", "vector"),
    [
        # With the rule, against the rule and the two obliques: -(C/2) cos 2a, -(C/2) sin 2a.
        ((-2.0, -1.0, 180.0), (-2.5, 0.5, 0.0)),
        ((-2.0, -1.0, 90.0), (-2.5, -0.5, 0.0)),
        ((-2.0, -1.0, 45.0), (-2.5, 0.0, 0.5)),
        ((-2.0, -1.0, 135.0), (-2.5, 0.0, -0.5)),
        # Plus cylinder; cos 60 = 1/2, sin 60 = 0.8660254.
        ((1.0, 2.0, 30.0), (2.0, -0.5, -0.8660254037844386)),
    ],
)
def test_power_vectors(rx: tuple[float, float, float], vector: tuple[float, float, float]) -> None:
    assert power_vector_d(SpheroCylinder(*rx)) == pytest.approx(vector, abs=ROUNDING)


def test_obliquely_crossed_cylinders() -> None:
    """Two equal cylinders 45 degrees apart: C sqrt(2) at the middle axis (Thompson's rule)."""
    one, other = (examiner_matrix_d(SpheroCylinder(0.0, -1.0, axis)) for axis in (10.0, 55.0))
    rx = sphero_cylinder(frames.swap_matrix_view(one + other))
    assert rx.cylinder_d == pytest.approx(-(2.0**0.5), abs=ROUNDING)
    assert rx.axis_deg == pytest.approx(32.5, abs=1e-9)
    # The mean power -1 D is kept: S = -1 + sqrt(2)/2.
    assert rx.sphere_d == pytest.approx(-1.0 + 2.0**-0.5, abs=ROUNDING)


def test_crossed_at_right_angles_is_a_sphere_without_an_axis() -> None:
    one, other = (examiner_matrix_d(SpheroCylinder(0.0, -1.25, axis)) for axis in (17.0, 107.0))
    rx = sphero_cylinder(frames.swap_matrix_view(one + other))
    assert (rx.cylinder_d, rx.axis_deg) == (0.0, 0.0)
    assert rx.sphere_d == pytest.approx(-1.25, abs=ROUNDING)


def test_examiner_matrix_is_that_of_power_vectors() -> None:
    """[[M + J0, J45], [J45, M - J0]] for -1.00 / -3.00 x 30: M -2.5, J0 0.75, J45 1.299."""
    matrix = examiner_matrix_d(SpheroCylinder(-1.0, -3.0, 30.0))
    j45 = 1.5 * np.sin(np.pi / 3)
    assert matrix == pytest.approx(np.array([[-1.75, j45], [j45, -3.25]]), abs=ROUNDING)


def test_cylinder_axis_of_45_lies_along_minus_1_plus_1_for_the_wearer() -> None:
    """Along the axis a pure cylinder has no power, across it all of it."""
    matrix = refraction_matrix_d(Eye(cylinder_d=-3.0, axis_deg=45.0, vertex_mm=0.0))
    assert matrix @ [-1.0, 1.0] == pytest.approx(np.zeros(2), abs=ROUNDING)
    assert matrix @ [1.0, 1.0] == pytest.approx(np.array([-3.0, -3.0]), abs=ROUNDING)


@unhurried
@given(spheres, cylinders, axes, st.floats(0.0, 15.0))
def test_wearer_matrix_from_principal_meridians(
    sphere_d: float, cylinder_d: float, axis_deg: float, vertex_mm: float
) -> None:
    eye = Eye(sphere_d=sphere_d, cylinder_d=cylinder_d, axis_deg=axis_deg, vertex_mm=vertex_mm)
    assert refraction_matrix_d(eye) == pytest.approx(matrix_d(eye), abs=1e-11)


@unhurried
@given(spheres, cylinders, axes, st.floats(0.0, 15.0))
def test_transposition_changes_nothing(
    sphere_d: float, cylinder_d: float, axis_deg: float, vertex_mm: float
) -> None:
    """-5 / -1 x 20 is -6 / +1 x 110, at any vertex distance."""
    written = Eye(sphere_d=sphere_d, cylinder_d=cylinder_d, axis_deg=axis_deg, vertex_mm=vertex_mm)
    transposed = Eye(
        sphere_d=sphere_d + cylinder_d,
        cylinder_d=-cylinder_d,
        axis_deg=axis_deg + 90.0 if axis_deg <= 90.0 else axis_deg - 90.0,
        vertex_mm=vertex_mm,
    )
    assert refraction_matrix_d(written) == pytest.approx(refraction_matrix_d(transposed), abs=1e-11)


@pytest.mark.parametrize(
    ("given_d", "vertex_mm", "wanted_d"),
    [
        (-10.0, 12.0, -10.0 / 1.12),  # -8.93
        (10.0, 12.0, 10.0 / 0.88),  # +11.36
        (-5.0, 12.0, -5.0 / 1.06),  # -4.72
        (-5.0, 0.0, -5.0),
    ],
)
def test_vertex_distance_of_spheres(given_d: float, vertex_mm: float, wanted_d: float) -> None:
    at_eye = at_pupil(SpheroCylinder(given_d, 0.0, 0.0), vertex_mm)
    assert at_eye.sphere_d == pytest.approx(wanted_d, abs=ROUNDING)
    assert at_eye.cylinder_d == pytest.approx(0.0, abs=ROUNDING)


def test_vertex_distance_meridian_by_meridian() -> None:
    """-8 / -4 x 20 at 14 mm: -8/1.112 = -7.194 along, -12/1.168 = -10.274 across the axis."""
    at_eye = at_pupil(SpheroCylinder(-8.0, -4.0, 20.0), 14.0)
    assert at_eye.sphere_d == pytest.approx(-7.194245, abs=1e-6)
    assert at_eye.cylinder_d == pytest.approx(-3.079728, abs=1e-6)
    assert at_eye.axis_deg == 20.0


@unhurried
@given(spheres, st.floats(-6.0, -0.01), axes)
def test_round_trip(sphere_d: float, cylinder_d: float, axis_deg: float) -> None:
    matrix = frames.swap_matrix_view(
        examiner_matrix_d(SpheroCylinder(sphere_d, cylinder_d, axis_deg))
    )
    rx = sphero_cylinder(matrix)
    assert rx.sphere_d == pytest.approx(sphere_d, abs=1e-11)
    assert rx.cylinder_d == pytest.approx(cylinder_d, abs=1e-11)
    assert 0.0 <= rx.axis_deg < 180.0
    # An axis of 179.99.. may come back as 0.00..: compare the doubled angle.
    turn = np.radians(2.0 * (rx.axis_deg - axis_deg))
    # The axis of a 0.01 D cylinder carries its rounding a thousandfold.
    assert abs(np.angle(np.exp(1j * turn))) < 1e-9


@unhurried
@given(st.lists(st.floats(-30.0, 30.0), min_size=3, max_size=3))
def test_every_symmetric_matrix_has_a_minus_cylinder_form(entries: list[float]) -> None:
    a, b, c = entries
    matrix = np.array([[a, b], [b, c]])
    rx = sphero_cylinder(matrix)
    assert rx.cylinder_d <= 0.0
    assert 0.0 <= rx.axis_deg < 180.0
    # A cylinder under 1e-12 of the sphere counts as none.
    back = frames.swap_matrix_view(examiner_matrix_d(rx))
    assert back == pytest.approx(matrix, abs=1e-10)


@pytest.mark.parametrize("axis_deg", [0.0, 180.0])
def test_axis_180_is_written_as_0(axis_deg: float) -> None:
    matrix = refraction_matrix_d(Eye(cylinder_d=-1.0, axis_deg=axis_deg, vertex_mm=0.0))
    axis = sphero_cylinder(matrix).axis_deg
    # sin(360 deg) is -2e-16 in floats, so 180 may come back as 180 less a rounding.
    assert min(axis, 180.0 - axis) < 1e-9
    assert 0.0 <= axis < 180.0


def test_quadratic_wavefront_gives_the_matrix_back() -> None:
    """T = R u / 1000, by way of W = -u'Ru/2."""
    matrix = np.array([[-1.0, 0.3], [0.3, 2.0]])
    wavefront = quadratic_wavefront_um(matrix)
    assert curvature_matrix_d(wavefront) == pytest.approx(matrix, abs=ROUNDING)
    tx, ty = transverse_aberration(wavefront)
    u = np.array([1.5, -0.5])
    value = [polynomial.evaluate(t, u[0], u[1]) for t in (tx, ty)]
    # By hand: (-1.5 - 0.15, 0.45 - 1.0) / 1000.
    assert value == pytest.approx([-1.65e-3, -0.55e-3], abs=1e-15)


def test_matrix_of_eye_optics_has_no_prism_and_no_higher_order() -> None:
    eye = {
        "sphere_d": -2.0,
        "vertex_mm": 0.0,
        "prism_pd": [2.0, 1.0],
        "zernike": {"diameter_mm": 6.0, "coefficients_um": {"4,0": 0.3, "3,1": 0.2}},
    }
    optics = eye_optics(rig(left=eye), "left")
    assert optics.matrix_d == pytest.approx(-2.0 * np.eye(2), abs=ROUNDING)
