"""What ``inspect`` says: every number by hand, and the warnings where they belong."""

from __future__ import annotations

import json
from math import atan, degrees, isinf, pi, sin, sqrt
from typing import Any

import numpy as np
import optics_by_hand as by_hand
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from optics_by_hand import points_mm, sides

from vrlf.model import Rig, load_rig
from vrlf.optics import limits
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import aberration_at, eye_optics
from vrlf.optics.inspect import inspect_rig
from vrlf.optics.lattice import lattice_of
from vrlf.optics.viewport import SIDES, Side, viewport
from vrlf.reference.forward import retinal_points
from vrlf.reference.perceive import trace

Numbers = dict[str, Any]

# Formulas written two ways in float64 differ by some rounding.
EXACT = {"rel": 1e-12, "abs": 1e-12}


def holds(found: Numbers, wanted: Numbers) -> None:
    """All wanted numbers, and the very thing where a None or a name is wanted."""
    numbers = {key for key, value in wanted.items() if isinstance(value, float)}
    for key in set(wanted) - numbers:
        assert found[key] == wanted[key], key
    got = {key: found[key] for key in numbers}
    assert got == pytest.approx({key: wanted[key] for key in numbers}, **EXACT)


def eye_rig(eye: Numbers, **tables: Numbers) -> Rig:
    """Both eyes alike, at a vertex distance of 0."""
    return by_hand.rig(**{"left": eye, "right": eye, **tables})


# --- the shipped rigs -------------------------------------------------------------------------


def test_thesis_minus_5d() -> None:
    """s_a 40, g 6, d = m = 46, 1 - d F = 0, R = -5 I: B = 46 * -0.005 = -0.23."""
    found = inspect_rig(load_rig("thesis-minus-5d"))
    assert found["left"] == found["right"]
    holds(
        found["left"],
        {
            "sphere_d": -5.0,
            "cylinder_d": 0.0,
            "axis_deg": 0.0,
            "mean_error_d": -5.0,
            "focus_distance_mm": 46.0 / 1.23,  # T 8.4
            "blur_mm": 1.38,
            "blur_px": 1.38 / 0.078,
            "accommodation_d": 0.0,
            "best_focal_mm": 1.0 / (1.0 / 6.0 + 1.0 / (40.0 - 46.0 / 1.23)),
            # Lenslets of f = g show (m/g) D |B - Phi|, Phi = 6/46 - 0.2, to which a pixel
            # through one lenslet adds |1 + (40/46) (46/6) B|.
            "corrected_blur_px": 2.99 * abs(-0.23 - 6.0 / 46.0 + 0.2) / 0.078
            + abs(1.0 - 40.0 / 6.0 * 0.23),
        },
    )
    holds(
        found["array"],
        {
            "kind": "microlens",
            "throughput": 1.0,
            "field_of_view_deg": degrees(2.0 * atan(0.39 / 12.0)),
            "views": 5.0,
            "spatial_nyquist_per_mm": 1.0 / 0.78,
            "depth_of_field_mm": 30.0,
            "eyebox_mm": 2.99,  # not the thesis's 6
            "best_pinhole_um": 1000.0 * sqrt(2.0 * 545e-6 * 6.0),
            "lens_to_array_mm": 40.0,
            "reduced_gap_mm": 6.0,
        },
    )
    # One pixel is atan(0.078/46) at the axis: 10.3 to a degree. At the focus: no image.
    holds(
        found["display"],
        {"pixels_per_degree": 46.0 * pi / 180.0 / 0.078, "virtual_image_mm": None},
    )


