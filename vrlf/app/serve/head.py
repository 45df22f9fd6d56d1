"""From a phone's turning to the head's: W3C's angles, a filter, a guess at the time of display.

The phone stands in its headset on a long edge, its screen toward the face, so that the wearer looks
along -z of the screen. W3C's device orientation (2016, section 4.1): the device's axes in the
earth's (east, north, up) are R = Rz(alpha) Rx(beta) Ry(gamma), intrinsic. The screen may stand
turned in the device by its own angle: its axes are R Rz(-angle).

Quaternions are (w, x, y, z), of length 1, and turn the screen's axes into the earth's.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import asin, atan2, cos, degrees, exp, pi, radians, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from vrlf.scene import HeadPose

Quaternion = NDArray[np.float64]

# A head's quick turn is 200 to 400 degrees a second; what is faster is no head.
_FASTEST_RAD_PER_S = radians(800.0)
# Cut-off of the filter at rest, and how much a turn opens it (Casiez, Roussel & Vogel 2012, the
# one-euro filter): a still head does not tremble, a turning one does not lag.
_REST_HZ, _OPENING_PER_RAD = 1.5, 4.0
# What the filter is behind by counts as a speed that would catch it up within so long.
_CATCHING_S = 0.05
# Farther ahead a guess does more harm than lag.
MOST_AHEAD_S = 0.08
# After a gap this long the filter begins anew.
_GAP_S = 0.5


@dataclass(frozen=True)
class Turning:
    """What the filter knows.

    Attributes
    ----------
    turn : ndarray, shape (4,)
        Screen to earth, filtered.
    speed_rad_per_s : ndarray, shape (3,)
        About the earth's axes, smoothed.
    at_s : float
        Of the last sample, by the phone's clock.
    """

    turn: Quaternion
    speed_rad_per_s: NDArray[np.float64]
    at_s: float


def screen_turn(
    alpha_deg: float, beta_deg: float, gamma_deg: float, screen_deg: float
) -> Quaternion:
    """Screen to earth, from W3C's three angles and the screen's own."""
    half = [radians(angle) / 2.0 for angle in (alpha_deg, beta_deg, gamma_deg, -screen_deg)]
    turns = [
        np.array([cos(half[0]), 0.0, 0.0, sin(half[0])]),
        np.array([cos(half[1]), sin(half[1]), 0.0, 0.0]),
        np.array([cos(half[2]), 0.0, sin(half[2]), 0.0]),
        np.array([cos(half[3]), 0.0, 0.0, sin(half[3])]),
    ]
    whole = turns[0]
    for turn in turns[1:]:
        whole = times(whole, turn)
    return whole


def filtered(before: Turning | None, turn: Quaternion, at_s: float) -> Turning:
    """The filter after another sample; the first one, or one after a gap, is taken as it is."""
    if before is None or not 0.0 < at_s - before.at_s <= _GAP_S:
        if before is not None and -_GAP_S <= at_s - before.at_s <= 0.0:
            return before  # an older sample that came late
        return Turning(turn, np.zeros(3), at_s)
    passed_s = at_s - before.at_s
    # Where the head should be by now, and some of the way from there to where it was measured.
    expected = times(turn_of(before.speed_rad_per_s * passed_s), before.turn)
    rest = rotation_vector(times(turn, conjugate(expected)))
    speed_now = float(np.linalg.norm(before.speed_rad_per_s) + np.linalg.norm(rest) / _CATCHING_S)
    share = _share(_REST_HZ + _OPENING_PER_RAD * speed_now, passed_s)
    # Kalata 1984: what the speed takes of the rest where the place takes ``share``, so that
    # neither overshoots. Differences of noisy places would shake the guess.
    speed = before.speed_rad_per_s + share**2 / (2.0 - share) / passed_s * rest
    size = float(np.linalg.norm(speed))
    if size > _FASTEST_RAD_PER_S:
        speed = speed * (_FASTEST_RAD_PER_S / size)
    return Turning(unit(times(turn_of(share * rest), expected)), speed, at_s)


def predicted(now: Turning, ahead_s: float) -> Quaternion:
    """Where the screen will be, if it goes on turning as it does."""
    ahead_s = min(max(ahead_s, 0.0), MOST_AHEAD_S)
    return unit(times(turn_of(now.speed_rad_per_s * ahead_s), now.turn))


def head_pose(turn: Quaternion, ahead_deg: float = 0.0) -> HeadPose:
    """The head that looks along the screen's -z.

    Parameters
    ----------
    turn : ndarray, shape (4,)
        Screen to earth.
    ahead_deg : float
        The heading that counts as straight ahead.
    """
    axes = matrix(turn)
    right, forward = axes[:, 0], -axes[:, 2]
    pitch = asin(min(max(forward[2], -1.0), 1.0))
    if abs(forward[2]) > 1.0 - 1e-9:  # straight up or down: the heading is the screen's right's
        heading = atan2(-right[1], right[0])
    else:
        heading = atan2(forward[0], forward[1])
    level_right = np.array([cos(heading), -sin(heading), 0.0])
    level_up = np.cross(level_right, forward)
    roll = atan2(-float(right @ level_up), float(right @ level_right))
    yaw = (degrees(heading) - ahead_deg + 180.0) % 360.0 - 180.0
    return HeadPose(yaw_deg=yaw, pitch_deg=degrees(pitch), roll_deg=degrees(roll))


def heading_deg(turn: Quaternion) -> float:
    """The compass heading that the wearer looks in; positive toward the east."""
    return head_pose(turn).yaw_deg


# Quaternions


def times(first: Quaternion, second: Quaternion) -> Quaternion:
    """Hamilton's product: the turn ``second``, then ``first``."""
    a, b = first, second
    return np.array(
        [
            a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
            a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
            a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
        ]
    )


def conjugate(turn: Quaternion) -> Quaternion:
    """The turn back."""
    return np.asarray(turn * np.array([1.0, -1.0, -1.0, -1.0]))


def unit(turn: Quaternion) -> Quaternion:
    """Of length 1."""
    return np.asarray(turn / sqrt(float(turn @ turn)))


def turn_of(vector_rad: NDArray[np.float64]) -> Quaternion:
    """The turn about a vector by its length."""
    angle = float(np.linalg.norm(vector_rad))
    if angle < 1e-12:
        return np.array([1.0, *(0.5 * vector_rad)])
    return np.array([cos(angle / 2.0), *(sin(angle / 2.0) / angle * vector_rad)])


def rotation_vector(turn: Quaternion) -> NDArray[np.float64]:
    """The vector of ``turn_of``, of length at most pi."""
    turn = turn if turn[0] >= 0.0 else -turn
    size = float(np.linalg.norm(turn[1:]))
    if size < 1e-12:
        return 2.0 * turn[1:]
    return np.asarray(2.0 * atan2(size, turn[0]) / size * turn[1:])


def matrix(turn: Quaternion) -> NDArray[np.float64]:
    """The screen's axes in the earth's, column by column."""
    w, x, y, z = turn
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _share(cut_off_hz: float, passed_s: float) -> float:
    """How much of the way a first-order filter goes in a time."""
    return 1.0 - exp(-2.0 * pi * cut_off_hz * passed_s)
