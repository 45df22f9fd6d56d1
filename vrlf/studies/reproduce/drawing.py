"""Pictures in memory: plots by matplotlib, and sheets of pictures pixel by pixel.

A panel image's pixels must not be resampled, or the picture shows moire of its own; sheets
repeat whole pixels.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from vrlf.images import draw_text, quantise_srgb, resize_nearest, srgb_encode, text_size
from vrlf.renderer import Image

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Colours that the colour-blind tell apart (Okabe & Ito 2008).
BLACK, BLUE, RED, GREEN, PINK, YELLOW, SKY = (
    "#000000",
    "#0072b2",
    "#d55e00",
    "#009e73",
    "#cc79a7",
    "#e69f00",
    "#56b4e9",
)
_DOTS_PER_INCH: Final = 110
_MARGIN_PX: Final = 24
_GAP_PX: Final = 16
_TITLE_PX, _TEXT_PX = 30, 20
_PAPER = 0.012
_INK = (0.85, 0.85, 0.85)
_QUIET = (0.5, 0.5, 0.5)
# A cell narrower than this leaves no room for words.
_LEAST_CELL_PX: Final = 300


def blank_figure(width_inches: float, height_inches: float) -> Figure:
    """An empty figure that lays itself out."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width_inches, height_inches), layout="constrained")


def figure_png(figure: Figure) -> bytes:
    """A figure as a PNG."""
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=_DOTS_PER_INCH)
    return drawn.getvalue()


@dataclass(frozen=True)
class Cell:
    """One picture of a sheet, linear light (h, w, 3), and the words above and below it."""

    heading: str
    light: Image
    note: str = ""


def sheet_png(title: str, rows: Sequence[Sequence[Cell]], *, enlarge: int = 1) -> bytes:
    """Pictures in rows, each with its heading; every pixel is drawn ``enlarge`` times both ways."""
    drawn = [_row(row, enlarge) for row in rows]
    width = max(row.shape[1] for row in drawn)
    heading = wrapped(title, width, _TITLE_PX)
    top = _MARGIN_PX + len(heading) * _line_px(_TITLE_PX) + _GAP_PX
    height = top + sum(row.shape[0] + _GAP_PX for row in drawn) + _MARGIN_PX
    sheet = np.full((height, width + 2 * _MARGIN_PX, 3), _PAPER, np.float32)
    _write(sheet, heading, _MARGIN_PX, _MARGIN_PX, _TITLE_PX, _INK)
    for row in drawn:
        sheet[top : top + row.shape[0], _MARGIN_PX : _MARGIN_PX + row.shape[1]] = row
        top += row.shape[0] + _GAP_PX
    return codes_png(quantise_srgb(sheet))


def codes_png(codes: np.ndarray) -> bytes:
    """8-bit sRGB (H, W, 3) as a PNG."""
    from matplotlib.image import imsave

    drawn = io.BytesIO()
    imsave(drawn, codes, format="png")
    return drawn.getvalue()


def _row(cells: Sequence[Cell], enlarge: int) -> Image:
    pictures = [resize_nearest(np.clip(cell.light, 0.0, 1.0), enlarge) for cell in cells]
    widths = [max(_LEAST_CELL_PX, picture.shape[1]) for picture in pictures]
    heads = [wrapped(c.heading, w, _TEXT_PX) for c, w in zip(cells, widths, strict=True)]
    notes = [wrapped(c.note, w, _TEXT_PX) for c, w in zip(cells, widths, strict=True)]
    line = _line_px(_TEXT_PX)
    top = max(map(len, heads)) * line
    bottom = top + max(picture.shape[0] for picture in pictures) + 4
    height = bottom + max(map(len, notes)) * line
    row = np.full((height, sum(widths) + _GAP_PX * (len(cells) - 1), 3), _PAPER, np.float32)
    x = 0
    for picture, width, head, note in zip(pictures, widths, heads, notes, strict=True):
        _write(row, head, x, 0, _TEXT_PX, _INK)
        row[top : top + picture.shape[0], x : x + picture.shape[1]] = picture
        _write(row, note, x, bottom, _TEXT_PX, _QUIET)
        x += width + _GAP_PX
    return row


def wrapped(text: str, width_px: int, size_px: int) -> list[str]:
    """Lines of whole words no wider than ``width_px``; none of an empty text."""
    lines: list[str] = []
    for word in text.split():
        joined = f"{lines[-1]} {word}" if lines else word
        if lines and text_size(joined, size_px)[0] <= width_px:
            lines[-1] = joined
        else:
            lines.append(word)
    return lines


def _line_px(size_px: int) -> int:
    return text_size("X", size_px)[1] + 4


def _write(
    sheet: Image, lines: list[str], x: int, y: int, size_px: int, color: tuple[float, float, float]
) -> None:
    for number, line in enumerate(lines):
        draw_text(sheet, line, x, y + number * _line_px(size_px), size_px=size_px, color=color)


def shown(light: Image) -> np.ndarray:
    """Linear light as matplotlib draws it, sRGB from 0 to 1."""
    return np.asarray(srgb_encode(np.clip(light, 0.0, 1.0)))
