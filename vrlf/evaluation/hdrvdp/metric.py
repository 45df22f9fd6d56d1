"""The stages of HDR-VDP-2.2 in their order, and what they ask of their input.

Source: Mantiuk, Kim, Rempel & Heidrich 2011, figure 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, sqrt
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from vrlf.errors import InputError
from vrlf.evaluation.hdrvdp.csf import neural_csf
from vrlf.evaluation.hdrvdp.eye import BRIGHTEST_CD_M2, DARKEST_CD_M2, Seen, see
from vrlf.evaluation.hdrvdp.filtering import Plane, filter_padded, radial_frequency
from vrlf.evaluation.hdrvdp.masking import visible_difference
from vrlf.evaluation.hdrvdp.pooling import (
    differing,
    opinion_score,
    pooled,
    probability,
    quality,
    threshold_map,
)
from vrlf.evaluation.hdrvdp.pyramid import Pyramid, decompose

# Far beyond any panel before an eye; the sensitivities are still numbers there.
PIXELS_PER_DEGREE: Final = (0.1, 10_000.0)


@dataclass(frozen=True)
class HdrVdp:
    """What HDR-VDP-2.2 says of a pair of pictures.

    Attributes
    ----------
    p_map
        Probability that the difference at each pixel is seen, (h, w). It saturates at 1.
    s_map
        The same before pooling over the picture: in units of the threshold raised to the
        psychometric function's slope, 3.5; does not saturate, (h, w).
    p_det
        Greatest of ``p_map``: the probability that any difference is seen.
    c_max
        Greatest of the pooled ``s_map``.
    q
        Quality correlate, lower is better; equal pictures have the least that their size and
        resolution allow.
    q_mos
        ``q`` as a mean opinion score, 0 to 100.
    """

    p_map: Plane
    s_map: Plane
    p_det: float
    c_max: float
    q: float
    q_mos: float


def _luminance(name: str, given: ArrayLike) -> Plane:
    """``given`` as float64, (h, w), or a complaint about it."""
    plane = np.asarray(given, dtype=np.float64)
    if plane.ndim != 2 or plane.size == 0:
        raise InputError(f"{name}: found an array of shape {plane.shape}, wanted (h, w)")
    bad = ~(np.isfinite(plane) & (plane >= 0.0))
    if bad.any():
        row, column = np.argwhere(bad)[0]
        raise InputError(
            f"{name}: found {plane[row, column]} in row {row}, column {column}"
            f" ({int(bad.sum())} such pixels), wanted finite luminance of 0 cd/m2 or more"
        )
    return plane


def _checked(
    test: ArrayLike, reference: ArrayLike, pixels_per_degree: float, surround_l: float
) -> tuple[Plane, Plane]:
    """Both pictures as float64, or a complaint about the first thing that is wrong."""
    test, reference = _luminance("test picture", test), _luminance("reference picture", reference)
    if test.shape != reference.shape:
        raise InputError(
            f"test picture: found {test.shape[1]}x{test.shape[0]} pixels, wanted"
            f" {reference.shape[1]}x{reference.shape[0]} as the reference picture has"
        )
    least, most = PIXELS_PER_DEGREE
    if not least <= pixels_per_degree <= most:
        raise InputError(
            f"pixels per degree: found {pixels_per_degree}, wanted {least:g} to {most:g}"
        )
    if not (isfinite(surround_l) and surround_l >= 0.0):
        raise InputError(f"surround: found {surround_l} cd/m2, wanted 0 or more")
    return test, reference


def _base_seen(pyramid: Pyramid, seen: Seen, pixels_per_degree: float, surround: float) -> Pyramid:
    """``pyramid`` with its base weighted by the neural CSF at the picture's mean luminance.

    The base holds frequencies from 0 up, for which no one threshold would do.
    """
    (base,) = pyramid.bands[-1]
    # Release 2.2 puts the base's Nyquist limit at sqrt(2) of the band's frequency.
    samples_per_degree = sqrt(2.0) * pixels_per_degree * pyramid.frequencies[-1]
    rho = radial_frequency((2 * base.shape[0], 2 * base.shape[1]), samples_per_degree)
    gain = neural_csf(rho, float(seen.adaptation.mean()))
    return Pyramid((*pyramid.bands[:-1], (filter_padded(base, gain, surround),)))


def _differences(
    test: Plane, reference: Plane, pixels_per_degree: float, surround_l: float
) -> Pyramid:
    """The visible differences of two pictures in cd/m2, band by band."""
    both = [see(picture, pixels_per_degree, surround_l) for picture in (test, reference)]
    pyramids = [decompose(seen.response) for seen in both]
    # One surround for both, lest it makes a difference of its own.
    surround = float(pyramids[1].bands[-1][0].mean())
    of_test, of_reference = (
        _base_seen(pyramid, seen, pixels_per_degree, surround)
        for pyramid, seen in zip(pyramids, both, strict=True)
    )
    adaptation = (both[0].adaptation + both[1].adaptation) / 2.0
    log_adaptation = np.log10(np.clip(adaptation, DARKEST_CD_M2, BRIGHTEST_CD_M2))
    return visible_difference(of_test, of_reference, log_adaptation, pixels_per_degree)


def hdr_vdp(
    test_cd_m2: ArrayLike,
    reference_cd_m2: ArrayLike,
    pixels_per_degree: float,
    *,
    surround_l: float = DARKEST_CD_M2,
) -> HdrVdp:
    """How visible a difference is, and how much it spoils, by HDR-VDP-2.2.

    Parameters
    ----------
    test_cd_m2, reference_cd_m2 : (h, w)
        Luminance in cd/m2, 0 or more, as light of D65. The order counts.
    pixels_per_degree : float
        0.1 to 10,000.
    surround_l : float
        Luminance around the pictures in cd/m2. The default is darkness, as in a headset.

    Raises
    ------
    InputError
        For arrays that are no pictures of one size, negative or not finite luminance, or a
        resolution or surround out of range.

    Notes
    -----
    Mantiuk, Kim, Rempel & Heidrich 2011, calibration of release 2.2 (Narwaria, Mantiuk, Perreira
    Da Silva & Le Callet 2015). Colour is not looked at.
    """
    test, reference = _checked(test_cd_m2, reference_cd_m2, pixels_per_degree, surround_l)
    differences = _differences(test, reference, pixels_per_degree, surround_l)
    s_map = threshold_map(differences)
    c_map = pooled(s_map)
    p_map = probability(c_map)
    q = quality(differences, differing(test, reference), pixels_per_degree)
    return HdrVdp(p_map, s_map, float(p_map.max()), float(c_map.max()), q, opinion_score(q))
