"""Plain pupil sampling with the design's equations: what perception means, in float64.

Twin of ``shaders/perceive.comp`` where it samples blindly, and what all of it converges to.

Every pupil point is traced for every retinal pixel in millimetres, step by step; nothing is
precomputed, binned or skipped.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vrlf.model import Rig
from vrlf.optics import lattice as cells
from vrlf.optics.bench import Bench
from vrlf.optics.eye import EyeOptics, aberration_at, eye_optics
from vrlf.optics.lattice import Lattice, lattice_of
from vrlf.optics.polynomial import Float
from vrlf.optics.samples import (
    footprint_pixels,
    footprint_scale,
    pupil_points,
    uses_area_means,
)
from vrlf.optics.subpixels import layout
from vrlf.optics.viewport import (
    SIDES,
    Side,
    Viewport,
    axis_in_viewport_px,
    panel_points_mm,
    pitch_mm,
    viewport,
)

Bool = NDArray[np.bool_]
Pixels = NDArray[np.int_]
Hit = tuple[Pixels, Float]


@dataclass(frozen=True)
class Landing:
    """Where one pupil point's rays meet array and panel, for every pixel of a viewport.

    Attributes
    ----------
    array_mm, panel_mm : ndarray (H, w, 2)
        Points relative to the optical axis.
    in_cell : ndarray (H, w, 2)
        Place in the cell, in cell coordinates; zero without an array.
    off_centre : ndarray (H, w, 2)
        The same as an even place, which is another where the pitch varies.
    cell : ndarray (H, w, 2)
        The cell's number.
    """

    array_mm: Float
    panel_mm: Float
    in_cell: Float
    off_centre: Float
    cell: Float


def trace(
    bench: Bench, lattice: Lattice | None, view: Viewport, x_mm: Float, u_mm: Float, slope: Float
) -> Landing:
    """Backward rays from retinal points ``x_mm`` through the pupil at ``u_mm``.

    ``slope`` is the eye's transverse aberration there. Steps and names are the design's.
    """
    # Leave the eye, pass the headset lens.
    alpha = x_mm / bench.retina_per_slope_mm + slope
    h = u_mm + bench.relief_mm * alpha
    beta = alpha - bench.lens_power_per_mm * h
    # Meet the array.
    y = h + bench.lens_to_array_mm * beta
    if lattice is None:
        zero = np.zeros_like(y)
        return Landing(y, y + bench.reduced_gap_mm * beta, zero, zero, zero)
    axis = np.array(view.axis_mm)
    q = cells.cell_coordinates(lattice, y + axis)
    cell = cells.nearest_cell(lattice, q)
    # Be bent by the lenslet (or not, in a hole) and cross the gap.
    from_centre_mm = y + axis - cells.cells_mm(lattice, cell)
    x = y + bench.reduced_gap_mm * beta - bench.bend * from_centre_mm
    off_centre = from_centre_mm @ lattice.cell_from_panel.T
    return Landing(y, x, q - cell, off_centre, cell)


def perceive(panel: Float, rig: Rig, rays: int) -> Float:
    """What both eyes see of a panel, side by side on the panel's raster.

    Parameters
    ----------
    panel : ndarray (H, W, 3)
        Linear light.
    rig : Rig
    rays : int
        Rays that are let through, for each retinal pixel.

    Returns
    -------
    ndarray, shape (H, W, 3)
        Linear light, no exposure applied; a middle column of an odd width is dark.
    """
    seen = np.zeros(panel.shape)
    for side in SIDES:
        view = viewport(rig, side)
        optics = eye_optics(rig, side)
        half = panel[:, view.columns].astype(np.float64)
        for colour in range(3):
            if colour == 0 or optics.is_chromatic:
                perceived = _one_path(half, rig, view, optics, colour, rays)
            seen[:, view.columns, colour] = perceived[..., colour]
    return seen


def _one_path(
    half: Float, rig: Rig, view: Viewport, optics: EyeOptics, colour: int, rays: int
) -> Float:
    """The view of one eye if all colours took the path of ``colour``."""
    gather = Gather(rig, view, optics.benches[colour])
    at = pupil_points(rig, optics, rays)
    slopes = aberration_at(optics.aberration[colour], at.from_centre_mm)
    total = np.zeros(half.shape)
    for u_mm, slope, within_mm in zip(at.u_mm, slopes, at.within_pixel_mm, strict=True):
        for pixel, weight in gather.hits(u_mm, slope, within_mm):
            total += weight * texels(half, pixel)
    return total / len(slopes)


class Gather:
    """Which panel pixels one pupil point shows to each pixel of a viewport, and how much."""

    def __init__(self, rig: Rig, view: Viewport, bench: Bench) -> None:
        self._view, self._bench, self._lattice = view, bench, lattice_of(rig)
        self._emission = layout(rig.panel.subpixels)
        self._pitch_mm = pitch_mm(rig)
        self._x_mm = panel_points_mm(rig, view)
        self._area_means = uses_area_means(self._bench, self._lattice)
        self._kappa = abs(footprint_scale(self._bench, self._lattice))
        self._pixels = footprint_pixels(self._bench, self._lattice)
        self._axis_px = axis_in_viewport_px(rig, view)

    def hits(self, u_mm: Float, slope: Float, within_mm: Float) -> list[Hit]:
        """What one pupil point shows: panel pixels (column, row) and weights of each colour.

        Returns
        -------
        list of (pixel, weight)
            ndarrays (H, w, 2) of int and (H, w, 3); the light is the sum of weight times the
            pixel's light, where the pixel lies in the viewport.
        """
        if not self._area_means:
            return [self._sampled(u_mm, slope, within_mm)]
        centre = trace(self._bench, self._lattice, self._view, self._x_mm, u_mm, slope)
        if self._lattice is None:
            return self._over_area(centre)
        whole = self._is_whole(self._lattice, centre)[..., None]
        pixel, weight = self._sampled(u_mm, slope, within_mm)
        return [(p, w * whole) for p, w in self._over_area(centre)] + [(pixel, weight * ~whole)]

    def _sampled(self, u_mm: Float, slope: Float, within_mm: Float) -> Hit:
        """The hit from one point of each retinal pixel."""
        x_mm = self._x_mm + within_mm
        landing = trace(self._bench, self._lattice, self._view, x_mm, u_mm, slope)
        passes = np.ones(landing.cell.shape[:2], dtype=bool)
        if self._lattice is not None:
            passes = cells.is_open(self._lattice, landing.off_centre)
            passes &= self.in_own_area(self._lattice, landing)
        pixel, weight = self.emitting(self.raster(landing))
        return pixel, weight * passes[..., None]

    def raster(self, landing: Landing) -> Float:
        """Panel points in the viewport's pixels, right and down from its corner."""
        return np.asarray(landing.panel_mm / self._pitch_mm * [1.0, -1.0] + self._axis_px)

    def _barrier_coordinates(self, lattice: Lattice, landing: Landing) -> Float:
        """Cell coordinates of the panel points as the barriers divide them."""
        owned = lattice.barrier_scale * landing.panel_mm + np.array(self._view.axis_mm)
        return cells.cell_coordinates(lattice, owned)

    def in_own_area(self, lattice: Lattice, landing: Landing) -> Bool:
        """Whether no barrier stands between a cell and the panel point reached through it."""
        if lattice.barriers == "none":
            return np.ones(landing.cell.shape[:2], dtype=bool)
        owner = cells.nearest_cell(lattice, self._barrier_coordinates(lattice, landing))
        return np.asarray(np.all(owner == landing.cell, axis=-1))

    def _is_whole(self, lattice: Lattice, landing: Landing) -> Bool:
        """Whether all rays of a retinal pixel pass one lenslet and no barrier cuts them."""
        # How far a pixel's corners are from its middle, toward each border of a cell.
        normals = lattice.normals
        spread = np.abs(normals @ lattice.cell_from_panel).sum(axis=1) * self._pitch_mm / 2.0
        spread = spread / lattice.least_pitch
        at_array = spread * self._bench.array_from_retina
        whole = np.all(np.abs(landing.in_cell @ normals.T) <= 0.5 - at_array, axis=-1)
        if lattice.barriers != "none":
            off = (self._barrier_coordinates(lattice, landing) - landing.cell) @ normals.T
            most = 0.5 - spread * lattice.barrier_scale * self._kappa
            whole &= np.all(np.abs(off) <= most, axis=-1)
        return np.asarray(whole)

    def emitting(self, raster: Float) -> Hit:
        """The pixel at each point, and whether and how strongly its colours emit there."""
        pixel = np.floor(raster)
        place = (raster - pixel)[..., None, :]
        boxes = self._boxes(pixel.astype(int))
        lit = np.all((place >= boxes[..., :2]) & (place < boxes[..., 2:]), axis=-1)
        return pixel.astype(int), lit * self._emission.gain

    def _boxes(self, pixel: Pixels) -> Float:
        """The emitting areas of a viewport's pixels; their place on the panel counts."""
        return self._emission.at(pixel[..., 0] + self._view.first_column, pixel[..., 1])

    def _over_area(self, landing: Landing) -> list[Hit]:
        """The means over the square of side kappa about each point, pixel by pixel."""
        # A square of no size is a point; the floor keeps the quotient finite.
        side = max(self._kappa, 1e-3)
        low = self.raster(landing) - side / 2.0
        hits = []
        for step in np.ndindex(self._pixels, self._pixels):
            pixel = np.floor(low) + step
            boxes = self._boxes(pixel.astype(int))
            start = np.clip(low - pixel, 0.0, 1.0)[..., None, :]
            end = np.clip(low + side - pixel, 0.0, 1.0)[..., None, :]
            shared = np.minimum(end, boxes[..., 2:]) - np.maximum(start, boxes[..., :2])
            area = np.prod(np.maximum(shared, 0.0), axis=-1) / side**2
            hits.append((pixel.astype(int), area * self._emission.gain))
        return hits


def texels(half: Float, pixel: Pixels) -> Float:
    """A viewport's light at pixels (column, row), black outside."""
    height, width = half.shape[:2]
    column, row = pixel[..., 0], pixel[..., 1]
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    value = half[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
    return np.asarray(value * inside[..., None])


def landing_points(rig: Rig, side: Side, rays: int, point: int) -> Landing:
    """Where the ``point``-th pupil point's rays land, from the pixels' centres; for tests."""
    view, optics = viewport(rig, side), eye_optics(rig, side)
    at = pupil_points(rig, optics, rays)
    slope = aberration_at(optics.aberration[0], at.from_centre_mm[point])
    x_mm = panel_points_mm(rig, view)
    return trace(optics.benches[0], lattice_of(rig), view, x_mm, at.u_mm[point], slope)
