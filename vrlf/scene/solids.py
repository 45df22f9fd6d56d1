"""Surfaces with a material: quads, boxes, pages, turned pots, tapered tubes.

Each builder gives ``(vertices, triangles)``: an array of ``SURFACE`` and indices of shape
(T, 3), anticlockwise from the front. ``place`` runs in metres along the surface, so that
every material has its true scale.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

Float = NDArray[np.float64]
Solid = tuple[NDArray[np.void], NDArray[np.int64]]

SURFACE = np.dtype(
    [
        ("in_position", "f4", 3),
        ("in_normal", "f4", 3),
        ("in_place", "f4", 2),
        ("in_material", "f4"),
    ]
)


class Material(IntEnum):
    """What a surface is made of; the numbers stand in shaders/scene/materials.glsl too."""

    LAWN = 0
    BRICK = 1
    PLASTER = 2
    WOOD = 3
    PAPER = 4
    BARK = 5
    CLAY = 6
    GLASS = 7
    CLOTH = 8
    STONE = 9


def merge(solids: Iterable[Solid]) -> Solid:
    """One solid of many."""
    parts = list(solids)
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in parts[:-1]])
    triangles = [t + start for (_, t), start in zip(parts, starts, strict=True)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(triangles)


def patch(points: Float, normals: Float, places: Float, material: Material) -> Solid:
    """A grid of points, shape (rows, columns, 3), as two triangles a cell.

    The front is where columns run right and rows run up.
    """
    rows, columns = points.shape[:2]
    vertices = np.zeros(rows * columns, SURFACE)
    vertices["in_position"] = points.reshape(-1, 3)
    vertices["in_normal"] = normals.reshape(-1, 3)
    vertices["in_place"] = places.reshape(-1, 2)
    vertices["in_material"] = material
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)[None, :]).ravel()
    right, up = corner + 1, corner + columns
    lower = np.stack([corner, right, up + 1], axis=-1)
    upper = np.stack([corner, up + 1, up], axis=-1)
    return vertices, np.concatenate([lower, upper])


def quad(
    corner: ArrayLike,
    right: ArrayLike,
    up: ArrayLike,
    material: Material,
    *,
    place: tuple[float, float] = (0.0, 0.0),
) -> Solid:
    """A parallelogram from its lower left corner; ``place`` is what that corner shows."""
    a, u, v = (np.asarray(each, np.float64) for each in (corner, right, up))
    points = np.array([[a, a + u], [a + v, a + u + v]])
    facing = np.cross(u, v)
    normals = np.broadcast_to(facing / np.linalg.norm(facing), (2, 2, 3))
    width, height = np.linalg.norm(u), np.linalg.norm(v)
    steps = np.array([[[0.0, 0.0], [width, 0.0]], [[0.0, height], [width, height]]])
    return patch(points, normals, steps + np.asarray(place), material)


def box(low: Sequence[float], high: Sequence[float], material: Material) -> Solid:
    """A box along the axes: its front, back, right, left, top and bottom."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    w, h, d = x1 - x0, y1 - y0, z1 - z0
    return merge(
        [
            quad((x0, y0, z1), (w, 0, 0), (0, h, 0), material),
            quad((x1, y0, z0), (-w, 0, 0), (0, h, 0), material),
            quad((x1, y0, z1), (0, 0, -d), (0, h, 0), material),
            quad((x0, y0, z0), (0, 0, d), (0, h, 0), material),
            quad((x0, y1, z1), (w, 0, 0), (0, 0, -d), material),
            quad((x0, y0, z0), (w, 0, 0), (0, 0, d), material),
        ]
    )


def page(
    corner: ArrayLike,
    right: ArrayLike,
    up: ArrayLike,
    *,
    first_texel_m: tuple[float, float],
    bulge: Float,
) -> Solid:
    """A sheet with print, bulging by ``bulge`` metres off its plane, column by column.

    Parameters
    ----------
    corner, right, up
        As for `quad`.
    first_texel_m : (x, y)
        Where the sheet's *upper* left corner lies in the print, whose rows run down.
    bulge : ndarray, shape (C,)
        At equal steps from the left edge to the right one.
    """
    a, u, v = (np.asarray(each, np.float64) for each in (corner, right, up))
    facing = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
    width, height = float(np.linalg.norm(u)), float(np.linalg.norm(v))
    steps = np.linspace(0.0, 1.0, len(bulge))
    row = a + steps[:, None] * u + bulge[:, None] * facing
    tilt = np.gradient(bulge, steps * width)
    normal = facing - tilt[:, None] * (u / width)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    x = first_texel_m[0] + steps * width
    low = np.stack([x, np.full_like(x, first_texel_m[1] + height)], axis=-1)
    high = np.stack([x, np.full_like(x, first_texel_m[1])], axis=-1)
    return patch(
        np.stack([row, row + v]), np.stack([normal, normal]), np.stack([low, high]), Material.PAPER
    )


def turned(centre: ArrayLike, profile: ArrayLike, material: Material, *, around: int = 40) -> Solid:
    """A body turned about the vertical through ``centre``.

    Parameters
    ----------
    profile : array_like, shape (P, 2)
        Radius and height, from the bottom up along the outside.
    """
    radius, height = np.asarray(profile, np.float64).T
    angle = np.linspace(0.0, 2.0 * np.pi, around + 1)
    circle = np.stack([np.cos(angle), np.zeros_like(angle), -np.sin(angle)], axis=-1)
    up = np.array([0.0, 1.0, 0.0])
    points = np.asarray(centre) + radius[:, None, None] * circle + height[:, None, None] * up
    run = np.hypot(np.gradient(radius), np.gradient(height))
    out, rise = np.gradient(height) / run, -np.gradient(radius) / run
    normals = out[:, None, None] * circle + rise[:, None, None] * up
    along = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(radius), np.diff(height)))])
    places = np.stack(np.broadcast_arrays(radius.max() * angle, along[:, None]), axis=-1)
    return patch(points, normals, places, material)


def tube(points: ArrayLike, radii: ArrayLike, material: Material, *, around: int = 9) -> Solid:
    """A tapered tube along a line of points, shape (P, 3), open at both ends."""
    line, radius = np.asarray(points, np.float64), np.asarray(radii, np.float64)
    along = np.gradient(line, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    # Any direction that is far from the line's serves as a start for its frame.
    start = np.eye(3)[np.argmin(np.abs(along).max(axis=0))]
    side = np.cross(along, start)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    third = np.cross(along, side)
    angle = np.linspace(0.0, 2.0 * np.pi, around + 1)
    ring = np.cos(angle)[:, None] * side[:, None, :] + np.sin(angle)[:, None] * third[:, None, :]
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    places = np.stack(np.broadcast_arrays(radius.max() * angle, length[:, None]), axis=-1)
    return patch(line[:, None, :] + radius[:, None, None] * ring, ring, places, material)
