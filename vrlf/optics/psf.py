"""Point spread functions: what an eye makes of a point, by geometry and by diffraction.

A pupil function A exp(2 pi i W / lambda) gives, by Fraunhofer's integral, the light that is
seen in direction p (a slope, right and up as the wearer sees it):

    h(p) ~ | sum over v of A exp(2 pi i (W(v) - p . v) / lambda) |^2

(Goodman, *Introduction to Fourier Optics*, 6.3; Watson 2015, "Computing human optical point
spread functions", equations 2 and 3). The phase stands still where grad W = p, so the spot
lies where the rays of ``pupil.spot_slopes`` go: one orientation for both.

h is band-limited by the pupil: samples lambda / 2D apart hold all of it. They are computed
once over a whole period, so all light is accounted for, and any other sampling follows
from them by a pair of matrices.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log, pi

import numpy as np

from vrlf.errors import InputError
from vrlf.optics import polynomial, sequence
from vrlf.optics.polynomial import Float
from vrlf.optics.pupil import spot_slopes, widest_slope
from vrlf.units import ARCMIN_PER_SLOPE, NM_PER_MM, NM_PER_UM

# Samples across the pupil: the least, and the most, for which memory stays below 1 GB.
LEAST_SAMPLES = 256
MOST_SAMPLES = 2048
_SAMPLES_STEP = 32  # sizes whose Fourier transforms are fast
# The period exceeds the geometric spot by a quarter, and by 64 widths lambda / D for what
# diffraction throws beyond it.
_PERIOD_MARGIN = 1.25
_HALO = 64
# Strehl: the brightest sample's neighbourhood is searched on a grid this much finer.
_FINER = 16
GEOMETRIC_POINTS = 1 << 19


@dataclass(frozen=True)
class Cells:
    """A square grid of square cells about a direction straight ahead of the spot's centre.

    Attributes
    ----------
    count : int
        Cells a side; the middle one of an odd count is centred on the origin.
    step_slope : float
        Side of a cell: arcmin / ``ARCMIN_PER_SLOPE``, or a panel pixel's pitch over m.
    """

    count: int
    step_slope: float

    @property
    def centres_slope(self) -> Float:
        """Centres along x or y, shape (count,), ascending."""
        return np.asarray((np.arange(self.count) - (self.count - 1) / 2.0) * self.step_slope)

    @property
    def half_slope(self) -> float:
        """Half the side of the whole grid."""
        return self.count * self.step_slope / 2.0


@dataclass(frozen=True)
class PointSpread:
    """A diffraction point spread function over one period, finely enough to hold all of it.

    Attributes
    ----------
    share : ndarray (N, N)
        The part of all light in each sample, sum 1; rows y upward, columns x to the right, the
        origin at [N / 2, N / 2].
    step_slope : float
        Distance of the samples.
    flat_peak : float
        The brightest sample of the same pupil without aberration.
    """

    share: Float
    step_slope: float
    flat_peak: float

    @property
    def slopes(self) -> Float:
        """Directions of the samples along x or y, shape (N,)."""
        count = len(self.share)
        return np.asarray((np.arange(count) - count // 2) * self.step_slope)

    @property
    def period_slope(self) -> float:
        """Side of the square that the samples fill; beyond it there is no light to speak of."""
        return len(self.share) * self.step_slope


def apodisation(radius_mm: Float, stiles_crawford_per_mm2: float) -> Float:
    """How much light counts that enters the pupil off its centre, 10^(-rho r^2).

    Stiles & Crawford 1933 in the form of Applegate & Lakshminarayanan 1993; rho = 0 is none.
    """
    return np.asarray(np.exp(-log(10.0) * stiles_crawford_per_mm2 * radius_mm**2))


def pupil_samples(wavefront_um: Float, pupil_mm: float, wavelength_nm: float) -> int:
    """Samples across the pupil that hold a wavefront's point spread in one period.

    Raises
    ------
    InputError
        If that is more than ``MOST_SAMPLES``.
    """
    width_slope = 2.0 * widest_slope(wavefront_um, pupil_mm)
    widths = width_slope * pupil_mm * NM_PER_MM / wavelength_nm
    needed = max(LEAST_SAMPLES, _PERIOD_MARGIN * widths + _HALO)
    if needed > MOST_SAMPLES:
        most = (MOST_SAMPLES - _HALO) / _PERIOD_MARGIN / widths * width_slope
        raise InputError(
            f"found a blur of {width_slope * ARCMIN_PER_SLOPE:.4g} arcmin, wanted at most "
            f"{most * ARCMIN_PER_SLOPE:.4g} for its diffraction in a pupil of {pupil_mm:g} mm "
            f"at {wavelength_nm:g} nm"
        )
    return _SAMPLES_STEP * ceil(needed / _SAMPLES_STEP)


def fraunhofer(
    wavefront_um: Float,
    pupil_mm: float,
    wavelength_nm: float,
    *,
    stiles_crawford_per_mm2: float = 0.0,
) -> PointSpread:
    """Diffraction point spread function of a round pupil.

    Parameters
    ----------
    wavefront_um : ndarray (k, k)
        Polynomial in mm from the pupil's centre, wearer's frame (``pupil.SeenWavefront``).
    pupil_mm, wavelength_nm : float
        Diameter and wavelength.
    stiles_crawford_per_mm2 : float
        rho of ``apodisation``; its root weighs the amplitude.
    """
    count = pupil_samples(wavefront_um, pupil_mm, wavelength_nm)
    step_mm = pupil_mm / (count - 1)
    v = np.asarray((np.arange(count) - (count - 1) / 2.0) * step_mm, np.float64)
    radius = np.hypot(v[None, :], v[:, None])
    # Samples on the rim count by how much of them the pupil covers.
    amplitude = np.clip((pupil_mm / 2.0 - radius) / step_mm + 0.5, 0.0, 1.0)
    amplitude *= np.sqrt(apodisation(radius, stiles_crawford_per_mm2))
    waves = polynomial.on_grid(wavefront_um, v, v) * NM_PER_UM / wavelength_nm
    field = amplitude * np.exp(2j * pi * waves)
    size = 2 * count
    field = np.fft.fft(np.fft.fft(field, size, axis=1), size, axis=0)
    # Parseval: the squares of all samples sum to size^2 times the squares in the pupil.
    energy = size**2 * float(np.sum(amplitude**2))
    return PointSpread(
        share=np.fft.fftshift(field.real**2 + field.imag**2) / energy,
        step_slope=wavelength_nm / NM_PER_MM / (size * step_mm),
        flat_peak=float(np.sum(amplitude)) ** 2 / energy,
    )


def _interpolation(psf: PointSpread, at_slope: Float, width_slope: float) -> Float:
    """The matrix (M, N) that takes samples to means over intervals about M directions.

    The samples' Fourier series, each of its terms averaged over the interval. Exact, as the
    series ends at the pupil's width; a width of 0 gives the values themselves.
    """
    count = len(psf.share)
    cycles = np.arange(1, count // 2) / (count * psf.step_slope)
    at, samples = 2 * pi * cycles * at_slope[:, None], 2 * pi * cycles[:, None] * psf.slopes
    damped = 2.0 * np.sinc(cycles * width_slope)
    terms = (np.cos(at) * damped) @ np.cos(samples) + (np.sin(at) * damped) @ np.sin(samples)
    return np.asarray((1.0 + terms) / count)


def cell_shares(psf: PointSpread, cells: Cells) -> Float:
    """The part of all light in each cell, (count, count), rows y upward.

    Exact within the period; cells beyond it are dark, where the samples would repeat.
    """
    centres = cells.centres_slope
    matrix = _interpolation(psf, centres, cells.step_slope) * (cells.step_slope / psf.step_slope)
    matrix[np.abs(centres) > psf.period_slope / 2.0] = 0.0
    return np.asarray(matrix @ psf.share @ matrix.T)


def strehl_ratio(psf: PointSpread) -> float:
    """The spot's brightest point over that of the same pupil without aberration."""
    row, column = np.unravel_index(int(np.argmax(psf.share)), psf.share.shape)
    near = np.linspace(-1.0, 1.0, 2 * _FINER + 1) * psf.step_slope
    across = _interpolation(psf, psf.slopes[column] + near, 0.0)
    upward = _interpolation(psf, psf.slopes[row] + near, 0.0)
    return float((upward @ psf.share @ across.T).max()) / psf.flat_peak


