"""How a picture lies in a viewport: as large as it can be, undistorted, centred."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vrlf.optics.viewport import Viewport

FitMode = Literal["contain", "cover"]


@dataclass(frozen=True)
class Fit:
    """Where a picture's upper left corner lies, and its scale.

    Attributes
    ----------
    start_px : (x, y)
        In the viewport's raster, right and down.
    source_px : (x, y)
        Picture pixels for each target pixel.
    """

    start_px: tuple[float, float]
    source_px: tuple[float, float]


def fit_picture(
    size_px: tuple[int, int], pixel_aspect: float, view: Viewport, mode: FitMode = "contain"
) -> Fit:
    """Fit a picture of ``size_px`` (width, height) into a viewport.

    Parameters
    ----------
    pixel_aspect : float
        Seen width of a picture's pixel over its seen height.
    mode : "contain" or "cover"
        All of the picture, with black beside it, or all of the viewport, the picture cut.
    """
    seen = (size_px[0] * pixel_aspect, float(size_px[1]))
    ratios = (view.width_px / seen[0], view.height_px / seen[1])
    scale = min(ratios) if mode == "contain" else max(ratios)
    width, height = seen[0] * scale, seen[1] * scale
    return Fit(
        start_px=((view.width_px - width) / 2.0, (view.height_px - height) / 2.0),
        source_px=(size_px[0] / width, size_px[1] / height),
    )
