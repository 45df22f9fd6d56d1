"""The inverse map of the forward prefilter, reduced to a place in a cell.

A panel point x whose ray to the pupil's centre crosses the array at the place t of a cell
(in pitches of the lattice's middle, from the centre c of the lenslet) reaches the pupil through
c at

    u - o = -(m / g) P t                                     P: millimetres per cell

and shows the retinal point

    X = (m_0 / m) (x - o (1 - d F) + (1 - d F) (m / g) P t - m T(-(m / g) P t)),

m_0 / m being 1 but for a colour that the headset's lens magnifies differently.

Both follow from the design's inverse by putting c = y - P t, where y is the chief ray's
crossing; the test holds them against the unreduced equations. What moves a panel point is
thus one polynomial in t for each eye and colour, made once for a prescription.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vrlf.model import Rig
from vrlf.optics import polynomial
from vrlf.optics.bench import Bench
from vrlf.optics.eye import EyeOptics
from vrlf.optics.lattice import Lattice
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import RASTER_FLIP, pitch_mm


@dataclass(frozen=True)
class InverseMap:
    """From a place in a cell to the pupil and to the retinal image.

    Attributes
    ----------
    pupil_radii_per_cell : ndarray (2, 2)
        (u - o) / (a / 2) of a place in a cell; the ray counts within the unit disc.
    displacement_px : two ndarrays (k, k)
        X - (m_0 / m) x in pixels, right and down, as polynomials of the place.
    retina_from_panel : float
        m_0 / m.
    """

    pupil_radii_per_cell: Float
    displacement_px: tuple[Float, Float]
    retina_from_panel: float = 1.0


def crossing_shift_mm(bench: Bench, optics: EyeOptics) -> Float:
    """What a moved pupil adds to the place where chief rays cross the array: (g / m) o."""
    offset = np.array(optics.pupil_offset_mm)
    return np.asarray(bench.reduced_gap_mm / bench.panel_per_slope_mm * offset)


def inverse_map(
    rig: Rig, bench: Bench, lattice: Lattice, optics: EyeOptics, colour: int
) -> InverseMap:
    """The map of one eye and colour."""
    reach = bench.panel_per_slope_mm / bench.reduced_gap_mm
    pupil_from_cell_mm = -reach * lattice.panel_from_cell
    offset = np.array(optics.pupil_offset_mm)
    moved = []
    for axis in range(2):
        aberration = polynomial.compose_linear(optics.aberration[colour][axis], pupil_from_cell_mm)
        linear = np.zeros((2, 2))
        linear[0, 0] = -offset[axis] * bench.defocus_factor
        linear[1, 0] = -bench.defocus_factor * pupil_from_cell_mm[axis, 0]
        linear[0, 1] = -bench.defocus_factor * pupil_from_cell_mm[axis, 1]
        moved.append(polynomial.add(linear, -bench.panel_per_slope_mm * aberration))
    right, down = (
        moved[axis] * RASTER_FLIP[axis, axis] / pitch_mm(rig) / bench.panel_from_retina
        for axis in range(2)
    )
    return InverseMap(
        pupil_radii_per_cell=pupil_from_cell_mm / (optics.pupil_mm / 2.0),
        displacement_px=(right, down),
        retina_from_panel=1.0 / bench.panel_from_retina,
    )
