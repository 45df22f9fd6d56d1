"""The wavefront with which an eye in its headset sees a point of the panel.

With X0 the panel point and u where in the pupil its light enters, the design's backward ray
says where that light is perceived: X = X0 - (1 - d F) u - m T(u - o). As a direction that is
X0 / m + grad W / 1000 with

    W(v) = W_eye(v) - 500 ((1 - d F) / m) |v|^2 - 1000 (prism + o (1 - d F) / m) . v,

v = u - o in mm from the pupil's centre and W in micrometres: panel vergence and prism are
wavefronts like the eye's own. What is linear in W moves the spot and is kept apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import prod, sqrt

import numpy as np

from vrlf.model import Array, Eye, Rig
from vrlf.optics import polynomial, refraction, sequence
from vrlf.optics.bench import Bench, bench_of, colour_benches
from vrlf.optics.eye import (
    accommodated_wavefront_um,
    accommodation_d,
    colour_wavefronts_um,
    viewer,
)
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import Side
from vrlf.optics.wavefront import zernike_polynomial
from vrlf.units import MM_PER_M, SLOPE_PER_PRISM_DIOPTRE

# Zernike orders that a plane takes, and those that spectacles take.
PLANE_ORDER = 1
SPECTACLE_ORDER = 2
# Where slopes are searched for their largest: the rim, which has it but for odd wavefronts.
_RIM_POINTS = 720
_INNER_POINTS = 4096


@dataclass(frozen=True)
class SeenWavefront:
    """An eye's wavefront as a point of the panel is seen with it; wearer's frame, x right, y up.

    Attributes
    ----------
    pupil_mm : float
        Diameter; the wavefronts' coordinates are mm from its centre.
    reference_um : ndarray (k, k)
        Polynomial at the wavelength that prescriptions are meant for, piston and tilt taken off.
    colours_um : tuple of three ndarrays
        The same for each of the panel's colours; one object where they do not differ.
    wavelengths_nm : tuple of three floats
    shift_slope : (x, y)
        Where the tilt moves the spot, right and up, as the wearer sees it.
    stiles_crawford_per_mm2 : float
        Light that enters r mm off the pupil's centre counts 10^(-this r^2) as much.
    """

    pupil_mm: float
    reference_um: Float
    colours_um: tuple[Float, ...]
    wavelengths_nm: tuple[float, float, float]
    shift_slope: tuple[float, float]
    stiles_crawford_per_mm2: float = 0.0


def seen_wavefront(rig: Rig, side: Side) -> SeenWavefront:
    """The wavefront of one eye before a rig's bare panel; the array is not in it."""
    eye, benches = viewer(rig, side), colour_benches(rig)
    added_d = accommodation_d(eye, bench_of(rig))
    before = _before_the_eye(eye, bench_of(rig))
    whole_um = polynomial.add(accommodated_wavefront_um(eye, -added_d), before)
    tilt_um = zernike_part_um(whole_um, eye.pupil_mm, PLANE_ORDER)
    colours = colour_wavefronts_um(eye, added_d, rig.panel.wavelengths_nm)
    differ = eye.chromatic or any(bench != benches[0] for bench in benches)
    levelled = [
        without_order(polynomial.add(each, _before_the_eye(eye, bench)), eye.pupil_mm, PLANE_ORDER)
        for each, bench in (
            zip(colours, benches, strict=True) if differ else ((colours[0], benches[0]),)
        )
    ]
    return SeenWavefront(
        pupil_mm=eye.pupil_mm,
        reference_um=without_order(whole_um, eye.pupil_mm, PLANE_ORDER),
        colours_um=tuple(levelled if differ else levelled * len(colours)),
        wavelengths_nm=rig.panel.wavelengths_nm,
        shift_slope=(float(tilt_um[1, 0]) / MM_PER_M, float(tilt_um[0, 1]) / MM_PER_M),
        stiles_crawford_per_mm2=eye.stiles_crawford_per_mm2,
    )


