"""Float64 twin of ``shaders/squares.comp``: sums over each eye's pixels inside its border."""

from __future__ import annotations

import numpy as np

from vrlf.model import Rig
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import SIDES, viewport


def squares(rig: Rig, seen: Float, target: Float, borders: tuple[int, int]) -> Float:
    """The values of ``vrlf.passes.squares.Sums``; pictures are (H, W, 3)."""
    found = np.zeros((len(SIDES), 3))
    for eye, side in enumerate(SIDES):
        view, border = viewport(rig, side), borders[eye]
        inner = (slice(border, view.height_px - border), slice(border, view.width_px - border))
        t = target[:, view.columns][inner].astype(np.float64)
        d = seen[:, view.columns][inner].astype(np.float64) - t
        found[eye] = np.sum(t * t), np.sum(t * d), np.sum(d * d)
    return found
