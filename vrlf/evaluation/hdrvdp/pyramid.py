"""The steerable pyramid in the plane of pixels: taking apart and putting together.

Source: Simoncelli & Freeman 1995; Mantiuk, Kim, Rempel & Heidrich 2011, section 3.2
(multi-scale decomposition). Beyond its edges a picture is mirrored about the edge pixel, which
keeps even pixels even when it is halved; pixels 0, 2, 4 ... are kept. Putting together is not
exact: the taps are short and the edges' mirror suits an even filter only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import fft

from vrlf.evaluation.hdrvdp.filtering import Plane
from vrlf.evaluation.hdrvdp.taps import band_taps, halving_taps, high_taps, low_taps


@dataclass(frozen=True)
class Pyramid:
    """A picture in bands.

    Attributes
    ----------
    bands
        From fine to coarse: the high residual alone, four orientations a level, the base alone.
    """

    bands: tuple[tuple[Plane, ...], ...]

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Each band's frequency, in units of half the samples per degree."""
        return tuple(0.5**number for number in range(len(self.bands)))

    def plane(self, number: int, orientation: int) -> Plane:
        """Plane ``orientation`` of band ``number``; a residual stands in for each orientation."""
        planes = self.bands[number]
        return planes[min(orientation, len(planes) - 1)]


def level_count(shape: tuple[int, int]) -> int:
    """How many levels: the shorter side is halved, rounded down, while the taps fit into it."""
    side, count = min(shape), 0
    while side >= halving_taps().shape[0]:
        side, count = side // 2, count + 1
    return count


def correlate(picture: Plane, kernels: Sequence[Plane]) -> list[Plane]:
    """``picture`` correlated with each of ``kernels``, which share one odd size."""
    reach = kernels[0].shape[0] // 2
    padded = np.pad(picture, reach, mode="reflect")
    size = [fft.next_fast_len(side, real=True) for side in padded.shape]
    spectrum = fft.rfft2(padded, s=size)
    inside = tuple(slice(2 * reach, 2 * reach + side) for side in picture.shape)
    turned = [fft.rfft2(kernel[::-1, ::-1], s=size) for kernel in kernels]
    return [np.asarray(fft.irfft2(spectrum * kernel, s=size)[inside]) for kernel in turned]


def convolve(picture: Plane, kernel: Plane) -> Plane:
    """``picture`` convolved with ``kernel``: correlated with it turned by half."""
    return correlate(picture, [kernel[::-1, ::-1]])[0]


def decompose(picture: Plane) -> Pyramid:
    """The bands of ``picture``, (h, w)."""
    bands = [tuple(correlate(picture, [high_taps()]))]
    low = correlate(picture, [low_taps()])[0]
    for _ in range(level_count(picture.shape)):
        bands.append(tuple(correlate(low, band_taps())))
        low = correlate(low, [halving_taps()])[0][::2, ::2]
    return Pyramid((*bands, (low,)))


def reconstruct(pyramid: Pyramid) -> Plane:
    """The picture that the bands of ``pyramid`` make together."""
    (high,), *levels, (low,) = pyramid.bands
    for planes in reversed(levels):
        doubled = np.zeros(planes[0].shape)
        doubled[::2, ::2] = low
        low = convolve(doubled, halving_taps())
        for plane, kernel in zip(planes, band_taps(), strict=True):
            low = low + convolve(plane, kernel)
    return convolve(low, low_taps()) + convolve(high, high_taps())
