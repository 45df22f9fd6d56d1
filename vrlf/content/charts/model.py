"""What a chart is drawn for, and what comes out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

Image: TypeAlias = NDArray[np.float32]
Colour: TypeAlias = tuple[float, float, float]
Eye: TypeAlias = Literal["left", "right"]

BLACK: Colour = (0.0, 0.0, 0.0)
GREY: Colour = (0.5, 0.5, 0.5)
WHITE: Colour = (1.0, 1.0, 1.0)
RED: Colour = (1.0, 0.0, 0.0)
GREEN: Colour = (0.0, 1.0, 0.0)
BLUE: Colour = (0.0, 0.0, 1.0)
YELLOW: Colour = (1.0, 1.0, 0.0)


@dataclass(frozen=True)
class Viewport:
    """The half panel that one eye sees; its size has been checked."""

    width_px: int
    height_px: int
    pixels_per_degree: float
    eye: Eye

    @property
    def shorter_side_px(self) -> int:
        """The smaller of width and height."""
        return min(self.width_px, self.height_px)


@dataclass(frozen=True)
class LetterLine:
    """One line of an acuity chart.

    Attributes
    ----------
    logmar : float
        log10 of the stroke width in minutes of arc.
    decimal_acuity : float
        10 ** -logmar.
    letter_height_px : float
        Height and width of each letter.
    letters : str
        From left to right.
    y_px : int
        The row of the letters' upper edge.
    """

    logmar: float
    decimal_acuity: float
    letter_height_px: float
    letters: str
    y_px: int


@dataclass(frozen=True, eq=False)
class Chart:
    """A drawn chart.

    Attributes
    ----------
    image : ndarray of float32, shape (height, width, 3)
        Linear light in [0, 1], row 0 at the top; read-only.
    notes : tuple of str
        What a reader of the chart must know, one fact a line.
    lines : tuple of LetterLine
        The lines of an acuity chart, largest first; empty for every other chart.
    """

    image: Image
    notes: tuple[str, ...]
    lines: tuple[LetterLine, ...] = ()

    def __post_init__(self) -> None:
        self.image.flags.writeable = False
