"""From luminance to the eye's achromatic response, in just noticeable differences.

Source: Mantiuk, Kim, Rempel & Heidrich 2011, section 3.1 (optical and retinal pathway: scatter,
receptors, luminance masking), with the constants of release 2.2. Where that differs from the
paper or narrows it:

- the coefficients of the MTF and of the sensitivities were fitted anew;
- a picture of luminance alone is light of D65, of which L and M cones take 0.9186, not 1;
- each pixel adapts to its own luminance on the retina, which is not blurred further;
- the response is integrated over log luminance and has a factor of its own, 1.7318;
- cones and rods lose their mean response each, before they are summed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from vrlf.evaluation.hdrvdp.filtering import Plane, filter_padded, radial_frequency

# What L cones, M cones and rods take of 1 cd/m2 of D65. S cones add nothing to luminance.
L_CONE: Final = 0.601847
M_CONE: Final = 0.316708
ROD: Final = 0.904671

MTF_GAINS: Final = (0.4248386, 0.5724351, 0.000167576, 0.00255872)
MTF_FALLS_DEG: Final = (0.028, 0.37, 37.0, 360.0)
DARKEST_CD_M2: Final = 1e-5
BRIGHTEST_CD_M2: Final = 1e5
TABLE_POINTS: Final = 2048
RESPONSE_SCALE: Final = 1.731844


@dataclass(frozen=True)
class Seen:
    """What an eye makes of a picture before its channels part.

    Attributes
    ----------
    response
        Achromatic response in JND, without its mean, (h, w).
    adaptation
        What each pixel adapts to, L + M on the retina in cd/m2, (h, w).
    """

    response: Plane
    adaptation: Plane


def optical_mtf(rho: Plane) -> Plane:
    """The eye's modulation transfer at ``rho`` cycles per degree, sum of a exp(-b rho)."""
    pairs = zip(MTF_GAINS, MTF_FALLS_DEG, strict=True)
    return np.asarray(sum(gain * np.exp(-fall * rho) for gain, fall in pairs))


def joint_sensitivity(cd_m2: Plane) -> Plane:
    """Peak contrast sensitivity of cones and rods together, adapted to ``cd_m2``."""
    return 30.162 * ((4.0627 / cd_m2) ** 1.6596 + 1.0) ** -0.2712


def rod_sensitivity(cd_m2: Plane) -> Plane:
    """Peak contrast sensitivity of the rods; greatest at 1.1732 cd/m2."""
    off_peak = np.log10(cd_m2 / 1.1732)
    above = np.abs(off_peak) ** 2.9899 / 0.5547
    below = np.abs(off_peak) ** 1.2167 / 1.1478
    return np.asarray(10.0**1.1414 * np.exp(-np.where(off_peak > 0.0, above, below)))


def cone_sensitivity(cd_m2: Plane) -> Plane:
    """Peak contrast sensitivity of one kind of cone, L or M, that takes ``cd_m2``, ascending.

    Half of what the rods leave of the joint sensitivity where both kinds take twice as much.
    Release 2.2 reads that off a line between the points of its table, which a difference to the
    power of 3.5 shows in the fifth digit.
    """
    left = np.maximum(joint_sensitivity(cd_m2) - rod_sensitivity(cd_m2), 1e-3)
    return np.asarray(0.5 * np.interp(np.minimum(2.0 * cd_m2, cd_m2[-1]), cd_m2, left))


@lru_cache(maxsize=1)
def response_tables() -> tuple[Plane, Plane, Plane]:
    """Log10 of luminance, and there the responses of one kind of cone and of rods, in JND.

    One JND is a step dL = L / S(L), so that the response is the integral of S ln(10) d(log10 L),
    here by trapezes.
    """
    log_l = np.linspace(np.log10(DARKEST_CD_M2), np.log10(BRIGHTEST_CD_M2), TABLE_POINTS)
    tables = []
    for sensitivity in (cone_sensitivity(10.0**log_l), rod_sensitivity(10.0**log_l)):
        steps = 0.5 * (sensitivity[1:] + sensitivity[:-1]) * np.diff(log_l)
        jnd = np.concatenate(([0.0], np.cumsum(steps)))
        tables.append(RESPONSE_SCALE * np.log(10.0) * jnd)
    return log_l, tables[0], tables[1]


def retinal_luminance(cd_m2: Plane, pixels_per_degree: float, surround_l: float) -> Plane:
    """``cd_m2`` after scatter in the eye, at least 1e-5, (h, w)."""
    height, width = cd_m2.shape
    rho = radial_frequency((2 * height, 2 * width), pixels_per_degree)
    return np.maximum(filter_padded(cd_m2, optical_mtf(rho), surround_l), DARKEST_CD_M2)


def see(cd_m2: Plane, pixels_per_degree: float, surround_l: float) -> Seen:
    """What the eye's optics and receptors make of ``cd_m2``, (h, w)."""
    retina = retinal_luminance(cd_m2, pixels_per_degree, surround_l)
    log_l, cone_jnd, rod_jnd = response_tables()
    log_retina = np.log10(retina)
    cones = np.interp(log_retina + np.log10(L_CONE), log_l, cone_jnd)
    cones += np.interp(log_retina + np.log10(M_CONE), log_l, cone_jnd)
    rods = np.interp(log_retina + np.log10(ROD), log_l, rod_jnd)
    response = (cones - cones.mean()) + (rods - rods.mean())
    return Seen(response, (L_CONE + M_CONE) * retina)
