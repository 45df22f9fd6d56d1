"""The sheets of the scene and where they lie in the one table of print.

At 0.42 m a pixel of a common phone is 0.7 mm wide: body text is set with strokes of that
width, titles with more, notes with less.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vrlf.scene.glyphs import TEXEL_M, Ink, set_text


@dataclass(frozen=True)
class Sheet:
    """A rectangle of the table of print: first column and row, width and height, in texels."""

    left: int
    top: int
    width: int
    height: int

    @property
    def size_m(self) -> tuple[float, float]:
        """Width and height."""
        return self.width * TEXEL_M, self.height * TEXEL_M

    @property
    def first_m(self) -> tuple[float, float]:
        """Its upper left corner."""
        return self.left * TEXEL_M, self.top * TEXEL_M


LEFT_PAGE = Sheet(0, 0, 620, 860)
RIGHT_PAGE = Sheet(640, 0, 620, 860)
SLIP = Sheet(0, 880, 520, 900)
NOTICE = Sheet(540, 880, 1500, 2200)
_TABLE_PX = (2060, 3100)  # width and height

_BODY = """The eye that cannot bend its light enough sees every point as a disc, and where the
discs of neighbours meet the letters run together. A lens before the eye mends this by bending
the light once more. Another way is to send the light already bent, so that every ray arrives
where it would have gone had the eye been made without a fault. For this a page must show not
one picture but a great many, each meant for another part of the pupil, and each seen through
its own small window. None of them is sharp, and none of them needs to be. Only when they fall
together on the retina does a single picture stand there, as fine as the windows allow."""
_SECOND = """The windows are small lenses in a square lattice, or holes in a mask. Holes are
simple and lose most of the light. Lenses keep it, but each of them must be placed with care,
for a tenth of a millimetre is enough to put the red where the green should be. Between two
windows nothing is shown, and so the price of bending light in this way is paid in detail. A
wide window lets more of it pass and a narrow one keeps the pictures apart. Whoever builds such
a thing looks for the place between the two, and finds it by trying, 4 or 5 times at least."""
_NOTE = """Small print. Whoever can read this without glasses has good eyes or sits too near.
The strokes of these letters are thinner than a pixel, so that they show what is left of detail
when a picture has gone through all of it. Printed in the year 1987 on paper that was white."""
_LIST = """Beans 250, bread, a pound of salt, lamp oil, thread 40, two lemons, nails, rice 500,
soap, string, ink, six eggs, a brush, tea, candles 12, honey, matches, yeast 42, onions, vinegar,
a new pencil, pepper 50, seeds of marjoram, thyme and sage, flour 1000, milk, a ball of wool"""


def printed() -> Ink:
    """The table of print: coverage of ink, shape (rows, columns)."""
    ink = np.zeros(_TABLE_PX[::-1], np.float32)
    _set_page(ink, LEFT_PAGE, "On bent light", _BODY)
    _set_page(ink, RIGHT_PAGE, "Many windows", _SECOND)
    y = set_text(ink, "To buy", box=_inside(SLIP, 30), scale=10)
    set_text(ink, _LIST, box=_inside(SLIP, 30, top=y + 20), scale=4)
    y = set_text(ink, "Garden open", box=_inside(NOTICE, 120), scale=30)
    y = set_text(ink, "daily from 9 to 17", box=_inside(NOTICE, 120, top=y + 40), scale=18)
    set_text(ink, _BODY, box=_inside(NOTICE, 120, top=y + 60), scale=9)
    return ink


def _set_page(ink: Ink, sheet: Sheet, title: str, body: str) -> None:
    """A title, body text with strokes of 0.75 mm and a note with strokes of 0.5 mm."""
    y = set_text(ink, title, box=_inside(sheet, 44), scale=7)
    half = sheet.top + 640
    set_text(ink, body, box=(*_inside(sheet, 44, top=y + 12)[:3], half), scale=3)
    set_text(ink, _NOTE, box=_inside(sheet, 44, top=half + 16), scale=2)


def _inside(sheet: Sheet, margin: int, *, top: int | None = None) -> tuple[int, int, int, int]:
    """A sheet without its margin; from row ``top`` of the table on, if one is given."""
    return (
        sheet.left + margin,
        sheet.top + margin if top is None else top,
        sheet.left + sheet.width - margin,
        sheet.top + sheet.height - margin,
    )