def test_matched_full() -> None:
    """s_a 43, g 3, f 1.95: B - (g/f) Phi = -0.23 - (3 - 43 * 0.23) / 46 * 3/1.95 = 0.000435."""
    found = inspect_rig(load_rig("matched-full"))
    phi = 3.0 / 46.0 - 43.0 * 0.005
    holds(
        found["right"],
        {
            "best_focal_mm": 1.0 / (1.0 / 3.0 + 1.0 / (43.0 - 46.0 / 1.23)),  # 1.954
            "corrected_blur_px": 5.98 * abs(-0.23 - 3.0 / 1.95 * phi) / 0.078
            + abs(1.0 - 43.0 / 3.0 * 0.23),
        },
    )
    holds(
        found["array"],
        {
            "throughput": 1.0,
            "field_of_view_deg": degrees(2.0 * atan(0.065)),
            "views": 5.0,
            "depth_of_field_mm": 15.0,
            "eyebox_mm": 5.98,
            "best_pinhole_um": 1000.0 * sqrt(2.0 * 545e-6 * 3.0),
            "lens_to_array_mm": 43.0,
            "reduced_gap_mm": 3.0,
        },
    )


def test_two_eyes() -> None:
    """At F = 1/d and no relief the residual is the prescription as it was written."""
    found = inspect_rig(load_rig("two-eyes"))
    holds(
        found["left"],
        {
            "sphere_d": -4.5,
            "cylinder_d": -1.75,
            "axis_deg": 30.0,
            "mean_error_d": -5.375,
            "focus_distance_mm": 1.0 / (1.0 / 46.0 + 0.005375),
            "blur_mm": 5.0 * 46.0 * 0.00625,  # the meridian of -6.25 D
            "blur_px": 5.0 * 46.0 * 0.00625 / 0.078,
        },
    )
    holds(
        found["right"],
        {
            "sphere_d": 2.25,
            "cylinder_d": -1.0,
            "axis_deg": 115.0,
            "mean_error_d": 1.75,
            "focus_distance_mm": 1.0 / (1.0 / 46.0 - 0.00175),  # behind the panel
            "blur_mm": 4.5 * 46.0 * 0.00225,
        },
    )
    holds(found["array"], {"views": 0.635 / 0.078, "eyebox_mm": 0.635 * 46.0 / 3.6})


def test_holes_pass_their_area() -> None:
    pinhole = inspect_rig(load_rig("pinhole"))["array"]
    assert pinhole["throughput"] == pytest.approx((75.0 / 390.0) ** 2, **EXACT)
    circle = load_rig("pinhole", overrides=['array.aperture_shape="circle"'])
    wanted = pi / 4.0 * (75.0 / 390.0) ** 2
    assert inspect_rig(circle)["array"]["throughput"] == pytest.approx(wanted, **EXACT)


# --- one thing at a time ----------------------------------------------------------------------


def test_solid_spacer() -> None:
    """6 mm of acrylic are 4.03 mm: d = 44.03, the panel stands inside the focus of F = 1/46."""
    found = inspect_rig(load_rig("thesis-minus-5d", overrides=["array.gap_index=1.49"]))
    g = 6.0 / 1.49
    d = 40.0 + g
    blur = 1.0 - d / 46.0 - 0.005 * d
    holds(
        found["left"],
        {
            "sphere_d": 1000.0 * (1.0 / d - 1.0 / 46.0) - 5.0,  # -4.03
            "cylinder_d": 0.0,
            "mean_error_d": 1000.0 * (1.0 / d - 1.0 / 46.0) - 5.0,
            "focus_distance_mm": 46.0 / 1.23,
            "blur_mm": -6.0 * blur,
        },
    )
    holds(
        found["array"],
        {
            "lens_to_array_mm": 40.0,
            "reduced_gap_mm": g,
            "eyebox_mm": 0.39 * d / g,
            "depth_of_field_mm": 0.39 * g / 0.078,
            "field_of_view_deg": degrees(2.0 * atan(0.39 / 2.0 / g)),
            "best_pinhole_um": 1000.0 * sqrt(2.0 * 545e-6 * g),
        },
    )
    holds(
        found["display"],
        {
            "pixels_per_degree": d * pi / 180.0 / 0.078,
            "virtual_image_mm": 1.0 / (1.0 / d - 1.0 / 46.0),  # 1.03 m
        },
    )


