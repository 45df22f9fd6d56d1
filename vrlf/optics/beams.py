"""The beam that one retinal point sends through the pupil, where it meets the array.

With X fixed, y = phi(u) and x = psi(u) up to a constant (``vrlf/optics/samples.py``), so that
about a ray through u, with J the derivative of the eye's aberration T there,

    dy = ((1 - s_a F) I + (e + s_a (1 - e F)) J) du = Phi du
    dx = ((1 - d F) I + m J) du = Psi du

and M = dx/dy = Psi Phi^-1, less g / f behind a lenslet: how much larger than an opening its
shadow is on the panel. For an eye whose plane of focus is L before the array, M = 1 + g / L.
"""

from __future__ import annotations

import numpy as np

from vrlf.optics import polynomial
from vrlf.optics.bench import Bench
from vrlf.optics.lattice import Lattice
from vrlf.optics.polynomial import Float

# An eye that focuses on the array itself makes M infinite: no opening cuts its beam there.
_LEAST_DETERMINANT = 1e-6


def aberration_slope(colour: tuple[Float, Float], v_mm: Float) -> Float:
    """dT/dv at pupil points from the pupil's centre, 1/mm; (..., 2) in, (..., 2, 2) out."""
    x, y = v_mm[..., 0], v_mm[..., 1]
    rows = [
        np.stack(
            [polynomial.evaluate(polynomial.derivative(t, axis), x, y) for axis in (0, 1)], axis=-1
        )
        for t in colour
    ]
    return np.stack(rows, axis=-2)


def shadow_scale(bench: Bench, colour: tuple[Float, Float], v_mm: Float) -> Float:
    """M, in the panel's frame, at pupil points from the pupil's centre; (..., 2, 2)."""
    slope = aberration_slope(colour, v_mm)
    unit = np.eye(2)
    phi = bench.array_defocus_factor * unit + bench.array_per_slope_mm * slope
    psi = bench.defocus_factor * unit + bench.panel_per_slope_mm * slope
    return np.asarray(psi @ _inverse(phi) - bench.bend * unit)


def _inverse(matrix: Float) -> Float:
    """Of 2x2 matrices, with a determinant that is at least so far from 0."""
    a, b = matrix[..., 0, 0], matrix[..., 0, 1]
    c, d = matrix[..., 1, 0], matrix[..., 1, 1]
    determinant = a * d - b * c
    sign = np.where(determinant < 0.0, -1.0, 1.0)
    determinant = sign * np.maximum(np.abs(determinant), _LEAST_DETERMINANT)
    adjugate = np.stack([np.stack([d, -b], axis=-1), np.stack([-c, a], axis=-1)], axis=-2)
    return np.asarray(adjugate / determinant[..., None, None])


def upright_scale(lattice: Lattice, scale: Float) -> Float:
    """What of M spreads light by diffraction, along the lattice's axes; (..., 2, 2) to (..., 2).

    A square's axes take M's diagonal in the lattice's frame, a disc the mean of it
    (``vrlf/optics/fresnel.py``).
    """
    turn = lattice.cell_from_panel * lattice.pitch_mm
    turned = turn @ scale @ turn.T
    along = np.stack([turned[..., 0, 0], turned[..., 1, 1]], axis=-1)
    if lattice.round_holes:
        along = np.broadcast_to(along.mean(axis=-1, keepdims=True), along.shape)
    return np.asarray(along)
