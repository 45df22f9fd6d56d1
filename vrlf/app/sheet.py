"""The demo's one picture: for each eye what is meant, shown, and seen, with a detail of each.

Small viewports are enlarged and huge ones averaged down, so that their text fits beside its
neighbours' and the whole can be looked at; what is still too long for its place is wrapped.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

from vrlf.images import draw_text, resize_area, resize_nearest, text_size
from vrlf.optics.viewport import Viewport
from vrlf.renderer import Image

_MARGIN_PX = 32
_GAP_PX = 20
_LARGE_PX, _MIDDLE_PX, _SMALL_PX = 44, 28, 22
_PAPER = 0.012
_INK = (0.85, 0.85, 0.85)
_WHITE = (1.0, 1.0, 1.0)
_QUIET = (0.42, 0.42, 0.42)
_FRAME = (1.0, 0.55, 0.05)

# A column narrower than this leaves no room for words; a viewport larger than that makes a
# sheet that no picture file holds.
_LEAST_CELL_PX = 480
_MOST_ENLARGED_PX = 2000
_MOST_SHOWN_PX = 3000
_DETAIL_FACTOR = 4
# The detail's width over that of the finest edge which makes it worth a look.
_EDGE_PARTS = 40
_SCALE_BARS_DEG = (5.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01)


@dataclass(frozen=True)
class Column:
    """One kind of picture: its heading, the whole panel's raster, and a line for each eye."""

    heading: str
    picture: Image
    notes: tuple[str, str]


@dataclass(frozen=True)
class _Plan:
    """How large everything is, in the sheet's pixels but for what is said to be the panel's.

    Attributes
    ----------
    enlarge, shrink : int
        Sheet pixels for each panel pixel, and panel pixels for each sheet pixel; one is 1.
    shown_px : (width, height)
        Of a viewport.
    detail_px : (width, height)
        Of the part that is magnified, panel pixels.
    heading_lines, note_lines : int
        What the longest heading and note come to.
    magnified : int
        Sheet pixels for each panel pixel of the detail.
    """

    cell_px: int
    enlarge: int
    shrink: int
    shown_px: tuple[int, int]
    detail_px: tuple[int, int]
    heading_lines: int
    note_lines: int
    magnified: int
    pixels_per_degree: float

    @property
    def band_px(self) -> int:
        """Height of all that belongs to one eye."""
        text = self.heading_lines * _line(_MIDDLE_PX) + (self.note_lines + 1) * _line(_SMALL_PX)
        return text + self.shown_px[1] + self.detail_px[1] * self.magnified + 3 * _GAP_PX


def draw_sheet(
    title: str,
    subtitle: str,
    columns: list[Column],
    views: tuple[Viewport, Viewport],
    pixels_per_degree: float,
    table: list[str],
) -> Image:
    """The whole sheet, linear light.

    Parameters
    ----------
    columns : list of Column
        From left to right. The first one's picture says which part is worth magnifying.
    views : the left and the right eye's viewport
        Of one size.
    pixels_per_degree : float
        Of the panel, on the axis.
    table : list of str
        Lines at the foot; what they are indented by, their continuations are too.
    """
    plan = _plan_for(views[0], columns, pixels_per_degree)
    width = len(columns) * (plan.cell_px + _GAP_PX) - _GAP_PX
    if plan.enlarge > 1:
        subtitle += f"; each pixel is drawn {plan.enlarge} x {plan.enlarge}"
    heads = _wrapped(title, width, _LARGE_PX), _wrapped(subtitle, width, _MIDDLE_PX)
    foot = [part for line in table for part in _wrapped(line, width, _MIDDLE_PX)]
    below_title = _MARGIN_PX + len(heads[0]) * _line(_LARGE_PX)
    top = below_title + len(heads[1]) * _line(_MIDDLE_PX) + _GAP_PX
    bottom = top + 2 * plan.band_px
    height = bottom + len(foot) * _line(_MIDDLE_PX) + _MARGIN_PX
    sheet = np.full((height, width + 2 * _MARGIN_PX, 3), _PAPER, np.float32)
    _draw_lines(sheet, heads[0], _MARGIN_PX, _MARGIN_PX, _LARGE_PX, _INK)
    _draw_lines(sheet, heads[1], _MARGIN_PX, below_title, _MIDDLE_PX, _QUIET)
    for eye, view in enumerate(views):
        part = _busiest_part(columns[0].picture[:, view.columns], *plan.detail_px)
        for number, column in enumerate(columns):
            corner = (_MARGIN_PX + number * (plan.cell_px + _GAP_PX), top + eye * plan.band_px)
            half = np.clip(column.picture[:, view.columns], 0.0, 1.0)
            heading = _heading(column, eye, first=number == 0)
            _draw_cell(sheet, half, part, heading, column.notes[eye], plan, corner)
    _draw_lines(sheet, foot, _MARGIN_PX, bottom, _MIDDLE_PX, _INK)
    return sheet