@dataclass(frozen=True)
class Rays:
    """Rays through well-spread points of a pupil: where each is seen, and how much it counts.

    Attributes
    ----------
    slopes : ndarray (n, 2)
        From the spot's origin, right and up.
    weights : ndarray (n,)
        Sum 1.
    """

    slopes: Float
    weights: Float


def rays_through(
    wavefront_um: Float,
    pupil_mm: float,
    *,
    stiles_crawford_per_mm2: float = 0.0,
    count: int = GEOMETRIC_POINTS,
) -> Rays:
    """The rays of a point through a pupil; arguments as of ``fraunhofer``."""
    v_mm = sequence.to_disc(sequence.points(count)[:, :2]) * pupil_mm / 2.0
    weights = apodisation(np.hypot(v_mm[:, 0], v_mm[:, 1]), stiles_crawford_per_mm2)
    return Rays(spot_slopes(wavefront_um, v_mm), weights / weights.sum())


def geometric_shares(rays: Rays, cells: Cells) -> Float:
    """The geometric point spread: the part of all rays in each cell, rows y upward."""
    place = np.floor((rays.slopes + cells.half_slope) / cells.step_slope)
    inside = np.all((place >= 0) & (place < cells.count), axis=1)
    column, row = place[inside].astype(np.int64).T
    flat = np.bincount(row * cells.count + column, rays.weights[inside], cells.count**2)
    return np.asarray(flat.reshape(cells.count, cells.count))


