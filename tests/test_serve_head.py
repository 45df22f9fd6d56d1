"""From a phone's angles to the head's pose, the filter and its guess."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vrlf.app.serve.head import (
    MOST_AHEAD_S,
    filtered,
    head_pose,
    heading_deg,
    matrix,
    predicted,
    rotation_vector,
    screen_turn,
    times,
    turn_of,
)

ANGLE = st.floats(-179.0, 179.0)


def w3c_matrix(alpha: float, beta: float, gamma: float) -> np.ndarray:
    """The rotation matrix as W3C's device orientation, section A.3, writes it out."""
    z, x, y = (radians(a) for a in (alpha, beta, gamma))
    c_x, c_y, c_z, s_x, s_y, s_z = cos(x), cos(y), cos(z), sin(x), sin(y), sin(z)
    return np.array(
        [
            [c_z * c_y - s_z * s_x * s_y, -c_x * s_z, c_y * s_z * s_x + c_z * s_y],
            [c_y * s_z + c_z * s_x * s_y, c_z * c_x, s_z * s_y - c_z * c_y * s_x],
            [-c_x * s_y, s_x, c_x * c_y],
        ]
    )


@given(alpha=ANGLE, beta=ANGLE, gamma=ANGLE)
def test_the_angles_make_w3cs_matrix(alpha: float, beta: float, gamma: float) -> None:
    ours = matrix(screen_turn(alpha, beta, gamma, 0.0))
    np.testing.assert_allclose(ours, w3c_matrix(alpha, beta, gamma), atol=1e-12)


# On its left long edge (screen.orientation.angle 90), upright before the face: gamma is -90.
@pytest.mark.parametrize(
    ("alpha", "beta", "gamma", "screen", "pose"),
    [
        (0.0, 90.0, 0.0, 0.0, (0.0, 0.0, 0.0)),  # portrait, upright, looking north
        (-30.0, 90.0, 0.0, 0.0, (30.0, 0.0, 0.0)),  # turned to the right, toward the east
        (0.0, 110.0, 0.0, 0.0, (0.0, 20.0, 0.0)),  # the head leans back: it looks up
        (0.0, 0.0, -90.0, 90.0, (90.0, 0.0, 0.0)),  # landscape, looking east
        (0.0, 0.0, -70.0, 90.0, (90.0, -20.0, 0.0)),  # and down
        (0.0, 0.0, 90.0, -90.0, (-90.0, 0.0, 0.0)),  # the other landscape, looking west
        (0.0, 10.0, -90.0, 90.0, (90.0, 0.0, 10.0)),  # leaning to the right
    ],
)
def test_known_poses(
    alpha: float, beta: float, gamma: float, screen: float, pose: tuple[float, float, float]
) -> None:
    found = head_pose(screen_turn(alpha, beta, gamma, screen))
    np.testing.assert_allclose((found.yaw_deg, found.pitch_deg, found.roll_deg), pose, atol=1e-9)


def axes_of(yaw: float, pitch: float, roll: float) -> np.ndarray:
    """Right, up, back of a head in (east, north, up): rolled, then pitched, then turned."""
    y, p, r = radians(yaw), radians(pitch), radians(roll)
    forward = np.array([sin(y) * cos(p), cos(y) * cos(p), sin(p)])
    level_right = np.array([cos(y), -sin(y), 0.0])
    level_up = np.cross(level_right, forward)
    right = cos(r) * level_right - sin(r) * level_up  # leaning right: the right side goes down
    return np.stack([right, np.cross(-forward, right), -forward], axis=1)


