"""Members that several uniform blocks share, and what a rig makes of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu import Buffer, Device, Field
from vrlf.model import Rig
from vrlf.optics.bench import bench_of, colour_benches, is_lateral
from vrlf.optics.lattice import Lattice
from vrlf.optics.polynomial import Float
from vrlf.optics.raster import (
    CellRaster,
    VaryingRaster,
    cell_raster,
    cells_per_pixel,
    pixels_per_cell,
    varying_raster,
)
from vrlf.optics.subpixels import layout
from vrlf.optics.viewport import SIDES, Side, axis_in_viewport_px, viewport

VIEWPORT_FIELDS = (
    Field("ivec2", "panel_px", "width and height of the panel"),
    Field("ivec2", "view_px", "width and height of one eye's viewport"),
    Field("int", "second_column", "where the right eye's viewport begins"),
)
# Of a period of pixels, and rectangles of three colours in each.
MOST_PLACES = 4
_BOXES = 3 * MOST_PLACES
SUBPIXEL_FIELDS = (
    Field("vec4", "emitting", "left, top, right, bottom of each place's colours", _BOXES),
    Field("vec4", "gain", "radiance that makes up for the area a colour lacks"),
)
LATTICE_FIELDS = (
    Field("vec4", "cells_per_px", "2x2, cells per pixel to the right and down"),
    Field("vec4", "px_per_cell", "2x2, its inverse"),
    Field("float", "array_from_panel", "array height of a chief ray per panel height"),
    Field("vec2", "growth", "by which a pitch that varies does, over three"),
    Field("vec2", "hole_reach", "how far a hole reaches from its centre, in cells"),
    Field("float", "half_aperture", "half a hole's side, or its radius, in pitches"),
    Field("float", "barrier_scale", "what a panel point is multiplied with to find its owner"),
    Field("int", "round_holes", "1 if holes are circles"),
    Field("int", "barriers", "1 if walls divide the panel among the cells"),
)
# What shaders/include/lateral.glsl needs; zeros where all colours are magnified alike.
LATERAL_FIELDS = (
    Field("vec4", "magnified", "of each colour: magnification less 1, itself, crossing scale", 3),
    Field("vec4", "lens_axes_px", "of each eye: its axis in the viewport's raster", 2),
)
# Stands for "no edge": larger than any place in a cell, small enough to square.
_OPEN = 1.0e9
_ZEROS = {"vec2": np.zeros(2), "vec4": np.zeros(4)}


def viewport_values(rig: Rig) -> dict[str, Any]:
    """For ``VIEWPORT_FIELDS``."""
    left, right = viewport(rig, "left"), viewport(rig, "right")
    return {
        "panel_px": (rig.panel.width_px, rig.panel.height_px),
        "view_px": (left.width_px, left.height_px),
        "second_column": right.first_column,
    }


def subpixel_values(rig: Rig) -> dict[str, Any]:
    """For ``SUBPIXEL_FIELDS``."""
    emission = layout(rig.panel.subpixels)
    return {"emitting": padded(emission.rectangles, _BOXES), "gain": (*emission.gain, 0.0)}


def subpixel_defines(rig: Rig) -> dict[str, int]:
    """For ``include/period.glsl``."""
    columns, rows = layout(rig.panel.subpixels).period
    return {"PERIOD_X": columns, "PERIOD_Y": rows}


def lattice_values(rig: Rig, lattice: Lattice | None) -> dict[str, Any]:
    """For ``LATTICE_FIELDS``; zeros without an array."""
    if lattice is None:
        return {field.name: _ZEROS.get(str(field.kind), 0) for field in LATTICE_FIELDS}
    return {
        "cells_per_px": cells_per_pixel(rig, lattice).ravel(),
        "px_per_cell": pixels_per_cell(rig, lattice).ravel(),
        "array_from_panel": bench_of(rig).array_from_panel,
        "growth": lattice.growth / 3.0,
        "hole_reach": np.minimum(lattice.hole_reach, _OPEN),
        "half_aperture": min(lattice.half_aperture, _OPEN),
        "barrier_scale": lattice.barrier_scale,
        "round_holes": int(lattice.round_holes),
        "barriers": int(lattice.barriers != "none"),
    }


def lattice_defines(lattice: Lattice | None) -> dict[str, int]:
    """For ``include/lattice.glsl``."""
    return {
        "HEXAGONAL": int(lattice is not None and lattice.is_hexagonal),
        "VARYING": int(lattice is not None and lattice.is_varying),
    }


def lateral_values(rig: Rig, magnifications: Sequence[float]) -> dict[str, Any]:
    """For ``LATERAL_FIELDS``.

    Parameters
    ----------
    magnifications : three floats
        By which each colour's places are multiplied.
    """
    if not is_lateral(rig):
        return {"magnified": np.zeros((3, 4)), "lens_axes_px": np.zeros((2, 4))}
    benches = colour_benches(rig)
    return {
        "magnified": [
            (scale - 1.0, scale, bench.array_from_panel, 0.0)
            for scale, bench in zip(magnifications, benches, strict=True)
        ],
        "lens_axes_px": [
            (*axis_in_viewport_px(rig, viewport(rig, side)), 0.0, 0.0) for side in SIDES
        ],
    }


def raster_buffer(
    device: Device, rasters: Sequence[CellRaster | VaryingRaster], label: str
) -> Buffer:
    """Columns, then rows, of one raster after the other, as the shaders index them."""
    parts = [part for raster in rasters for part in (raster.columns, raster.rows)]
    return Buffer(device, np.concatenate(parts).astype(np.float32), label=label)


Shifts = Mapping[Side, Float]


def lattice_rasters(
    device: Device,
    rig: Rig,
    lattice: Lattice | None,
    shift_mm: Shifts | None = None,
) -> tuple[Buffer, Buffer]:
    """Cell coordinates of the chief rays' crossings at 589 nm, and of the barriers' owners."""
    crossings = [(bench_of(rig).array_from_panel, shift_mm)]
    return crossing_rasters(device, rig, lattice, crossings)


def crossing_rasters(
    device: Device,
    rig: Rig,
    lattice: Lattice | None,
    crossings: Sequence[tuple[float, Shifts | None]],
) -> tuple[Buffer, Buffer]:
    """Cell coordinates of crossings by several scales, and of the barriers' owners.

    Parameters
    ----------
    crossings : sequence of (float, dict or None)
        Scale and shift as ``cell_raster`` takes them: one for all colours, or one for each.
    """
    if lattice is None:
        nothing = np.zeros((1, 4), np.float32)
        return (
            Buffer(device, nothing, label="no crossings"),
            Buffer(device, nothing, label="no owners"),
        )
    make = varying_raster if lattice.is_varying else cell_raster
    rasters = [make(rig, lattice, scale, shift_mm) for scale, shift_mm in crossings]
    owners = make(rig, lattice, lattice.barrier_scale)
    return (
        raster_buffer(device, rasters, "crossings"),
        raster_buffer(device, [owners], "owners"),
    )


def padded(rows: Any, count: int) -> NDArray[np.float64]:
    """As an array of vec4 in a block holds them, the rest 0; shape (count, 4)."""
    values = np.zeros((count, 4))
    given = np.asarray(rows)
    if len(given):
        values[: given.shape[0], : given.shape[1]] = given
    return values


def vec2_rows(values: Float) -> NDArray[np.float32]:
    """A (n, 2) table as the shaders read it."""
    return np.ascontiguousarray(values, dtype=np.float32)
