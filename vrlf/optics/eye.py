"""An eye behind the headset: its wavefront in the wearer's frame, accommodated.

The model's ``Eye`` is what was given; here is what follows from it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vrlf.errors import InputError
from vrlf.model import Eye, Rig
from vrlf.optics import frames, polynomial, refraction
from vrlf.optics.bench import Bench, bench_of, colour_benches
from vrlf.optics.polynomial import Float
from vrlf.optics.pupil_light import DEFAULT_AGE_YEARS, natural_pupil_mm, weighed_mm
from vrlf.optics.viewport import Side, pitch_mm, viewport
from vrlf.optics.wavefront import rescaled_um, zernike_wavefront_um
from vrlf.units import MM_PER_M, NM_PER_UM, REFERENCE_WAVELENGTH_NM, SLOPE_PER_PRISM_DIOPTRE

# Hofstetter 1950, mean amplitude.
AMPLITUDE_AT_BIRTH_D = 18.5
AMPLITUDE_LOSS_D_PER_YEAR = 0.30


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


def accommodated_wavefront_um(eye: Eye, power_d: float) -> Float:
    """The relaxed eye's wavefront with ``power_d`` of refraction added; wearer's frame."""
    shift = refraction.quadratic_wavefront_um(power_d * np.eye(2))
    return polynomial.add(relaxed_wavefront_um(eye), shift)


def colour_wavefronts_um(
    eye: Eye, added_d: float, wavelengths_nm: tuple[float, float, float]
) -> tuple[Float, ...]:
    """The wavefront of an eye that accommodates by ``added_d``, for each colour.

    Without chromatic aberration the three are one and the same object.
    """
    if not eye.chromatic:
        return (accommodated_wavefront_um(eye, -added_d),) * len(wavelengths_nm)
    shifts_d = [chromatic_difference_d(nm) for nm in wavelengths_nm]
    return tuple(accommodated_wavefront_um(eye, shift_d - added_d) for shift_d in shifts_d)


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


def paraxial_matrix_d(eye: Eye) -> Float:
    """Refractive error of an unaccommodated eye's pupil centre, all orders in; wearer's frame.

    Minus the Hessian of the whole wavefront at the centre: the power vector with higher orders,
    M = (-4 sqrt3 c20 + 12 sqrt5 c40 - 24 sqrt7 c60 + ...) / r^2 (Thibos et al. 2004).

    Returns
    -------
    ndarray, shape (2, 2), dioptre
    """
    return refraction.curvature_matrix_d(relaxed_wavefront_um(eye))


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


def higher_order_rms_um(eye: Eye) -> float:
    """Root mean square of the wavefront's orders above 2 over the eye's pupil.

    Normalised terms are orthonormal over the pupil that they are given for, so it is the root
    of the sum of their squares there.
    """
    if eye.zernike is None:
        return 0.0
    terms = rescaled_um(zernike_terms_um(eye), eye.zernike.diameter_mm, eye.pupil_mm)
    return float(np.sqrt(sum(value**2 for (n, _), value in terms.items() if n > 2)))


def clear_zone_mm(eye: Eye) -> tuple[float | None, float | None] | None:
    """Nearest and farthest distance that an eye by itself sees sharp (T 3.3, its slips mended).

    The mean error M reaches from M, relaxed, to M - A; what is negative is a distance of
    -1000 / M mm. A myope of -5 D with 8 D to add sees sharp from 77 to 200 mm, a hyperope of
    +5 D from 333 mm to infinity.

    Returns
    -------
    (near, far) or None
        None in place of a distance is infinity; no zone at all where all of the amplitude is not
        enough.
    """
    relaxed_d = float(np.trace(refraction_matrix_d(eye))) / 2.0
    nearest_d = relaxed_d - amplitude_of_accommodation_d(eye.age_years)
    if nearest_d > 0.0:
        return None
    near = None if nearest_d == 0.0 else -MM_PER_M / nearest_d
    return near, (-MM_PER_M / relaxed_d if relaxed_d < 0.0 else None)


@dataclass(frozen=True)
class EyeOptics:
    """What the ray equations need of one eye.

    Attributes
    ----------
    pupil_mm, pupil_offset_mm
        Diameter and centre, wearer's frame.
    accommodation_d
        The power that the eye adds.
    matrix_d, paraxial_matrix_d : ndarray (2, 2)
        Refraction at 589 nm, accommodated, second order alone and with all orders; wearer's
        frame.
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
    paraxial_matrix_d: Float
    stiles_crawford_per_mm2: float = 0.0

    def weighed(self, even_mm: Float) -> Float:
        """Pupil points that all count alike, from evenly spread ones; (..., 2) mm from its centre.

        They differ by the Stiles-Crawford effect.
        """
        rho_per_mm2 = self.stiles_crawford_per_mm2
        return even_mm if rho_per_mm2 == 0.0 else weighed_mm(even_mm, self.pupil_mm, rho_per_mm2)

    @property
    def has_higher_orders(self) -> bool:
        """Whether the wavefront is more than sphere, cylinder and prism."""
        return any(polynomial.degree(each) > 1 for each in self.aberration[0])

    @property
    def is_chromatic(self) -> bool:
        """Whether the colours take different paths through the eye or the headset's lens."""
        return any(other is not self.aberration[0] for other in self.aberration[1:]) or any(
            other != self.benches[0] for other in self.benches[1:]
        )


