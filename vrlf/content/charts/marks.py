"""Marks for setting up: which eye, which way up, and a colour for each corner.

No mirror and no turn maps the picture onto itself, and the two eyes' pictures differ.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from vrlf.content.charts.letters import UP_ARROW, paint_letter
from vrlf.content.charts.model import (
    BLACK,
    BLUE,
    GREEN,
    RED,
    WHITE,
    YELLOW,
    Chart,
    Image,
    Viewport,
)
from vrlf.content.charts.raster import blank

EYE_LETTERS: Final = MappingProxyType({"left": "L", "right": "R"})
# Shares of the shorter side. From the top: arrow, the word UP, the eye's letter.
_CORNER: Final = 0.15
_ARROW: Final = 0.20
_WORD: Final = 0.125
_EYE_LETTER: Final = 0.40
_GAP: Final = 0.05


def draw_marks(viewport: Viewport) -> Chart:
    """Draw white signs on black: an arrow up, UP, L or R, and four corner squares."""
    picture = blank(viewport, BLACK)
    corner_px = max(1, round(_CORNER * viewport.shorter_side_px))
    _paint_corners(picture, corner_px)
    side = viewport.shorter_side_px
    total = _ARROW + _WORD + _EYE_LETTER + 2 * _GAP
    top_px = (viewport.height_px - total * side) / 2.0
    for word, share in (
        (UP_ARROW, _ARROW),
        ("UP", _WORD),
        (EYE_LETTERS[viewport.eye], _EYE_LETTER),
    ):
        _paint_word(picture, word, round(top_px), round(share * side))
        top_px += (share + _GAP) * side
    notes = (
        f"the {viewport.eye} eye: the letter {EYE_LETTERS[viewport.eye]}; the arrow points up",
        f"corner squares of {corner_px} px: red top left, green top right, "
        "blue bottom left, yellow bottom right",
    )
    return Chart(picture, notes)


def _paint_corners(picture: Image, side_px: int) -> None:
    picture[:side_px, :side_px] = RED
    picture[:side_px, -side_px:] = GREEN
    picture[-side_px:, :side_px] = BLUE
    picture[-side_px:, -side_px:] = YELLOW


def _paint_word(picture: Image, word: str, top_px: int, height_px: int) -> None:
    """Letters half a letter apart, centred; whole pixels keep their edges sharp."""
    advance_px = height_px + height_px // 2
    left_px = (picture.shape[1] - (len(word) - 1) * advance_px - height_px) // 2
    for place, letter in enumerate(word):
        paint_letter(
            picture,
            letter,
            left_px=left_px + place * advance_px,
            top_px=top_px,
            height_px=height_px,
            colour=WHITE,
        )
