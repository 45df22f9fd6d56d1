"""ColorVideoVDP: the quality that is left, in just-objectionable differences.

R. K. Mantiuk, P. Hanji, M. Ashraf, Y. Asano, A. Chapiro: *ColorVideoVDP: A visual difference
predictor for image, video and display distortions*, ACM TOG 43 (4), 2024, in its authors' own
library.
"""

from __future__ import annotations

import contextlib
import functools
import importlib
import os
from collections.abc import Iterator
from math import inf
from typing import Any, Final

import numpy as np

from vrlf.evaluation.metrics.model import MetricError, MissingExtraError, Picture, Score, Viewing

_NAME: Final = "cvvdp_jod"
# Stands for black where a picture has no light at all.
_DARKEST_NIT: Final = 1e-6
_LEAST_SIDE_PX: Final = 4  # fewer leave the library's pyramid no level


def score_cvvdp(reference: Picture, test: Picture, viewing: Viewing) -> Score:
    """Quality in JOD, 10 for equal pictures, and the map of differences in JOD.

    Contrasts are what it compares: of a picture that is evenly half as bright it says 10.
    """
    height, width = reference.shape[:2]
    if min(height, width) < _LEAST_SIDE_PX:
        return Score(None, f"{width}x{height} pixels, wanted {_LEAST_SIDE_PX} a side")
    colours = [viewing.colours_nit(each) for each in (test, reference)]
    brightest = max(float(max(each.max() for each in colours)), _DARKEST_NIT)
    shares = [(each / brightest).astype(np.float32) for each in colours]
    with environment_kept():
        library = load_library()
        metric = library.cvvdp(
            display_photometry=_linear_display(library, brightest),
            display_geometry=library.vvdp_display_geometry(
                (width, height), ppd=viewing.pixels_per_degree
            ),
            heatmap="raw",
            quiet=True,
        )
        jod, details = metric.predict(*shares, dim_order="HWC")
    heat = np.asarray(details["heatmap"].numpy(), np.float64).reshape(height, width)
    if not (np.isfinite(float(jod)) and np.all(np.isfinite(heat))):
        raise MetricError(f"{_NAME}: found a result that is not finite, wanted numbers")
    return Score(float(jod), maps={"cvvdp": heat})


@contextlib.contextmanager
def environment_kept() -> Iterator[None]:
    """Take back what the library and torch write into the process's environment variables."""
    before = dict(os.environ)
    try:
        yield
    finally:
        for name in os.environ.keys() - before.keys():
            del os.environ[name]
        os.environ.update(before)


def _linear_display(library: Any, brightest_nit: float) -> Any:
    """A display that shows luminance as it is told, 1 being ``brightest_nit``.

    A gamma of 1, because the library's linear display cuts off below 0.005 cd/m2; no ambient
    light, and no black of its own, for that is in the luminance already.
    """
    return library.vvdp_display_photo_eotf(
        Y_peak=brightest_nit,
        contrast=inf,
        source_colorspace="sRGB",
        EOTF="1",
        E_ambient=0,
    )


def load_library() -> Any:
    """The library itself.

    Raises
    ------
    MissingExtraError
        If it isn't there.
    """
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