RELIEF = {"lens_to_panel_mm": 40.0, "lens_power_d": 20.0, "eye_relief_mm": 15.0}


def test_relief_and_lens_power() -> None:
    """m = 15 + 40 - 40 * 15 * 0.02 = 43, 1 - d F = 0.2, B = 0.2 - 43 * 0.005 = -0.015."""
    found = inspect_rig(eye_rig({"sphere_d": -5.0, "vertex_mm": 0, "pupil_mm": 4}, headset=RELIEF))
    holds(
        found["left"],
        {
            "sphere_d": -15.0 / 43.0,
            "mean_error_d": -15.0 / 43.0,
            "blur_mm": 0.06,
            "blur_px": 0.06 / 0.078,
            # R + e R moved to the lens: -0.005 / 0.925.
            "focus_distance_mm": 1.0 / (0.02 + 0.005 / 0.925),
            "best_focal_mm": None,
            "corrected_blur_px": None,
        },
    )
    holds(
        found["display"],
        {"pixels_per_degree": 43.0 * pi / 180.0 / 0.078, "virtual_image_mm": 200.0},
    )


def test_relief_and_lens_power_with_an_array() -> None:
    """s_a 35, g 4 / 1.6 = 2.5, d = 37.5: m = 15 + 37.5 * 0.7 = 41.25, 1 - d F = 0.25."""
    array = {"kind": "microlens", "pitch_um": 400, "gap_mm": 5, "gap_index": 2.0, "focal_mm": 5}
    found = inspect_rig(
        eye_rig({"sphere_d": 1.0, "vertex_mm": 0, "pupil_mm": 4}, headset=RELIEF, array=array)
    )
    blur = 0.25 + 0.04125
    holds(
        found["left"],
        {
            "sphere_d": 1000.0 * blur / 41.25,
            "blur_mm": 4.0 * blur,
            "focus_distance_mm": 1.0 / (0.02 - 0.001 / 1.015),
        },
    )
    holds(found["array"], {"eyebox_mm": 0.4 * 41.25 / 2.5, "lens_to_array_mm": 35.0})
    # The image that the lens shows through the spacer: 1 / (1/37.5 - 0.02).
    assert found["display"]["virtual_image_mm"] == pytest.approx(150.0, **EXACT)


def test_without_an_array_its_numbers_are_null() -> None:
    found = inspect_rig(load_rig("bare"))
    array = dict(found["array"])
    assert array.pop("kind") == "none"
    assert array.pop("throughput") == 1.0
    assert set(array) == {
        "lattice",
        "field_of_view_deg",
        "views",
        "spatial_nyquist_per_mm",
        "depth_of_field_mm",
        "eyebox_mm",
        "best_pinhole_um",
        "lens_to_array_mm",
        "reduced_gap_mm",
        "least_pitch_um",
        "widest_pitch_um",
    }
    assert set(array.values()) == {None}
    # JSON has no NaN and no infinity: all that is there must be a number or null.
    json.dumps(found, allow_nan=False)


def test_a_panel_beyond_the_focus_has_its_image_behind() -> None:
    """30 D and 40 mm: 1 / (25 - 30) is -0.2 m, converging light."""
    found = inspect_rig(by_hand.rig(headset={"lens_to_panel_mm": 40.0, "lens_power_d": 30.0}))
    assert found["display"]["virtual_image_mm"] == pytest.approx(-200.0, **EXACT)
    # Plane of focus of a perfect eye: the lens's own focus.
    holds(found["left"], {"sphere_d": -5.0, "focus_distance_mm": 1000.0 / 30.0})


def test_plane_of_focus_that_is_not_in_front() -> None:
    """A +25 D eye behind a lens of 46 mm (21.7 D) focuses light that converges already."""
    holds(inspect_rig(eye_rig({"sphere_d": 25.0}))["left"], {"focus_distance_mm": None})
    # Nor does a perfect eye without a lens: it focuses at infinity.
    no_lens = by_hand.rig(headset={"lens_power_d": 0.0})
    holds(inspect_rig(no_lens)["left"], {"focus_distance_mm": None})


