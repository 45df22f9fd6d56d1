"""How sharp one panel point is seen through single openings, with all orders of the eye in.

With x the panel point and c the opening's centre, the ray through the pupil at u shows it at

    X = (x - psi(u) + (g / f) (phi(u) - c)) / (1 - (g / f) a)

(``vrlf/optics/samples.py``), where it crosses the array at y = a X + phi(u), within the opening.
For a sphero-cylinder all openings blur alike; with higher orders each part of the pupil has an
error of its own, and an array that serves one does not serve the others.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, sqrt

import numpy as np

from vrlf.model import Rig
from vrlf.optics import sequence
from vrlf.optics.eye import EyeOptics, aberration_at
from vrlf.optics.lattice import Lattice, lattice_of
from vrlf.optics.polynomial import Float
from vrlf.optics.samples import footprint_scale
from vrlf.optics.viewport import pitch_mm

# Openings whose own blur is below this many pixels count as focused.
FOCUSED_PX = 3.0
_PUPIL_POINTS = 2048
# Openings stand anywhere: so many places along a pitch are tried.
_PLACES_A_PITCH = 2
# Fewer rays than these have no width.
_FEWEST_RAYS = 4
# An even disc is this times as wide as the root mean square of its radius.
_WIDTH_OF_RMS = 2.0 * sqrt(2.0)
# A lenslet that spreads nothing over the pupil shows it all at once, at no one place.
_LEAST_SCALE = 1e-3


@dataclass(frozen=True)
class Served:
    """What openings do for an eye; widths as of an even disc of that spread.

    Attributes
    ----------
    share : float
        Of the pupil's light, what passes openings that blur a point over `FOCUSED_PX` at most.
    mean_px, most_px : float
        Root mean square over the light, and of the worst opening.
    """

    share: float
    mean_px: float
    most_px: float


def served_pupil(rig: Rig, optics: EyeOptics) -> Served | None:
    """How much of an eye's pupil the array serves, for the green primary; None without one."""
    lattice = lattice_of(rig)
    if lattice is None:
        return None
    widths, rays = _openings(rig, lattice, optics)
    total = rays.sum()
    if total == 0:
        return Served(0.0, 0.0, 0.0)
    return Served(
        share=float(rays[widths <= FOCUSED_PX].sum() / total),
        mean_px=float(np.sqrt(np.sum(rays * widths**2) / total)),
        most_px=float(widths.max()),
    )


def _openings(rig: Rig, lattice: Lattice, optics: EyeOptics) -> tuple[Float, Float]:
    """Width in pixels of a point through each opening that shows it, and its rays; (n,) each."""
    bench = optics.benches[1]
    scale = footprint_scale(bench, lattice)
    even = sequence.to_disc(sequence.points(_PUPIL_POINTS)[:, :2]) * optics.pupil_mm / 2.0
    from_centre = optics.weighed(even)
    u_mm = from_centre + np.array(optics.pupil_offset_mm)
    slope = aberration_at(optics.aberration[1], from_centre)
    phi = bench.array_defocus_factor * u_mm + bench.array_per_slope_mm * slope
    psi = bench.defocus_factor * u_mm + bench.panel_per_slope_mm * slope
    if abs(scale) < _LEAST_SCALE:
        scale = _LEAST_SCALE
    seen_mm = (bench.bend * phi - psi) / scale  # of x = 0 through c = 0
    crossing = bench.array_from_panel * seen_mm + phi
    # Another c moves X by -(g / f) c / scale, and the crossing by a times that: what counts is
    # y - c, which moves by -c / scale.
    relative = crossing * scale
    step = lattice.pitch_mm / _PLACES_A_PITCH
    reach = np.abs(relative).max(axis=0) + lattice.pitch_mm
    sides = [np.arange(-ceil(r / step), ceil(r / step) + 1) * step for r in reach]
    half_mm = min(lattice.half_aperture, 0.5) * lattice.pitch_mm * abs(scale)
    widths, rays = [], []
    for c_x in sides[0]:
        near = np.flatnonzero(np.abs(relative[:, 0] - c_x) <= half_mm)
        for c_y in sides[1]:
            held = near[np.abs(relative[near, 1] - c_y) <= half_mm]
            if len(held) >= _FEWEST_RAYS:
                spread = float(np.sum(np.var(seen_mm[held], axis=0)))
                widths.append(_WIDTH_OF_RMS * sqrt(spread) / pitch_mm(rig))
                rays.append(float(len(held)))
    return np.array(widths), np.array(rays)
