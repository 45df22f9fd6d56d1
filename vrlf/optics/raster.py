"""The lattice on the panel's raster, split so that 32-bit floats lose nothing.

The cell coordinate of a pixel's (scaled) centre is a sum of what its column and its row
contribute. Each contribution is kept as a whole number of cells and a rest of at most half
a cell, so a shader adds small numbers only: at 3840 pixels its places in a cell are good to
1e-4 um where plain millimetres would give 4e-3.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vrlf.model import Rig
from vrlf.optics.lattice import Lattice, ungrown
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import (
    RASTER_FLIP,
    SIDES,
    Side,
    column_centres_mm,
    pitch_mm,
    row_centres_mm,
    viewport,
)


@dataclass(frozen=True)
class CellRaster:
    """Cell coordinates of all pixels, by column and by row.

    Attributes
    ----------
    columns : ndarray (W, 4)
        Rest x, rest y, whole x, whole y, in cells; the eye's own axis is in it.
    rows : ndarray (H, 4)
    """

    columns: Float
    rows: Float


def cell_raster(
    rig: Rig, lattice: Lattice, scale: float, shift_mm: Mapping[Side, Float] | None = None
) -> CellRaster:
    """Cell coordinates of ``scale * X + shift`` for the panel points X of all pixels.

    Parameters
    ----------
    scale : float
        Where a pixel's ray crosses the plane in question, per millimetre of X.
    shift_mm : dict of side to ndarray (2,), optional
        What is added for an eye, whatever the pixel.
    """
    x, y = column_centres_mm(rig), row_centres_mm(rig)
    along = np.zeros((len(x), 2))
    for side in SIDES:
        view = viewport(rig, side)
        axis = np.array(view.axis_mm)
        fixed = (1.0 - scale) * axis - lattice.origin_mm
        if shift_mm is not None:
            fixed = fixed + shift_mm[side]
        along[view.columns] = fixed
        along[view.columns, 0] += scale * x[view.columns]
    down = np.stack([np.zeros(len(y)), scale * y], axis=-1)
    return CellRaster(
        _split(along @ lattice.cell_from_panel.T), _split(down @ lattice.cell_from_panel.T)
    )


@dataclass(frozen=True)
class VaryingRaster:
    """Cell coordinates where the pitch varies, and how it does about them.

    From a pixel's q on, an even place that is n farther is d cells farther,
    n = d (a + d (b + d c)), a = 1 + G q^2, b = G q and c = G / 3, which is exact.

    Attributes
    ----------
    columns : ndarray (W, 4)
        Along the first axis: rest, whole, a, b.
    rows : ndarray (2 H, 4)
        Along the second, for the left eye, then for the right one: their pupils may stand apart.
    """

    columns: Float
    rows: Float


def varying_raster(
    rig: Rig, lattice: Lattice, scale: float, shift_mm: Mapping[Side, Float] | None = None
) -> VaryingRaster:
    """As ``cell_raster``."""
    x, y = column_centres_mm(rig), row_centres_mm(rig)
    columns, rows = np.zeros((len(x), 4)), []
    for side in SIDES:
        view = viewport(rig, side)
        fixed = (1.0 - scale) * np.array(view.axis_mm) - lattice.origin_mm
        if shift_mm is not None:
            fixed = fixed + shift_mm[side]
        across, down = fixed[0] + scale * x[view.columns], fixed[1] + scale * y
        columns[view.columns] = _law(lattice.growth[0], across / lattice.pitch_mm)
        rows.append(_law(lattice.growth[1], down / lattice.pitch_mm))
    return VaryingRaster(columns, np.concatenate(rows))


def _law(growth: float, even: Float) -> Float:
    q = ungrown(np.asarray(growth), even)
    whole = np.floor(q + 0.5)
    return np.stack([q - whole, whole, 1.0 + growth * q**2, growth * q], axis=-1)


def _split(q: Float) -> Float:
    whole = np.floor(q + 0.5)
    return np.concatenate([q - whole, whole], axis=-1)


def cells_per_pixel(rig: Rig, lattice: Lattice) -> Float:
    """Cells per pixel (right, down), shape (2, 2)."""
    return np.asarray(lattice.cell_from_panel @ RASTER_FLIP * pitch_mm(rig))


def pixels_per_cell(rig: Rig, lattice: Lattice) -> Float:
    """Pixels (right, down) per cell, shape (2, 2)."""
    return np.asarray(RASTER_FLIP @ lattice.panel_from_cell / pitch_mm(rig))


def half_cell_px(rig: Rig, lattice: Lattice) -> Float:
    """How far a cell's corners lie from its centre, right and down, at most; shape (2,)."""
    return np.asarray(np.abs(lattice.corners @ pixels_per_cell(rig, lattice).T).max(axis=0))
