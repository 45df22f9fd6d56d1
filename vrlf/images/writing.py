"""Writing pictures: encoded in memory first, then put in place in one step.

OpenImageIO cannot be trusted with a full disk (its PNG claims success, its
JPEG ends the process, its WebP hangs), so it never writes to one: it encodes
into memory, and Python's own write, which fails honestly, does the rest.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
import OpenImageIO
from numpy.typing import NDArray

from vrlf.errors import OutputError, OutputPathError
from vrlf.files import atomic_write_bytes, check_target, shown
from vrlf.images.oiio import MAX_SIDE_PX, take_error
from vrlf.images.srgb import quantise_srgb

AnyPixels = NDArray[Any]


@dataclass(frozen=True)
class _Format:
    name: str  # OpenImageIO's
    kinds: tuple[str, ...]  # numpy's names of the numbers that it stores
    keeps_names: bool = False  # any name of metadata, not just a description
    options: Mapping[str, str | int] = field(default_factory=dict)


_TIFF = _Format("tiff", ("uint8", "uint16"), options={"compression": "zip", "tiff:write_exif": 0})
# Full colour resolution: a panel image is read pixel by pixel.
_JPEG = _Format("jpeg", ("uint8",), options={"compression": "jpeg:95", "jpeg:subsampling": "4:4:4"})

_FORMATS: Final[Mapping[str, _Format]] = {
    ".exr": _Format("openexr", ("float32",), keeps_names=True, options={"compression": "zip"}),
    ".png": _Format("png", ("uint8", "uint16"), keeps_names=True),
    ".tif": _TIFF,
    ".tiff": _TIFF,
    ".jpg": _JPEG,
    ".jpeg": _JPEG,
    ".webp": _Format("webp", ("uint8",), options={"compression": "lossless:50"}),
    ".bmp": _Format("bmp", ("uint8",)),
}

PICTURE_ENDINGS: Final = tuple(_FORMATS)


def check_picture_target(path: str | os.PathLike[str]) -> Path:
    """Make sure that a picture can be written to ``path``, before any work is done for it.

    Returns
    -------
    Path
        The file that would be made or replaced.

    Raises
    ------
    OutputPathError
        An ending that is not in `PICTURE_ENDINGS`, or a place that cannot hold a file.
    """
    _format_of(path)
    return check_target(path)


def write_picture(
    path: str | os.PathLike[str],
    linear: NDArray[np.floating[Any]],
    *,
    bits: int = 8,
    metadata: Mapping[str, str] | None = None,
) -> None:
    """Write linear light: as it is to ``.exr``, clamped to [0, 1] and sRGB encoded to others.

    Parameters
    ----------
    path : path
        The ending, one of `PICTURE_ENDINGS`, names the format.
    linear : ndarray of float, shape (H, W, 3)
        Linear light, 1 for full drive, row 0 at the top.
    bits : {8, 10, 16}
        Width of the integers; 16, and 10 within 16, for PNG and TIFF only. An EXR is always
        float32.
    metadata : mapping of str to str, optional
        Goes into the file, each name behind ``vrlf:``; into the description of
        JPEG and TIFF, not at all into WebP and BMP.

    Raises
    ------
    OutputPathError
        An unknown ending, a width that the format has not, a place that cannot hold a file.
    OutputError
        NaN or infinite light, a full disk, a failing encoder. The target is as it was.
    ValueError
        The array is not a picture.
    """
    if linear.ndim != 3 or linear.shape[2] != 3 or not np.issubdtype(linear.dtype, np.floating):
        raise ValueError(f"found {linear.dtype} {linear.shape}, wanted floats (H, W, 3)")
    kind = _format_of(path)
    light = _finite_float32(linear, shown(path))
    if "float32" in kind.kinds:
        _write(path, light, ("R", "G", "B"), metadata)
    else:
        _write(path, quantise_srgb(linear, bits), ("R", "G", "B"), metadata)


def write_encoded(
    path: str | os.PathLike[str],
    encoded: NDArray[np.uint8] | NDArray[np.uint16],
    *,
    metadata: Mapping[str, str] | None = None,
) -> None:
    """Write integers that are sRGB encoded already, bit by bit where the format is lossless.

    Parameters
    ----------
    path : path
        As for `write_picture`, but no EXR, which holds linear light.
    encoded : ndarray of uint8 or uint16, shape (H, W, 3)
        sRGB values, row 0 at the top.
    metadata : mapping of str to str, optional
        As for `write_picture`.

    Raises
    ------
    OutputPathError, OutputError, ValueError
        As `write_picture`.
    """
    if encoded.ndim != 3 or encoded.shape[2] != 3 or encoded.dtype not in (np.uint8, np.uint16):
        raise ValueError(f"found {encoded.dtype} {encoded.shape}, wanted uint8 or 16 (H, W, 3)")
    _write(path, encoded, ("R", "G", "B"), metadata)


def write_channels(
    path: str | os.PathLike[str],
    channels: Mapping[str, NDArray[np.floating[Any]]],
    *,
    metadata: Mapping[str, str] | None = None,
) -> None:
    """Write named channels of numbers, not of light, as a float32 EXR.

    Parameters
    ----------
    path : path
        Ends in ``.exr``.
    channels : mapping of str to ndarray of float, shape (H, W)
        All of one shape.
    metadata : mapping of str to str, optional
        As for `write_picture`.

    Raises
    ------
    OutputPathError, OutputError, ValueError
        As `write_picture`.
    """
    if "float32" not in _format_of(path).kinds:
        raise OutputPathError(f"{shown(path)}: found '{Path(path).suffix}', wanted .exr")
    planes = np.stack([np.asarray(plane) for plane in channels.values()], axis=2)
    if planes.ndim != 3 or not np.issubdtype(planes.dtype, np.floating):
        raise ValueError(f"found {planes.dtype} {planes.shape[:2]}, wanted floats (H, W)")
    _write(path, _finite_float32(planes, shown(path)), tuple(channels), metadata)


def _format_of(path: str | os.PathLike[str]) -> _Format:
    ending = Path(path).suffix.lower()
    if ending not in _FORMATS:
        raise OutputPathError(
            f"{shown(path)}: found the ending '{ending}', wanted one of {' '.join(_FORMATS)}"
        )
    return _FORMATS[ending]


def _finite_float32(values: AnyPixels, name: str) -> NDArray[np.float32]:
    with np.errstate(over="ignore"):  # what float32 cannot hold is counted as infinite
        narrow = values.astype(np.float32)
    bad = np.count_nonzero(~np.isfinite(narrow))
    if bad:
        raise OutputError(
            f"{name}: found {bad} of {narrow.size} values NaN or infinite, wanted finite ones; "
            "nothing was written"
        )
    return narrow


def _write(
    path: str | os.PathLike[str],
    pixels: AnyPixels,
    channels: tuple[str, ...],
    metadata: Mapping[str, str] | None,
) -> None:
    name, kind = shown(path), _format_of(path)
    check_target(path)
    if str(pixels.dtype) not in kind.kinds:
        raise OutputPathError(
            f"{name}: found an ending for {' or '.join(kind.kinds)}, wanted one for {pixels.dtype}"
        )
    height, width = pixels.shape[:2]
    if not (0 < width <= MAX_SIDE_PX and 0 < height <= MAX_SIDE_PX):
        raise OutputError(
            f"{name}: found {width}x{height} pixels, wanted 1 to {MAX_SIDE_PX} a side"
        )
    spec = _spec(pixels, channels, kind, metadata or {})
    atomic_write_bytes(path, _encode(np.ascontiguousarray(pixels), spec, kind.name, name))


def _spec(
    pixels: AnyPixels, channels: tuple[str, ...], kind: _Format, metadata: Mapping[str, str]
) -> Any:
    """OpenImageIO's description of the file; nothing in it changes from day to day."""
    # "float32" would be an unknown type, which EXR silently takes for half.
    stored = {"float32": "float"}.get(str(pixels.dtype), str(pixels.dtype))
    spec = OpenImageIO.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], stored)
    spec.channelnames = channels
    spec.attribute("DateTime", "")  # else EXR and TIFF write the time of day
    if channels == ("R", "G", "B"):
        spec.attribute("oiio:ColorSpace", "lin_rec709" if stored == "float" else "sRGB")
    for option, value in kind.options.items():
        spec.attribute(option, value)
    named = {f"vrlf:{key}": value for key, value in sorted(metadata.items())}
    if kind.keeps_names:
        for key, value in named.items():
            spec.attribute(key, value)
    elif named:
        spec.attribute("ImageDescription", "; ".join(f"{k}={v}" for k, v in named.items()))
    return spec


