"""Reading pictures: any format, to upright linear light, or one line that says why not."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
import OpenImageIO
from numpy.typing import NDArray

from vrlf.errors import ImageReadError
from vrlf.files import shown
from vrlf.images.oiio import MAX_PICTURE_MIB, MAX_SIDE_PX, take_error
from vrlf.images.png import png_fault
from vrlf.images.srgb import srgb_decode

Encoding = Literal["auto", "srgb", "linear"]
AnyPixels = NDArray[Any]

_WANTED = "wanted a whole picture (PNG, JPEG, EXR, TIFF, WebP, HDR ...)"

# EXIF 2.32, tag 0x0112: what to do with the stored raster to see it upright.
_UPRIGHT: Final[dict[int, Callable[[AnyPixels], AnyPixels]]] = {
    1: lambda a: a,
    2: lambda a: a[:, ::-1],
    3: lambda a: a[::-1, ::-1],
    4: lambda a: a[::-1],
    5: lambda a: a.swapaxes(0, 1),
    6: lambda a: np.rot90(a, -1),
    7: lambda a: a[::-1, ::-1].swapaxes(0, 1),
    8: lambda a: np.rot90(a, 1),
}


@dataclass(frozen=True)
class _Stored:
    """A picture as the file has it: upright, but neither decoded nor composited."""

    name: str
    pixels: AnyPixels  # (H, W, C), the file's own kind of number
    channels: tuple[str, ...]
    premultiplied: bool
    says_linear: bool

    @property
    def is_float(self) -> bool:
        return np.issubdtype(self.pixels.dtype, np.floating)


def read_picture(
    path: str | os.PathLike[str], *, encoding: Encoding = "auto"
) -> NDArray[np.float32]:
    """Read a picture as linear light.

    The EXIF orientation is applied, grey becomes three equal channels, alpha is
    composited over black in linear light, and an EXR fills its display window.

    Parameters
    ----------
    path : path
        A file of any format that OpenImageIO reads; of several pictures in it, the first.
    encoding : {"auto", "srgb", "linear"}
        How the stored numbers stand for light. ``auto`` takes EXR, HDR, floats and
        files that call themselves linear as linear, all others as sRGB.

    Returns
    -------
    ndarray of float32, shape (H, W, 3)
        Linear light, 1 for full drive, row 0 at the top.

    Raises
    ------
    ImageReadError
        Missing, no file, no picture, damaged, too large, not finite, or of
        channels that are no colour picture.
    """
    stored = _read_stored(path)
    colour, alpha = _colour_and_alpha(stored)
    linear = stored.is_float or stored.says_linear if encoding == "auto" else encoding == "linear"
    light = _to_light(colour, alpha, linear=linear, premultiplied=stored.premultiplied)
    if light.shape[2] == 1:
        light = np.repeat(light, 3, axis=2)
    return np.ascontiguousarray(light, dtype=np.float32)


def read_codes(path: str | os.PathLike[str]) -> NDArray[np.uint8]:
    """The integers of an 8-bit picture as they are in the file, shape (H, W, 3).

    Raises
    ------
    ImageReadError
        As `read_picture`, or the file holds no three 8-bit channels.
    """
    stored = _read_stored(path)
    if stored.pixels.dtype != np.uint8 or stored.pixels.shape[2] < 3:
        raise ImageReadError(
            f"{stored.name}: found {stored.pixels.shape[2]} channels of {stored.pixels.dtype}, "
            "wanted 8-bit RGB"
        )
    return np.ascontiguousarray(stored.pixels[..., :3])


def read_channels(path: str | os.PathLike[str]) -> dict[str, NDArray[np.float32]]:
    """Read the named channels of a float picture, an EXR as a rule, as they are.

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    dict of str to ndarray of float32, shape (H, W)
        Every channel under its name.

    Raises
    ------
    ImageReadError
        As `read_picture`, or the file holds integers.
    """
    stored = _read_stored(path)
    if not stored.is_float:
        raise ImageReadError(
            f"{stored.name}: found {stored.pixels.dtype} values, wanted a float picture (EXR)"
        )
    planes = np.moveaxis(stored.pixels.astype(np.float32), 2, 0)
    return {
        name: np.ascontiguousarray(plane)
        for name, plane in zip(stored.channels, planes, strict=True)
    }


def _read_stored(path: str | os.PathLike[str]) -> _Stored:
    name = shown(path)
    _check_file(Path(path), name)
    # The bare colours: OpenImageIO would multiply by alpha before the decoding.
    wish = OpenImageIO.ImageSpec()
    wish.attribute("oiio:UnassociatedAlpha", 1)
    source = OpenImageIO.ImageInput.open(os.fspath(path), wish)
    if source is None:
        raise _unreadable(name, take_error())
    try:
        return _take(source, name)
    finally:
        source.close()
        take_error(source)


def _check_file(path: Path, name: str) -> None:
    """Refuse what OpenImageIO would misread, wait for, or complain about by itself."""
    text = os.fspath(path)
    if "\0" in text:  # OpenImageIO would read the file of the part before it
        raise ImageReadError(f"{name}: found a NUL character in the path, wanted a file name")
    try:
        text.encode("utf-8")
    except UnicodeEncodeError as error:
        raise ImageReadError(
            f"{name}: found a file name that is not UTF-8, wanted one that is"
        ) from error
    try:
        status = path.stat()
        if stat.S_ISDIR(status.st_mode):
            raise ImageReadError(f"{name}: found a folder, {_WANTED}")
        if not stat.S_ISREG(status.st_mode):
            raise ImageReadError(f"{name}: found a device or pipe, {_WANTED}")
        if status.st_size == 0:
            raise ImageReadError(f"{name}: found an empty file, {_WANTED}")
        fault = png_fault(path)
    except FileNotFoundError as error:
        raise ImageReadError(f"{name}: found no such file, {_WANTED}") from error
    except OSError as error:
        raise ImageReadError(f"{name}: found '{error.strerror}', {_WANTED}") from error
    if fault is not None:
        raise ImageReadError(f"{name}: found {fault}, {_WANTED}")


def _unreadable(name: str, reason: str) -> ImageReadError:
    if "limits:" in reason or "MB limit" in reason:
        return ImageReadError(
            f"{name}: found a header that claims too much ({reason.split(' exceeds')[0]}), "
            f"wanted at most {MAX_SIDE_PX} pixels a side and {MAX_PICTURE_MIB} MiB"
        )
    if not reason or "could not find a format reader" in reason:
        reason = "of no known format"
    return ImageReadError(f"{name}: found no readable picture ({reason}), {_WANTED}")


def _take(source: Any, name: str) -> _Stored:
    spec = source.spec()
    kind = source.format_name()
    _check_header(spec, kind, name)
    pixels = source.read_image("unknown")  # "unknown": the file's own kind of number
    fault = take_error(source)
    if fault or pixels is None:
        raise ImageReadError(f"{name}: found a damaged picture ({fault or 'no pixels'}), {_WANTED}")
    _check_numbers(pixels, name)
    if kind == "openexr":
        pixels = _in_display_window(pixels, spec)
    return _Stored(
        name=name,
        pixels=_UPRIGHT[_orientation(spec, kind)](pixels),
        channels=tuple(spec.channelnames),
        premultiplied=not spec.get_int_attribute("oiio:UnassociatedAlpha"),
        says_linear=spec.get_string_attribute("oiio:ColorSpace").startswith("lin"),
    )


def _check_header(spec: Any, kind: str, name: str) -> None:
    """Refuse by the header alone what cannot become a flat picture of sane size."""
    if kind == "null":  # OpenImageIO's made-up picture for names that end so
        raise _unreadable(name, "")
    if spec.deep or spec.depth > 1:
        raise ImageReadError(f"{name}: found deep or volume data, wanted a flat picture")
    for width, height in ((spec.width, spec.height), (spec.full_width, spec.full_height)):
        size_mib = width * height * spec.pixel_bytes(True) / 2**20
        if not (0 < width <= MAX_SIDE_PX and 0 < height <= MAX_SIDE_PX):
            raise ImageReadError(
                f"{name}: found {width}x{height} pixels, wanted 1 to {MAX_SIDE_PX} a side"
            )
        if size_mib > MAX_PICTURE_MIB:
            raise ImageReadError(
                f"{name}: found {size_mib:.0f} MiB of pixels, wanted at most {MAX_PICTURE_MIB}"
            )


def _check_numbers(pixels: AnyPixels, name: str) -> None:
    if np.issubdtype(pixels.dtype, np.unsignedinteger):
        return
    if not np.issubdtype(pixels.dtype, np.floating):
        raise ImageReadError(
            f"{name}: found {pixels.dtype} values, wanted unsigned integers or floats"
        )
    with np.errstate(over="ignore"):  # a double beyond float32 is as bad as an infinity
        bad = ~np.isfinite(pixels.astype(np.float32, copy=False))
    if bad.any():
        row, column, _ = np.argwhere(bad)[0]
        raise ImageReadError(
            f"{name}: found {np.count_nonzero(bad)} values that are NaN or infinite, the first in "
            f"row {row}, column {column}; wanted finite light only"
        )


def _in_display_window(pixels: AnyPixels, spec: Any) -> AnyPixels:
    """Lay an EXR's data window where it belongs in the display window, black around it."""
    top, left = spec.y - spec.full_y, spec.x - spec.full_x
    height, width = pixels.shape[:2]
    if (top, left, height, width) == (0, 0, spec.full_height, spec.full_width):
        return pixels
    canvas = np.zeros((spec.full_height, spec.full_width, pixels.shape[2]), pixels.dtype)
    y0, y1 = max(top, 0), min(top + height, spec.full_height)
    x0, x1 = max(left, 0), min(left + width, spec.full_width)
    if y0 < y1 and x0 < x1:
        canvas[y0:y1, x0:x1] = pixels[y0 - top : y1 - top, x0 - left : x1 - left]
    return canvas


