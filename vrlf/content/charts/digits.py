"""Digits as a 5 x 7 bitmap, for labels that need no exact geometry."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from vrlf.content.charts.model import Colour, Image

DIGIT_WIDTH: Final = 5
DIGIT_HEIGHT: Final = 7
_ADVANCE: Final = DIGIT_WIDTH + 1

_BITMAPS: Final = MappingProxyType(
    {
        "-": (".....", ".....", ".....", "#####", ".....", ".....", "....."),
        "0": (".###.", "#...#", "#..##", "#.#.#", "##..#", "#...#", ".###."),
        "1": ("..#..", ".##..", "..#..", "..#..", "..#..", "..#..", ".###."),
        "2": (".###.", "#...#", "....#", "..##.", ".#...", "#....", "#####"),
        "3": (".###.", "#...#", "....#", "..##.", "....#", "#...#", ".###."),
        "4": ("...#.", "..##.", ".#.#.", "#..#.", "#####", "...#.", "...#."),
        "5": ("#####", "#....", "####.", "....#", "....#", "#...#", ".###."),
        "6": ("..##.", ".#...", "#....", "####.", "#...#", "#...#", ".###."),
        "7": ("#####", "....#", "...#.", "..#..", ".#...", ".#...", ".#..."),
        "8": (".###.", "#...#", "#...#", ".###.", "#...#", "#...#", ".###."),
        "9": (".###.", "#...#", "#...#", ".####", "....#", "...#.", ".##.."),
    }
)


def number_width_px(number: int, scale: int) -> int:
    """Width of a whole number painted at ``scale`` pixels a bitmap cell."""
    return (len(str(number)) * _ADVANCE - 1) * scale


def paint_number(
    picture: Image, number: int, *, left_px: int, top_px: int, scale: int, colour: Colour
) -> None:
    """Paint a whole number, ``7 * scale`` pixels high, in place."""
    for place, sign in enumerate(str(number)):
        for row, cells in enumerate(_BITMAPS[sign]):
            for column, cell in enumerate(cells):
                if cell == "#":
                    x = left_px + (place * _ADVANCE + column) * scale
                    y = top_px + row * scale
                    picture[y : y + scale, x : x + scale] = colour
