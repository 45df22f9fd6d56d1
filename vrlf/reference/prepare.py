"""Float64 twin of ``shaders/prepare.comp``: each eye's picture fitted into its viewport."""

from __future__ import annotations

import numpy as np

from vrlf.images import srgb_decode
from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.distortion import coefficients_of, seen_slopes
from vrlf.optics.fitting import Fit
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import SIDES, Viewport, axis_in_viewport_px, pitch_mm, viewport


def prepare(
    pictures: tuple[Float, Float], fits: tuple[Fit, Fit], rig: Rig, *, encoded: bool = False
) -> Float:
    """The target on the panel's raster.

    Parameters
    ----------
    pictures : two ndarrays (h, w, 3)
        The left and the right eye's picture.
    fits : two Fit
        How each lies in its viewport.
    encoded : bool
        Whether the pictures are sRGB encoded; else they are linear.

    Returns
    -------
    ndarray, shape (H, W, 3)
        Linear light in [0, 1]; black where no picture lies.
    """
    target = np.zeros((rig.panel.height_px, rig.panel.width_px, 3))
    for side, picture, fit in zip(SIDES, pictures, fits, strict=True):
        view = viewport(rig, side)
        linear = srgb_decode(picture) if encoded else picture.astype(np.float64)
        source = (_seen_places(rig, view) - fit.start_px) * fit.source_px
        target[:, view.columns] = _filtered(linear, source, fit)
    return target


def _seen_places(rig: Rig, view: Viewport) -> Float:
    """Where in the viewport's raster the content of each pixel stands, (H, w, 2).

    The lens shows slope r at r (1 + k1 r^2 + k2 r^4); the content for a pixel is what should
    be seen there.
    """
    columns, rows = np.arange(view.width_px) + 0.5, np.arange(view.height_px) + 0.5
    place = np.stack(np.meshgrid(columns, rows), axis=-1)
    if rig.headset.distortion is None:
        return place
    axis = axis_in_viewport_px(rig, view)
    px_per_slope = bench_of(rig).panel_per_slope_mm / pitch_mm(rig)
    slopes = seen_slopes((place - axis) / px_per_slope, coefficients_of(rig))
    return np.asarray(axis + slopes * px_per_slope)


def cubic(x: Float) -> Float:
    """Keys 1981, cubic convolution with a = -1/2."""
    x = np.abs(x)
    near = (1.5 * x - 2.5) * x**2 + 1.0
    far = ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0
    return np.where(x < 1.0, near, np.where(x < 2.0, far, 0.0))


def _filtered(picture: Float, source: Float, fit: Fit) -> Float:
    """The picture at places of it, over the area that one target pixel covers."""
    height, width = picture.shape[:2]
    widen = np.maximum(fit.source_px, 1.0)
    inside = np.all((source >= 0.0) & (source < [width, height]), axis=-1)
    total, weight = np.zeros((*source.shape[:2], 3)), np.zeros(source.shape[:2])
    first = np.ceil(source - 0.5 - 2.0 * widen).astype(int)
    for row_step in range(int(4.0 * widen[1]) + 2):
        for column_step in range(int(4.0 * widen[0]) + 2):
            column, row = first[..., 0] + column_step, first[..., 1] + row_step
            here = (column >= 0) & (column < width) & (row >= 0) & (row < height)
            w = here * cubic((column + 0.5 - source[..., 0]) / widen[0])
            w = w * cubic((row + 0.5 - source[..., 1]) / widen[1])
            at = picture[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
            total += w[..., None] * at
            weight += w
    mean = np.divide(total, weight[..., None], out=np.zeros_like(total), where=inside[..., None])
    return np.clip(mean, 0.0, 1.0)