def test_vertex_distance() -> None:
    """-8 D at 12 mm is -8 / 1.096 at the eye; of -8 / -3 the other meridian is -11 / 1.132."""
    eye = {"sphere_d": -8.0, "cylinder_d": -3.0, "axis_deg": 20.0, "vertex_mm": 12.0}
    holds(
        inspect_rig(eye_rig(eye))["left"],
        {"sphere_d": -8.0 / 1.096, "cylinder_d": 8.0 / 1.096 - 11.0 / 1.132, "axis_deg": 20.0},
    )


@pytest.mark.parametrize(
    ("term", "axis_deg"),
    # J0 = -2 sqrt(6) c22 / r^2 = -(C/2) cos 2a, J45 = -2 sqrt(6) c2-2 / r^2 = -(C/2) sin 2a.
    [("2,2", 90.0), ("2,-2", 135.0)],
)
def test_wavefront_astigmatism(term: str, axis_deg: float) -> None:
    """0.3 um over 6 mm: a mixed astigmatism of +-2 sqrt(6) 0.3 / 9 D about a mean of 0."""
    eye = {"zernike": {"diameter_mm": 6.0, "coefficients_um": {term: 0.3}}}
    half = 2.0 * sqrt(6.0) * 0.3 / 9.0
    holds(
        inspect_rig(eye_rig(eye))["left"],
        {
            "sphere_d": half,
            "cylinder_d": -2.0 * half,
            "axis_deg": axis_deg,
            "mean_error_d": 0.0,
            "blur_mm": 6.0 * 46.0 * half / 1000.0,
        },
    )


@settings(max_examples=200, deadline=None)
@given(st.floats(-8, 8), st.floats(-6, 6), st.floats(0, 180))
def test_a_prescription_is_said_in_minus_cylinder(
    sphere_d: float, cylinder_d: float, axis_deg: float
) -> None:
    eye = {"sphere_d": sphere_d, "cylinder_d": cylinder_d, "axis_deg": axis_deg, "vertex_mm": 0.0}
    found = inspect_rig(eye_rig(eye))["left"]
    if cylinder_d > 0.0:
        sphere_d, cylinder_d, axis_deg = sphere_d + cylinder_d, -cylinder_d, axis_deg + 90.0
    assert 0.0 <= found["axis_deg"] < 180.0
    assert found["cylinder_d"] <= 0.0
    # What is below 1e-12 D each way counts as no cylinder.
    assert found["sphere_d"] == pytest.approx(sphere_d, rel=1e-12, abs=2e-12)
    assert found["cylinder_d"] == pytest.approx(cylinder_d, rel=1e-12, abs=2e-12)
    if cylinder_d == 0.0:
        assert found["axis_deg"] == 0.0
    elif cylinder_d < -1e-3:
        # On a circle of 180 degrees; 1e-15 D of rounding turn 1e-3 D by 1e-10 degrees.
        turned = (found["axis_deg"] - axis_deg + 90.0) % 180.0 - 90.0
        assert turned == pytest.approx(0.0, abs=1e-9)


# --- accommodation ----------------------------------------------------------------------------

# 1000 (1/40 - 1/50): the panel appears 200 mm before the eye, 5 D.
NEAR = {"lens_to_panel_mm": 40.0, "lens_power_d": 20.0}


