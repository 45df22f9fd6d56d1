"""How much contrast is left at each spatial frequency."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vrlf.evaluation.metrics.model import Float, Picture, Score, Viewing
from vrlf.scene import luminance
from vrlf.scene.spectrum import HIGHEST_CYCLES_PER_PX, LOWEST_CYCLES, radial_amplitude

# Rings of the reference that hold less than this of its mean amplitude hold rounding errors.
_FAINT = 1e-7


@dataclass(frozen=True)
class ContrastKept:
    """Contrast of a picture, of that of another, by frequency.

    Attributes
    ----------
    cycles_per_degree
        Shape (B,), ascending.
    kept
        Shape (B,): 1 where the contrast is the same, 0 where none is left, above 1 where there
        is more, be it of noise or of false edges.
    """

    cycles_per_degree: Float
    kept: Float


def contrast_kept(
    reference: Picture, test: Picture, pixels_per_degree: float
) -> ContrastKept | None:
    """Ratio of both pictures' spectra, each over its mean luminance, ring by ring.

    A ring holds all directions and its mean amplitude (``scene.spectrum``), so a blur shows up
    as its MTF and a shift not at all. Phases don't count: how near a picture comes to what it
    should be is another metric's question.

    Returns
    -------
    ContrastKept or None
        None where there is nothing to compare: a dark or even picture, or less than 12 pixels.
    """
    lights = [luminance(each) for each in (reference, test)]
    means = [float(each.mean()) for each in lights]
    if min(means) <= 0.0 or min(lights[0].shape) * HIGHEST_CYCLES_PER_PX <= LOWEST_CYCLES:
        return None
    (cycles_per_px, wanted), (_, found) = (
        radial_amplitude(light / mean) for light, mean in zip(lights, means, strict=True)
    )
    there = wanted > _FAINT * lights[0].size
    if not np.any(there):
        return None
    return ContrastKept(cycles_per_px[there] * pixels_per_degree, found[there] / wanted[there])


def score_contrast(reference: Picture, test: Picture, viewing: Viewing) -> Score:
    """Contrast kept by cycles per degree, whose three leading digits are the names."""
    found = contrast_kept(reference, test, viewing.pixels_per_degree)
    if found is None:
        return Score(None, "a picture is dark, even or too small")
    pairs = zip(found.cycles_per_degree, found.kept, strict=True)
    return Score({f"{frequency:.3g}": float(kept) for frequency, kept in pairs})
