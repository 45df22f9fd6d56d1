"""Cameras: world points against projections in closed form, and pyrr's ways."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import ArrayLike, NDArray
from pyrr import Matrix44

from vrlf.model import Rig, load_rig
from vrlf.optics.bench import bench_of
from vrlf.optics.viewport import SIDES, Side, panel_points_mm, viewport
from vrlf.scene.camera import (
    FAR_M,
    NEAR_M,
    HeadPose,
    clip_from_world,
    eye_position_m,
    head_axes,
    panel_frustum,
    seen_frustum,
)

Float = NDArray[np.float64]

# Double precision over some ten operations on numbers up to 100.
EXACT = 1e-12

# Nothing of it is symmetric: an odd width, axes above the middle, an eye relief, a weak lens.
SKEW = (
    "panel.width_px=1335",
    "headset.lens_height_mm=2.5",
    "headset.eye_relief_mm=17.0",
    "headset.lens_power_d=19.0",
    "headset.lens_separation_mm=58.0",
)


@pytest.fixture(scope="module")
def rig() -> Rig:
    """A rig without symmetries."""
    return load_rig("matched-microlens", overrides=SKEW)


def seen_at_mm(rig: Rig, side: Side, point: ArrayLike, head: HeadPose | None = None) -> Float:
    """The panel point at which an eye sees a world point, by way of the matrix."""
    clip = np.append(point, 1.0) @ clip_from_world(rig, side, head or HeadPose())
    assert clip[3] > 0.0
    f = seen_frustum(rig, side)
    share = 0.5 + 0.5 * clip[:2] / clip[3]
    slope = np.array([f.left, f.bottom]) + share * np.array(f.size)
    return np.asarray(slope * bench_of(rig).panel_per_slope_mm)


def by_hand_mm(rig: Rig, side: Side, point: ArrayLike) -> Float:
    """m times the slope from the eye: X = m (x - x_eye) / (-z), Y = m y / (-z)."""
    x, y, z = np.asarray(point, np.float64)
    half_m = rig.headset.lens_separation_mm / 2000.0
    eye_x = -half_m if side == "left" else half_m
    return np.array([x - eye_x, y]) / -z * bench_of(rig).panel_per_slope_mm


@pytest.mark.parametrize("side", SIDES)
@given(x=st.floats(-3.0, 3.0), y=st.floats(-3.0, 3.0), depth=st.floats(0.3, 20.0, exclude_min=True))
def test_a_world_point_projects_in_closed_form(
    rig: Rig, side: Side, x: float, y: float, depth: float
) -> None:
    point = (x, y, -depth)
    # Slopes reach 10 here, times m.
    assert seen_at_mm(rig, side, point) == pytest.approx(by_hand_mm(rig, side, point), abs=1e-9)


def test_one_point_in_numbers() -> None:
    """The default rig: m = 46 mm, eyes 62 mm apart; a point 11 cm right, 5 cm up, 0.5 m away."""
    rig = load_rig("matched-microlens")
    left, right = (seen_at_mm(rig, side, (0.11, 0.05, -0.5)) for side in SIDES)
    assert left == pytest.approx([46.0 * 0.141 / 0.5, 4.6], abs=1e-9)
    assert right == pytest.approx([46.0 * 0.079 / 0.5, 4.6], abs=1e-9)


def test_near_things_have_crossed_disparity(rig: Rig) -> None:
    """The left eye sees them further right, by m times the separation over the distance."""
    m, separation_m = bench_of(rig).panel_per_slope_mm, 0.058
    for depth in (0.35, 2.0, 19.0):
        left, right = (seen_at_mm(rig, side, (0.04, -0.1, -depth)) for side in SIDES)
        assert left[0] - right[0] == pytest.approx(m * separation_m / depth, abs=1e-9)
        assert left[1] == pytest.approx(right[1], abs=1e-9)


def test_far_things_stand_at_the_same_place(rig: Rig) -> None:
    far = 1e6
    left, right = (seen_at_mm(rig, side, (0.3 * far, 0.2 * far, -far)) for side in SIDES)
    # What is left of the disparity: m * separation / distance.
    assert left == pytest.approx(right, abs=1e-5)


@pytest.mark.parametrize("side", SIDES)
def test_the_frustum_ends_half_a_pixel_beyond_the_outer_pixels(rig: Rig, side: Side) -> None:
    points = panel_points_mm(rig, viewport(rig, side)) / bench_of(rig).panel_per_slope_mm
    half = 0.078 / 2.0 / bench_of(rig).panel_per_slope_mm
    f = panel_frustum(rig, side)
    found = (f.left, f.right, f.bottom, f.top)
    wanted = (
        points[0, 0, 0] - half,
        points[0, -1, 0] + half,
        points[-1, 0, 1] - half,
        points[0, 0, 1] + half,
    )
    assert found == pytest.approx(wanted, abs=EXACT)
    assert seen_frustum(rig, side) == f  # no distortion


def test_the_frusta_mirror_each_other_about_the_nose() -> None:
    left, right = (panel_frustum(load_rig("matched-microlens"), side) for side in SIDES)
    assert (left.left, left.right) == pytest.approx((-right.right, -right.left), abs=EXACT)
    # 31 mm to the nose, 21 mm to the temple.
    assert left.right == pytest.approx(31.0 / 46.0, abs=EXACT)
    assert left.left == pytest.approx(-(667 * 0.078 - 31.0) / 46.0, abs=EXACT)


def test_depth_runs_from_near_to_far(rig: Rig) -> None:
    matrix = clip_from_world(rig, "left", HeadPose())
    for depth, wanted in ((NEAR_M, -1.0), (FAR_M, 1.0)):
        clip = np.array([0.0, 0.0, -depth, 1.0]) @ matrix
        assert clip[2] / clip[3] == pytest.approx(wanted, abs=1e-9)


# What turning the head by 30 degrees does to its own axes, from a drawing.
C, S = np.sqrt(0.75), 0.5
TURNS = {
    "yaw to the right": (HeadPose(yaw_deg=30), [[C, 0, S], [0, 1, 0], [-S, 0, C]]),
    "pitch up": (HeadPose(pitch_deg=30), [[1, 0, 0], [0, C, S], [0, -S, C]]),
    "roll to the right": (HeadPose(roll_deg=30), [[C, -S, 0], [S, C, 0], [0, 0, 1]]),
}


@pytest.mark.parametrize("name", TURNS)
def test_a_turn_by_hand(name: str) -> None:
    head, wanted = TURNS[name]
    assert head_axes(head) == pytest.approx(np.array(wanted), abs=EXACT)


def test_roll_comes_first_then_pitch_then_yaw() -> None:
    """The pitch is about the turned ears, the roll about the pitched glance."""
    axes = head_axes(HeadPose(yaw_deg=90, pitch_deg=30))
    assert -axes[2] == pytest.approx([C, S, 0], abs=EXACT)
    # A roll by 90 puts the right ear down; the pitch then tips it forward.
    axes = head_axes(HeadPose(pitch_deg=30, roll_deg=90))
    assert axes[0] == pytest.approx([0, -C, -S], abs=EXACT)


@given(
    yaw=st.floats(-180, 180),
    pitch=st.floats(-89, 89),
    roll=st.floats(-90, 90),
    x=st.floats(-2, 2),
    y=st.floats(-2, 2),
    z=st.floats(-2, 2),
)
def test_a_moved_head_sees_what_it_would_see_at_rest(
    rig: Rig, yaw: float, pitch: float, roll: float, x: float, y: float, z: float
) -> None:
    """A point given in the head's own axes is seen at the same place, however the head is."""
    head = HeadPose(yaw, pitch, roll, (x, y, z))
    own = np.array([0.07, -0.12, -0.9])
    axes = head_axes(head)
    assert axes @ axes.T == pytest.approx(np.eye(3), abs=EXACT)
    assert np.linalg.det(axes) == pytest.approx(1.0, abs=EXACT)
    point = np.array([x, y, z]) + own @ axes
    for side in SIDES:
        # m times what rounding leaves of a slope.
        assert seen_at_mm(rig, side, point, head) == pytest.approx(
            by_hand_mm(rig, side, own), abs=1e-9
        )