def _before_the_eye(eye: Eye, bench: Bench) -> Float:
    """What panel vergence, prism and a moved pupil are as a wavefront; um, pupil in mm."""
    per_mm = bench.defocus_factor / bench.panel_per_slope_mm
    before = refraction.quadratic_wavefront_um(MM_PER_M * per_mm * np.eye(2))
    for power, prism_pd, offset_mm in zip(
        ((1, 0), (0, 1)), eye.prism_pd, eye.pupil_offset_mm, strict=True
    ):
        before[power] = -MM_PER_M * (prism_pd * SLOPE_PER_PRISM_DIOPTRE + offset_mm * per_mm)
    return before


def looking_far(rig: Rig) -> Rig:
    """The same eyes without what a headset does to them: no array, the panel at infinity."""
    headset = rig.headset.model_copy(update={"lens_power_d": None, "eye_relief_mm": 0.0})
    return rig.model_copy(update={"headset": headset, "array": Array(kind="none")})


def disc_mean(c: Float, diameter_mm: float) -> float:
    """Mean of a polynomial over the disc about the origin, exactly.

    The mean of x^i y^j is 2 r^(i+j) / (i+j+2) times that of cos^i sin^j over the circle,
    (i-1)!! (j-1)!! / (i+j)!! for even i and j, else 0.
    """
    radius_mm, total = diameter_mm / 2.0, 0.0
    for (i, j), value in np.ndenumerate(c):
        if value and not i % 2 and not j % 2:
            circle = _double_factorial(i - 1) * _double_factorial(j - 1) / _double_factorial(i + j)
            total += float(value) * 2.0 * radius_mm ** (i + j) / (i + j + 2) * circle
    return total


def _double_factorial(n: int) -> int:
    return prod(range(n, 0, -2))


def rms_um(wavefront_um: Float, diameter_mm: float) -> float:
    """Root of the mean square over the pupil."""
    return sqrt(disc_mean(polynomial.multiply(wavefront_um, wavefront_um), diameter_mm))


def zernike_part_um(wavefront_um: Float, diameter_mm: float, order: int) -> Float:
    """What Zernike terms up to ``order`` are in a wavefront over its pupil, as a polynomial.

    The terms are orthonormal over the disc, so each coefficient is the mean of the product.
    """
    total = np.zeros((order + 1, order + 1))
    for n in range(order + 1):
        for m in range(-n, n + 1, 2):
            term = polynomial.scale(zernike_polynomial(n, m), 2.0 / diameter_mm)
            coefficient = disc_mean(polynomial.multiply(wavefront_um, term), diameter_mm)
            total = polynomial.add(total, coefficient * term)
    return total


def without_order(wavefront_um: Float, diameter_mm: float, order: int) -> Float:
    """A wavefront without its Zernike terms up to ``order``."""
    part = zernike_part_um(wavefront_um, diameter_mm, order)
    return polynomial.add(wavefront_um, -part)


def spot_slopes(wavefront_um: Float, v_mm: Float) -> Float:
    """Where the light of pupil points is seen, from the unshifted spot's centre.

    grad W / 1000: minus the transverse aberration; (..., 2) mm in, slopes out, right and up.
    """
    tx, ty = refraction.transverse_aberration(wavefront_um)
    x, y = v_mm[..., 0], v_mm[..., 1]
    return -np.stack([polynomial.evaluate(tx, x, y), polynomial.evaluate(ty, x, y)], axis=-1)


def widest_slope(wavefront_um: Float, diameter_mm: float) -> float:
    """Half the side of the square about the origin that holds the geometric spot."""
    angle = np.linspace(0.0, 2.0 * np.pi, _RIM_POINTS, endpoint=False)
    rim = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    inner = sequence.to_disc(sequence.points(_INNER_POINTS)[:, :2])
    v_mm = np.concatenate([rim, inner]) * diameter_mm / 2.0
    return float(np.abs(spot_slopes(wavefront_um, v_mm)).max())