@pytest.mark.parametrize(
    ("eye", "adds_d", "left_d"),
    [
        ({}, 5.0, 0.0),  # 30 years by default: 9.5 D at most
        ({"sphere_d": 2.0}, 7.0, 0.0),
        ({"age_years": 50.0}, 3.5, 1.5),
        ({"age_years": 50.0, "sphere_d": -2.0}, 3.0, 0.0),
        ({"age_years": 62.0}, 0.0, 5.0),  # 18.5 - 18.6 is no amplitude
        ({"sphere_d": -8.0}, 0.0, -3.0),  # a lens cannot be made weaker than relaxed
        ({"sphere_d": 1.0, "cylinder_d": -4.0, "axis_deg": 77.0}, 4.0, 0.0),
        # c20 of -0.45 sqrt(3) um over 6 mm: M = 4 sqrt(3) * 0.45 sqrt(3) / 9 = 0.6.
        (
            {"zernike": {"diameter_mm": 6.0, "coefficients_um": {"2,0": -0.45 * sqrt(3.0)}}},
            5.6,
            0.0,
        ),
    ],
)
def test_best_accommodation(eye: Numbers, adds_d: float, left_d: float) -> None:
    given_eye = {"vertex_mm": 0.0, "accommodation": "best", **eye}
    found = inspect_rig(eye_rig(given_eye, headset=NEAR))["left"]
    holds(found, {"accommodation_d": adds_d, "mean_error_d": left_d})
    relaxed = inspect_rig(eye_rig(given_eye | {"accommodation": "relaxed"}, headset=NEAR))["left"]
    holds(relaxed, {"accommodation_d": 0.0, "mean_error_d": adds_d + left_d})
    # A power that is the same along all meridians changes no cylinder.
    holds(found, {"cylinder_d": relaxed["cylinder_d"], "axis_deg": relaxed["axis_deg"]})


# --- limits -----------------------------------------------------------------------------------


@settings(max_examples=50, deadline=None)
@given(by_hand.rigs())
def test_limits_of_any_array(rig: Rig) -> None:
    """The design's section 2 with lengths worked out apart."""
    e, power, s_a, g = by_hand.lengths_mm(rig)
    m = by_hand.slope_distance_mm(rig)
    pitch = rig.array.pitch_um / 1000.0
    rows = pitch if rig.array.lattice == "square" else pitch * sin(pi / 3.0)
    holds(
        inspect_rig(rig)["array"],
        {
            "lattice": rig.array.lattice,
            "field_of_view_deg": degrees(2.0 * atan(pitch / (2.0 * g))),
            "views": pitch / 0.078,
            "spatial_nyquist_per_mm": 1.0 / (2.0 * rows),
            "depth_of_field_mm": pitch * g / 0.078,
            "eyebox_mm": pitch * m / g,
            "best_pinhole_um": 1000.0 * sqrt(2.0 * 545e-6 * g),
            "lens_to_array_mm": s_a,
            "reduced_gap_mm": g,
        },
    )
    for side in SIDES:
        eye = rig.left if side == "left" else rig.right
        wanted = eye.pupil_mm / 2.0 + pitch * (e + s_a * (1.0 - e * power)) / 2.0 / g
        lattice = lattice_of(rig)
        assert lattice is not None
        half = limits.barrier_field_mm(bench_of(rig), lattice, eye_optics(rig, side))
        assert half * abs(1.0 - e * power) == pytest.approx(wanted, rel=1e-12)


def test_eyebox_is_the_distance_between_two_openings_of_one_pixel() -> None:
    """By tracing: one panel point, its own lenslet's centre and the neighbour's, the pupil."""
    array = {"kind": "pinhole", "pitch_um": 390, "gap_mm": 4, "gap_index": 1.3, "aperture_um": 60}
    rig = by_hand.rig(headset=RELIEF, array=array)
    x, zero, right = np.array([1.0, 2.0]), np.zeros(2), np.array([0.39, 0.0])
    apart = by_hand.inverse(rig, x, right)[0] - by_hand.inverse(rig, x, zero)[0]
    assert np.abs(apart) == pytest.approx([inspect_rig(rig)["array"]["eyebox_mm"], 0.0], abs=1e-12)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("relief_mm", [0.0, 12.0, 60.0])  # 60: beyond the lens's focus
