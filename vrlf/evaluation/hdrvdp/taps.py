"""The taps of the steerable pyramid of four orientations ("sp3").

Source: Simoncelli & Freeman 1995, designed as Karasaridis & Simoncelli 1996 describe. The taps
are the published ones (sp3Filters of matlabPyrTools), whole numbers of 1e-8 here, without what
their symmetry gives.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

Taps: TypeAlias = NDArray[np.float64]

UNIT: Final = 1e-8

# Upper left quarters with the middle row and column; the rest is mirrored.
HIGH: Final = (
    (-40484, -62596, -3783, 88387, 154508, 192360, 206875, 208987),
    (-62596, -32735, 77435, 158744, 217507, 256265, 228922, 197551),
    (-3783, 77435, 117932, 140510, 222534, 211453, 33578, -83369),
    (88387, 158744, 140510, 129610, -49274, -312953, -457518, -510145),
    (154508, 217507, 222534, -49274, -632227, -275560, 536322, 730326),
    (192360, 256265, 211453, -312953, -275560, 1396236, 780463, -938122),
    (206875, 228922, 33578, -457518, 536322, 780463, -7950164, -15541416),
    (208987, 197551, -83369, -510145, 730326, -938122, -15541416, 73038661),
)
LOW: Final = (
    (-8701, -135428, -160126, -50337, 252401),
    (-135428, 292158, 752272, 822442, 110762),
    (-160126, 752272, -706129, -3769487, -3297137),
    (-50337, 822442, -3769487, 4381320, 18116030),
    (252401, 110762, -3297137, 18116030, 43762499),
)
HALVING: Final = (
    (-4350, 12078, -67714, -12434, -80064, -159704, -25168, -42020, 126200),
    (12078, 44606, -58146, 56216, -13688, 232554, 288986, 428728, 558940),
    (-67714, -58146, 146078, 216054, 376136, 308098, 411220, 222122, 55382),
    (-12434, 56216, 216054, 317578, 318468, -177748, -743170, -905692, -963722),
    (-80064, -13688, 376136, 318468, -353064, -1260420, -1884744, -1750818, -1648568),
    (-159704, 232554, 308098, -177748, -1260420, -2022938, -1109170, 395566, 1438512),
    (-25168, 288986, 411220, -743170, -1884744, -1109170, 2190660, 6806584, 9058014),
    (-42020, 428728, 222122, -905692, -1750818, 395566, 6806584, 14454998, 17736512),
    (126200, 558940, 55382, -963722, -1648568, 1438512, 9058014, 17736512, 21203744),
)
# Upper halves down to the middle tap, which is 0; the rest is turned by half and negated.
UPRIGHT: Final = (
    (-81125, 444516, 1231698, 1395588, 1417945, 1395588, 1231698, 444516, -81125),
    (391035, 445654, -587243, -287608, 852676, -287608, -587243, 445654, 391035),
    (134627, -377407, 825816, 3944228, 5360564, 3944228, 825816, -377407, 134627),
    (74701, -36522, -2252268, -11056907, -17684193, -11056907, -2252268, -36522, 74701),
    (0, 0, 0, 0),
)
DIAGONAL: Final = (
    (0, -82847, -5711, 4011, 466709, 808719, 1480761, 862044, -312215),
    (82847, 0, -97480, -697190, -208656, 232988, -448149, 1491750, 862044),
    (5711, 97480, 0, -1214554, -2442729, 5079706, 3278587, -448149, 1480761),
    (-4011, 697190, 1214554, 0, -15105556, -8249550, 5079706, 232988, 808719),
    (-466709, 208656, 2442729, 15105556),
)


def _mirrored(quarter: Sequence[Sequence[int]]) -> Taps:
    """The filter whose upper left quarter, middle row and column included, is given."""
    left = np.array(quarter, dtype=np.float64) * UNIT
    upper = np.hstack((left, left[:, -2::-1]))
    return np.vstack((upper, upper[-2::-1]))


def _turned(half: Sequence[Sequence[int]]) -> Taps:
    """The odd filter whose taps before the middle one are given."""
    before = np.array([tap for row in half for tap in row], dtype=np.float64) * UNIT
    side = len(half[0])
    return np.concatenate((before, [0.0], -before[::-1])).reshape(side, side)


def high_taps() -> Taps:
    """What leaves the high residual, (15, 15); sums to 0."""
    return _mirrored(HIGH)


def low_taps() -> Taps:
    """What leaves the rest for the levels, (9, 9); sums to 1."""
    return _mirrored(LOW)


def halving_taps() -> Taps:
    """What is left before each halving, (17, 17); sums to 2, so that bands double by level."""
    return _mirrored(HALVING)


def band_taps() -> tuple[Taps, Taps, Taps, Taps]:
    """The four orientations, 45 degrees apart, (9, 9) each; the first answers to columns.

    Their order counts: a residual borders on the first of them when bands mask one another.
    """
    upright, diagonal = _turned(UPRIGHT), _turned(DIAGONAL)
    return upright.T, diagonal, upright, diagonal[:, ::-1]
