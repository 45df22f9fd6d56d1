"""The one door to the charts: checks what was asked for and picks who draws it."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable
from types import MappingProxyType
from typing import Final, get_args

from vrlf.content.charts.grid import draw_grid
from vrlf.content.charts.logmar import draw_logmar
from vrlf.content.charts.marks import draw_marks
from vrlf.content.charts.model import Chart, Eye, Viewport
from vrlf.content.charts.points import draw_points
from vrlf.content.charts.siemens import draw_siemens
from vrlf.content.charts.usaf1951 import draw_usaf1951
from vrlf.errors import InputError

# Below this no chart has room for its smallest sign.
MIN_SIDE_PX: Final = 40
# The largest texture that every OpenGL 4.5 driver must take.
MAX_SIDE_PX: Final = 16384
# Beyond these a degree is less than a tenth of a pixel or wider than any panel.
MIN_PIXELS_PER_DEGREE: Final = 0.1
MAX_PIXELS_PER_DEGREE: Final = 1.0e5

_CHARTS: Final = MappingProxyType[str, Callable[[Viewport], Chart]](
    {
        "logmar": draw_logmar,
        "usaf1951": draw_usaf1951,
        "siemens": draw_siemens,
        "grid": draw_grid,
        "points": draw_points,
        "marks": draw_marks,
    }
)

CHART_NAMES: Final[tuple[str, ...]] = tuple(_CHARTS)


def draw_chart(
    name: str, *, width_px: int, height_px: int, pixels_per_degree: float, eye: Eye
) -> Chart:
    """Draw one chart for one viewport.

    Parameters
    ----------
    name : str
        One of ``CHART_NAMES``.
    width_px, height_px : int
        Size of the viewport, 40 to 16384 pixels a side.
    pixels_per_degree : float
        Pixels a degree of the visual field, on the axis.
    eye : {"left", "right"}
        The eye that the viewport belongs to; ``marks`` shows its letter. All other
        charts are the same for both eyes, so that the two pictures fuse.

    Returns
    -------
    Chart
        The picture (height, width, 3) and what to know about it. The same
        arguments give the same bytes.

    Raises
    ------
    InputError
        For an unknown name, a viewport too small or too large, or a value that
        means nothing.
    """
    viewport = Viewport(
        width_px=_side(name, "width_px", width_px),
        height_px=_side(name, "height_px", height_px),
        pixels_per_degree=_pixels_per_degree(name, pixels_per_degree),
        eye=_eye(name, eye),
    )
    return _painter(name)(viewport)


def _painter(name: str) -> Callable[[Viewport], Chart]:
    try:
        return _CHARTS[name]
    except (KeyError, TypeError):
        close = difflib.get_close_matches(str(name).lower(), CHART_NAMES, n=1, cutoff=0.5)
        hint = f"; did you mean {close[0]!r}?" if close else ""
        raise InputError(
            f"chart: found {name!r}, wanted one of {', '.join(CHART_NAMES)}{hint}"
        ) from None


def _side(name: str, key: str, found: int) -> int:
    whole = isinstance(found, int) and not isinstance(found, bool)
    if not whole or not MIN_SIDE_PX <= found <= MAX_SIDE_PX:
        raise InputError(
            f"chart {name}: {key}: found {found!r}, "
            f"wanted a whole number from {MIN_SIDE_PX} to {MAX_SIDE_PX}"
        )
    return found


def _pixels_per_degree(name: str, found: float) -> float:
    number = isinstance(found, int | float) and math.isfinite(found)
    if not number or not MIN_PIXELS_PER_DEGREE <= found <= MAX_PIXELS_PER_DEGREE:
        raise InputError(
            f"chart {name}: pixels_per_degree: found {found!r}, wanted a number "
            f"from {MIN_PIXELS_PER_DEGREE:g} to {MAX_PIXELS_PER_DEGREE:g}"
        )
    return float(found)


def _eye(name: str, found: Eye) -> Eye:
    if found not in get_args(Eye):
        raise InputError(f"chart {name}: eye: found {found!r}, wanted left or right")
    return found
