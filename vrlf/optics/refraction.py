"""Prescriptions, power vectors and refraction matrices.

Everything here is in dioptres; matrices are symmetric 2x2. Which frame a matrix is in,
the examiner's or the wearer's, is said by each function.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vrlf.optics import frames, polynomial
from vrlf.optics.polynomial import Float
from vrlf.units import MM_PER_M


@dataclass(frozen=True)
class SpheroCylinder:
    """A refraction as it is written on paper: axis in degrees, TABO, in [0, 180)."""

    sphere_d: float
    cylinder_d: float
    axis_deg: float


def at_pupil(rx: SpheroCylinder, vertex_mm: float) -> SpheroCylinder:
    """A spectacle prescription as it acts at the eye: F / (1 - v F), meridian by meridian.

    Bennett & Rabbetts, *Clinical Visual Optics*, "effectivity".
    """
    vertex_m = vertex_mm / MM_PER_M
    along = rx.sphere_d / (1.0 - vertex_m * rx.sphere_d)
    across_d = rx.sphere_d + rx.cylinder_d
    across = across_d / (1.0 - vertex_m * across_d)
    return SpheroCylinder(along, across - along, rx.axis_deg)


def transposed(rx: SpheroCylinder) -> SpheroCylinder:
    """The same refraction in the other cylinder form: S + C, -C, axis turned by 90 degrees."""
    return SpheroCylinder(
        rx.sphere_d + rx.cylinder_d, 0.0 - rx.cylinder_d, (rx.axis_deg + 90.0) % 180.0
    )


def power_vector_d(rx: SpheroCylinder) -> tuple[float, float, float]:
    """(M, J0, J45), Thibos, Wheeler & Horner 1997, equations 2 to 4."""
    double_axis = 2.0 * np.radians(rx.axis_deg)
    half = rx.cylinder_d / 2.0
    return (
        rx.sphere_d + half,
        float(-half * np.cos(double_axis)),
        float(-half * np.sin(double_axis)),
    )


def examiner_matrix_d(rx: SpheroCylinder) -> Float:
    """Refraction matrix [[M + J0, J45], [J45, M - J0]], examiner's frame, shape (2, 2)."""
    m, j0, j45 = power_vector_d(rx)
    return np.array([[m + j0, j45], [j45, m - j0]])


def sphero_cylinder(wearer_matrix_d: Float) -> SpheroCylinder:
    """The minus-cylinder prescription of a matrix in the wearer's frame.

    The axis is 0 where there is no cylinder. Inverse of ``examiner_matrix_d`` up to the view.
    """
    matrix = frames.swap_matrix_view(wearer_matrix_d)
    m = (matrix[0, 0] + matrix[1, 1]) / 2.0
    j0 = (matrix[0, 0] - matrix[1, 1]) / 2.0
    j45 = (matrix[0, 1] + matrix[1, 0]) / 2.0
    half = float(np.hypot(j0, j45))
    # Rounding leaves a cylinder of 1e-16 D behind a purely spherical sum; it has no axis.
    if half < 1e-12 * max(1.0, abs(float(m))):
        return SpheroCylinder(float(m), 0.0, 0.0)
    axis_deg = float(np.degrees(np.arctan2(j45, j0)) / 2.0) % 180.0
    return SpheroCylinder(float(m) + half, -2.0 * half, axis_deg if axis_deg < 180.0 else 0.0)


def quadratic_wavefront_um(matrix_d: Float) -> Float:
    """The wavefront -u'Ru/2 (um, u in mm) of a refraction matrix, in the matrix's own frame."""
    wavefront = np.zeros((3, 3))
    wavefront[2, 0] = -matrix_d[0, 0] / 2.0
    wavefront[0, 2] = -matrix_d[1, 1] / 2.0
    wavefront[1, 1] = -(matrix_d[0, 1] + matrix_d[1, 0]) / 2.0
    return wavefront


def curvature_matrix_d(wavefront_um: Float) -> Float:
    """Minus the Hessian of a wavefront at the pupil's centre: its refraction matrix there."""
    c = np.zeros((3, 3))
    kept = wavefront_um[:3, :3]
    c[: kept.shape[0], : kept.shape[1]] = kept
    return np.array([[-2.0 * c[2, 0], -c[1, 1]], [-c[1, 1], -2.0 * c[0, 2]]])


def transverse_aberration(wavefront_um: Float) -> tuple[Float, Float]:
    """T = -grad W / 1000 as two polynomials (slopes; the pupil in mm, W in um)."""
    return (
        -polynomial.derivative(wavefront_um, 0) / MM_PER_M,
        -polynomial.derivative(wavefront_um, 1) / MM_PER_M,
    )
