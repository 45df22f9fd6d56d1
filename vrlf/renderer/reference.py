"""The steps by the float64 twins: slow, needs no GPU."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vrlf.content.pictures import StereoSource
from vrlf.model import Rig
from vrlf.optics.fitting import FitMode
from vrlf.optics.tracing import Tracing
from vrlf.reference.encode import encode
from vrlf.reference.forward import forward
from vrlf.reference.optimal import optimal
from vrlf.reference.prepare import prepare
from vrlf.reference.quadrature import perceive_well
from vrlf.reference.sharpen import sharpen
from vrlf.reference.traced import perceive_traced
from vrlf.renderer.steps import (
    DEFAULT_RAYS,
    PLAIN,
    Exposure,
    Image,
    check_rays,
    checked_image,
    exposure_factor,
    fitted,
)
from vrlf.solve.spread import SPREAD_RAYS, point_spread
from vrlf.solve.wiener import kernel_of


class ReferenceRenderer:
    """The steps by the float64 twins: slow, needs no GPU."""

    def target(self, source: StereoSource, rig: Rig, fit: FitMode = "contain") -> Image:
        """See ``Renderer.target``."""
        if source.panel is not None:
            return np.clip(source.panel, 0.0, 1.0)
        pictures, fits = fitted(source, rig, fit)
        as_double = (pictures[0].astype(np.float64), pictures[1].astype(np.float64))
        return prepare(as_double, fits, rig).astype(np.float32)

    def prefilter(self, target: Image, rig: Rig) -> Image:
        """See ``Renderer.prefilter``."""
        target = checked_image(target, rig, "target")
        if rig.prefilter.method == "none":
            return np.array(target, dtype=np.float32)
        if rig.prefilter.method == "optimal":
            return optimal(target.astype(np.float64), rig, DEFAULT_RAYS).astype(np.float32)
        wanted = target.astype(np.float64)
        if rig.prefilter.wiener:
            kernel = kernel_of(point_spread(rig, _perceived), rig.prefilter.wiener_noise)
            wanted = sharpen(wanted, rig, kernel.taps, kernel.shift_px)
        return forward(wanted, rig).astype(np.float32)

    def perceive(
        self,
        panel: Image,
        rig: Rig,
        *,
        rays: int = DEFAULT_RAYS,
        exposure: Exposure = "auto",
        tracing: Tracing = PLAIN,
    ) -> Image:
        """See ``Renderer.perceive``."""
        panel = checked_image(panel, rig, "panel image")
        check_rays(rays)
        light = panel.astype(np.float64)
        if tracing:
            seen = perceive_traced(light, rig, rays, tracing)
        else:
            seen = perceive_well(light, rig, rays)
        return (seen * exposure_factor(rig, exposure)).astype(np.float32)

    def encode(self, light: Image, *, dither: bool = False) -> NDArray[np.uint8]:
        """See ``Renderer.encode``."""
        return encode(light.astype(np.float64), dither=dither)


def _perceived(target: Image, rig: Rig) -> Image:
    """What is perceived of a target, for measuring point spreads."""
    shown = forward(target.astype(np.float64), rig)
    return perceive_well(shown, rig, SPREAD_RAYS).astype(np.float32)
