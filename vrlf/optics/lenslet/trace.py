"""Exact rays through a lenslet: Snell's law in vectors, many rays at once, and their paths.

Coordinates are the surface's own: its vertex is the origin, z points to the panel. A ray that
misses a surface, is reflected totally or leaves the lenslet's cell is *blocked*, not dropped.
Intersections after Welford 1986, *Aberrations of Optical Systems*, sec. 4.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from vrlf.optics.lenslet.paraxial import cardinal, system_matrix
from vrlf.optics.lenslet.surfaces import AIR, Lens, Surface
from vrlf.optics.polynomial import Float

# Rays aimed at the very rim do not miss it by rounding.
_RIM = 1.0 + 1e-9


@dataclass(frozen=True)
class Rays:
    """Rays at a surface.

    Attributes
    ----------
    points_mm, directions : ndarray (n, 3)
        Places and unit vectors.
    path_mm : ndarray (n,)
        Optical path from the object, but for a constant.
    open : ndarray of bool (n,)
        False for rays that were blocked; their numbers mean nothing.
    """

    points_mm: Float
    directions: Float
    path_mm: Float
    open: NDArray[np.bool_]


@dataclass(frozen=True)
class Beam:
    """Light of one wavelength from one object point.

    Attributes
    ----------
    slope : (float, float)
        Of the ray through the front principal point: to the panel point (gap times slope),
        right and up, in the thin lens's view.
    object_mm : float
        How far before that point the object is: infinite, or negative where the light converges
        to a point behind the lens.
    """

    wavelength_nm: float
    slope: tuple[float, float] = (0.0, 0.0)
    object_mm: float = inf


def aperture_points(lens: Lens, side: int) -> Float:
    """Points that fill the aperture evenly, each for one area; shape (n, 2)."""
    places = (np.arange(side) + 0.5) / side - 0.5
    points = np.stack(np.meshgrid(places, places), axis=-1).reshape(-1, 2)
    if not lens.square:
        points = points[np.hypot(points[:, 0], points[:, 1]) <= 0.5]
    return points * lens.aperture_mm


@dataclass(frozen=True)
class Passage:
    """Rays at one surface, in its own coordinates: as they come and as they leave it."""

    surface: Surface
    before: float
    behind: float
    coming: Rays
    leaving: Rays


def vergence_per_mm(lens: Lens, beam: Beam) -> float:
    """1 / the object's distance before the first vertex; 0 for light from infinity."""
    if beam.object_mm == inf:
        return 0.0
    return 1.0 / (beam.object_mm - cardinal(lens, beam.wavelength_nm).front_principal_mm)


def launch(lens: Lens, beam: Beam, at_stop_mm: Float) -> Rays:
    """Rays from the object on the first vertex's plane, aimed paraxially at points of the stop."""
    per_height = vergence_per_mm(lens, beam)
    front_mm = cardinal(lens, beam.wavelength_nm).front_principal_mm
    own = np.array(beam.slope) * (1.0 + per_height * front_mm)
    (a, b), _ = system_matrix(lens, beam.wavelength_nm, lens.stop)
    # At the stop, a p + b u with the slope u = p / s + own of a ray from p.
    start = (at_stop_mm - b * own) / (a + b * per_height)
    slopes = per_height * start + own
    steps = np.concatenate([slopes, np.ones((len(slopes), 1))], axis=1)
    length = np.linalg.norm(steps, axis=1)
    directions = steps / length[:, None]
    if per_height == 0.0:
        path = np.sum(start * directions[:, :2], axis=1)
    else:
        path = (length - 1.0) / per_height  # but for the constant: from the object's plane
    points = np.concatenate([start, np.zeros((len(start), 1))], axis=1)
    return Rays(points, directions, path, np.ones(len(start), bool))


def passages(lens: Lens, beam: Beam, at_stop_mm: Float) -> Iterator[Passage]:
    """Rays from surface to surface."""
    rays = launch(lens, beam, at_stop_mm)
    before = AIR.index_at(beam.wavelength_nm)
    for surface in lens.surfaces:
        behind = surface.medium.index_at(beam.wavelength_nm)
        leaving = _refracted(lens, surface, rays, before, behind)
        yield Passage(surface, before, behind, rays, leaving)
        shift = np.array([0.0, 0.0, surface.thickness_mm])
        rays = replace(leaving, points_mm=leaving.points_mm - shift)
        before = behind


def trace(lens: Lens, beam: Beam, at_stop_mm: Float) -> Rays:
    """Rays behind the last surface; places from its vertex."""
    *_, last = passages(lens, beam, at_stop_mm)
    return last.leaving


def landing(rays: Rays, distance_mm: float, index: float) -> Rays:
    """The rays on a plane ``distance_mm`` behind the last vertex, in a medium of ``index``."""
    way = (distance_mm - rays.points_mm[:, 2]) / rays.directions[:, 2]
    points = rays.points_mm + way[:, None] * rays.directions
    return Rays(points, rays.directions, rays.path_mm + index * way, rays.open)


def _refracted(lens: Lens, surface: Surface, rays: Rays, before: float, behind: float) -> Rays:
    points, way, meets = _met(surface, rays)
    is_open = rays.open & meets & _within(lens, surface, points)
    c, k = surface.curvature_per_mm, surface.conic
    normal = np.stack(
        [-c * points[:, 0], -c * points[:, 1], 1.0 - c * (1.0 + k) * points[:, 2]], axis=1
    )
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    ratio = before / behind
    cos_in = np.sum(rays.directions * normal, axis=1)
    square = 1.0 - ratio**2 * (1.0 - cos_in**2)
    cos_out = np.sqrt(np.maximum(square, 0.0))
    turned = ratio * rays.directions + (cos_out - ratio * cos_in)[:, None] * normal
    is_open &= square >= 0.0
    # What is blocked goes on along the axis, where nothing fails.
    points, turned = (
        np.where(is_open[:, None], value, instead)
        for value, instead in ((points, np.zeros(3)), (turned, np.array([0.0, 0.0, 1.0])))
    )
    return Rays(points, turned, rays.path_mm + before * np.where(is_open, way, 0.0), is_open)


def _met(surface: Surface, rays: Rays) -> tuple[Float, Float, NDArray[np.bool_]]:
    """Where rays meet the surface near its vertex, how far that is, and whether they do.

    The least root of A s^2 - 2 B s + C = 0 on the vertex's sheet, from c (x^2 + y^2 + (1 + k)
    z^2) = 2 z along the ray from where it meets z = 0.
    """
    flat = -rays.points_mm[:, 2] / rays.directions[:, 2]
    start = rays.points_mm + flat[:, None] * rays.directions
    c = surface.curvature_per_mm
    along = rays.directions[:, 2]
    a = c * (1.0 + surface.conic * along**2)
    b = along - c * np.sum(start[:, :2] * rays.directions[:, :2], axis=1)
    rest = c * np.sum(start[:, :2] ** 2, axis=1)
    root = b**2 - a * rest
    meets = (root >= 0.0) & (b > 0.0)
    way = np.divide(rest, b + np.sqrt(np.maximum(root, 0.0)), out=np.zeros_like(b), where=meets)
    return start + way[:, None] * rays.directions, flat + way, meets


def _within(lens: Lens, surface: Surface, points: Float) -> NDArray[np.bool_]:
    if surface.curvature_per_mm == 0.0:
        return np.ones(len(points), bool)
    half = _RIM * lens.aperture_mm / 2.0
    if lens.square:
        return np.asarray(np.abs(points[:, :2]).max(axis=1) <= half)
    return np.asarray(np.hypot(points[:, 0], points[:, 1]) <= half)