def test_field_behind_perpendicular_barriers(side: Side, relief_mm: float) -> None:
    """Cells beyond the limit show nothing, those just within show something: by tracing."""
    eye = {"pupil_mm": 3.0, "vertex_mm": 0.0}
    array = {"kind": "microlens", "pitch_um": 400, "gap_mm": 3, "focal_mm": 3}
    rig = by_hand.rig(
        headset={"lens_to_panel_mm": 46.0, "eye_relief_mm": relief_mm},
        array=array | {"barriers": "perpendicular"},
        left=eye,
        right=eye,
    )
    lattice = lattice_of(rig)
    assert lattice is not None
    half = limits.barrier_field_mm(bench_of(rig), lattice, eye_optics(rig, side))
    for centre_x, shows in ((half - 1e-6, True), (half + 1e-6, False)):
        # The panel area of that cell, as far in as it goes, along the x axis.
        c = np.array([centre_x, 0.0])
        u = [by_hand.inverse(rig, c + np.array([dx, 0.0]), c)[0][0] for dx in (-0.2, 0.2)]
        meets = min(u) <= 1.5 and max(u) >= -1.5  # the pupil's radius
        assert meets == shows


def jacobian(function: Any, at: np.ndarray[Any, Any], step: float) -> np.ndarray[Any, Any]:
    """Central differences, columns by variable."""
    moves = np.eye(len(at)) * step
    return np.stack([(function(at + d) - function(at - d)) / (2 * step) for d in moves], axis=-1)


def without_wavefronts(rig: Rig) -> Rig:
    """Higher orders have second derivatives of their own, which the numbers leave out."""
    plain = {name: getattr(rig, name).model_copy(update={"zernike": None}) for name in SIDES}
    return rig.model_copy(update=plain)


