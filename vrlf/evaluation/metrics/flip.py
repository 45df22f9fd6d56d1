"""FLIP: how much a person notices who flips between two pictures.

P. Andersson, J. Nilsson, T. Akenine-Moller, M. Oskarsson, K. Astrom, M. D. Fairchild: *FLIP: A
Difference Evaluator for Alternating Images*, HPG 2020, in its authors' own library.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vrlf.evaluation.metrics.model import MetricError, MissingExtraError, Picture, Score, Viewing
from vrlf.images import srgb_encode

_NAME = "flip"


def score_flip(reference: Picture, test: Picture, viewing: Viewing) -> Score:
    """LDR-FLIP's mean and map, 0 for equal pictures and at most 1.

    It judges pictures as sRGB shows them: values outside 0 to 1 are cut off, and luminance has
    no part in it.
    """
    # The library makes NaN an error of about 1 without a word, so nothing else may go in.
    encoded = [
        np.ascontiguousarray(srgb_encode(np.clip(each, 0.0, 1.0)), np.float32)
        for each in (reference, test)
    ]
    error_map, mean, _ = _library().evaluate(
        *encoded,
        "LDR",
        inputsRGB=True,
        applyMagma=False,
        computeMeanError=True,
        parameters={"ppd": viewing.pixels_per_degree},
    )
    values = np.asarray(error_map, np.float64)[..., 0]
    if not np.all(np.isfinite(values)):
        raise MetricError(f"{_NAME}: found a map that is not finite, wanted numbers")
    return Score(float(mean), maps={_NAME: values})


def _library() -> Any:
    try:
        import flip_evaluator
    except ModuleNotFoundError as error:
        raise MissingExtraError(_NAME, "flip-evaluator", "flip") from error
    except (ImportError, OSError) as error:
        raise MissingExtraError(_NAME, "flip-evaluator", "flip", str(error)) from error
    return flip_evaluator
