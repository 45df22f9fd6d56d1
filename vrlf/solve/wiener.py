"""Wiener pre-sharpening of the target before the forward prefilter (thesis 6.3).

What an eye perceives of a target is nearly a convolution of it. Its *point spreads* are measured:
single white pixels go through ``forward`` and perception on a small panel of the same rig, at
places spread over the array's cells. With H the spectrum of their mean, and N their scatter
about it, which no convolution makes up for, the sharpened target w * i comes nearest to the
target when perceived for

    W = conj(H) / (|H|^2 + N + wiener_noise)                     (Wiener 1949)

A kernel of a few pixels comes close to that if it is not cut out of the W above, but solves the
same problem among kernels of its size: the normal equations of

    minimise  sum S |H w - 1|^2 + S (N + wiener_noise) |w|^2,  sum of the taps = 1

with S = 1 / f^2, the spectrum of natural pictures (Field 1987). A flat target stays as it is.
(Scaling free taps to the sum 1 instead cost 0.1 dB behind matched-full and pinholes.) The
smallest kernel is taken whose expected error is within 1 % of that of the largest.

Perceived PSNR in dB (440 x 220 panel, green, left eye; astronaut, coffee, chelsea):

================= ================== ================== ======
array             forward            sharpened          pixels
================= ================== ================== ======
matched-microlens 23.5 25.4 30.3     23.9 25.7 30.7     7
matched-full      23.5 25.1 31.6     24.3 26.0 33.0     9
matched-wide      16.4 18.2 22.5     16.5 18.3 22.6     7
thesis-minus-5d   17.1 17.8 25.4     17.4 18.0 26.0     17
pinhole           14.6 15.2 22.0     14.7 15.4 22.0     17
bare              17.3 18.5 25.7     17.6 18.7 26.7     17
================= ================== ================== ======

A kernel without end gained up to 0.5 dB more behind matched-full, whose crosstalk comes from 15
pixels away, and 0.3 dB behind pinholes. Without the scatter in the sum pinholes lost 0.1 to
0.3 dB at a noise of 0.1, and more below it. Of the noises 0.01, 0.03 and 0.1 the middle one is
within 0.2 dB of the best for each array. Making the tables takes 0.8 to 1.7 s on two cores of
software GL: 4 to 8 shots of 0.1 to 0.2 s.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu import Device
from vrlf.model import Rig
from vrlf.optics.polynomial import Float
from vrlf.passes.forward import Forward
from vrlf.passes.perceive import Perceive
from vrlf.passes.sharpen import SharpenTables
from vrlf.solve.spread import PointSpread, spread_pieces

_RADII = (2, 3, 4, 6, 8)
# Expected error, over the largest kernel's, at which a smaller one is good enough.
_GOOD_ENOUGH = 1.01
# Pictures have no structure coarser than this many pixels, as far as their spectrum goes.
_COARSEST_PX = 128.0


@dataclass(frozen=True)
class Kernel:
    """What sharpens a target, as ``SharpenTables`` and ``vrlf.reference.sharpen`` take it."""

    taps: Float
    shift_px: NDArray[np.int_]


def kernel_of(spread: PointSpread, noise: float) -> Kernel:
    """The sharpening kernels, of one size for both eyes and all colours.

    Parameters
    ----------
    spread : PointSpread
    noise : float
        Noise-to-signal power beside the scatter, above 0.
    """
    kernel: Kernel = _finished(kernel_pieces(spread, noise))
    return kernel


def kernel_pieces(spread: PointSpread, noise: float) -> Generator[None, None, Kernel]:
    """``kernel_of``, resting after each system of equations."""
    radius = _RADII[-1]
    equations = [
        _normal_equations(spread.mean[index], float(spread.scatter[index]) + noise, radius)
        for index in np.ndindex(2, 3)
    ]
    taps, least = yield from _solutions(equations, radius, radius)
    for smaller in _RADII[:-1]:
        found, error = yield from _solutions(equations, radius, smaller)
        if error <= _GOOD_ENOUGH * least:
            taps = found
            break
    return Kernel(taps.reshape(2, 3, *taps.shape[1:]), spread.shift_px)


def _solutions(
    equations: list[tuple[Float, Float]], largest: int, radius: int
) -> Generator[None, None, tuple[Float, float]]:
    """Taps of every eye and colour, and their mean expected error."""
    solved = []
    for each in equations:
        solved.append(_solved(*each, largest, radius))
        yield
    return np.stack([taps for taps, _ in solved]), float(np.mean([error for _, error in solved]))


def _finished(pieces: Generator[None, None, Any]) -> Any:
    """What a generator returns after its last rest."""
    while True:
        try:
            next(pieces)
        except StopIteration as done:
            return done.value


def _normal_equations(mean: Float, noise: float, radius: int) -> tuple[Float, Float]:
    """Matrix and right side over a square of taps; gather weights, row by row."""
    # Room for the spread and the largest kernel beside each other, so that nothing wraps.
    size = 1 << (mean.shape[-1] + 4 * radius).bit_length()
    reach = mean.shape[-1] // 2
    centred = np.zeros((size, size))
    centred[: mean.shape[0], : mean.shape[1]] = mean
    spectrum = np.fft.fft2(np.roll(centred, (-reach, -reach), axis=(0, 1)))
    f = np.fft.fftfreq(size)
    natural = 1.0 / (f[:, None] ** 2 + f**2 + _COARSEST_PX**-2)
    # The mean brightness is kept by the condition, whatever it would count.
    natural[0, 0] = 0.0
    natural /= natural.sum()
    total = size**2
    # Taps are gather weights: the convolution's kernel turned about, hence H, not its conjugate.
    matrix = np.fft.ifft2(natural * (np.abs(spectrum) ** 2 + noise)).real * total
    right = np.fft.ifft2(natural * spectrum).real * total
    y, x = (axis.ravel() for axis in np.mgrid[-radius : radius + 1, -radius : radius + 1])
    return matrix[y[:, None] - y, x[:, None] - x], right[y, x]


def _solved(matrix: Float, right: Float, largest: int, radius: int) -> tuple[Float, float]:
    """Taps within ``radius`` that sum to 1, and their expected squared error."""
    side = 2 * largest + 1
    inner = np.zeros((side, side), bool)
    inner[largest - radius : largest + radius + 1, largest - radius : largest + radius + 1] = True
    kept = inner.ravel()
    a, b = matrix[np.ix_(kept, kept)], right[kept]
    free, flat = np.linalg.solve(a, np.stack([b, np.ones_like(b)], axis=1)).T
    taps = free + flat * (1.0 - free.sum()) / flat.sum()
    error = float(taps @ a @ taps - 2.0 * b @ taps + 1.0)
    return taps.reshape(2 * radius + 1, 2 * radius + 1), error


def sharpen_pieces(
    device: Device, rig: Rig, forward: Forward, perceive: Perceive
) -> Generator[None, None, SharpenTables]:
    """Make a rig's sharpening tables, resting after each piece of work.

    ``forward`` and ``perceive`` are the programs to measure with; they stay their owners'.
    """
    spread = yield from spread_pieces(device, rig, forward, perceive)
    yield
    kernel = yield from kernel_pieces(spread, rig.prefilter.wiener_noise)
    return SharpenTables(device, rig, kernel.taps, kernel.shift_px)


def sharpen_tables(device: Device, rig: Rig, forward: Forward, perceive: Perceive) -> SharpenTables:
    """A rig's sharpening tables, made at once."""
    tables: SharpenTables = _finished(sharpen_pieces(device, rig, forward, perceive))
    return tables
