"""The demo's one picture: for each eye what is meant, shown, and seen, with a detail of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vrlf.images import draw_text, resize_nearest, text_size
from vrlf.optics.viewport import Viewport
from vrlf.renderer import Image

_MARGIN_PX = 32
_GAP_PX = 20
_LARGE_PX, _MIDDLE_PX, _SMALL_PX = 44, 28, 22
_PAPER = 0.012
_INK = (0.85, 0.85, 0.85)
_QUIET = (0.42, 0.42, 0.42)
_FRAME = (1.0, 0.55, 0.05)


@dataclass(frozen=True)
class Column:
    """One kind of picture: its heading, the whole panel's raster, and a line for each eye."""

    heading: str
    picture: Image
    notes: tuple[str, str]


@dataclass(frozen=True)
class Detail:
    """The part of each viewport that is magnified."""

    first_column: int
    first_row: int
    width_px: int
    height_px: int
    factor: int


def detail_for(view: Viewport, factor: int = 4) -> Detail:
    """A part that fills the viewport's width when magnified, from the middle of the picture."""
    width = view.width_px // factor
    height = max(1, min(view.height_px, width * 5 // 8))
    return Detail(
        first_column=(view.width_px - width) // 2,
        first_row=(view.height_px - height) // 2,
        width_px=width,
        height_px=height,
        factor=factor,
    )


def draw_sheet(
    title: str,
    subtitle: str,
    columns: list[Column],
    views: tuple[Viewport, Viewport],
    detail: Detail,
    pixels_per_degree: float,
    table: list[str],
) -> Image:
    """The whole sheet, linear light.

    Parameters
    ----------
    columns : list of Column
        From left to right.
    views : the left and the right eye's viewport
    table : list of str
        Lines at the foot.
    """
    view = views[0]
    band = _band_height(view, detail)
    head = _MARGIN_PX + _line(_LARGE_PX) + _line(_MIDDLE_PX) + _GAP_PX
    foot = _line(_MIDDLE_PX) * len(table) + _MARGIN_PX
    width = 2 * _MARGIN_PX + len(columns) * view.width_px + (len(columns) - 1) * _GAP_PX
    sheet = np.full((head + 2 * band + foot, width, 3), _PAPER, np.float32)
    draw_text(sheet, title, _MARGIN_PX, _MARGIN_PX, size_px=_LARGE_PX, color=_INK)
    below = _MARGIN_PX + _line(_LARGE_PX)
    draw_text(sheet, subtitle, _MARGIN_PX, below, size_px=_MIDDLE_PX, color=_QUIET)
    for eye, name in enumerate(("LEFT EYE", "RIGHT EYE")):
        for number, column in enumerate(columns):
            x = _MARGIN_PX + number * (view.width_px + _GAP_PX)
            heading = f"{name}   {column.heading}" if number == 0 else column.heading
            _draw_cell(
                sheet, column, heading, views[eye], detail, pixels_per_degree, eye, (x, head)
            )
        head += band
    for number, line in enumerate(table):
        y = head + number * _line(_MIDDLE_PX)
        draw_text(sheet, line, _MARGIN_PX, y, size_px=_MIDDLE_PX, color=_INK)
    return sheet


def _line(size_px: int) -> int:
    return text_size("X", size_px)[1] + 6


def _band_height(view: Viewport, detail: Detail) -> int:
    labels = _line(_MIDDLE_PX) + 2 * _line(_SMALL_PX)
    return labels + view.height_px + detail.height_px * detail.factor + 3 * _GAP_PX


def _draw_cell(
    sheet: Image,
    column: Column,
    heading: str,
    view: Viewport,
    detail: Detail,
    pixels_per_degree: float,
    eye: int,
    corner: tuple[int, int],
) -> None:
    """Heading, the viewport pixel for pixel, its note, the detail magnified, its scale."""
    x, y = corner
    draw_text(sheet, heading, x, y, size_px=_MIDDLE_PX, color=_INK)
    y += _line(_MIDDLE_PX)
    half = np.clip(column.picture[:, view.columns], 0.0, 1.0)
    framed = half.copy()
    _draw_frame(framed, detail)
    sheet[y : y + view.height_px, x : x + view.width_px] = framed
    _draw_scale(sheet, x, y + view.height_px - 14, 5.0, pixels_per_degree)
    y += view.height_px + 4
    draw_text(sheet, column.notes[eye], x, y, size_px=_SMALL_PX, color=_INK)
    y += _line(_SMALL_PX)
    rows = slice(detail.first_row, detail.first_row + detail.height_px)
    cut = half[rows, detail.first_column : detail.first_column + detail.width_px]
    large = resize_nearest(cut, detail.factor)
    sheet[y : y + large.shape[0], x : x + large.shape[1]] = large
    _draw_scale(sheet, x, y + large.shape[0] - 14, 1.0, pixels_per_degree * detail.factor)
    y += large.shape[0] + 4
    draw_text(
        sheet, f"the framed part, {detail.factor} times", x, y, size_px=_SMALL_PX, color=_QUIET
    )


def _draw_frame(picture: Image, detail: Detail) -> None:
    top, left = max(detail.first_row - 2, 0), max(detail.first_column - 2, 0)
    bottom = detail.first_row + detail.height_px + 2
    right = detail.first_column + detail.width_px + 2
    for rows, columns in (
        (slice(top, top + 2), slice(left, right)),
        (slice(bottom - 2, bottom), slice(left, right)),
        (slice(top, bottom), slice(left, left + 2)),
        (slice(top, bottom), slice(right - 2, right)),
    ):
        picture[rows, columns] = _FRAME


def _draw_scale(sheet: Image, x: int, y: int, degrees: float, pixels_per_degree: float) -> None:
    """A bar of so many degrees, white on black."""
    length = round(degrees * pixels_per_degree)
    sheet[y - 2 : y + 6, x + 10 : x + 14 + length] = 0.0
    sheet[y : y + 4, x + 12 : x + 12 + length] = 1.0
    label = f"{degrees:g} deg"
    width, height = text_size(label, _SMALL_PX)
    top = y - height - 4
    sheet[top : top + height, x + 10 : x + 14 + width] *= 0.25
    draw_text(sheet, label, x + 12, top, size_px=_SMALL_PX, color=(1.0, 1.0, 1.0))