@settings(max_examples=40, deadline=None)
@given(by_hand.rigs(), sides, points_mm(3.0))
def test_a_pixel_is_seen_as_large_as_the_inverse_map_shows_it(
    rig: Rig, side: Side, near: np.ndarray[Any, Any]
) -> None:
    rig = without_wavefronts(rig)
    bench, optics, lattice, view = (
        bench_of(rig),
        eye_optics(rig, side),
        lattice_of(rig),
        viewport(rig, side),
    )
    assert lattice is not None
    # A panel point whose chief ray meets its lenslet in the middle, far from its border.
    c = by_hand.cell_centre_mm(rig, side, near)
    m, at_array = by_hand.slope_distance_mm(rig), bench.array_per_slope_mm
    x = (m * c - bench.reduced_gap_mm * np.array(optics.pupil_offset_mm)) / at_array

    def seen(x_mm: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        return np.asarray(retinal_points(x_mm, bench, lattice, view, optics, 1)[0])

    # The map is linear within the cell: differences leave rounding alone, 1e-15 m / g / step.
    found = np.abs(np.linalg.eigvals(jacobian(seen, x, 1e-4))).max()
    assert limits.seen_pixel_px(bench, optics) == pytest.approx(found, rel=1e-6, abs=1e-6)


@settings(max_examples=40, deadline=None)
@given(by_hand.rigs(), sides, points_mm(3.0))
def test_an_opening_blurs_as_the_traced_rays_do(
    rig: Rig, side: Side, near: np.ndarray[Any, Any]
) -> None:
    """Hold the panel point, move across one opening: how far does the retinal point move?"""
    rig = without_wavefronts(rig)
    bench, optics, lattice, view = (
        bench_of(rig),
        eye_optics(rig, side),
        lattice_of(rig),
        viewport(rig, side),
    )
    assert lattice is not None
    offset = np.array(optics.pupil_offset_mm)

    def traced(X_and_u: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        X, u = X_and_u[:2], X_and_u[2:]
        landing = trace(bench, lattice, view, X, u, aberration_at(optics.aberration[1], u - offset))
        return np.concatenate([landing.array_mm, landing.panel_mm])

    # Start in the middle of a cell: the chief ray of the pupil's centre through ``c``.
    c = by_hand.cell_centre_mm(rig, side, near)
    start = np.concatenate([c, offset])
    for _ in range(2):  # y is linear in X within and across cells
        y = traced(start)[:2]
        start[:2] += (c - y) / bench.array_from_panel
    from_array_and_panel = np.linalg.inv(jacobian(traced, start, 1e-4))
    retina, pupil = from_array_and_panel[:2, :2], from_array_and_panel[2:, :2]
    opening_mm = (
        rig.array.pitch_um if lattice.kind == "microlens" else rig.array.aperture_um
    ) / 1e3
    # The rays of one panel point through an opening spread over the pupil by du/dy; what of
    # the opening lies beyond the pupil's edge adds nothing.
    through = float(np.abs(np.linalg.eigvals(pupil)).max())
    used_mm = opening_mm if through == 0.0 else min(opening_mm, optics.pupil_mm / through)
    found = float(np.abs(np.linalg.eigvals(retina)).max()) * used_mm
    # Inverting differences loses some digits where a lenslet images the pupil on the panel.
    wanted = pytest.approx(found, rel=1e-5, abs=1e-6)
    assert limits.opening_blur_mm(bench, lattice, optics) == wanted


@settings(max_examples=100, deadline=None)
@given(by_hand.rigs(), sides)
def test_best_focal_length_images_the_panel_onto_the_plane_of_focus(rig: Rig, side: Side) -> None:
    """1/f = 1/g + 1/(s_a - d_f), signs kept, also where the plane lies behind the eye."""
    e, power, s_a, g = by_hand.lengths_mm(rig)
    rig = without_wavefronts(rig)
    eye = rig.left if side == "left" else rig.right
    mean = float(np.trace(by_hand.matrix_d(eye))) / 2000.0
    focus = 1.0 / (power - mean / (1.0 + e * mean)) if power != mean / (1.0 + e * mean) else np.inf
    inverse_f = 1.0 / g + (0.0 if isinf(focus) else 1.0 / (s_a - focus))
    found = inspect_rig(rig)[side]["best_focal_mm"]
    # Lenslets of more than 10 m are none, and rounding decides their sign.
    if inverse_f < -1e-4:
        assert found is None
    elif inverse_f > 1e-4:
        assert found == pytest.approx(1.0 / inverse_f, rel=1e-6)


def test_best_focal_length_of_a_far_sighted_eye_without_a_lens() -> None:
    """+4 D and no lens: light must converge to 250 mm behind. 1/f = 1/4 + 1/(42 + 250)."""
    array = {"kind": "microlens", "pitch_um": 390, "gap_mm": 4, "focal_mm": 4}
    rig = eye_rig({"sphere_d": 4.0, "vertex_mm": 0.0}, headset={"lens_power_d": 0.0}, array=array)
    found = inspect_rig(rig)["left"]
    holds(found, {"focus_distance_mm": None, "best_focal_mm": 1.0 / (1.0 / 4.0 + 1.0 / 292.0)})


# --- warnings ---------------------------------------------------------------------------------

CLEAN = [
    ("matched-full", []),
    ("matched-full", ["both.pupil_mm=4"]),
    ("matched-full", ["headset.eye_relief_mm=10"]),
    ("bare", ["both.sphere_d=0"]),
]


def changed(name: str, changes: list[str]) -> Rig:
    """A shipped rig; ``both.`` stands for each eye."""
    overrides = [
        each.replace("both.", f"{side}.") for each in changes for side in ("left", "right")
    ]
    return load_rig(name, overrides=overrides)


# Rig, changes, what the sentence must name.
WARNED = [
    ("thesis-minus-5d", [], ["both eyes", "pupil of 6 mm", "eyebox of 2.99 mm", "up to 5"]),
    ("thesis-minus-5d", [], ["lenslets of 6 mm", "plane of focus", "1.81 mm"]),
    ("bare", [], ["17.7 pixels", "without an array"]),
    (
        "matched-full",
        ["left.zernike={diameter_mm=6.0, coefficients_um={'2,0'=0.1}}"],
        ["left eye", "second-order", "prescription", "twice"],
    ),
    (
        "matched-full",
        ["right.zernike={diameter_mm=5.0, extrapolate=true, coefficients_um={'3,1'=0.1}}"],
        ["right eye", "5 mm", "6 mm", "wavefront"],
    ),
    # 3 / 46 of a pupil of 6 mm and 0.39 * 43 / 6: 5.795 mm at the array, 6.199 on the panel.
    ("matched-full", ['array.barriers="perpendicular"'], ["perpendicular", "15 degrees", "black"]),
    ("pinhole", [], ["array", "3.7 %", "light"]),
    ("pinhole", ["array.aperture_um=50"], ["50 um", "81 um", "diffraction"]),
    # -15 D focuses at 27.2 mm, 15.8 mm before the array of 15 mm depth of field.
    ("matched-full", ["left.sphere_d=-15"], ["left eye", "27.2 mm", "15.8 mm", "depth of field"]),
    (
        "bare",
        [
            "headset.lens_power_d=10",
            "both.sphere_d=3",
            'both.accommodation="best"',
            "both.age_years=50",
        ],
        ["accommodation", "limit", "3.50 D"],
    ),
    ("matched-full", ["headset.lens_separation_mm=110"], ["axis", "half"]),
    ("matched-full", ["headset.lens_height_mm=-30"], ["axis", "half"]),
    ("matched-full", ["array.pitch_um=50"], ["array", "pitch", "pixel"]),
    ("pinhole", ["array.aperture_um=200"], ["hole", "blurs"]),
]


@pytest.mark.parametrize(("name", "changes", "words"), WARNED)
def test_warnings_stand_where_they_should(name: str, changes: list[str], words: list[str]) -> None:
    sentences = inspect_rig(changed(name, changes))["warnings"]
    assert any(all(word in sentence for word in words) for sentence in sentences), sentences


@pytest.mark.parametrize(("name", "changes"), CLEAN)
def test_a_clean_rig_has_no_warnings(name: str, changes: list[str]) -> None:
    assert inspect_rig(changed(name, changes))["warnings"] == []


@pytest.mark.parametrize(
    ("name", "changes", "word"),
    [
        # Each the nearest case that is no case.
        ("matched-full", ["both.pupil_mm=5.98"], "eyebox"),
        ("matched-full", ["left.zernike={diameter_mm=6.0, coefficients_um={'3,1'=0.1}}"], "order"),
        (
            "matched-full",
            ["both.sphere_d=0", "left.zernike={diameter_mm=6.0, coefficients_um={'2,0'=0.1}}"],
            "order",
        ),
        ("matched-full", ["left.zernike={diameter_mm=6.0, coefficients_um={'3,1'=0.1}}"], "meas"),
        ("matched-full", ['array.barriers="converging"'], "barriers"),
        ("pinhole", ["array.aperture_um=200"], "light"),
        ("matched-full", ["headset.lens_separation_mm=104"], "axis"),
        ("bare", ["both.sphere_d=3", 'both.accommodation="best"', "both.age_years=50"], "limit"),
        ("bare", ["both.sphere_d=-5", 'both.accommodation="best"'], "accommodation"),
    ],
)
def test_warnings_stand_nowhere_else(name: str, changes: list[str], word: str) -> None:
    sentences = inspect_rig(changed(name, changes))["warnings"]
    assert not any(word in sentence for sentence in sentences), sentences


def test_the_same_warning_for_both_eyes_is_said_once() -> None:
    sentences = inspect_rig(load_rig("thesis-minus-5d"))["warnings"]
    assert len(sentences) == len(set(sentences))
    assert not any(text.startswith(("left eye", "right eye")) for text in sentences)
    apart = inspect_rig(changed("thesis-minus-5d", ["right.pupil_mm=5"]))["warnings"]
    assert any(text.startswith("left eye") and "pupil of 6 mm" in text for text in apart)
    assert any(text.startswith("right eye") and "pupil of 5 mm" in text for text in apart)
