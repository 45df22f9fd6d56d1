"""How far the eye may turn before the array's correction fails.

An eye that turns by an angle a takes its pupil sideways by rho sin a, rho from the pupil to the
eye's centre of rotation. The panel's picture was made for where the pupil was. Through the lenslet
that it was made for, a panel pixel's light meets the pupil's plane within a square about the old
centre o, the eyebox E = D m / g wide (``vrlf/optics/inverse.py``: u - o = -(m / g) P t, t a place
in a cell); beside it lie the squares of the neighbouring lenslets, which show the same pixel where
it was not meant to be seen. So of the light that enters a pupil the right share is what its disc
and that square have in common.

*Fails* means here: no more than half of the right light that entered the pupil that looked straight
ahead still enters it, the rest being other lenslets'. For a pupil of up to four fifths of the
eyebox that is where its centre reaches the eyebox's edge, E / 2 away: half the light is wrong then.
For one much wider than the eyebox, which sees all of it for long, it is a / 2. Sphere and cylinder
do not blur by themselves meanwhile: all right rays of a moved pupil are displaced alike.
"""

from __future__ import annotations

from math import asin, degrees

import numpy as np

from vrlf.optics.bench import Bench
from vrlf.optics.eye import EyeOptics
from vrlf.optics.lattice import Lattice
from vrlf.optics.polynomial import Float

# Behind the cornea: the centre about which eyes turn sideways, mean of Fry & Hill 1962 ("The
# center of rotation of the eye"; upward it is 12.2, Fry & Hill 1963, which allows more), and
# the entrance pupil of Gullstrand's schematic eye.
ROTATION_CENTRE_MM = 14.8
ENTRANCE_PUPIL_MM = 3.05
PUPIL_FROM_CENTRE_MM = ROTATION_CENTRE_MM - ENTRANCE_PUPIL_MM

_KEPT = 0.5
_SLICES, _DIRECTIONS, _HALVINGS = 1000, 8, 40


def gaze_limit_deg(bench: Bench, lattice: Lattice, optics: EyeOptics) -> float | None:
    """The angle by which the eye may turn; None where it cannot turn far enough to fail.

    The least over all directions along the lattice.
    """
    eyebox_mm = lattice.pitch_mm * bench.panel_per_slope_mm / bench.reduced_gap_mm
    moved_mm = pupil_move_mm(optics.pupil_mm, eyebox_mm)
    if moved_mm >= PUPIL_FROM_CENTRE_MM:
        return None
    return degrees(asin(moved_mm / PUPIL_FROM_CENTRE_MM))


def pupil_move_mm(pupil_mm: float, eyebox_mm: float) -> float:
    """How far a pupil moves until half of the light that it shared with the eyebox is left."""
    angles = np.linspace(0.0, np.pi / 4.0, _DIRECTIONS)  # the rest of the square is the same
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    wanted = _KEPT * shared_mm2(np.zeros((1, 2)), pupil_mm, eyebox_mm)
    # Both are convex and alike on both sides: what they share only falls on any way outward.
    low = np.zeros(_DIRECTIONS)
    high = np.full(_DIRECTIONS, pupil_mm + eyebox_mm)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2.0
        keeps = shared_mm2(middle[:, None] * ways, pupil_mm, eyebox_mm) > wanted
        low, high = np.where(keeps, middle, low), np.where(keeps, high, middle)
    return float(low.min())


def shared_mm2(centre_mm: Float, pupil_mm: float, eyebox_mm: float) -> Float:
    """Area that discs and a square about the origin have in common.

    Parameters
    ----------
    centre_mm : ndarray (n, 2)
        Of the discs, along the square's sides.
    """
    half, radius = eyebox_mm / 2.0, pupil_mm / 2.0
    # Slices of the disc between the square's sides, even in the angle about its centre: so they
    # are close where its edge is steep.
    x, y = centre_mm[:, :1], centre_mm[:, 1:]
    first, last = (np.arccos(np.clip((x - edge) / radius, -1.0, 1.0)) for edge in (-half, half))
    angle = first + (last - first) * (np.arange(_SLICES) + 0.5) / _SLICES
    chord = radius * np.sin(angle)
    inside = np.minimum(y + chord, half) - np.maximum(y - chord, -half)
    slices = np.maximum(inside, 0.0) * chord * (last - first) / _SLICES
    return np.asarray(slices.sum(axis=1))
