"""Light and colour of a picture against those of another: what is left, what came in unmeant."""

from __future__ import annotations

import numpy as np

from vrlf.evaluation.metrics.model import Float, Picture, Score, Viewing
from vrlf.scene import luminance


def colour_error(seen: Picture, target: Picture) -> Float:
    """c: the part of the difference that no grey could have made; (H, W, 3), luminance 0."""
    difference = seen.astype(np.float64) - target.astype(np.float64)
    return np.asarray(difference - luminance(difference)[..., None])


def fringe_share(seen: Picture, target: Picture) -> float | None:
    """RMS of c over pixels and colours, of the target's mean luminance; None where that is 0.

    ``evaluation.fringes`` says why this is a measure of coloured edges.
    """
    light = float(luminance(target).mean())
    if light == 0.0:
        return None
    return float(np.sqrt(np.mean(colour_error(seen, target) ** 2)) / light)


def light_kept(seen: Picture, target: Picture) -> float | None:
    """Mean luminance of what is seen, of the target's; None where that is 0.

    What a headset leaves of the light, if ``seen`` was perceived without making up for the
    array's throughput (exposure ``none``).
    """
    light = float(luminance(target).mean())
    return None if light == 0.0 else float(luminance(seen).mean()) / light


def score_fringe(reference: Picture, test: Picture, _: Viewing) -> Score:
    """Colour that is seen where none was meant, without any gain."""
    return _of_light(fringe_share(test, reference))


def score_light(reference: Picture, test: Picture, _: Viewing) -> Score:
    """Share of the reference's light."""
    return _of_light(light_kept(test, reference))


def _of_light(value: float | None) -> Score:
    return Score(value, None if value is not None else "the reference is dark")
