"""Float64 twin of ``shaders/scene/panorama.comp``: the world all around from a picture."""

from __future__ import annotations

import numpy as np

from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.distortion import coefficients_of, seen_slopes
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import SIDES, Viewport, axis_in_viewport_px, pitch_mm, viewport


def panorama(worlds: tuple[Float, Float], rig: Rig, axes: Float, samples: int) -> Float:
    """The target on the panel's raster.

    Parameters
    ----------
    worlds : two ndarrays (h, 2 h, 3)
        The left and the right eye's picture, equirectangular, linear.
    axes : ndarray (3, 3)
        The head's right, up and back in the world, as rows.
    samples : int
        A side, within each pixel.

    Returns
    -------
    ndarray, shape (H, W, 3)
    """
    target = np.zeros((rig.panel.height_px, rig.panel.width_px, 3))
    for side, world in zip(SIDES, worlds, strict=True):
        view = viewport(rig, side)
        total = np.zeros((view.height_px, view.width_px, 3))
        for row in range(samples):
            for column in range(samples):
                within = ((column + 0.5) / samples, (row + 0.5) / samples)
                slopes = _seen_slopes(rig, view, within)
                directions = slopes @ axes[:2] - axes[2]
                total += _bilinear(world, _places(directions, world.shape[1::-1]))
        target[:, view.columns] = np.clip(total / samples**2, 0.0, 1.0)
    return target


def _seen_slopes(rig: Rig, view: Viewport, within: tuple[float, float]) -> Float:
    """Slopes right and up at which the lens shows a place within each pixel, (H, w, 2)."""
    columns, rows = np.arange(view.width_px) + within[0], np.arange(view.height_px) + within[1]
    place = np.stack(np.meshgrid(columns, rows), axis=-1) - axis_in_viewport_px(rig, view)
    slope = place * pitch_mm(rig) / bench_of(rig).panel_per_slope_mm * [1.0, -1.0]
    return seen_slopes(slope, coefficients_of(rig))


def _places(directions: Float, size: tuple[int, ...]) -> Float:
    """Snyder 1987, 12, plate carree."""
    x, y, z = np.moveaxis(directions, -1, 0)
    longitude, latitude = np.arctan2(x, -z), np.arctan2(y, np.hypot(x, z))
    across, down = longitude / (2.0 * np.pi) + 0.5, 0.5 - latitude / np.pi
    return np.stack([across * size[0], down * size[1]], axis=-1)


def _bilinear(world: Float, places: Float) -> Float:
    corner = np.floor(places - 0.5).astype(int)
    part = places - 0.5 - corner
    total = np.zeros((*places.shape[:2], 3))
    for right in (0, 1):
        for down in (0, 1):
            weight = np.abs(1 - right - part[..., 0]) * np.abs(1 - down - part[..., 1])
            total += weight[..., None] * _round(
                world, corner[..., 0] + right, corner[..., 1] + down
            )
    return total


def _round(world: Float, column: Float, row: Float) -> Float:
    """Texels, round the world: beyond a pole lies the other side's meridian."""
    height, width = world.shape[:2]
    beyond = (row < 0) | (row >= height)
    row = np.where(row < 0, -1 - row, np.where(row >= height, 2 * height - 1 - row, row))
    column = np.where(beyond, column + width // 2, column) % width
    return np.asarray(world[row, column], np.float64)