def _orientation(spec: Any, kind: str) -> int:
    orientation = spec.get_int_attribute("Orientation", 1)
    if kind == "hdr":
        # OpenImageIO 3.2 takes Radiance's "+X +Y" and "-X -Y" for each other.
        orientation = {6: 8, 8: 6}.get(orientation, orientation)
    return orientation if orientation in _UPRIGHT else 1


def _colour_and_alpha(stored: _Stored) -> tuple[AnyPixels, AnyPixels | None]:
    """The (H, W, 3 or 1) colours and the (H, W, 1) alpha, by the channels' names."""
    names = [channel.upper() for channel in stored.channels]
    pixels = stored.pixels
    alpha = pixels[..., names.index("A"), None] if "A" in names else None
    if {"R", "G", "B"} <= set(names):
        return pixels[..., [names.index(letter) for letter in "RGB"]], alpha
    if len(names) == 1:
        return pixels, None
    if len(names) == 2 and alpha is not None:
        return pixels[..., 1 - names.index("A"), None], alpha
    raise ImageReadError(
        f"{stored.name}: found the channels {', '.join(stored.channels)}, "
        "wanted red, green and blue, or grey"
    )


def _to_light(
    colour: AnyPixels, alpha: AnyPixels | None, *, linear: bool, premultiplied: bool
) -> AnyPixels:
    """Decode to linear light and composite over black."""
    if alpha is None:
        return _unit(colour) if linear else _decode(colour)
    opacity = _unit(alpha)
    if premultiplied:
        return _unit(colour) if linear else _decode_premultiplied(colour, opacity)
    return (_unit(colour) if linear else _decode(colour)) * opacity


def _unit(values: AnyPixels) -> AnyPixels:
    """Full scale to 1; floats are there already."""
    if np.issubdtype(values.dtype, np.floating):
        return values.astype(np.float32, copy=False)
    return (values / np.float64(np.iinfo(values.dtype).max)).astype(np.float32)


def _decode(values: AnyPixels) -> AnyPixels:
    """sRGB to light through float64; by a table where every value fits into one."""
    if values.dtype in (np.uint8, np.uint16):
        full = np.iinfo(values.dtype).max
        table = srgb_decode(np.arange(full + 1) / full).astype(np.float32)
        return table[values]
    return srgb_decode(_unit(values)).astype(np.float32)


def _decode_premultiplied(values: AnyPixels, opacity: AnyPixels) -> AnyPixels:
    """Undo the multiplication where it was done, in sRGB, and redo it in linear light."""
    encoded = _unit(values).astype(np.float64)
    cover = np.where(opacity > 0, opacity, 1.0).astype(np.float64)
    return (srgb_decode(encoded / cover) * cover).astype(np.float32)