def viewer(rig: Rig, side: Side) -> Eye:
    """What looks at one half of the panel: the eye, its pupil as wide as it is then, or a camera.

    A camera that is sharp at s mm is an eye with a far point there: of -1000 / s D, with a pupil
    of its focal length over its f-number.

    Raises
    ------
    InputError
        If the light opens the pupil beyond what its wavefront was measured over.
    """
    eye: Eye = rig.left if side == "left" else rig.right
    if eye.camera is not None:
        focus_mm = eye.camera.focus_mm
        return Eye(
            sphere_d=0.0 if focus_mm is None else -MM_PER_M / focus_mm,
            vertex_mm=0.0,
            pupil_mm=eye.camera.focal_mm / eye.camera.f_number,
            pupil_offset_mm=eye.pupil_offset_mm,
        )
    if eye.luminance_cd_m2 is None:
        return eye
    pupil_mm = natural_pupil_mm(eye.luminance_cd_m2, field_deg2(rig, side), eye.age_years)
    zernike = eye.zernike
    if zernike is not None and not zernike.extrapolate and pupil_mm > zernike.diameter_mm:
        raise InputError(
            f"{side}.luminance_cd_m2: found {eye.luminance_cd_m2:g}, which opens the pupil to "
            f"{pupil_mm:.2f} mm, wanted at most {zernike.diameter_mm:g} mm, over which the "
            "wavefront was measured (or zernike.extrapolate = true)"
        )
    return eye.model_copy(update={"pupil_mm": pupil_mm})


def field_deg2(rig: Rig, side: Side) -> float:
    """Area of an eye's half of the panel as it sees it, in square degrees."""
    view, bench = viewport(rig, side), bench_of(rig)
    slopes = [
        length * pitch_mm(rig) / bench.panel_per_slope_mm
        for length in (view.width_px, view.height_px)
    ]
    across, up = (2.0 * np.degrees(np.arctan(slope / 2.0)) for slope in slopes)
    return float(across * up)


def eye_optics(rig: Rig, side: Side) -> EyeOptics:
    """The optics of the eye on ``side`` ("left" or "right") of a rig."""
    eye = viewer(rig, side)
    added_d = accommodation_d(eye, bench_of(rig))
    right, up = (np.array([[p * SLOPE_PER_PRISM_DIOPTRE]]) for p in eye.prism_pd)

    def aberration(wavefront_um: Float) -> tuple[Float, Float]:
        tx, ty = refraction.transverse_aberration(wavefront_um)
        return polynomial.add(tx, right), polynomial.add(ty, up)

    wavefronts = colour_wavefronts_um(eye, added_d, rig.panel.wavelengths_nm)
    if eye.chromatic:
        colours = tuple(aberration(wavefront) for wavefront in wavefronts)
    else:
        colours = (aberration(wavefronts[0]),) * len(wavefronts)
    return EyeOptics(
        pupil_mm=eye.pupil_mm,
        pupil_offset_mm=eye.pupil_offset_mm,
        accommodation_d=added_d,
        matrix_d=refraction_matrix_d(eye) - added_d * np.eye(2),
        aberration=colours,
        benches=colour_benches(rig),
        paraxial_matrix_d=paraxial_matrix_d(eye) - added_d * np.eye(2),
        stiles_crawford_per_mm2=eye.stiles_crawford_per_mm2,
    )


def aberration_at(colour: tuple[Float, Float], u_mm: Float) -> Float:
    """T at pupil points measured from the pupil's centre; (..., 2) mm in, slopes out."""
    x, y = u_mm[..., 0], u_mm[..., 1]
    return np.stack(
        [polynomial.evaluate(colour[0], x, y), polynomial.evaluate(colour[1], x, y)], axis=-1
    )
