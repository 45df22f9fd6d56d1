"""Which columns of the panel an eye sees, and where its axis meets them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vrlf.model import Rig
from vrlf.optics.polynomial import Float
from vrlf.units import UM_PER_MM

Side = Literal["left", "right"]
SIDES: tuple[Side, Side] = ("left", "right")

# From a millimetre offset with y up to a raster offset with rows downward.
RASTER_FLIP = np.diag([1.0, -1.0])


@dataclass(frozen=True)
class Viewport:
    """The half of the panel that one eye sees.

    Attributes
    ----------
    first_column, width_px, height_px
        Its columns on the panel; all rows are its own.
    axis_mm : (x, y)
        Where the optical axis meets the panel, panel frame.
    """

    first_column: int
    width_px: int
    height_px: int
    axis_mm: tuple[float, float]

    @property
    def columns(self) -> slice:
        """The viewport's columns on the panel."""
        return slice(self.first_column, self.first_column + self.width_px)


def viewport(rig: Rig, side: Side) -> Viewport:
    """The viewport of one eye; the middle column of an odd width is nobody's."""
    width_px = rig.panel.width_px // 2
    left = side == "left"
    half_separation_mm = rig.headset.lens_separation_mm / 2.0
    return Viewport(
        first_column=0 if left else rig.panel.width_px - width_px,
        width_px=width_px,
        height_px=rig.panel.height_px,
        axis_mm=(-half_separation_mm if left else half_separation_mm, rig.headset.lens_height_mm),
    )


def pitch_mm(rig: Rig) -> float:
    """The panel's pixel pitch."""
    return rig.panel.pixel_pitch_um / UM_PER_MM


def column_centres_mm(rig: Rig) -> Float:
    """x of every column's centre on the whole panel, shape (W,), panel frame."""
    width = rig.panel.width_px
    return np.asarray((np.arange(width) + 0.5 - width / 2.0) * pitch_mm(rig), np.float64)


def row_centres_mm(rig: Rig) -> Float:
    """y of every row's centre, shape (H,), panel frame: row 0 is the highest."""
    height = rig.panel.height_px
    return np.asarray((height / 2.0 - np.arange(height) - 0.5) * pitch_mm(rig), np.float64)


def panel_points_mm(rig: Rig, view: Viewport) -> Float:
    """The panel points X of a viewport's pixels, relative to its axis; shape (H, w, 2)."""
    x = column_centres_mm(rig)[view.columns] - view.axis_mm[0]
    y = row_centres_mm(rig) - view.axis_mm[1]
    return np.stack(np.broadcast_arrays(x[None, :], y[:, None]), axis=-1)


def axis_in_viewport_px(rig: Rig, view: Viewport) -> Float:
    """The optical axis in the viewport's own raster (right, down; corners at whole numbers)."""
    pitch = pitch_mm(rig)
    column = view.axis_mm[0] / pitch + rig.panel.width_px / 2.0 - view.first_column
    return np.array([column, rig.panel.height_px / 2.0 - view.axis_mm[1] / pitch])