def _encode(pixels: AnyPixels, spec: Any, kind: str, name: str) -> bytes:
    with _memory_file(_room_bytes(pixels), name) as scratch:
        output = OpenImageIO.ImageOutput.create(kind)
        if output is None or not output.open(scratch, spec):
            # write_image after a failed open would be a segmentation fault.
            raise _encoder_failed(name, take_error(*filter(None, (output,))))
        written = output.write_image(pixels)
        closed = output.close()
        fault = take_error(output)
        if fault or not (written and closed):
            raise _encoder_failed(name, fault)
        data = Path(scratch).read_bytes()
    if not data:
        raise _encoder_failed(name, "it made no bytes")
    return data


def _encoder_failed(name: str, fault: str) -> OutputError:
    return OutputError(
        f"{name}: found that the encoder failed ({fault or 'no reason given'}), "
        "wanted a whole file; nothing was written"
    )


def _room_bytes(pixels: AnyPixels) -> int:
    """More than any encoder here makes of incompressible pixels, headers and all."""
    return 2 * pixels.nbytes + 2**20


@contextlib.contextmanager
def _memory_file(room_bytes: int, name: str) -> Iterator[str]:
    """The path of an empty file that lives in memory and holds ``room_bytes`` for certain.

    Where a system has no such files it is one on the disk for temporary files,
    whose room is looked at first.
    """
    _check_file_size_limit(room_bytes, name)
    if hasattr(os, "memfd_create"):
        descriptor = os.memfd_create("vrlf")
        try:
            yield f"/proc/self/fd/{descriptor}"
        finally:
            os.close(descriptor)
        return
    with tempfile.TemporaryDirectory(prefix="vrlf-") as folder:
        free = shutil.disk_usage(folder).free
        if free < room_bytes:
            raise OutputError(
                f"{name}: found {free} bytes free in {folder}, wanted {room_bytes} to encode in"
            )
        yield str(Path(folder) / "picture")


def _check_file_size_limit(room_bytes: int, name: str) -> None:
    """A limit on file sizes (``ulimit -f``) holds in memory too, where it ends the process."""
    try:
        import resource
    except ImportError:  # Windows has neither the module nor the limit
        return
    limit, _ = resource.getrlimit(resource.RLIMIT_FSIZE)
    if limit not in (resource.RLIM_INFINITY, -1) and limit < room_bytes:
        raise OutputError(
            f"{name}: found a limit of {limit} bytes a file (ulimit -f), wanted {room_bytes} "
            "to be sure; nothing was written"
        )
