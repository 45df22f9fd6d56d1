"""HDR-VDP-2: what of a difference an eye detects, and the quality that is left."""

from __future__ import annotations

from vrlf.evaluation.hdrvdp import hdr_vdp
from vrlf.evaluation.metrics.model import Picture, Score, Viewing


def score_hdr_vdp(reference: Picture, test: Picture, viewing: Viewing) -> Score:
    """``q_mos``, ``q``, ``p_det``, ``c_max`` and the maps P (detection) and S (not pooled)."""
    found = hdr_vdp(
        viewing.luminance_nit(test), viewing.luminance_nit(reference), viewing.pixels_per_degree
    )
    numbers = {"q_mos": found.q_mos, "q": found.q, "p_det": found.p_det, "c_max": found.c_max}
    return Score(numbers, maps={"P": found.p_map, "S": found.s_map})
