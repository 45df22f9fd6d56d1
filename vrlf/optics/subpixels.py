"""Where in a pixel each colour emits, and how strongly."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.model import SubpixelLayout, subpixel_layout
from vrlf.model.layouts import COLOURS
from vrlf.optics.polynomial import Float

# Of a colour that a pixel lacks: no area, so that nothing is ever inside.
_NOWHERE = (0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Layout:
    """A sub-pixel layout.

    The emission repeats over the panel with a period of 1 or 2 columns and rows; which place of
    it a pixel takes is decided by its column and row on the whole panel.

    Attributes
    ----------
    period : (columns, rows)
    rectangles : ndarray (3 columns rows, 4)
        Emitting areas: left, top, right, bottom, in pixels from the pixel's upper left corner.
        Red, green and blue of the period's first place, then of the others, by rows; of no size
        where a pixel lacks a colour.
    gain : ndarray (3,)
        Radiance that makes up for the area that a colour lacks over the period, so that a white
        field gives the same light in each colour whatever the layout.
    """

    period: tuple[int, int]
    rectangles: Float
    gain: Float

    @property
    def places(self) -> int:
        """Pixels of the period."""
        return self.period[0] * self.period[1]

    @property
    def is_shared(self) -> bool:
        """Whether all colours emit from the same areas."""
        boxes = self.rectangles.reshape(-1, 3, 4)
        return bool(np.all(boxes == boxes[:, :1]))

    @property
    def lit(self) -> Float:
        """The rectangles that have an area, (n, 4)."""
        return np.asarray(self.rectangles[self.rectangles[:, 2] > self.rectangles[:, 0]])

    def at(self, column: NDArray[Any] | int, row: NDArray[Any] | int) -> Float:
        """The rectangles of pixels of the panel, (..., 3, 4).

        Parameters
        ----------
        column, row : ndarray or int
            On the whole panel; beyond its borders too.
        """
        if self.places == 1:
            return self.rectangles
        columns, rows = self.period
        place = np.asarray(row) % rows * columns + np.asarray(column) % columns
        return np.asarray(self.rectangles.reshape(-1, 3, 4)[place])


@functools.cache
def layout(name: str) -> Layout:
    """The shipped layout of that name."""
    return layout_of(subpixel_layout(name))


def layout_of(given: SubpixelLayout) -> Layout:
    """What follows from a layout's file."""
    boxes = [getattr(pixel, colour) or _NOWHERE for pixel in given.pixels for colour in COLOURS]
    rectangles = np.array(boxes)
    area = (rectangles[:, 2] - rectangles[:, 0]) * (rectangles[:, 3] - rectangles[:, 1])
    rectangles.setflags(write=False)
    gain = len(given.pixels) / area.reshape(-1, 3).sum(axis=0)
    gain.setflags(write=False)
    return Layout((given.columns, given.rows), rectangles, gain)