@given(
    yaw=st.floats(-179.0, 179.0),
    pitch=st.floats(-85.0, 85.0),
    roll=st.floats(-170.0, 170.0),
    screen=st.sampled_from([0.0, 90.0, -90.0, 180.0]),
)
def test_a_pose_comes_back_whatever_the_screens_angle(
    yaw: float, pitch: float, roll: float, screen: float
) -> None:
    """The device's angles for a pose, by W3C's matrix, give the pose again."""
    s = radians(screen)
    device = axes_of(yaw, pitch, roll) @ np.array(
        [[cos(s), -sin(s), 0.0], [sin(s), cos(s), 0.0], [0.0, 0.0, 1.0]]
    )
    beta = np.degrees(np.arcsin(np.clip(device[2, 1], -1.0, 1.0)))
    if abs(beta) > 89.9:  # alpha and gamma are one angle there
        return
    alpha = np.degrees(np.arctan2(-device[0, 1], device[1, 1]))
    gamma = np.degrees(np.arctan2(-device[2, 0], device[2, 2]))
    found = head_pose(screen_turn(alpha, beta, gamma, screen))
    np.testing.assert_allclose(
        axes_of(found.yaw_deg, found.pitch_deg, found.roll_deg),
        axes_of(yaw, pitch, roll),
        atol=1e-7,
    )


def test_straight_ahead_is_where_it_was_set() -> None:
    turn = screen_turn(-200.0, 90.0, 0.0, 0.0)
    assert head_pose(turn, heading_deg(turn)).yaw_deg == pytest.approx(0.0, abs=1e-9)


@given(x=st.floats(-1.7, 1.7), y=st.floats(-1.7, 1.7), z=st.floats(-1.7, 1.7))
def test_turns_and_their_vectors(x: float, y: float, z: float) -> None:
    vector = np.array([x, y, z])
    np.testing.assert_allclose(rotation_vector(turn_of(vector)), vector, atol=1e-9)


def turning(speed: np.ndarray, seconds: float, noise_rad: float = 0.0, rate_hz: float = 60.0):
    """The filter after a steady turn, and the true turn at its end."""
    random, now, base = np.random.default_rng(4), None, screen_turn(10.0, 80.0, 5.0, 90.0)
    truth = base
    for k in range(round(seconds * rate_hz)):
        truth = times(turn_of(speed * k / rate_hz), base)
        seen = times(turn_of(random.normal(0.0, noise_rad, 3) if noise_rad else np.zeros(3)), truth)
        now = filtered(now, seen, 5.0 + k / rate_hz)
    assert now is not None
    return now, truth


def angle_deg(first: np.ndarray, second: np.ndarray) -> float:
    inverse = second * np.array([1.0, -1.0, -1.0, -1.0])
    return float(np.degrees(np.linalg.norm(rotation_vector(times(first, inverse)))))


def test_a_steady_turn_is_foretold() -> None:
    """100 degrees a second, 50 ms ahead: 5 degrees of lag become a tenth of one."""
    speed = np.radians([20.0, -30.0, 93.0])
    now, truth = turning(speed, 1.0)
    later = times(turn_of(0.05 * speed), truth)
    assert angle_deg(truth, later) == pytest.approx(5.0, abs=0.1)
    assert angle_deg(predicted(now, 0.05), later) < 0.1


def test_a_still_head_does_not_tremble() -> None:
    """Of a sensor's noise of 0.1 degrees a guess 50 ms ahead keeps less than it was, on average."""
    errors = []
    for seconds in np.arange(1.0, 3.0, 0.1):
        now, truth = turning(np.zeros(3), seconds, np.radians(0.1))
        errors.append(angle_deg(predicted(now, 0.05), truth))
    # Three axes' noise together: 0.1 sqrt(3).
    assert np.sqrt(np.mean(np.square(errors))) < 0.1 * np.sqrt(3.0)


def test_no_guess_is_farther_ahead_than_helps() -> None:
    now, _ = turning(np.radians([0.0, 0.0, 90.0]), 1.0)
    farthest = predicted(now, MOST_AHEAD_S)
    assert angle_deg(predicted(now, 10.0), farthest) == pytest.approx(0.0, abs=1e-9)


def test_a_gap_begins_anew_and_late_samples_are_left_out() -> None:
    now, _ = turning(np.radians([0.0, 0.0, 90.0]), 1.0)
    other = screen_turn(170.0, 20.0, -40.0, 90.0)
    assert filtered(now, other, now.at_s - 0.01) is now
    anew = filtered(now, other, now.at_s + 3.0)
    assert angle_deg(anew.turn, other) < 1e-6
    assert not anew.speed_rad_per_s.any()
