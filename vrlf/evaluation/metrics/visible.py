"""HDR-VDP-2: what of a difference an eye detects, and the quality that is left."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from vrlf.evaluation.metrics.model import MetricError, Picture, Score, Viewing


def score_hdr_vdp(reference: Picture, test: Picture, viewing: Viewing) -> Score:
    """``q_mos``, ``q``, ``p_det``, ``c_max`` and the maps P (detection) and S (not pooled)."""
    found = _model().hdr_vdp(
        viewing.luminance_nit(test), viewing.luminance_nit(reference), viewing.pixels_per_degree
    )
    numbers = {name: float(getattr(found, name)) for name in ("q_mos", "q", "p_det", "c_max")}
    return Score(numbers, maps={"P": found.p_map, "S": found.s_map})


def _model() -> Any:
    try:
        return import_module("vrlf.evaluation.hdrvdp")
    except ModuleNotFoundError as error:
        raise MetricError("hdr_vdp: found no such model in this version of vrlf") from error
