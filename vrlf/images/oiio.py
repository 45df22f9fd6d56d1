"""What every call of OpenImageIO here needs: its limits, and its errors as text."""

from __future__ import annotations

from typing import Any, Final

import OpenImageIO

MAX_SIDE_PX: Final = 16384
MAX_PICTURE_MIB: Final = 512
MAX_CHANNELS: Final = 64

# Set where OpenImageIO is first imported, since they count only before the first read:
# without them a header of 74 bytes asks for gigabytes.
OpenImageIO.attribute("limits:resolution", MAX_SIDE_PX)
OpenImageIO.attribute("limits:imagesize_MB", MAX_PICTURE_MIB)
OpenImageIO.attribute("limits:channels", MAX_CHANNELS)


def take_error(*sources: Any) -> str:
    """Fetch and clear the pending error text of the sources and of the library.

    Parameters
    ----------
    *sources : ImageInput, ImageOutput or ImageBuf
        Whatever may hold an error of its own.

    Returns
    -------
    str
        The first line of the first error; empty if there is none.
    """
    texts = []
    for source in (*sources, OpenImageIO):
        try:
            texts.append(source.geterror())
        except UnicodeDecodeError:  # some messages quote the file's raw bytes
            texts.append("unreadable error message")
    return next((text.strip().splitlines()[0] for text in texts if text.strip()), "")
