"""How a hole or a lenslet spreads light by diffraction: patterns of slits and discs, as a map.

A retinal point's light reaches an aperture of width w as a beam with some curvature; the panel
stands a reduced gap g behind. Over the aperture the beam's geometric shadow on the panel is M
times as large as the aperture, M = dx/dy at a fixed retinal point (``vrlf/optics/beams.py``):
M = 1 + g/L for light from a point L before it, less g/f for a lenslet. Fresnel's integral over
the aperture then depends on one number. With s = y/w and a displacement on the panel of
xi lambda g / w from the ray through the aperture's centre,

    U(xi) = integral over the aperture of exp(i pi N s^2 - 2 pi i xi s) ds,
    N = w^2 M / (lambda g),

|U|^2 being the light (Goodman 2005, section 4.2; the curvature of the beam adds to that of the
gap). N is the Fresnel number (four times a radius's); for N -> 0 it is Fraunhofer's sinc^2 or
Airy's pattern, for large N the shadow, |xi| <= N/2. In a spacer of index n, light of lambda/n
crosses t = n g: lambda t / n = lambda g, so the vacuum's wavelength and the reduced gap serve.
The sign of N mirrors the pattern, which is even.

Adding a far-field slope to each of the rays that fill the aperture would blur its shadow by the
pattern of an infinite distance: sinc^2 * shadow. The interval that holds half of a slit's light
is then least for w = 1.03 sqrt(lambda g) (M = 1), but Fresnel's, which narrows between shadow
and far field, for 1.38 sqrt(lambda g). So the shadow is *replaced* by Fresnel's pattern: a ray at
a place in the aperture that has the share rho of the light between itself and the centre line
lands where the pattern has that share,

    xi = N s + r(rho, N),   rho = 2 |s|, or radius over radius with shares rho^2,

which moves a ray by r lambda g / w along its place's direction. Rays evenly spread over the
aperture make exactly the pattern, no light is lost and none is drawn at random; for large N
r is the edge's alone (it goes as sqrt N), and geometry remains.

In a square both axes are slits; a curvature that couples x and y (an oblique cylinder) is left to
the rays: by Parseval the light along x is then still exactly the mean over y of the slit's
pattern, moved by the geometric M_xy y. In a disc the mean of M's eigenvalues spreads and the
rest is geometric. Different openings do not interfere: their paths differ by more than light's
coherence, or the interference averages over a pixel. The pupil's own diffraction is not in it.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vrlf.optics.polynomial import Float

# sqrt N goes from 0 to this; beyond, each edge spreads by itself, self-similar in sqrt N.
_MOST_ROOT = 12.0
# So many rows and columns misplace 0.1 % of the light.
_ROOTS_PER_UNIT = 16
_PLACES = 512
# Tails go as 1/xi^2: the outermost rays, this share of a slit's light, end at 207 lambda g / w.
EDGE = 1.0 / 2048.0
# Samples of the aperture, and transform samples per 1 in xi. The period of 4096 folds a tail
# over that is 1/20 in amplitude at 207.
_SAMPLES, _FINER = 4096, 16


@dataclass(frozen=True)
class Spread:
    """The map r(rho, N) of one shape of aperture, tabulated.

    Attributes
    ----------
    values : ndarray (roots, places)
        r (1 - rho), which is bounded; rows even in sqrt N, columns even in rho from 0 to 1.
    roots_per_unit : int
        Rows for each 1 of sqrt N.
    """

    values: Float
    roots_per_unit: int

    @property
    def most_root(self) -> float:
        """The last row's sqrt N."""
        return (len(self.values) - 1) / self.roots_per_unit


def residual(spread: Spread, rho: Float, fresnel_number: Float) -> Float:
    """How far diffraction moves a ray outward, in lambda g / w.

    Parameters
    ----------
    rho : ndarray
        Its place, from 0 in the middle to 1 at the border.
    fresnel_number : ndarray
        |N|.
    """
    from_border = np.maximum(1.0 - rho, EDGE)
    root = np.sqrt(fresnel_number)
    # A wider pattern's edge is the widest tabulated one's, enlarged.
    larger = np.maximum(root / spread.most_root, 1.0)
    from_border = from_border * larger
    inside = from_border < 1.0
    from_border = np.minimum(from_border, 1.0)
    row = np.minimum(root, spread.most_root) * spread.roots_per_unit
    column = (1.0 - from_border) * (spread.values.shape[1] - 1)
    value = _between(spread.values, row, column)
    return np.asarray(larger * value / from_border * inside)


