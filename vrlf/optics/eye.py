"""An eye behind the headset: its wavefront in the wearer's frame, accommodated.

The model's ``Eye`` is what was given; here is what follows from it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vrlf.model import Eye, Rig
from vrlf.optics import frames, polynomial, refraction
from vrlf.optics.bench import Bench, bench_of, colour_benches
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import Side
from vrlf.optics.wavefront import zernike_wavefront_um
from vrlf.units import MM_PER_M, NM_PER_UM, REFERENCE_WAVELENGTH_NM, SLOPE_PER_PRISM_DIOPTRE

# Hofstetter 1950, mean amplitude; the age stands in where a rig gives none.
AMPLITUDE_AT_BIRTH_D = 18.5
AMPLITUDE_LOSS_D_PER_YEAR = 0.30
DEFAULT_AGE_YEARS = 30.0


def amplitude_of_accommodation_d(age_years: float | None) -> float:
    """max(0, 18.5 - 0.30 age), Hofstetter 1950."""
    age = DEFAULT_AGE_YEARS if age_years is None else age_years
    return max(0.0, AMPLITUDE_AT_BIRTH_D - AMPLITUDE_LOSS_D_PER_YEAR * age)


def chromatic_difference_d(wavelength_nm: float) -> float:
    """Refraction at a wavelength less that at 589 nm: D = 1.7312 - 0.63346/(lambda - 0.21410)."""

    def error_d(nm: float) -> float:
        return 1.7312 - 0.63346 / (nm / NM_PER_UM - 0.21410)

    return error_d(wavelength_nm) - error_d(REFERENCE_WAVELENGTH_NM)


def zernike_terms_um(eye: Eye) -> dict[tuple[int, int], float]:
    """The eye's Zernike coefficients by (n, m); empty without a wavefront."""
    return {} if eye.zernike is None else dict(eye.zernike.terms)


def relaxed_wavefront_um(eye: Eye) -> Float:
    """Prescription and Zernike wavefront together, without accommodation; wearer's frame."""
    rx = refraction.SpheroCylinder(eye.sphere_d, eye.cylinder_d, eye.axis_deg)
    at_pupil = refraction.examiner_matrix_d(refraction.at_pupil(rx, eye.vertex_mm))
    wavefront = refraction.quadratic_wavefront_um(at_pupil)
    if eye.zernike is not None:
        terms = zernike_wavefront_um(zernike_terms_um(eye), eye.zernike.diameter_mm)
        wavefront = polynomial.add(wavefront, terms)
    return frames.swap_wavefront_view(wavefront)


def refraction_matrix_d(eye: Eye) -> Float:
    """Refractive error of an unaccommodated eye at its pupil, in the wearer's frame.

    The prescription, brought to the pupil from its vertex distance, and the second-order
    Zernike terms; higher orders are not in it.

    Returns
    -------
    ndarray, shape (2, 2), dioptre
        Symmetric; negative eigenvalues are myopic meridians.
    """
    rx = refraction.SpheroCylinder(eye.sphere_d, eye.cylinder_d, eye.axis_deg)
    matrix = refraction.examiner_matrix_d(refraction.at_pupil(rx, eye.vertex_mm))
    if eye.zernike is not None:
        second = zernike_wavefront_um(zernike_terms_um(eye), eye.zernike.diameter_mm, order=2)
        matrix = matrix + refraction.curvature_matrix_d(second)
    return frames.swap_matrix_view(matrix)


def accommodation_d(eye: Eye, bench: Bench) -> float:
    """The power that the eye adds: none when relaxed, else what brings the mean error to 0.

    The mean error is that of prescription, c(2,0) and panel vergence together, at 589 nm;
    the amplitude bounds it.
    """
    if eye.accommodation == "relaxed":
        return 0.0
    vergence_d = MM_PER_M * bench.defocus_factor / bench.panel_per_slope_mm
    wanted_d = vergence_d + float(np.trace(refraction_matrix_d(eye))) / 2.0
    return float(np.clip(wanted_d, 0.0, amplitude_of_accommodation_d(eye.age_years)))


@dataclass(frozen=True)
class EyeOptics:
    """What the ray equations need of one eye.

    Attributes
    ----------
    pupil_mm, pupil_offset_mm
        Diameter and centre, wearer's frame.
    accommodation_d
        The power that the eye adds.
    matrix_d : ndarray (2, 2)
        Refraction at 589 nm, accommodated, second order alone; wearer's frame.
    aberration : tuple of three (Tx, Ty)
        The transverse aberration T(u - o), polynomials in mm of the pupil, for each of the
        panel's colours; prism included.
    benches : tuple of three Bench
        The headset before the eye, for each of the panel's colours.
    """

    pupil_mm: float
    pupil_offset_mm: tuple[float, float]
    accommodation_d: float
    matrix_d: Float
    aberration: tuple[tuple[Float, Float], ...]
    benches: tuple[Bench, Bench, Bench]

    @property
    def is_chromatic(self) -> bool:
        """Whether the colours take different paths through the eye or the headset's lens."""
        return any(other is not self.aberration[0] for other in self.aberration[1:]) or any(
            other != self.benches[0] for other in self.benches[1:]
        )


def eye_optics(rig: Rig, side: Side) -> EyeOptics:
    """The optics of the eye on ``side`` ("left" or "right") of a rig."""
    eye: Eye = rig.left if side == "left" else rig.right
    added_d = accommodation_d(eye, bench_of(rig))
    relaxed = relaxed_wavefront_um(eye)
    identity = np.eye(2)

    def aberration(shift_d: float) -> tuple[Float, Float]:
        shift = refraction.quadratic_wavefront_um((shift_d - added_d) * identity)
        tx, ty = refraction.transverse_aberration(polynomial.add(relaxed, shift))
        right, up = (p * SLOPE_PER_PRISM_DIOPTRE for p in eye.prism_pd)
        return (
            polynomial.add(tx, np.array([[right]])),
            polynomial.add(ty, np.array([[up]])),
        )

    if eye.chromatic:
        colours = tuple(aberration(chromatic_difference_d(nm)) for nm in rig.panel.wavelengths_nm)
    else:
        colours = (aberration(0.0),) * 3
    return EyeOptics(
        pupil_mm=eye.pupil_mm,
        pupil_offset_mm=eye.pupil_offset_mm,
        accommodation_d=added_d,
        matrix_d=refraction_matrix_d(eye) - added_d * identity,
        aberration=colours,
        benches=colour_benches(rig),
    )


def aberration_at(colour: tuple[Float, Float], u_mm: Float) -> Float:
    """T at pupil points measured from the pupil's centre; (..., 2) mm in, slopes out."""
    x, y = u_mm[..., 0], u_mm[..., 1]
    return np.stack(
        [polynomial.evaluate(colour[0], x, y), polynomial.evaluate(colour[1], x, y)], axis=-1
    )
