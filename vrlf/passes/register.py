"""What the forward prefilter does to a bare panel whose colours the lens magnifies differently."""

from __future__ import annotations

from typing import Any

import numpy as np

from vrlf.gpu import Block, Field
from vrlf.model import Rig
from vrlf.optics.bench import is_lateral
from vrlf.optics.lateral import registering_maps
from vrlf.optics.viewport import SIDES, axis_in_viewport_px, viewport
from vrlf.passes.fields import VIEWPORT_FIELDS, viewport_values

REGISTER = Block(
    "Register",
    (
        *VIEWPORT_FIELDS,
        Field("vec4", "lens_axes_px", "of each eye: its axis in the viewport's raster", 2),
        Field("vec4", "maps", "of each eye and colour: scale less 1, then a shift in pixels", 6),
    ),
)


class RegisterTables:
    """All that it needs of one rig: numbers alone."""

    def __init__(self, rig: Rig) -> None:
        if not is_lateral(rig):
            raise ValueError("forward: a bare panel needs no tables, its image is the target")
        self.size_px = (rig.panel.width_px, rig.panel.height_px)
        maps = np.concatenate([registering_maps(rig, side) for side in SIDES])
        axes = [axis_in_viewport_px(rig, viewport(rig, side)) for side in SIDES]
        self.values: dict[str, Any] = {
            **viewport_values(rig),
            "lens_axes_px": np.pad(axes, ((0, 0), (0, 2))),
            "maps": np.pad(maps, ((0, 0), (0, 1))),
        }

    def release(self) -> None:
        """There is nothing to give back."""
