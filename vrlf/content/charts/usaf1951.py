"""Three-bar targets after MIL-STD-150A (USAF 1951), in cycles per degree.

Element e of group g has 2 ** (g + (e - 1) / 6) cycles a degree, so group 0
element 1 is one cycle a degree: its bars are half a degree wide.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

from vrlf.content.charts.digits import DIGIT_HEIGHT, number_width_px, paint_number
from vrlf.content.charts.model import BLACK, WHITE, Chart, Image, Viewport
from vrlf.content.charts.raster import Box, blank, paint_rectangle
from vrlf.errors import InputError

ELEMENTS_PER_GROUP: Final = 6
BARS: Final = 3
# Three bars and the two gaps between them: a triplet is as long as it is wide.
TRIPLET_BARS: Final = 2 * BARS - 1
MIN_BAR_PX: Final = 1.0
_MARGIN_PX: Final = 2
_MIN_GAP_PX: Final = 2
# Labels are about one and a half bars high, and at least one pixel a bitmap cell.
_LABEL_BARS: Final = 1.5
_ROUNDING: Final = 1e-9


@dataclass(frozen=True)
class Element:
    """One pair of triplets, and the place of its upper left corner with the label."""

    group: int
    element: int
    cycles_per_degree: float
    bar_px: float
    left_px: int = 0
    top_px: int = 0
    heads_column: bool = False

    @property
    def label_scale(self) -> int:
        """Pixels a bitmap cell of the label."""
        return max(1, int(_LABEL_BARS * self.bar_px / DIGIT_HEIGHT))

    @property
    def gap_px(self) -> int:
        """White space around the triplets."""
        return max(_MIN_GAP_PX, round(1.5 * self.bar_px))

    @property
    def triplet_px(self) -> float:
        """Side of a triplet."""
        return TRIPLET_BARS * self.bar_px

    @property
    def upright_left_px(self) -> int:
        """Left edge of the upright bars."""
        label_px = number_width_px(self.element, self.label_scale)
        return self.left_px + label_px + max(_MIN_GAP_PX, 2 * self.label_scale)

    @property
    def level_left_px(self) -> int:
        """Left edge of the level bars."""
        return self.upright_left_px + math.ceil(self.triplet_px) + self.gap_px

    @property
    def right_px(self) -> int:
        """First column beyond the element and its column's heading."""
        heading_px = self.left_px + number_width_px(self.group, self.label_scale)
        return max(self.level_left_px + math.ceil(self.triplet_px), heading_px)

    @property
    def bottom_px(self) -> int:
        """First row below the element."""
        return self.top_px + max(math.ceil(self.triplet_px), DIGIT_HEIGHT * self.label_scale)


def draw_usaf1951(viewport: Viewport) -> Chart:
    """Draw black bars on white, one column a group, as coarse a first element as fits.

    A column is headed by its group, a target by its element. The finest bars are
    at least one pixel wide. Bar widths are exact: edge pixels are grey by coverage.

    Raises
    ------
    InputError
        If not even the finest element fits.
    """
    elements = place_elements(viewport)
    picture = blank(viewport, WHITE)
    for element in elements:
        _paint_element(picture, element)
    return Chart(picture, tuple(_notes(viewport, elements)))


def place_elements(viewport: Viewport) -> tuple[Element, ...]:
    """All elements that are drawn, coarsest first, each in its place."""
    width, height, ppd = viewport.width_px, viewport.height_px, viewport.pixels_per_degree
    finest = math.floor(ELEMENTS_PER_GROUP * math.log2(ppd / 2.0 / MIN_BAR_PX) + _ROUNDING)
    octaves = math.ceil(math.log2(max(width, height) / MIN_BAR_PX))
    for coarsest in range(finest - octaves * ELEMENTS_PER_GROUP, finest + 1):
        placed = _flow([_element(i, ppd) for i in range(coarsest, finest + 1)], height)
        right, bottom = (max(e.right_px for e in placed), max(e.bottom_px for e in placed))
        if right + _MARGIN_PX <= width and bottom + _MARGIN_PX <= height:
            dx = (width - _MARGIN_PX - right) // 2
            dy = (height - _MARGIN_PX - bottom) // 2
            return tuple(replace(e, left_px=e.left_px + dx, top_px=e.top_px + dy) for e in placed)
    raise InputError(
        f"chart usaf1951: found a viewport of {width} x {height} px, "
        "wanted room for one pair of three-bar targets with its labels"
    )


def _element(index: int, pixels_per_degree: float) -> Element:
    """Element ``index`` counted from group 0 element 1."""
    group, place = divmod(index, ELEMENTS_PER_GROUP)
    frequency = 2.0 ** (index / ELEMENTS_PER_GROUP)
    return Element(group, place + 1, frequency, pixels_per_degree / (2.0 * frequency))


def _flow(elements: list[Element], height_px: int) -> list[Element]:
    """Place elements down columns; a new group or a full column starts the next one."""
    placed: list[Element] = []
    left_px, top_px = _MARGIN_PX, _heading_bottom_px(elements[0])
    for element in elements:
        here = replace(element, left_px=left_px, top_px=top_px)
        full = here.bottom_px + _MARGIN_PX > height_px
        if placed and (full or element.group != placed[-1].group):
            gap_px = 2 * element.gap_px
            left_px = max(e.right_px for e in placed) + gap_px
            here = replace(element, left_px=left_px, top_px=_heading_bottom_px(element))
        here = replace(here, heads_column=not placed or here.left_px != placed[-1].left_px)
        placed.append(here)
        top_px = here.bottom_px + here.gap_px
    return placed


def _heading_bottom_px(element: Element) -> int:
    return _MARGIN_PX + DIGIT_HEIGHT * element.label_scale + 2 * element.gap_px


def _paint_element(picture: Image, element: Element) -> None:
    left, top, scale = element.left_px, element.top_px, element.label_scale
    if element.heads_column:
        head_top = top - 2 * element.gap_px - DIGIT_HEIGHT * scale
        paint_number(
            picture, element.group, left_px=left, top_px=head_top, scale=scale, colour=BLACK
        )
    paint_number(picture, element.element, left_px=left, top_px=top, scale=scale, colour=BLACK)
    bar, length = element.bar_px, element.triplet_px
    for k in range(BARS):
        across = 2 * k * bar
        paint_rectangle(picture, Box(element.upright_left_px + across, top, bar, length), BLACK)
        paint_rectangle(picture, Box(element.level_left_px, top + across, length, bar), BLACK)


def _notes(viewport: Viewport, elements: tuple[Element, ...]) -> list[str]:
    unit_px = viewport.pixels_per_degree / 2.0
    return [
        f"group 0 element 1 is 1 cycle per degree: bars {unit_px:.2f} px wide "
        f"at {viewport.pixels_per_degree:.2f} pixels per degree",
        *(
            f"group {e.group} element {e.element}: {e.cycles_per_degree:.3f} cycles per degree, "
            f"bars {e.bar_px:.2f} px wide"
            for e in elements
        ),
    ]
