"""The forward prefilter by the design's equations, in float64.

Twin of ``shaders/forward.comp`` and, for bare panels, of ``shaders/register.comp``.

Each sample is traced in millimetres through the centre of its lenslet, step by step.
"""

from __future__ import annotations

import numpy as np

from vrlf.model import Rig
from vrlf.optics import lattice as cells
from vrlf.optics.bench import Bench, bench_of, is_lateral
from vrlf.optics.eye import EyeOptics, aberration_at, eye_optics
from vrlf.optics.lattice import Lattice, lattice_of
from vrlf.optics.polynomial import Float
from vrlf.optics.subpixels import layout
from vrlf.optics.viewport import (
    SIDES,
    Viewport,
    axis_in_viewport_px,
    panel_points_mm,
    pitch_mm,
    viewport,
)


def forward(target: Float, rig: Rig) -> Float:
    """The panel image that the forward prefilter shows for a target.

    Parameters
    ----------
    target : ndarray (H, W, 3)
        What the eyes should perceive, linear light, on the panel's raster.

    Returns
    -------
    ndarray, shape (H, W, 3)
        Linear light; without an array the target itself, but for colours that the headset's lens
        magnifies differently.
    """
    lattice = lattice_of(rig)
    if lattice is None:
        return _registered(target, rig)
    shown = np.zeros(target.shape)
    for side in SIDES:
        view = viewport(rig, side)
        half = target[:, view.columns].astype(np.float64)
        optics = eye_optics(rig, side)
        for colour in range(3):
            shown[:, view.columns, colour] = _colour(
                half[..., colour], rig, lattice, view, optics, colour
            )
    return shown


def _registered(target: Float, rig: Rig) -> Float:
    """A bare panel: twin of ``shaders/register.comp``, by each colour's chief ray."""
    if not is_lateral(rig):
        return np.array(target, dtype=np.float64)
    shown, named = np.zeros(target.shape), bench_of(rig)
    for side in SIDES:
        view, optics = viewport(rig, side), eye_optics(rig, side)
        half = target[:, view.columns].astype(np.float64)
        o, x_mm = np.array(optics.pupil_offset_mm), panel_points_mm(rig, view)
        for colour, bench in enumerate(optics.benches):
            # The slope at which the pixel is seen, and the pixel of 589 nm that is seen there.
            alpha = (x_mm - o * bench.defocus_factor) / bench.panel_per_slope_mm
            seen_mm = alpha * named.panel_per_slope_mm + o * named.defocus_factor
            shown[:, view.columns, colour] = read_target(half[..., colour], seen_mm, rig, view)
    return shown


def _colour(
    half: Float, rig: Rig, lattice: Lattice, view: Viewport, optics: EyeOptics, colour: int
) -> Float:
    """One colour's sub-pixels of a viewport."""
    grid = rig.prefilter.subpixel_grid
    columns, rows = np.arange(half.shape[1]), np.arange(half.shape[0])[:, None]
    boxes = layout(rig.panel.subpixels).at(columns + view.first_column, rows)[..., colour, :]
    left, top, right, bottom = np.moveaxis(boxes, -1, 0)
    light, met = np.zeros(half.shape), np.zeros(half.shape)
    centres_mm = panel_points_mm(rig, view)
    for row, column in np.ndindex(grid, grid):
        # The sample's place in its pixel, from the centre, y up.
        place = np.stack(
            [
                left + (column + 0.5) / grid * (right - left) - 0.5,
                0.5 - top - (row + 0.5) / grid * (bottom - top),
            ],
            axis=-1,
        )
        x_mm = centres_mm + place * pitch_mm(rig)
        seen_mm, meets = retinal_points(x_mm, optics.benches[colour], lattice, view, optics, colour)
        light += meets * read_target(half, seen_mm, rig, view)
        met += meets
    # What a pixel lacks stays dark.
    return np.divide(light, met, out=np.zeros_like(light), where=(met > 0) & (right > left))


def retinal_points(
    x_mm: Float, bench: Bench, lattice: Lattice, view: Viewport, optics: EyeOptics, colour: int
) -> tuple[Float, Float]:
    """Where panel points are seen through the one lenslet that serves them.

    Parameters
    ----------
    x_mm : ndarray (..., 2)
        Panel points relative to the axis.

    Returns
    -------
    X : ndarray (..., 2)
        Retinal points, as panel points relative to the axis.
    meets : ndarray (...)
        1 where the ray meets the pupil and no barrier, else 0.
    """
    axis = np.array(view.axis_mm)
    offset = np.array(optics.pupil_offset_mm)
    # The ray from x to the pupil's centre chooses the lenslet.
    chief = (x_mm * bench.array_per_slope_mm + bench.reduced_gap_mm * offset) / (
        bench.panel_per_slope_mm
    )
    cell = cells.nearest_cell(lattice, cells.cell_coordinates(lattice, chief + axis))
    c = cells.cells_mm(lattice, cell) - axis
    # The ray through that lenslet's centre is not bent there.
    beta = (x_mm - c) / bench.reduced_gap_mm
    h = c - bench.lens_to_array_mm * beta
    alpha = beta + bench.lens_power_per_mm * h
    u = h - bench.relief_mm * alpha
    from_centre = u - offset
    seen = bench.retina_per_slope_mm * (
        alpha - aberration_at(optics.aberration[colour], from_centre)
    )
    meets = np.sum(from_centre**2, axis=-1) <= (optics.pupil_mm / 2.0) ** 2
    # Converging walls follow the chief rays, one of which chose the lenslet: they cut none of
    # these rays. (With a moved pupil that is the rule of the design's known results.)
    if lattice.barriers == "perpendicular":
        owner = cells.cell_coordinates(lattice, lattice.barrier_scale * x_mm + axis)
        meets = meets & np.all(cells.nearest_cell(lattice, owner) == cell, axis=-1)
    return seen, meets.astype(np.float64)


def read_target(half: Float, x_mm: Float, rig: Rig, view: Viewport) -> Float:
    """Bilinear reads: the edge pixel goes on to the viewport's border, black beyond."""
    height, width = half.shape
    pitch = pitch_mm(rig)
    axis = axis_in_viewport_px(rig, view)
    column, row = axis[0] + x_mm[..., 0] / pitch, axis[1] - x_mm[..., 1] / pitch
    inside = (column >= 0.0) & (column <= width) & (row >= 0.0) & (row <= height)
    x0, y0 = np.floor(column - 0.5), np.floor(row - 0.5)
    fx, fy = column - 0.5 - x0, row - 0.5 - y0

    def texel(dx: int, dy: int) -> Float:
        i = np.clip(x0 + dx, 0, width - 1).astype(int)
        j = np.clip(y0 + dy, 0, height - 1).astype(int)
        return np.asarray(half[j, i])

    upper = texel(0, 0) * (1.0 - fx) + texel(1, 0) * fx
    lower = texel(0, 1) * (1.0 - fx) + texel(1, 1) * fx
    return np.asarray((upper * (1.0 - fy) + lower * fy) * inside)
