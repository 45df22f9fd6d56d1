"""Visual masking: how far a difference stands out of what else is seen there.

Source: Mantiuk, Kim, Rempel & Heidrich 2011, section 3.3 (neural noise: sensitivity and
contrast masking), with the constants of release 2.2. With n = 2^(b-1) of band b, a difference
delta, the threshold N = 1 / CSF and the mask M,

    D = sign(delta) abs(delta / n)^p n / sqrt(N^(2 p) + M^2)
    M = n (k_self (m / N / n)^q + k_xo (m_xo / N / n)^q + k_xn (m_xn / N)^q)

Where release 2.2 differs from the paper: the difference itself is not weighted with the CSF,
which enters by N alone; exponents and weights were fitted anew.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from vrlf.evaluation.hdrvdp.csf import LOG_LUMINANCES, sensitivity_map
from vrlf.evaluation.hdrvdp.filtering import Plane, resize
from vrlf.evaluation.hdrvdp.pyramid import Pyramid

P: Final = 3.5
Q: Final = 3.131555
K_SELF: Final = 1.545486
K_ORIENTATIONS: Final = 2.813190
K_NEIGHBOURS: Final = 33.505801


def mean_of_nine(plane: Plane) -> Plane:
    """The mean of each pixel and its eight neighbours, zero outside."""
    padded = np.pad(plane, 1)
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    return np.asarray((rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]) / 9.0)


def shared_signal(test: Pyramid, reference: Pyramid) -> Pyramid:
    """What both pictures hold, and so masks; spread over 3x3 pixels, as no phase is known."""
    return Pyramid(
        tuple(
            tuple(
                mean_of_nine(np.minimum(np.abs(in_test), np.abs(in_reference)))
                for in_test, in_reference in zip(*planes, strict=True)
            )
            for planes in zip(test.bands, reference.bands, strict=True)
        )
    )


def neighbours(shared: Pyramid, number: int, orientation: int) -> Plane:
    """The masking signal of the next finer and coarser band, at the size of band ``number``."""
    norm, shape = 2.0**number, shared.plane(number, orientation).shape
    total = np.zeros(shape)
    if number > 0:
        finer = resize(shared.plane(number - 1, orientation), shape)
        total += np.maximum(finer, 0.0) / (norm / 2.0)
    # The base is in units of its threshold already, and masks no other band.
    if number < len(shared.bands) - 2:
        coarser = resize(shared.plane(number + 1, orientation), shape)
        total += np.maximum(coarser, 0.0) / (norm * 2.0)
    return total


def thresholds(
    number: int, shared: Pyramid, log_adaptation: Plane, pixels_per_degree: float
) -> Plane:
    """The threshold N of each pixel of band ``number``: 1 / CSF, and 1 for the base."""
    shape = shared.plane(number, 0).shape
    if number == len(shared.bands) - 1:
        return np.ones(shape)
    here = np.clip(resize(log_adaptation, shape), LOG_LUMINANCES[0], LOG_LUMINANCES[-1])
    return 1.0 / sensitivity_map(pixels_per_degree / 2.0 * shared.frequencies[number], here)


def masked_band(
    deltas: tuple[Plane, ...], shared: Pyramid, number: int, threshold: Plane
) -> Iterator[Plane]:
    """D of each plane of band ``number``, whose pictures differ by ``deltas``."""
    norm = 2.0**number
    total = np.sum(shared.bands[number], axis=0)
    for orientation, delta in enumerate(deltas):
        own = shared.plane(number, orientation)
        others = np.maximum(total - own, 0.0)
        mask = norm * (
            K_SELF * (own / threshold / norm) ** Q
            + K_ORIENTATIONS * (others / threshold / norm) ** Q
            + K_NEIGHBOURS * (neighbours(shared, number, orientation) / threshold) ** Q
        )
        signal = np.sign(delta) * np.abs(delta / norm) ** P * norm
        yield signal / np.sqrt(threshold ** (2.0 * P) + mask**2)


def visible_difference(
    test: Pyramid, reference: Pyramid, log_adaptation: Plane, pixels_per_degree: float
) -> Pyramid:
    """D: how ``test`` differs from ``reference``, in units of what is seen half the time.

    ``log_adaptation`` is log10 of the luminance that each pixel adapts to, (h, w).
    """
    shared = shared_signal(test, reference)
    bands = []
    for number, planes in enumerate(zip(test.bands, reference.bands, strict=True)):
        deltas = tuple(
            in_test - in_reference for in_test, in_reference in zip(*planes, strict=True)
        )
        threshold = thresholds(number, shared, log_adaptation, pixels_per_degree)
        bands.append(tuple(masked_band(deltas, shared, number, threshold)))
    return Pyramid(tuple(bands))
