"""Print: a 5 x 7 face, text set into pages, and the table that filters them.

A page is coverage of ink, 0 to 1, at ``TEXEL_M`` a texel; rows run down. The shader reads
it over any box at all from a summed-area table (Crow 1984), so that print is filtered as
well across a page that is seen aslant as along it.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

Ink = NDArray[np.float32]

TEXEL_M: Final = 0.00025
GLYPH_ROWS: Final = 7
_LINE_ROWS: Final = 10  # a line and the space below it
_WORD_SPACE: Final = 4

# Each letter's columns from the left, the lowest bit on top.
_SIGNS: Final = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789.,-'"
_HEX: Final = (
    "7E1111117E 7F49494936 3E41414122 7F4141221C 7F49494941 7F09090101 3E41415132 "
    "7F0808087F 417F41 2040413F01 7F08142241 7F40404040 7F0204027F 7F0408107F "
    "3E4141413E 7F09090906 3E4151215E 7F09192946 4649494931 01017F0101 3F4040403F "
    "1F2040201F 7F2018207F 6314081463 0304780403 6151494543 "
    "2054545478 7F48444438 3844444420 384444487F 3854545418 087E090102 0C5252523E "
    "7F08040478 447D40 2040443D 7F102844 417F40 7C04180478 7C08040478 3844444438 "
    "7C14141408 081414187C 7C08040408 4854545420 043F444020 3C4040207C 1C2040201C "
    "3C4030403C 4428102844 0C5050503C 4464544C44 "
    "3E5149453E 427F40 4261514946 2141454B31 1814127F10 2745454539 3C4A494930 "
    "0171090503 3649494936 064949291E "
    "6060 5030 080808 0503"
)
_COLUMNS: Final = MappingProxyType(
    {
        sign: tuple(bytes.fromhex(columns))
        for sign, columns in zip(_SIGNS, _HEX.split(" "), strict=True)
    }
)


def glyph(sign: str) -> Ink:
    """One letter, shape (7, 2 to 5)."""
    columns = np.array(_COLUMNS[sign], np.uint8)
    return ((columns[None, :] >> np.arange(GLYPH_ROWS)[:, None]) & 1).astype(np.float32)


def word(letters: str) -> Ink:
    """A word, one empty column between its letters; shape (7, w)."""
    gap = np.zeros((GLYPH_ROWS, 1), np.float32)
    parts = [part for sign in letters for part in (glyph(sign), gap)]
    return np.concatenate(parts[:-1], axis=1)


def set_text(page: Ink, text: str, *, box: tuple[int, int, int, int], scale: int) -> int:
    """Set text into a box of a page, in place, ragged right.

    Parameters
    ----------
    page : ndarray, shape (H, W)
    box : (left, top, right, bottom)
        In texels; lines that don't fit are left out.
    scale : int
        Texels of a letter's cell.

    Returns
    -------
    int
        The first free row below the text.
    """
    left, top, right, bottom = box
    x, y = left, top
    for each in text.split():
        cells = np.kron(word(each), np.ones((scale, scale), np.float32))
        height, width = cells.shape
        if x + width > right:
            x, y = left, y + _LINE_ROWS * scale
        if y + height > bottom or x + width > right:
            break
        page[y : y + height, x : x + width] = cells
        x += width + _WORD_SPACE * scale
    return y + _LINE_ROWS * scale


def summed_area(ink: Ink) -> tuple[Ink, float]:
    """The summed-area table of a page about its mean, and that mean.

    Entry (j, i) is the sum of ``ink - mean`` over the rows above j and the columns left of
    i, so the table has one row and column more. Without the mean the sums stay small and
    float32 keeps them to 1e-4 of a texel.

    Returns
    -------
    table : ndarray of float32, shape (H + 1, W + 1)
    mean : float
    """
    mean = float(ink.mean(dtype=np.float64))
    table = np.zeros((ink.shape[0] + 1, ink.shape[1] + 1))
    table[1:, 1:] = np.cumsum(np.cumsum(ink - mean, axis=0, dtype=np.float64), axis=1)
    return table.astype(np.float32), mean
