"""Panoramas from files: the whole world around, for both eyes one or over-under for each."""

from __future__ import annotations

import os
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vrlf.errors import ImageReadError
from vrlf.files import shown
from vrlf.images import Encoding, read_picture

World = NDArray[np.float32]
WorldLayout = Literal["auto", "mono", "over-under"]


def load_panorama(
    path: str | os.PathLike[str],
    *,
    layout: str = "auto",
    encoding: Encoding = "auto",
) -> tuple[World, World]:
    """Read an equirectangular picture of 360 by 180 degrees.

    Parameters
    ----------
    path : path
    layout : str
        ``mono``, twice as wide as high; ``over-under``, as wide as high, the left eye's world
        above the right one's; ``auto`` goes by the shape.

    Returns
    -------
    left, right : ndarray of float32, shape (H, 2 H, 3)
        Linear light; one and the same array for mono.

    Raises
    ------
    ImageReadError
        It cannot be read, or has another shape.
    """
    if layout not in ("auto", "mono", "over-under"):
        raise ImageReadError(
            f"{shown(path)}: found the layout {layout} for a panorama, "
            "wanted auto, mono or over-under"
        )
    world = read_picture(path, encoding=encoding)
    height, width = world.shape[:2]
    if layout != "over-under" and width == 2 * height:
        return world, world
    if layout != "mono" and width == height and height % 2 == 0:
        return world[: height // 2], world[height // 2 :]
    shapes = {"auto": "2:1, or 1:1 for over-under", "mono": "2:1", "over-under": "1:1, even"}
    raise ImageReadError(
        f"{shown(path)}: found {width}x{height} pixels, wanted {shapes[layout]} for a panorama"
    )
