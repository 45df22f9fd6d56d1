"""RMSE, PSNR and SSIM, in linear light of peak 1: the only place of their formulas."""

from __future__ import annotations

from math import inf, log10
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from skimage.metrics import structural_similarity

from vrlf.evaluation.metrics.model import Picture, Score, Viewing

Numbers = NDArray[np.floating[Any]]

# 3.5 deviations to each side of the middle, as scikit-image cuts the Gaussian off.
SSIM_WINDOW_PX: Final = 11


def rmse(test: Numbers, reference: Numbers) -> float:
    """Root of the mean squared difference: T 6.1 with the 1/N that it forgot."""
    difference = test.astype(np.float64) - reference.astype(np.float64)
    return float(np.sqrt(np.mean(difference**2)))


def psnr_db(rmse_of_peak_1: float) -> float:
    """10 log10(1 / rmse^2); infinite for equal pictures."""
    return inf if rmse_of_peak_1 == 0.0 else -20.0 * log10(rmse_of_peak_1)


def ssim(test: Numbers, reference: Numbers) -> float | None:
    """Mean structural similarity of two pictures (H, W, 3) of peak 1, as in Wang et al. 2004.

    The mean is over the places whose window lies within the picture. None if there are none.
    """
    if min(reference.shape[:2]) < SSIM_WINDOW_PX:
        return None
    value = structural_similarity(  # type: ignore[no-untyped-call]
        test.astype(np.float64),
        reference.astype(np.float64),
        gaussian_weights=True,
        sigma=1.5,
        use_sample_covariance=False,
        data_range=1.0,
        channel_axis=-1,
    )
    return float(value)


def score_rmse(reference: Picture, test: Picture, _: Viewing) -> Score:
    """RMSE of all pixels and colours."""
    return Score(rmse(test, reference))


def score_psnr(reference: Picture, test: Picture, _: Viewing) -> Score:
    """PSNR in dB; JSON has no infinity, so equal pictures have none."""
    error = rmse(test, reference)
    if error == 0.0:
        return Score(None, "the pictures are equal: infinite")
    return Score(psnr_db(error))


def score_ssim(reference: Picture, test: Picture, _: Viewing) -> Score:
    """SSIM; none for pictures smaller than its window."""
    value = ssim(test, reference)
    if value is None:
        height, width = reference.shape[:2]
        return Score(None, f"{width}x{height} pixels are less than its window of {SSIM_WINDOW_PX}")
    return Score(value)