def geometric_half_light_slope(rays: Rays) -> float:
    """Diameter of the circle about the spot's centroid that holds half of all rays."""
    centre = rays.weights @ rays.slopes
    return _half_held(np.hypot(*(rays.slopes - centre).T), rays.weights)


def half_light_slope(psf: PointSpread, cells: Cells) -> float:
    """Diameter of the circle about the spot's centroid that holds half of all light.

    The centroid is that of the light within ``cells``, which must hold more than half; the
    circle is then found on cells as fine as it allows.
    """
    shares, x = cell_shares(psf, cells), cells.centres_slope
    centre = np.array([shares.sum(axis=0) @ x, shares.sum(axis=1) @ x]) / shares.sum()
    width = _half_held(_distances(cells, centre), shares.ravel())
    reach = float(np.abs(centre).max()) + width / 2.0 + cells.step_slope
    finer = Cells(cells.count, 2.0 * reach / cells.count)
    return _half_held(_distances(finer, centre), cell_shares(psf, finer).ravel())


def _distances(cells: Cells, centre: Float) -> Float:
    """How far each cell's centre is from a point (x, y), row by row."""
    x, y = (cells.centres_slope - each for each in centre)
    return np.asarray(np.hypot(x[None, :], y[:, None]).ravel())


def _half_held(distances: Float, weights: Float) -> float:
    """Twice the distance within which the weights sum to 1/2."""
    order = np.argsort(distances)
    held = np.searchsorted(np.cumsum(weights[order]), 0.5)
    return float(2.0 * distances[order[min(int(held), len(order) - 1)]])


def modulation(psf: PointSpread, cycles_per_slope: Float) -> Float:
    """Modulation transfer at spatial frequencies (K, 2), right and up; shape (K,).

    The modulus of the spread's Fourier transform, which ends at the width of the pupil: beyond
    it samples would only repeat themselves.
    """
    passed = np.hypot(*cycles_per_slope.T) < 0.5 / psf.step_slope
    turn = -2.0 * pi * psf.slopes[:, None]
    across, upward = turn * cycles_per_slope[:, 0], turn * cycles_per_slope[:, 1]
    real, imaginary = psf.share @ np.cos(across), psf.share @ np.sin(across)
    total = np.sum(np.exp(1j * upward) * (real + 1j * imaginary), axis=0)
    return np.asarray(np.abs(total) * passed)


def perfect_modulation(cycles_per_slope: Float, pupil_mm: float, wavelength_nm: float) -> Float:
    """Modulation transfer of a round pupil without aberration; Goodman, equation 6-32."""
    s = np.clip(cycles_per_slope * wavelength_nm / NM_PER_MM / pupil_mm, 0.0, 1.0)
    return np.asarray(2.0 / pi * (np.arccos(s) - s * np.sqrt(1.0 - s**2)))
