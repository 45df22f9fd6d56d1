"""Pictures in and out: the only room that imports OpenImageIO.

Inside, a picture is linear light, float32, (H, W, 3), row 0 at the top.

- ``reading``: any file to linear light, or one line that says why not.
- ``writing``: linear light, encoded bytes or named channels to whole files.
- ``srgb``: the sRGB formulas, exact.
- ``text``: labels in the shipped font.
- ``raster``: cutting and scaling for sheets.
- ``png``: finds a damaged PNG before libpng prints about it.
- ``oiio``: OpenImageIO's limits and errors.
"""

from vrlf.images.raster import crop, resize_area, resize_nearest
from vrlf.images.reading import Encoding, read_channels, read_codes, read_picture
from vrlf.images.srgb import quantise_srgb, srgb_decode, srgb_encode
from vrlf.images.text import draw_text, text_size
from vrlf.images.writing import (
    PICTURE_ENDINGS,
    check_picture_target,
    write_channels,
    write_encoded,
    write_picture,
)

__all__ = [
    "PICTURE_ENDINGS",
    "Encoding",
    "check_picture_target",
    "crop",
    "draw_text",
    "quantise_srgb",
    "read_channels",
    "read_codes",
    "read_picture",
    "resize_area",
    "resize_nearest",
    "srgb_decode",
    "srgb_encode",
    "text_size",
    "write_channels",
    "write_encoded",
    "write_picture",
]