def test_a_rolled_head_carries_its_eyes_along(rig: Rig) -> None:
    head = HeadPose(roll_deg=90, position_m=(1.0, 2.0, 3.0))
    assert eye_position_m(rig, "left", head) == pytest.approx([1.0, 2.029, 3.0], abs=EXACT)
    assert eye_position_m(rig, "right", head) == pytest.approx([1.0, 1.971, 3.0], abs=EXACT)


def test_whole_numbers_do_as_well_as_floats(rig: Rig) -> None:
    whole = clip_from_world(rig, "left", HeadPose(30, 20, 10, (1, 2, 3)))
    floats = clip_from_world(rig, "left", HeadPose(30.0, 20.0, 10.0, (1.0, 2.0, 3.0)))
    assert whole.dtype == np.float64
    assert np.array_equal(whole, floats)


def test_distortion_widens_the_seen_frustum() -> None:
    """k > 0: the corner of the viewport, the farthest from the axis, is seen farthest out."""
    k1, k2 = 0.34, 0.55
    rig = load_rig("matched-microlens", overrides=[f"headset.distortion=[{k1},{k2}]"])
    plain, seen = panel_frustum(rig, "left"), seen_frustum(rig, "left")
    r2 = plain.right**2 + plain.top**2
    assert seen.right == pytest.approx(plain.right * (1 + k1 * r2 + k2 * r2**2), abs=EXACT)
    r2 = plain.left**2 + plain.top**2
    assert seen.left == pytest.approx(plain.left * (1 + k1 * r2 + k2 * r2**2), abs=EXACT)


def test_distortion_that_turns_back_is_held_too() -> None:
    """k < 0: r (1 - r^2) is greatest at r = 1 / sqrt(3), inside the viewport."""
    rig = load_rig("matched-microlens", overrides=["headset.distortion=[-1.0,0.0]"])
    seen = seen_frustum(rig, "left")
    # Found on a grid of 65 places: the maximum is flat, so the grid misses little of it.
    assert seen.right == pytest.approx(2.0 / 3.0 / np.sqrt(3.0), abs=2e-3)


def test_the_traps_of_pyrr_still_hold() -> None:
    """What camera.py is written around: should pyrr mend it, this tells."""
    bounds = (-1.0, 2.0, -0.5, 3.0, 1.0, 10.0)
    by_place = Matrix44.perspective_projection_bounds(*bounds)
    named = dict(zip(("left", "right", "bottom", "top", "near", "far"), bounds, strict=True))
    by_name = Matrix44.perspective_projection_bounds(**named)
    corner = np.array([2.0, 3.0, -1.0, 1.0])
    assert (corner @ np.asarray(by_place))[:2] == pytest.approx([1.0, 1.0])
    assert (corner @ np.asarray(by_name))[:2] == pytest.approx([1.0, -1.0])
