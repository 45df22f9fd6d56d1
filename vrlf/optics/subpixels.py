"""Where in a pixel each colour emits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vrlf.errors import InputError
from vrlf.optics.polynomial import Float

_FULL = (0.0, 0.0, 1.0, 1.0)
_THIRDS = tuple((k / 3.0, 0.0, (k + 1) / 3.0, 1.0) for k in range(3))

# Name: the emitting rectangle of red, green and blue as (left, top, right, bottom) in pixels,
# x to the right and y downward from the pixel's upper left corner.
_RECTANGLES: dict[str, tuple[tuple[float, float, float, float], ...]] = {
    "full": (_FULL, _FULL, _FULL),
    "rgb-stripe": _THIRDS,
    "bgr-stripe": _THIRDS[::-1],
}


@dataclass(frozen=True)
class Layout:
    """A sub-pixel layout.

    Attributes
    ----------
    rectangles : ndarray (3, 4)
        Emitting area of each colour: left, top, right, bottom, in pixels.
    gain : ndarray (3,)
        Radiance that makes up for the area a colour lacks.
    """

    rectangles: Float
    gain: Float


def layout(name: str) -> Layout:
    """The layout of that name."""
    if name not in _RECTANGLES:
        raise InputError(f"panel.subpixels: found {name!r}, wanted one of {', '.join(_RECTANGLES)}")
    rectangles = np.array(_RECTANGLES[name])
    area = (rectangles[:, 2] - rectangles[:, 0]) * (rectangles[:, 3] - rectangles[:, 1])
    return Layout(rectangles, 1.0 / area)