def _between(values: Float, row: Float, column: Float) -> Float:
    """Bilinear."""
    top, left = (
        np.minimum(np.floor(at).astype(int), size - 2)
        for at, size in zip((row, column), values.shape, strict=True)
    )
    down, right = row - top, column - left
    upper = values[top, left] * (1.0 - right) + values[top, left + 1] * right
    lower = values[top + 1, left] * (1.0 - right) + values[top + 1, left + 1] * right
    return np.asarray(upper * (1.0 - down) + lower * down)


@functools.cache
def spread_of(is_round: bool) -> Spread:
    """The map of a square's axis, or of a disc."""
    roots = np.arange(round(_MOST_ROOT * _ROOTS_PER_UNIT) + 1) / _ROOTS_PER_UNIT
    rho = np.linspace(0.0, 1.0, _PLACES + 1)
    rows = [tabulated(n, rho, is_round=is_round) for n in roots**2]
    values = np.stack(rows)
    values.setflags(write=False)
    return Spread(values, _ROOTS_PER_UNIT)


def tabulated(fresnel_number: float, rho: Float, *, is_round: bool) -> Float:
    """r (1 - rho) for one N, (places,); the last place, rho = 1, has the tail's limit 1/pi^2."""
    xi, held = held_light(fresnel_number, is_round=is_round)
    share = rho**2 if is_round else rho
    reached = np.interp(share, held, xi)
    values = (reached - fresnel_number * rho / 2.0) * (1.0 - rho)
    # Beyond a slit's |xi| lies 1 / (pi^2 |xi|) of its light, beyond a disc's radius 2 / (pi^2 xi).
    values[-1] = 1.0 / np.pi**2
    return np.asarray(values)


def held_light(fresnel_number: float, *, is_round: bool) -> tuple[Float, Float]:
    """xi >= 0 and the share of the light within it, along an axis of a slit or about a disc."""
    s = (np.arange(_SAMPLES) + 0.5) / _SAMPLES - 0.5
    amplitude = np.exp(1j * np.pi * fresnel_number * s**2)
    if is_round:
        amplitude = amplitude * _chords(fresnel_number, s)
    size = _SAMPLES * _FINER
    light = np.abs(np.fft.fft(amplitude, size)[: size // 2] / _SAMPLES) ** 2
    xi = np.arange(size // 2) / _FINER
    # A disc's amplitude on a line through the middle is the transform of its chords' sums.
    density = light * 2.0 * np.pi * xi / (np.pi / 4.0) if is_round else 2.0 * light
    held = np.concatenate([[0.0], np.cumsum(density[1:] + density[:-1]) / 2.0 / _FINER])
    # Euler and Maclaurin's next term makes the trapezia right to the fourth order.
    rise = np.gradient(density, edge_order=2)
    held -= (rise - rise[0]) / (12.0 * _FINER)
    # Where there is no light, rounding must not make the share fall.
    return xi, np.maximum.accumulate(held)


def _chords(fresnel_number: float, s: Float) -> NDArray[np.complex128]:
    """The sums of exp(i pi N y^2) along a disc's chords; of a strip's whole width, as they end
    in a root at its rim.
    """
    half = np.sqrt(0.25 - s**2)
    y = np.linspace(0.0, 0.5, _SAMPLES + 1)
    term = np.exp(1j * np.pi * fresnel_number * y**2)
    total = np.concatenate([[0.0], np.cumsum(term[1:] + term[:-1])]) * (y[1] / 2.0)
    mean = (np.interp(half, y, total.real) + 1j * np.interp(half, y, total.imag)) / half
    edges = np.linspace(-0.5, 0.5, _SAMPLES + 1)
    area = edges * np.sqrt(0.25 - edges**2) + 0.25 * np.arcsin(2.0 * edges)
    return np.asarray(mean * np.diff(area) * _SAMPLES)
