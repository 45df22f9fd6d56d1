"""The acuity chart: lines of Sloan letters in steps of 0.1 logMAR (Bailey & Lovie 1976, ETDRS)."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vrlf.content.charts.letters import LETTER_SIDE, paint_letter
from vrlf.content.charts.model import BLACK, WHITE, Chart, LetterLine, Viewport
from vrlf.content.charts.raster import blank
from vrlf.errors import InputError
from vrlf.units import ARCMIN_PER_DEGREE

# logMAR 0 has strokes of one minute of arc, and a letter is five strokes high.
LETTER_ARCMIN_AT_ZERO: Final = 5.0
# A stroke is a fifth of the letter and takes at least one pixel.
MIN_LETTER_HEIGHT_PX: Final = 5.0
STEPS_PER_UNIT: Final = 10
LETTERS_PER_LINE: Final = 5
# A viewport that five letters don't fit gets fewer; with less than three, no line.
MIN_LETTERS_PER_LINE: Final = 3
# White at either end of the widest line and of the stack of lines, in letters.
_MARGIN_LETTERS: Final = 0.25
# A letter of exactly the limiting size fits, whatever rounding says.
_ROUNDING: Final = 1e-9

# Five different letters a line, all ten in each two lines, and no letter twice in
# a row, along the lines or straight below itself, however many of the five are
# shown. A fixed list, so that a chart is the same on every machine and with every version.
_LETTER_SEQUENCE: Final = (
    "ZNORSVCDKHSHCZNOKRVDNOZRKHSDCVSVNHORKDZCNORHDKSVCZ"
    "HZRNKDSVCORKSHVONCDZNZSVKRCOHDZHCSVNKORDCRVNSKODHZ"
    "CDRNVZKSOHNDKHRZVCSORHVOCSZNKDHKVCSOZRDNKCSVHONRZD"
)
LETTER_LINES: Final = tuple(
    _LETTER_SEQUENCE[start : start + LETTERS_PER_LINE]
    for start in range(0, len(_LETTER_SEQUENCE), LETTERS_PER_LINE)
)


class _Layout(NamedTuple):
    """Lines from step ``largest`` down to ``smallest``, in tenths of logMAR."""

    largest: int
    smallest: int
    letters: int


def letter_height_px(logmar: float, pixels_per_degree: float) -> float:
    """Height of a letter: 5 minutes of arc at logMAR 0, ten times as much a unit."""
    arcmin = LETTER_ARCMIN_AT_ZERO * math.pow(10.0, logmar)
    return arcmin * pixels_per_degree / ARCMIN_PER_DEGREE


def draw_logmar(viewport: Viewport) -> Chart:
    """Draw black letters on white, the largest line that fits at the top.

    Letters stand one letter apart, a line its own height below the line above it.
    Upper left corners lie on whole pixels, so that all letters of a line are
    equally sharp; gaps are exact to within that rounding.

    Raises
    ------
    InputError
        If not even one line fits.
    """
    layout = _choose_layout(viewport)
    lines = _place_lines(viewport, layout)
    picture = blank(viewport, WHITE)
    for line in lines:
        for left_px, letter in zip(_letter_lefts_px(viewport, line), line.letters, strict=True):
            paint_letter(
                picture,
                letter,
                left_px=left_px,
                top_px=line.y_px,
                height_px=line.letter_height_px,
                colour=BLACK,
            )
    return Chart(picture, tuple(_notes(viewport, lines)), lines)


def _choose_layout(viewport: Viewport) -> _Layout:
    """As many letters a line as fit, up to five; then as large a first line as fits."""
    unit_px = letter_height_px(0.0, viewport.pixels_per_degree)
    smallest = math.ceil(STEPS_PER_UNIT * math.log10(MIN_LETTER_HEIGHT_PX / unit_px) - _ROUNDING)
    for letters in range(LETTERS_PER_LINE, MIN_LETTERS_PER_LINE - 1, -1):
        widest_px = viewport.width_px / (2 * letters - 1 + 2 * _MARGIN_LETTERS)
        largest = math.floor(STEPS_PER_UNIT * math.log10(widest_px / unit_px) + _ROUNDING)
        while largest >= smallest:
            heights = _heights_px(viewport, largest, smallest)
            if _stack_height_px(heights) <= viewport.height_px:
                return _Layout(largest, smallest, letters)
            largest -= 1
    raise InputError(
        f"chart logmar: found a viewport of {viewport.width_px} x {viewport.height_px} px, "
        f"wanted room for {MIN_LETTERS_PER_LINE} letters of {MIN_LETTER_HEIGHT_PX:g} px"
    )


def _heights_px(viewport: Viewport, largest: int, smallest: int) -> list[float]:
    steps = range(largest, smallest - 1, -1)
    return [letter_height_px(k / STEPS_PER_UNIT, viewport.pixels_per_degree) for k in steps]


def _stack_height_px(heights_px: list[float]) -> float:
    """All lines, the gap above each but the first, and the white at either end."""
    return 2.0 * sum(heights_px) - heights_px[0] * (1.0 - 2 * _MARGIN_LETTERS)


def _place_lines(viewport: Viewport, layout: _Layout) -> tuple[LetterLine, ...]:
    heights = _heights_px(viewport, layout.largest, layout.smallest)
    top_px = (viewport.height_px - _stack_height_px(heights)) / 2.0
    top_px += _MARGIN_LETTERS * heights[0]
    lines = []
    for index, height in enumerate(heights):
        logmar = (layout.largest - index) / STEPS_PER_UNIT
        if index:
            top_px += height
        letters = LETTER_LINES[index % len(LETTER_LINES)][: layout.letters]
        lines.append(LetterLine(logmar, math.pow(10.0, -logmar), height, letters, round(top_px)))
        top_px += height
    return tuple(lines)


def _letter_lefts_px(viewport: Viewport, line: LetterLine) -> list[int]:
    height = line.letter_height_px
    first = (viewport.width_px - (2 * len(line.letters) - 1) * height) / 2.0
    return [round(first + 2 * place * height) for place in range(len(line.letters))]


def _notes(viewport: Viewport, lines: tuple[LetterLine, ...]) -> list[str]:
    scale = f"{viewport.pixels_per_degree:.2f} pixels per degree"
    stroke_px = lines[-1].letter_height_px / LETTER_SIDE
    return [
        f"{len(lines[0].letters)} Sloan letters a line at {scale}; "
        f"the finest stroke is {stroke_px:.2f} px",
        *(
            f"line {number}: logMAR {line.logmar:.2f}, "
            f"decimal acuity {line.decimal_acuity:.3g}, "
            f"letter {line.letter_height_px:.1f} px high, {' '.join(line.letters)}"
            for number, line in enumerate(lines, start=1)
        ),
    ]
