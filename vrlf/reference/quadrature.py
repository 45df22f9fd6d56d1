"""Float64 twin of perception by lines and by holes' points (``vrlf/optics/quadrature.py``).

Plain: every line is cut, for every pixel, at whatever border of a cell, of an emitting area
or of a barrier's area it meets; between two cuts nothing changes, so the middle stands for
the piece. Every point of every hole is led back to the pupil. Rays are traced in millimetres
by the design's equations.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vrlf.model import Rig
from vrlf.optics.eye import EyeOptics, aberration_at, eye_optics
from vrlf.optics.holes import hole_points
from vrlf.optics.lattice import (
    Lattice,
    cell_coordinates,
    cells_mm,
    grown,
    lattice_of,
    nearest_cell,
)
from vrlf.optics.lines import Stretches, stretches
from vrlf.optics.polynomial import Float
from vrlf.optics.quadrature import quadrature_of
from vrlf.optics.subpixels import layout
from vrlf.optics.viewport import RASTER_FLIP, SIDES, Viewport, panel_points_mm, pitch_mm, viewport
from vrlf.reference.perceive import Gather, Landing, perceive, texels, trace


def perceive_well(panel: Float, rig: Rig, rays: int) -> Float:
    """What both eyes see of a panel, by the rays that the GPU traces; see ``perceive``."""
    kind = quadrature_of(rig, rays)
    if kind == "points":
        return perceive(panel, rig, rays)
    seen = np.zeros(panel.shape)
    for side in SIDES:
        view, optics = viewport(rig, side), eye_optics(rig, side)
        half = panel[:, view.columns].astype(np.float64)
        for colour in range(3):
            if colour == 0 or optics.is_chromatic:
                eye = _Eye.of(rig, view, optics, colour)
                light = _by_lines if kind == "lines" else _by_holes
                perceived = light(half, eye, rays)
            seen[:, view.columns, colour] = perceived[..., colour]
    return seen


@dataclass(frozen=True)
class _Eye:
    """One eye before its half of the panel, for the path of one colour."""

    rig: Rig
    view: Viewport
    optics: EyeOptics
    colour: int
    lattice: Lattice
    gather: Gather
    x_mm: Float

    @classmethod
    def of(cls, rig: Rig, view: Viewport, optics: EyeOptics, colour: int) -> _Eye:
        lattice = lattice_of(rig)
        assert lattice is not None
        gather = Gather(rig, view, optics.benches[colour])
        return cls(rig, view, optics, colour, lattice, gather, panel_points_mm(rig, view))

    def slope(self, from_centre_mm: Float) -> Float:
        return aberration_at(self.optics.aberration[self.colour], from_centre_mm)

    def traced(self, from_centre_mm: Float, slope: Float, within_mm: Float) -> Landing:
        """Where a ray of every pixel goes; the pupil point may differ from pixel to pixel."""
        u_mm = from_centre_mm + np.array(self.optics.pupil_offset_mm)
        x_mm = self.x_mm + within_mm
        bench = self.optics.benches[self.colour]
        return trace(bench, self.lattice, self.view, x_mm, u_mm, slope)

    def light(self, half: Float, landing: Landing) -> Float:
        """What the panel shows at the landings, black where a barrier stands in the way."""
        pixel, weight = self.gather.emitting(self.gather.raster(landing))
        owned = self.gather.in_own_area(self.lattice, landing)
        return np.asarray(texels(half, pixel) * weight * owned[..., None])


# Lines.


def _by_lines(half: Float, eye: _Eye, rays: int) -> Float:
    lines = stretches(eye.rig, eye.optics, eye.colour, rays, "all")
    total = np.zeros(half.shape)
    for index in range(len(lines.share)):
        if lines.share[index] > 0.0:
            total += lines.share[index] * _along(half, eye, lines, index)
    return total


def _along(half: Float, eye: _Eye, lines: Stretches, index: int) -> Float:
    """The mean light along one stretch, for every pixel."""
    ends_mm = eye.optics.weighed(lines.from_centre_mm[index])
    within_mm = lines.within_pixel_mm[index]
    slopes = eye.slope(ends_mm)

    def at(place: Float) -> Landing:
        def between(ends: Float) -> Float:
            return np.asarray(ends[0] + place[..., None] * (ends[1] - ends[0]))

        return eye.traced(between(ends_mm), between(slopes), between(within_mm))

    everywhere = np.zeros(half.shape[:2])
    begin, end = at(everywhere), at(everywhere + 1.0)
    borders = _borders(eye, _coordinates(eye, begin.array_mm), _coordinates(eye, end.array_mm))
    total = np.zeros(half.shape)
    for low, high in _between([borders]):
        middle = at((low + high) / 2.0)
        # Within one cell a landing moves evenly; led on to the stretch's own ends.
        steps = [_led_on(eye, middle, each) for each in (begin, end)]
        cuts = [borders, *_panel_cuts(eye, *steps)]
        for from_, to in _between(cuts, low, high):
            total += (to - from_)[..., None] * eye.light(half, at((from_ + to) / 2.0))
    return total


def _led_on(eye: _Eye, middle: Landing, end: Landing) -> Landing:
    """Where the ray at ``end`` would land if it passed the lenslet of ``middle``."""
    moved_mm = cells_mm(eye.lattice, middle.cell) - cells_mm(eye.lattice, end.cell)
    panel_mm = end.panel_mm + eye.optics.benches[eye.colour].bend * moved_mm
    return Landing(end.array_mm, panel_mm, end.in_cell, end.off_centre, middle.cell)


def _coordinates(eye: _Eye, y_mm: Float) -> Float:
    return cell_coordinates(eye.lattice, y_mm + np.array(eye.view.axis_mm))


def _panel_cuts(eye: _Eye, begin: Landing, end: Landing) -> Iterator[Float]:
    """Where emitting areas end, and the areas that barriers leave."""
    boxes = layout(eye.rig.panel.subpixels).lit
    first, last = (eye.gather.raster(each) for each in (begin, end))
    for axis in range(2):
        edges = tuple(float(edge) for edge in np.unique(boxes[:, [axis, axis + 2]] % 1.0))
        yield _crossings(first[..., axis : axis + 1], last[..., axis : axis + 1], edges)
    if eye.lattice.barriers != "none":
        scale = eye.lattice.barrier_scale
        ends = [_coordinates(eye, scale * each.panel_mm) for each in (begin, end)]
        yield _borders(eye, ends[0], ends[1])


def _borders(eye: _Eye, first: Float, last: Float) -> Float:
    """Where what moves from ``first`` to ``last``, in cells, may pass from cell to cell.

    A hexagon's borders stand on lines half a pitch apart, of which they cover a third.
    """
    if eye.lattice.is_varying:
        return _varying_borders(eye, first, last)
    normals = eye.lattice.normals
    edges = (0.0, 0.5) if eye.lattice.is_hexagonal else (0.5,)
    return _crossings(first @ normals.T, last @ normals.T, edges)


def _varying_borders(eye: _Eye, first: Float, last: Float) -> Float:
    """The same where the pitch varies: a way is straight in even places alone."""
    growth = eye.lattice.growth
    begin, end = grown(growth, first), grown(growth, last)
    step = np.where(end == begin, np.inf, end - begin)
    low = np.floor(np.minimum(first, last)) - 0.5
    found = []
    for number in range(int(np.ceil(np.abs(last - first).max())) + 3):
        place = (grown(growth, low + number) - begin) / step
        found.append(np.where((place > 0.0) & (place < 1.0), place, 1.0))
    return np.concatenate(found, axis=-1)


def _crossings(first: Float, last: Float, edges: tuple[float, ...]) -> Float:
    """Places in [0, 1] where what moves from ``first`` to ``last`` passes a whole number + edge.

    ``first`` and ``last`` are (H, w, k); the result is (H, w, n), 1 where there is none.
    """
    count = int(np.ceil(np.abs(last - first).max())) + 1
    step = np.where(last == first, np.inf, last - first)
    found = []
    for edge in edges:
        low = np.ceil(np.minimum(first, last) - edge) + edge
        for number in range(count):
            place = (low + number - first) / step
            found.append(np.where((place > 0.0) & (place < 1.0), place, 1.0))
    return np.concatenate(found, axis=-1)


def _between(
    cuts: list[Float], low: Float | float = 0.0, high: Float | float = 1.0
) -> Iterator[tuple[Float, Float]]:
    """Pieces between neighbouring cuts within [low, high], where any pixel has one."""
    places = np.concatenate(cuts, axis=-1)
    ends = [np.broadcast_to(each, places.shape[:2])[..., None] for each in (low, high)]
    places = np.sort(np.concatenate([np.clip(places, *ends), *ends], axis=-1), axis=-1)
    for index in range(places.shape[-1] - 1):
        from_, to = places[..., index], places[..., index + 1]
        if np.any(to > from_):
            yield from_, to


# Holes.


def _by_holes(half: Float, eye: _Eye, rays: int) -> Float:
    """Every point of every hole, led back to the pupil; those that meet it count."""
    points = _points_of_both_eyes(eye, rays)
    radius_mm = eye.optics.pupil_mm / 2.0
    map_mm = _array_per_pupil(eye)
    total = np.zeros(half.shape)
    for in_hole, within_px in zip(points[:, :2], points[:, 2:], strict=True):
        within_mm = RASTER_FLIP @ within_px * pitch_mm(eye.rig)
        middle = eye.traced(np.zeros(2), eye.slope(np.zeros(2)), within_mm)
        for cell in _cells_about(eye, middle, map_mm):
            hole_mm = in_hole @ eye.lattice.panel_from_cell.T
            target_mm = cells_mm(eye.lattice, cell) + hole_mm
            off_mm = target_mm - np.array(eye.view.axis_mm) - middle.array_mm
            u_mm = off_mm @ np.linalg.inv(map_mm).T
            meets = np.hypot(u_mm[..., 0], u_mm[..., 1]) <= radius_mm
            if meets.any():
                landing = eye.traced(u_mm, eye.slope(u_mm), within_mm)
                total += meets[..., None] * eye.light(half, landing)
    area_cells = abs(np.linalg.det(eye.lattice.cell_from_panel @ map_mm)) * np.pi * radius_mm**2
    return np.asarray(total * eye.lattice.opening / area_cells / len(points))


def _points_of_both_eyes(eye: _Eye, rays: int) -> Float:
    """The points of the eye that needs more."""
    both = [
        hole_points(eye.rig, eye.lattice, eye_optics(eye.rig, side), rays, "all") for side in SIDES
    ]
    return max(both, key=len)


def _array_per_pupil(eye: _Eye) -> Float:
    """Millimetres at the array per millimetre in the pupil, (2, 2): two rays less the middle's."""
    corner = [
        eye.traced(u, eye.slope(u), np.zeros(2)).array_mm[0, 0] for u in (np.zeros(2), *np.eye(2))
    ]
    return np.stack([corner[1] - corner[0], corner[2] - corner[0]], axis=-1)


def _cells_about(eye: _Eye, middle: Landing, map_mm: Float) -> Iterator[Float]:
    """For every pixel the cells whose holes the pupil may show, one of each in turn; (H, w, 2)."""
    nearest = nearest_cell(eye.lattice, _coordinates(eye, middle.array_mm))
    extent = np.linalg.norm(eye.lattice.cell_from_panel @ map_mm, axis=1)
    # From a cell's centre to its corner, and from another's to the end of its hole.
    beside = np.abs(eye.lattice.corners).max(axis=0) + eye.lattice.hole_reach
    even = extent * eye.optics.pupil_mm / 2.0 + beside
    reach = np.ceil(even / eye.lattice.least_pitch).astype(int)
    for column in range(-reach[0], reach[0] + 1):
        for row in range(-reach[1], reach[1] + 1):
            yield nearest + np.array([column, row])
