"""How natural a picture's spectrum is: the fall of its amplitude with frequency.

Natural scenes have an amplitude of about 1/f: a slope of -1 on logarithmic axes, give or
take 0.3 from scene to scene (Field 1987; Tolhurst, Tadmor and Chao 1992).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Float = NDArray[np.float64]

# Luminance of linear Rec. 709 (ITU-R BT.709-6).
LUMINANCE = (0.2126, 0.7152, 0.0722)

LOWEST_CYCLES = 4.0  # a picture; below that a few waves decide
HIGHEST_CYCLES_PER_PX = 0.35  # above that the pixel's own area does
_RINGS = 24


def luminance(picture: ArrayLike) -> Float:
    """Luminance of a linear RGB picture, shape (H, W, 3) to (H, W)."""
    return np.asarray(np.asarray(picture, np.float64) @ np.asarray(LUMINANCE), np.float64)


def radial_amplitude(light: ArrayLike) -> tuple[Float, Float]:
    """Mean amplitude over rings of frequency.

    Parameters
    ----------
    light : array_like, shape (H, W)
        Luminance, linear.

    Returns
    -------
    frequencies : ndarray, shape (B,)
        Cycles per pixel: geometric centres of rings that are equally wide in the logarithm,
        from 4 cycles a picture's shorter side to 0.35 cycles a pixel. Empty rings are left out.
    amplitudes : ndarray, shape (B,)
        Mean absolute value of the Fourier transform there, under a Hann window.
    """
    values = np.asarray(light, np.float64)
    height, width = values.shape
    window = np.outer(np.hanning(height), np.hanning(width))
    # The mean under the window is taken off, or it would leak into the low rings.
    mean = np.sum(values * window) / np.sum(window)
    amplitude = np.abs(np.fft.rfft2((values - mean) * window))
    frequency = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.rfftfreq(width)[None, :])
    edges = np.geomspace(LOWEST_CYCLES / min(height, width), HIGHEST_CYCLES_PER_PX, _RINGS + 1)
    ring = np.digitize(frequency, edges) - 1
    inside = (ring >= 0) & (ring < _RINGS)
    counts = np.bincount(ring[inside], minlength=_RINGS)
    sums = np.bincount(ring[inside], amplitude[inside], minlength=_RINGS)
    filled = counts > 0
    centres = np.sqrt(edges[:-1] * edges[1:])
    return centres[filled], sums[filled] / counts[filled]


def spectrum_slope(light: ArrayLike) -> float:
    """Slope of log amplitude over log frequency, by least squares over the rings.

    Parameters
    ----------
    light : array_like, shape (H, W)
        Luminance, linear; not constant.
    """
    frequencies, amplitudes = radial_amplitude(light)
    return float(np.polyfit(np.log(frequencies), np.log(amplitudes), 1)[0])
