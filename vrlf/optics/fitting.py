"""How a picture lies in a viewport: as large as it can be, undistorted, centred."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vrlf.errors import InputError
from vrlf.optics.viewport import Viewport

FitMode = Literal["contain", "cover", "axis"]


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
    size_px: tuple[int, int],
    pixel_aspect: float,
    view: Viewport,
    mode: FitMode = "contain",
    axis_px: tuple[float, float] | None = None,
) -> Fit:
    """Fit a picture of ``size_px`` (width, height) into a viewport.

    Parameters
    ----------
    pixel_aspect : float
        Seen width of a picture's pixel over its seen height.
    mode : "contain", "cover" or "axis"
        All of the picture, with black beside it; all of the viewport, the picture cut; or all of
        the picture about the optical axis, so that both eyes see its middle straight ahead.
    axis_px : (x, y), optional
        The optical axis in the viewport's raster, for "axis".

    Raises
    ------
    InputError
        If the axis leaves no room for a picture about it.
    """
    whole = (float(view.width_px), float(view.height_px))
    centre, room = (whole[0] / 2.0, whole[1] / 2.0), whole
    if mode == "axis" and axis_px is not None:
        centre = axis_px
        room = _room_about(axis_px, whole)
    seen = (size_px[0] * pixel_aspect, float(size_px[1]))
    ratios = (room[0] / seen[0], room[1] / seen[1])
    scale = max(ratios) if mode == "cover" else min(ratios)
    width, height = seen[0] * scale, seen[1] * scale
    return Fit(
        start_px=(centre[0] - width / 2.0, centre[1] - height / 2.0),
        source_px=(size_px[0] / width, size_px[1] / height),
    )


def _room_about(axis_px: tuple[float, float], whole: tuple[float, float]) -> tuple[float, float]:
    """The largest box about the axis that the viewport holds."""
    x, y = (2.0 * min(at, size - at) for at, size in zip(axis_px, whole, strict=True))
    if min(x, y) < 2.0:
        raise InputError(
            f"fit: found 'axis' with the axis at {axis_px[0]:.0f}, {axis_px[1]:.0f} of a viewport "
            f"of {whole[0]:.0f}x{whole[1]:.0f} pixels, wanted it inside (or the fit 'contain')"
        )
    return x, y
