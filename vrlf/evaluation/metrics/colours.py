"""A map of differences as colours: dark where there is none, ever lighter with more."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from vrlf.evaluation.metrics.model import Float

# Every sixteenth of "magma" (N. Smith & S. van der Walt 2015, CC0): its lightness grows evenly,
# so that the colour-blind and a print in grey read it right. FLIP's authors show maps in it.
_MAGMA: Final = (
    *((0, 0, 4), (10, 8, 34), (29, 17, 71), (54, 16, 107), (81, 18, 124), (106, 28, 129)),
    *((131, 38, 129), (156, 46, 127), (183, 55, 121), (208, 65, 111), (231, 82, 99)),
    *((245, 107, 92), (252, 137, 97), (254, 167, 114), (254, 196, 136), (253, 226, 163)),
    (252, 253, 191),
)


def false_colour(values: Float, full: float = 1.0) -> NDArray[np.uint8]:
    """Colours for 0 (black) to ``full`` (pale yellow); what lies outside has its end's colour.

    Parameters
    ----------
    values : ndarray (H, W)
        Finite.
    full : float
        1 serves every map of ``METRICS`` but S of HDR-VDP-2: FLIP's differences and HDR-VDP-2's
        probabilities end there, and ColorVideoVDP's map is in JOD.

    Returns
    -------
    ndarray of uint8, shape (H, W, 3)
        sRGB.
    """
    share = np.clip(values / full, 0.0, 1.0)
    places = np.linspace(0.0, 1.0, len(_MAGMA))
    colours = np.stack([np.interp(share, places, each) for each in zip(*_MAGMA, strict=True)], -1)
    return np.asarray(np.round(colours), np.uint8)
