"""ColorVideoVDP: the quality that is left, in just-objectionable differences.

R. K. Mantiuk, P. Hanji, M. Ashraf, Y. Asano, A. Chapiro: *ColorVideoVDP: A visual difference
predictor for image, video and display distortions*, ACM TOG 43 (4), 2024, in its authors' own
library.
"""

from __future__ import annotations

import functools
import importlib
from typing import Any, Final

import numpy as np

from vrlf.evaluation.metrics.model import MetricError, MissingExtraError, Picture, Score, Viewing

_NAME: Final = "cvvdp_jod"
# What the library takes as darkest anyway, so no black level that a panel has is lost.
_CONTRAST: Final = 1e12


def score_cvvdp(reference: Picture, test: Picture, viewing: Viewing) -> Score:
    """Quality in JOD, 10 for equal pictures, and the map of differences in JOD.

    The library is told luminance, not pixel values, so its display has no curve of its own, no
    ambient light and no end to its range above; it takes 0.005 cd/m2 as the darkest there is.
    """
    library = _library()
    colours = [viewing.colours_nit(each).astype(np.float32) for each in (test, reference)]
    height, width = reference.shape[:2]
    metric = library.cvvdp(
        display_photometry=library.vvdp_display_photo_eotf(
            Y_peak=float(max(each.max() for each in colours)),
            contrast=_CONTRAST,
            source_colorspace="BT.709-linear",
            E_ambient=0,
        ),
        display_geometry=library.vvdp_display_geometry(
            (width, height), ppd=viewing.pixels_per_degree
        ),
        heatmap="raw",
        quiet=True,
    )
    jod, details = metric.predict(*colours, dim_order="HWC")
    heat = np.asarray(details["heatmap"].numpy(), np.float64).reshape(height, width)
    if not (np.isfinite(float(jod)) and np.all(np.isfinite(heat))):
        raise MetricError(f"{_NAME}: found a result that is not finite, wanted numbers")
    return Score(float(jod), maps={"cvvdp": heat})


def _library() -> Any:
    try:
        _mend_torchvision()
        return importlib.import_module("pycvvdp")
    except ModuleNotFoundError as error:
        raise MissingExtraError(_NAME, error.name or "pycvvdp", "cvvdp") from error
    except (ImportError, OSError, RuntimeError) as error:
        raise MissingExtraError(_NAME, "pycvvdp", "cvvdp", str(error)) from error


@functools.cache
def _mend_torchvision() -> Any:
    """Let torchvision load beside a torch that it was not built for.

    It then misses two operators of its own, of which nothing here makes use. What this returns
    must be kept, or the operators are gone again; the cache does that.
    """
    try:
        importlib.import_module("torchvision")
    except RuntimeError:
        operators = importlib.import_module("torch.library").Library("torchvision", "DEF")
        for name in ("nms", "qnms"):
            operators.define(f"{name}(Tensor dets, Tensor scores, float threshold) -> Tensor")
        return operators
    return None
