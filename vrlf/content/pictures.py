"""Stereo pictures from files: which part of which file belongs to which eye."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from vrlf.errors import ImageReadError
from vrlf.files import shown
from vrlf.images import Encoding, read_picture

Layout = Literal["mono", "side-by-side", "half-side-by-side", "over-under", "half-over-under"]
Pixels = TypeVar("Pixels", bound=np.generic)

# Seen width of a source pixel over its seen height: a half layout has squeezed
# each eye's picture to half its width or height.
PIXEL_ASPECT: Final[dict[Layout, float]] = {
    "mono": 1.0,
    "side-by-side": 1.0,
    "half-side-by-side": 2.0,
    "over-under": 1.0,
    "half-over-under": 0.5,
}

# What video players and stereo cameras call their files.
_NAME_HINTS: Final[dict[str, Layout]] = {
    "sbs": "side-by-side",
    "lr": "side-by-side",
    "hsbs": "half-side-by-side",
    "ou": "over-under",
    "tb": "over-under",
    "hou": "half-over-under",
    "htb": "half-over-under",
}
_HINT_IN_NAME: Final = re.compile(rf"_({'|'.join(_NAME_HINTS)})(?=$|[-_. ])", re.IGNORECASE)

# Wider than any single picture (cinema is 2.39), narrower than two of 4:3 (2.67).
_STEREO_ASPECT: Final = 2.4


@dataclass(frozen=True)
class StereoSource:
    """A picture for each eye, linear light.

    Attributes
    ----------
    left, right : ndarray of float32, shape (H, W, 3)
        Each eye's own picture, upright; one and the same array for a mono source.
    layout : str
        The layout that was taken, never ``auto``.
    pixel_for_pixel : bool
        Each eye's picture has the raster of its viewport and needs no scaling.
    pixel_aspect : float
        Seen width of a source pixel over its seen height.
    panel : ndarray of float32, shape (H, W, 3), or None
        The whole picture where it has exactly the panel's size: a bare panel shows it as it
        is, the middle column of an odd width too.
    """

    left: NDArray[np.float32]
    right: NDArray[np.float32]
    layout: Layout
    pixel_for_pixel: bool
    pixel_aspect: float
    panel: NDArray[np.float32] | None = None


def load_stereo(
    path: str | os.PathLike[str],
    *,
    panel_size: tuple[int, int],
    layout: Layout | Literal["auto"] = "auto",
    cross_eyed: bool = False,
    encoding: Encoding = "auto",
    right_path: str | os.PathLike[str] | None = None,
) -> StereoSource:
    """Read a picture, or one for each eye, and split it between the eyes.

    ``auto`` takes a picture of exactly the panel's size as what the two
    viewports show; else it believes a hint in the file's name (``_sbs``,
    ``_hsbs``, ``_lr``, ``_ou``, ``_tb``, ``_hou``, ``_htb``, or the ending
    ``.jps``, whose right eye comes first); else it takes what is wider than
    2.4 : 1 as side by side, and all the rest as mono.

    Parameters
    ----------
    path : path
        The picture; the left eye's, if there are two.
    panel_size : tuple of int
        Width and height of the panel in pixels.
    layout : str
        ``auto`` or one of the `Layout` names. A middle column or row that two halves
        leave over is nobody's.
    cross_eyed : bool
        The right eye's picture comes first. (For a ``.jps`` whose left eye comes
        first, name the layout.)
    encoding : {"auto", "srgb", "linear"}
        As for `vrlf.images.read_picture`.
    right_path : path, optional
        A file of its own for the right eye; ``layout`` must then be ``auto`` or ``mono``.

    Returns
    -------
    StereoSource
        One picture for each eye.

    Raises
    ------
    ImageReadError
        A file cannot be read, is too small to be split, or does not fit the other.
    """
    first = read_picture(path, encoding=encoding)
    whole = first if right_path is None and first.shape[1::-1] == panel_size else None
    if right_path is not None:
        taken: Layout = "mono"
        second = _read_second(path, right_path, first, layout, encoding)
    else:
        if layout == "auto":
            taken, swapped = guess_layout(Path(path), first.shape, panel_size)
            cross_eyed = cross_eyed or swapped
        else:
            taken = layout
        first, second = halves(first, taken, shown(path))
    left, right = (second, first) if cross_eyed else (first, second)
    aspect = PIXEL_ASPECT[taken]
    viewport_shape = (panel_size[1], panel_size[0] // 2)
    return StereoSource(
        left=left,
        right=right,
        layout=taken,
        pixel_for_pixel=aspect == 1.0 and left.shape[:2] == viewport_shape,
        pixel_aspect=aspect,
        panel=whole if taken == "side-by-side" and not cross_eyed else None,
    )


def guess_layout(
    path: Path, shape: tuple[int, ...], panel_size: tuple[int, int] | None
) -> tuple[Layout, bool]:
    """The layout, and whether the right eye's picture comes first."""
    height, width = shape[:2]
    if (width, height) == panel_size:
        return "side-by-side", False
    if path.suffix.lower() == ".jps":  # a stereo JPEG is made for the crossed-eye view
        return "side-by-side", True
    hints = _HINT_IN_NAME.findall(path.stem)
    if hints:
        return _NAME_HINTS[hints[-1].lower()], False
    return ("side-by-side" if width > _STEREO_ASPECT * height else "mono"), False