def _plan_for(view: Viewport, columns: list[Column], pixels_per_degree: float) -> _Plan:
    width, height = view.width_px, view.height_px
    shrink = ceil(max(width, height, 1) / _MOST_SHOWN_PX)
    enlarge = max(1, min(ceil(_LEAST_CELL_PX / width), _MOST_ENLARGED_PX // height))
    shown = (max(1, width * enlarge // shrink), max(1, height * enlarge // shrink))
    cell = max(_LEAST_CELL_PX, shown[0])
    magnified = min(_DETAIL_FACTOR, width) * enlarge
    cut_width = shown[0] // magnified
    cut_height = max(1, min(height // shrink, cut_width * 5 // 8))
    headings = [_heading(c, eye, first=c is columns[0]) for c in columns for eye in (0, 1)]
    return _Plan(
        cell_px=cell,
        enlarge=enlarge,
        shrink=shrink,
        shown_px=shown,
        detail_px=(cut_width, cut_height),
        heading_lines=max(len(_wrapped(text, cell, _MIDDLE_PX)) for text in headings),
        note_lines=max(len(_wrapped(text, cell, _SMALL_PX)) for c in columns for text in c.notes),
        magnified=magnified,
        pixels_per_degree=pixels_per_degree,
    )


def _heading(column: Column, eye: int, *, first: bool) -> str:
    return f"{('LEFT EYE', 'RIGHT EYE')[eye]}, {column.heading}" if first else column.heading


def _line(size_px: int) -> int:
    return text_size("X", size_px)[1] + 6


def _wrapped(text: str, width_px: int, size_px: int) -> list[str]:
    """Lines no wider than ``width_px``; a word that is wider by itself is cut."""
    indent = text[: len(text) - len(text.lstrip())]
    lines = [indent]
    for word in text.split():
        joined = f"{lines[-1]} {word}" if lines[-1] != indent else indent + word
        if text_size(joined, size_px)[0] <= width_px:
            lines[-1] = joined
            continue
        if lines[-1] != indent:
            lines.append(indent)
        for letter in word:
            if lines[-1] != indent and text_size(lines[-1] + letter, size_px)[0] > width_px:
                lines.append(indent)
            lines[-1] += letter
    return lines


def _draw_lines(
    sheet: Image, lines: list[str], x: int, y: int, size_px: int, color: tuple[float, float, float]
) -> None:
    for number, line in enumerate(lines):
        draw_text(sheet, line, x, y + number * _line(size_px), size_px=size_px, color=color)


def _busiest_part(picture: Image, width: int, height: int) -> tuple[slice, slice]:
    """Rows and columns of the part with most edges: there a blur and its cure are seen best.

    Edges count after a little smoothing, so that they are such as an array can carry.
    """
    lightness = np.sqrt(np.clip(picture, 0.0, 1.0)).mean(axis=-1, dtype=np.float64)
    reach = max(1, min(width // _EDGE_PARTS, height // 4))
    means = _box_sums(lightness, reach, reach) / reach**2
    edges = np.zeros_like(lightness)
    rows, columns = means.shape[0] - reach, means.shape[1] - reach
    edges[: max(rows, 0), : means.shape[1]] += np.abs(means[reach:] - means[:-reach])
    edges[: means.shape[0], : max(columns, 0)] += np.abs(means[:, reach:] - means[:, :-reach])
    sums = _box_sums(edges, width, height)
    row, column = (int(n) for n in np.unravel_index(int(sums.argmax()), sums.shape))
    return slice(row, row + height), slice(column, column + width)


def _box_sums(values: NDArray[np.float64], width: int, height: int) -> NDArray[np.float64]:
    """Sum over the box of that size that begins at each pixel, where it fits."""
    whole = np.pad(values.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    bands: NDArray[np.float64] = whole[height:] - whole[:-height]
    return bands[:, width:] - bands[:, :-width]


def _draw_cell(
    sheet: Image,
    half: Image,
    part: tuple[slice, slice],
    heading: str,
    note: str,
    plan: _Plan,
    corner: tuple[int, int],
) -> None:
    """Heading, the viewport, its note, the detail magnified, each with its scale."""
    x, y = corner
    _draw_lines(sheet, _wrapped(heading, plan.cell_px, _MIDDLE_PX), x, y, _MIDDLE_PX, _INK)
    y += plan.heading_lines * _line(_MIDDLE_PX)
    picture = _resized(half, plan)
    _draw_frame(picture, part, plan)
    _paste(sheet, picture, x, y)
    _draw_scale(sheet, x, y, picture, plan.pixels_per_degree * plan.enlarge / plan.shrink)
    y += picture.shape[0] + 4
    _draw_lines(sheet, _wrapped(note, plan.cell_px, _SMALL_PX), x, y, _SMALL_PX, _INK)
    y += plan.note_lines * _line(_SMALL_PX)
    large = resize_nearest(half[part], plan.magnified)
    _paste(sheet, large, x, y)
    _draw_scale(sheet, x, y, large, plan.pixels_per_degree * plan.magnified, longest_deg=1.0)
    y += large.shape[0] + 4
    caption = f"the framed part, {plan.magnified * plan.shrink // plan.enlarge} times"
    _draw_lines(sheet, [caption], x, y, _SMALL_PX, _QUIET)


def _resized(half: Image, plan: _Plan) -> Image:
    if plan.shrink > 1:
        return resize_area(half, *plan.shown_px)
    return resize_nearest(half, plan.enlarge).copy()


def _paste(sheet: Image, picture: Image, x: int, y: int) -> None:
    sheet[y : y + picture.shape[0], x : x + picture.shape[1]] = picture


def _draw_frame(picture: Image, part: tuple[slice, slice], plan: _Plan) -> None:
    """A line of two pixels around the part that is magnified."""
    (top, bottom), (left, right) = (
        (each.start * plan.enlarge // plan.shrink, each.stop * plan.enlarge // plan.shrink)
        for each in part
    )
    top, left, bottom, right = max(top - 2, 0), max(left - 2, 0), bottom + 2, right + 2
    for rows, columns in (
        (slice(top, top + 2), slice(left, right)),
        (slice(bottom - 2, bottom), slice(left, right)),
        (slice(top, bottom), slice(left, left + 2)),
        (slice(top, bottom), slice(right - 2, right)),
    ):
        picture[rows, columns] = _FRAME


def _draw_scale(
    sheet: Image,
    x: int,
    y: int,
    picture: Image,
    pixels_per_degree: float,
    *,
    longest_deg: float = _SCALE_BARS_DEG[0],
) -> None:
    """A bar of so many degrees in the picture's lower left corner, white on black."""
    height, width = picture.shape[:2]
    degrees = next(
        (
            each
            for each in _SCALE_BARS_DEG
            if each <= longest_deg and each * pixels_per_degree < 0.6 * width
        ),
        0.0,
    )
    label = f"{degrees:g} deg"
    label_width, label_height = text_size(label, _SMALL_PX)
    if degrees == 0.0 or height < label_height + 24 or width < label_width + 24:
        return
    length = round(degrees * pixels_per_degree)
    bar = y + height - 14
    sheet[bar - 2 : bar + 6, x + 10 : x + 14 + length] = 0.0
    sheet[bar : bar + 4, x + 12 : x + 12 + length] = 1.0
    top = bar - label_height - 4
    sheet[top : top + label_height, x + 10 : x + 14 + label_width] *= 0.25
    draw_text(sheet, label, x + 12, top, size_px=_SMALL_PX, color=_WHITE)
