"""How far diffraction and aberrations let a lenslet resolve: wavefront and MTF.

A beam's rays behind the lens are its angular spectrum: direction cosines (L, M) in the medium of
index n there, each with the phase k W. W is the optical path to the foot of the perpendicular from
the reference point (the spot's middle, on the panel) to the ray, less its mean; that is exact,
Fresnel numbers of lenslets being high enough for Debye's integral (N = a^2 / (lambda f) = 11 of
the thesis's). The optical transfer function is the autocorrelation of exp(i k W) over (L, M), and
a shift by dL stands for n dL / lambda lines a millimetre (Hopkins 1955; Goodman 2005, sec. 6.4).
Direction cosines are taken to go evenly over the aperture (Abbe's sine condition), at the mean
step of the rays traced: over a cell's field of some degrees they do; at 20 degrees a thesis's lens
so seems 5 % sharper along the field than its rays are.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from vrlf.errors import InputError
from vrlf.optics.lenslet.surfaces import Lens
from vrlf.optics.lenslet.trace import Beam, aperture_points, landing, trace
from vrlf.optics.polynomial import Float
from vrlf.units import NM_PER_MM

# Samples along each side of the aperture: the MTF of a disc is right to 0.005 with it.
SAMPLES_A_SIDE = 64


@dataclass(frozen=True)
class Wavefront:
    """What leaves a lenslet toward a point of the panel.

    Attributes
    ----------
    path_mm : ndarray (n, n)
        W, rows upward, columns to the right; 0 where ``light`` is.
    light : ndarray (n, n)
        1 where rays come through, else 0.
    step : ndarray (2,)
        Direction cosine times index from one column to the next, and from row to row.
    """

    path_mm: Float
    light: Float
    step: Float

    @property
    def rms_mm(self) -> float:
        """Root mean square of W."""
        return float(np.sqrt(np.sum(self.path_mm**2) / np.sum(self.light)))


def wavefront(lens: Lens, beam: Beam, distance_mm: float, side: int = SAMPLES_A_SIDE) -> Wavefront:
    """The wavefront about the middle of the spot on a plane behind the last surface.

    Raises
    ------
    InputError
        If next to no ray comes through.
    """
    index = lens.surfaces[-1].medium.index_at(beam.wavelength_nm)
    places = aperture_points(lens, side)
    rays = landing(trace(lens, beam, places), distance_mm, index)
    if rays.open.sum() < 4:
        raise InputError("lenslet: found its rays blocked, wanted less oblique light")
    points, directions = rays.points_mm[rays.open], rays.directions[rays.open]
    off = points.mean(axis=0) - points
    path = rays.path_mm[rays.open] + index * np.sum(off * directions, axis=1)
    # Least squares of the direction cosines over the places in the aperture.
    centred = places[rays.open] - places[rays.open].mean(axis=0)
    cosines = directions[:, :2] - directions[:, :2].mean(axis=0)
    rate = np.sum(centred * cosines, axis=0) / np.sum(centred**2, axis=0)
    cells = np.rint(places[rays.open] / lens.aperture_mm * side + (side - 1) / 2.0).astype(int)
    grid, light = np.zeros((side, side)), np.zeros((side, side))
    grid[cells[:, 1], cells[:, 0]] = path - path.mean()
    light[cells[:, 1], cells[:, 0]] = 1.0
    return Wavefront(grid, light, np.abs(rate) * index * lens.aperture_mm / side)


@dataclass(frozen=True)
class Transfer:
    """A modulation transfer function along the two axes.

    Attributes
    ----------
    per_mm : ndarray (2, k)
        Lines a millimetre on the panel, right and up.
    contrast : ndarray (2, k)
        For lines that follow one another to the right, and upward.
    """

    per_mm: Float
    contrast: Float

    def at(self, per_mm: Float) -> Float:
        """Interpolated; 0 beyond the cutoff. Shape (2, k)."""
        return np.stack(
            [
                np.interp(per_mm, own, contrast, right=0.0)
                for own, contrast in zip(self.per_mm, self.contrast, strict=True)
            ]
        )


def transfer(front: Wavefront, wavelength_nm: float, *, perfect: bool = False) -> Transfer:
    """The MTF of a wavefront; ``perfect`` for the same aperture without aberrations."""
    side = front.light.shape[0]
    turns = 2.0 * pi * NM_PER_MM / wavelength_nm * (0.0 if perfect else 1.0) * front.path_mm
    amplitude = front.light * np.exp(1j * turns)
    # Twice the side, so that the correlation does not come round.
    power = np.abs(np.fft.fft2(amplitude, s=(2 * side, 2 * side))) ** 2
    otf = np.abs(np.fft.ifft2(power))
    otf /= otf[0, 0]
    shifts = np.arange(side + 1) * NM_PER_MM / wavelength_nm
    contrast = np.stack([otf[0, : side + 1], otf[: side + 1, 0]])
    return Transfer(front.step[:, None] * shifts, contrast)


def cutoff_per_mm(front: Wavefront, wavelength_nm: float) -> Float:
    """Lines a millimetre that nothing is left of, right and up."""
    return np.asarray(front.step * front.light.shape[0] * NM_PER_MM / wavelength_nm)
