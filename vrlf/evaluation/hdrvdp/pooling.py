"""From visible differences in bands to maps and single numbers.

Source: Mantiuk, Kim, Rempel & Heidrich 2011, sections 3.4 (visibility: psychometric function,
spatial integration) and 3.5 (quality). The quality's weights, its logarithm of root sums and
the logistic curve are those of release 2.2 (Narwaria, Mantiuk, Perreira Da Silva & Le Callet
2015).
"""

from __future__ import annotations

from math import exp, log
from typing import Final

import numpy as np

from vrlf.evaluation.hdrvdp.filtering import Plane, resize
from vrlf.evaluation.hdrvdp.pyramid import Pyramid, reconstruct

QUALITY_CPD: Final = (0.2344, 0.4688, 0.9375, 1.875, 3.75, 7.5, 15.0)
QUALITY_WEIGHTS: Final = (0.0002, 0.0003, 0.0003, 0.0398, 0.2690, 0.2142, 0.2832)
RELATIVE_DIFFERENCE: Final = 0.001
TINY: Final = 1e-12


def threshold_map(differences: Pyramid) -> Plane:
    """S: what the bands' differences make together at each pixel."""
    return np.abs(reconstruct(differences))


def pooled(s_map: Plane) -> Plane:
    """C: S with what the rest of the picture adds to its being found."""
    return s_map * float(s_map.sum() / (s_map.max() + TINY))


def probability(c_map: Plane) -> Plane:
    """The probability that the difference at each pixel is seen, 1/2 where C is 1."""
    return np.asarray(1.0 - 0.5**c_map)


def differing(test: Plane, reference: Plane) -> Plane:
    """1 where ``test`` is off ``reference`` by more than a thousandth of it, else 0."""
    return (np.abs(test - reference) > RELATIVE_DIFFERENCE * reference).astype(np.float64)


def quality(differences: Pyramid, where: Plane, pixels_per_degree: float) -> float:
    """Q: the mean over all planes of a weight times ln(root of the sum of D^2, per pixel).

    The lower the better. Each orientation of a level counts as a plane of its own. ``where``
    (h, w) weights the pixels.
    """
    total = 0.0
    for planes, frequency in zip(differences.bands, differences.frequencies, strict=True):
        cpd = pixels_per_degree / 2.0 * frequency
        weight = float(np.interp(cpd, QUALITY_CPD, QUALITY_WEIGHTS))
        here = resize(where, planes[0].shape)
        for plane in planes:
            root = float(np.sqrt(np.sum(np.square(plane * here)))) / plane.size
            total += weight * log(root + TINY)
    return total / sum(len(planes) for planes in differences.bands)


def opinion_score(q: float) -> float:
    """Q as a mean opinion score, from 0 (bad) to 100."""
    return 100.0 / (1.0 + exp(3.455 * (q + 0.8886)))