def halves(
    picture: NDArray[Pixels], layout: Layout, name: str
) -> tuple[NDArray[Pixels], NDArray[Pixels]]:
    """The first and the second eye's picture; a mono picture stands for both."""
    if layout == "mono":
        return picture, picture
    height, width = picture.shape[:2]
    upright = layout in ("over-under", "half-over-under")
    if (height if upright else width) < 2:
        raise ImageReadError(
            f"{name}: found {width}x{height} pixels, wanted at least 2 "
            f"{'rows' if upright else 'columns'} for the layout {layout}"
        )
    if upright:
        half = height // 2
        return picture[:half].copy(), picture[height - half :].copy()
    return split_viewports(picture)


def _read_second(
    path: str | os.PathLike[str],
    right_path: str | os.PathLike[str],
    first: NDArray[np.float32],
    layout: str,
    encoding: Encoding,
) -> NDArray[np.float32]:
    if layout not in ("auto", "mono"):
        raise ImageReadError(
            f"{shown(right_path)}: found a second file with the layout {layout}, "
            "wanted the layout mono, one picture a file"
        )
    second = read_picture(right_path, encoding=encoding)
    if second.shape != first.shape:
        (height, width), (height_1, width_1) = second.shape[:2], first.shape[:2]
        raise ImageReadError(
            f"{shown(right_path)}: found {width}x{height} pixels, "
            f"wanted {width_1}x{height_1} like {shown(path)}"
        )
    return second


def split_viewports(panel: NDArray[Pixels]) -> tuple[NDArray[Pixels], NDArray[Pixels]]:
    """Cut a panel image into the two eyes' viewports.

    Parameters
    ----------
    panel : ndarray, shape (H, W) or (H, W, C)
        Row 0 at the top.

    Returns
    -------
    left, right : ndarray, shape (H, W // 2) or (H, W // 2, C)
        Copies. A middle column of an odd width is in neither.
    """
    width = panel.shape[1]
    half = width // 2
    return panel[:, :half].copy(), panel[:, width - half :].copy()


def join_viewports(
    left: NDArray[Pixels], right: NDArray[Pixels], panel_size: tuple[int, int]
) -> NDArray[Pixels]:
    """Lay the two eyes' viewports side by side on the panel.

    Parameters
    ----------
    left, right : ndarray, shape (H, W // 2) or (H, W // 2, C)
        What the viewports show.
    panel_size : tuple of int
        Width W and height H of the panel in pixels.

    Returns
    -------
    ndarray, shape (H, W) or (H, W, C)
        The panel image; a middle column of an odd width is dark.

    Raises
    ------
    ValueError
        A picture has not the raster of its viewport.
    """
    width, height = panel_size
    half = width // 2
    for name, picture in (("left", left), ("right", right)):
        if picture.shape[:2] != (height, half) or picture.shape != left.shape:
            raise ValueError(
                f"{name} viewport: found the shape {picture.shape}, wanted ({height}, {half}, ...)"
            )
    panel: NDArray[Any] = np.zeros((height, width, *left.shape[2:]), left.dtype)
    panel[:, :half] = left
    panel[:, width - half :] = right
    return panel
