"""Drawing labels with the shipped font, DejaVu Sans."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Final

import numpy as np
import OpenImageIO
from numpy.typing import NDArray

from vrlf.errors import VrlfError
from vrlf.images.oiio import take_error
from vrlf.images.srgb import srgb_decode, srgb_encode
from vrlf.resources import assets_dir

# DejaVu Sans 2.37, table hhea: over and under the baseline, in parts of the size.
_ASCENT: Final = 0.928
_DESCENT: Final = 0.236


def text_size(text: str, size_px: int) -> tuple[int, int]:
    """Width and height of the box that `draw_text` fills.

    Parameters
    ----------
    text : str
        One line or, with newlines, several.
    size_px : int
        Size of the font, at least 1.

    Returns
    -------
    width_px, height_px : int
        The height depends on the number of lines only, so that labels line up.
    """
    lines = text.split("\n")
    width_px = max(_line_width(line, size_px) for line in lines)
    return width_px, _line_height(size_px) * len(lines)


def draw_text(
    image: NDArray[np.float32],
    text: str,
    x_px: int,
    y_px: int,
    *,
    size_px: int,
    color: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> NDArray[np.float32]:
    """Draw text into a picture, in place.

    The edges of the letters are blended in sRGB, where they look evenly thick;
    pixels without ink keep their exact values.

    Parameters
    ----------
    image : ndarray of float32, shape (H, W, 3)
        Linear light, changed in place.
    text : str
        One line or several. What lies outside the picture is cut off.
    x_px, y_px : int
        Column and row of the top left corner of the text's box.
    size_px : int
        Size of the font, at least 1.
    color : tuple of 3 floats
        Linear light of the ink.

    Returns
    -------
    ndarray
        ``image`` itself.

    Raises
    ------
    VrlfError
        The font is missing or the library cannot draw.
    """
    for number, line in enumerate(text.split("\n")):
        if line:
            ink = _ink(line, size_px)
            _blend(image, ink, x_px, y_px + number * _line_height(size_px), color)
    return image


def _font() -> str:
    font: Path = assets_dir() / "fonts" / "DejaVuSans.ttf"
    if not font.is_file():
        raise VrlfError(f"{font}: found no such file, wanted the shipped font; install vrlf again")
    return str(font)


def _line_height(size_px: int) -> int:
    return math.ceil(size_px * (_ASCENT + _DESCENT))


def _line_width(line: str, size_px: int) -> int:
    if size_px < 1:
        raise ValueError(f"found a font size of {size_px} pixels, wanted at least 1")
    if not line:
        return 0
    box = OpenImageIO.ImageBufAlgo.text_size(line, size_px, _font())
    fault = take_error()
    if fault:
        raise VrlfError(f"text: found that it cannot be measured ({fault}), wanted a font's help")
    return max(int(box.xend), 0)


def _ink(line: str, size_px: int) -> NDArray[np.float32]:
    """How much of each pixel of the line's box the letters cover, (h, w), 0 to 1."""
    # A letter may lean a little over its own width.
    width_px, height_px = _line_width(line, size_px) + size_px, _line_height(size_px)
    canvas = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(width_px, height_px, 1, "float"))
    baseline = round(_ASCENT * size_px)
    drawn = OpenImageIO.ImageBufAlgo.render_text(
        canvas, 0, baseline, line, size_px, _font(), (1.0,)
    )
    fault = take_error(canvas)
    pixels = canvas.get_pixels(OpenImageIO.FLOAT)
    if fault or not drawn or pixels is None:
        raise VrlfError(f"text: found that it cannot be drawn ({fault}), wanted OpenImageIO's text")
    cover: NDArray[np.float32] = np.clip(pixels[..., 0], 0.0, 1.0)
    return cover


def _blend(
    image: NDArray[np.float32],
    ink: NDArray[np.float32],
    x_px: int,
    y_px: int,
    color: tuple[float, float, float],
) -> None:
    height, width = image.shape[:2]
    x0, x1 = max(x_px, 0), min(x_px + ink.shape[1], width)
    y0, y1 = max(y_px, 0), min(y_px + ink.shape[0], height)
    if x0 >= x1 or y0 >= y1:
        return
    cover = ink[y0 - y_px : y1 - y_px, x0 - x_px : x1 - x_px, None].astype(np.float64)
    under = image[y0:y1, x0:x1]
    mixed = srgb_decode(srgb_encode(under) * (1.0 - cover) + srgb_encode(color) * cover)
    np.copyto(under, mixed, where=cover > 0.0, casting="same_kind")
