"""Every metric that two pictures are enough for, by name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from importlib.util import find_spec
from types import MappingProxyType
from typing import Final

from vrlf.errors import InputError, VrlfError
from vrlf.evaluation.metrics.colour import score_fringe, score_light
from vrlf.evaluation.metrics.contrast import score_contrast
from vrlf.evaluation.metrics.cvvdp import score_cvvdp
from vrlf.evaluation.metrics.fidelity import score_psnr, score_rmse, score_ssim
from vrlf.evaluation.metrics.flip import score_flip
from vrlf.evaluation.metrics.model import (
    Metric,
    MissingExtraError,
    Picture,
    Scores,
    Viewing,
    check_pair,
)
from vrlf.evaluation.metrics.visible import score_hdr_vdp

_ALL: Final = (
    Metric("rmse", "RMSE", "", "lower", None, False, (), score_rmse),
    Metric("psnr_db", "PSNR", "dB", "higher", None, False, (), score_psnr),
    Metric("ssim", "SSIM", "", "higher", None, False, (), score_ssim),
    Metric("flip", "FLIP", "", "lower", "flip", True, ("flip",), score_flip),
    Metric("cvvdp_jod", "ColorVideoVDP", "JOD", "higher", "cvvdp", True, ("cvvdp",), score_cvvdp),
    Metric("hdr_vdp", "HDR-VDP-2", "", "higher", None, True, ("P", "S"), score_hdr_vdp),
    Metric("contrast", "contrast kept", "", "higher", None, True, (), score_contrast),
    Metric("fringe", "colour fringe", "", "lower", None, False, (), score_fringe),
    Metric("light", "light kept", "", "higher", None, False, (), score_light),
)

_LIBRARIES: Final[Mapping[str, str]] = {"flip": "flip_evaluator", "cvvdp": "pycvvdp"}

METRICS: Final[Mapping[str, Metric]] = MappingProxyType({each.name: each for each in _ALL})


def score(names: Iterable[str], reference: Picture, test: Picture, viewing: Viewing) -> Scores:
    """Compare two pictures by several metrics; where one can't be had, the others go on.

    Parameters
    ----------
    names : iterable of str
        Keys of ``METRICS``.
    reference, test : ndarray (H, W, 3)
        Linear light, of equal size.
    viewing : Viewing
        How both are seen.

    Returns
    -------
    Scores
        A metric is in ``values`` or in ``failed``.

    Raises
    ------
    InputError
        An unknown name, pictures of unequal size, or values that are not finite.
    """
    wanted = list(dict.fromkeys(names))
    unknown = [name for name in wanted if name not in METRICS]
    if unknown:
        raise InputError(f"metric: found {unknown[0][:40]!r}, wanted one of {', '.join(METRICS)}")
    check_pair(reference, test)
    scores = Scores({}, {}, {}, {})
    for name in wanted:
        _add(scores, METRICS[name], reference, test, viewing)
    return scores


def missing(names: Iterable[str]) -> dict[str, str]:
    """Those of the metrics whose library is not installed, each with the line that says so."""
    wanted = [METRICS[name] for name in dict.fromkeys(names)]
    return {
        metric.name: str(MissingExtraError(metric.name, _LIBRARIES[metric.extra], metric.extra))
        for metric in wanted
        if metric.extra is not None and find_spec(_LIBRARIES[metric.extra]) is None
    }


def _add(scores: Scores, metric: Metric, reference: Picture, test: Picture, v: Viewing) -> None:
    try:
        found = metric.compute(reference, test, v)
    except VrlfError as error:
        scores.failed[metric.name] = str(error)
    except Exception as error:  # a library's fault must not take the other metrics along
        reason = " ".join(str(error).split())[:200]
        scores.failed[metric.name] = f"{metric.name}: found {type(error).__name__}: {reason}"
    else:
        scores.values[metric.name] = found.value
        if found.reason is not None:
            scores.reasons[metric.name] = found.reason
        if found.maps:
            scores.maps[metric.name] = found.maps
