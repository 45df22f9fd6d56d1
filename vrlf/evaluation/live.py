"""RMSE and PSNR of what both eyes perceive, from three sums that a GPU makes each frame.

With t the target, s what is perceived and d = s - t, each over N values (pixels inside the border
times three colours), the least-squares gain is

    g = S_st / S_ss,    S_st = S_tt + S_td,    S_ss = S_tt + 2 S_td + S_dd,

and what it leaves is S_tt - S_st^2 / S_ss, which is the same as

    sum of (g s - t)^2 = (S_tt S_dd - S_td^2) / S_ss.

The second form is not a small difference of large sums where s is near t: with sums of float32 it
holds to 0.002 dB at 70 dB, and with a gain of 1.7 to 0.2 dB there. It is the measure of
``measure.likeness``.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, sqrt

from vrlf.evaluation.measure import border_px
from vrlf.evaluation.metrics.fidelity import psnr_db
from vrlf.model import Rig
from vrlf.optics.viewport import SIDES, Side, viewport
from vrlf.passes.squares import Sums


@dataclass(frozen=True)
class LiveLikeness:
    """One eye's ``rmse``, ``psnr_db`` (infinite for equal pictures) and ``gain``."""

    rmse: float
    psnr_db: float
    gain: float


def borders_px(rig: Rig) -> tuple[int, int]:
    """Of both eyes: what ``measure.likeness`` leaves out at each side."""
    return border_px(rig, "left"), border_px(rig, "right")


def live_likeness(sums: Sums) -> dict[Side, LiveLikeness]:
    """What the sums of both eyes mean; without an eye whose border leaves nothing."""
    found: dict[Side, LiveLikeness] = {}
    for values, side, border in zip(sums.values, SIDES, sums.borders, strict=True):
        tt, td, dd = values.tolist()
        view = viewport(sums.rig, side)
        width, height = view.width_px - 2 * border, view.height_px - 2 * border
        if min(width, height) <= 0 or not isfinite(tt + td + dd):
            continue
        energy = tt + 2.0 * td + dd
        gain = (tt + td) / energy if energy > 0.0 else 1.0
        left = (tt * dd - td * td) / energy if energy > 0.0 else tt
        rmse = sqrt(max(left, 0.0) / (3 * width * height))
        found[side] = LiveLikeness(rmse, psnr_db(rmse), gain)
    return found
