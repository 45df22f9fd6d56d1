"""Picture files put together byte by byte, so that no library judges itself."""

from __future__ import annotations

import struct
import zlib

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]


def asymmetric(height: int = 5, width: int = 7) -> Bytes:
    """A picture that no flip, turn or swap of channels leaves as it is."""
    rows, columns = np.mgrid[0:height, 0:width]
    return np.stack(
        [20 + 31 * rows, 10 + 29 * columns, 200 - 17 * rows - 5 * columns], axis=2
    ).astype(np.uint8)


def png_chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(pixels: NDArray[np.unsignedinteger], *extra_chunks: bytes) -> bytes:
    """(H, W, C) uint8 or uint16; 1: grey, 2: grey and alpha, 3: RGB, 4: RGBA."""
    height, width, channels = pixels.shape
    colour_type = {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    depth = 8 * pixels.dtype.itemsize
    big_endian = pixels.astype(pixels.dtype.newbyteorder(">"))
    rows = b"".join(b"\0" + row.tobytes() for row in big_endian)
    header = struct.pack(">IIBBBBB", width, height, depth, colour_type, 0, 0, 0)
    return b"".join(
        [
            b"\x89PNG\r\n\x1a\n",
            png_chunk(b"IHDR", header),
            *extra_chunks,
            png_chunk(b"IDAT", zlib.compress(rows)),
            png_chunk(b"IEND", b""),
        ]
    )


def png_header(width: int, height: int) -> bytes:
    """A PNG of 69 bytes that claims any size."""
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + png_chunk(b"IHDR", header)
        + png_chunk(b"IDAT", zlib.compress(b""))
        + png_chunk(b"IEND", b"")
    )


def ppm(pixels: Bytes) -> bytes:
    height, width, _ = pixels.shape
    return f"P6\n{width} {height}\n255\n".encode() + pixels.tobytes()


def ppm_text(pixels: Bytes) -> bytes:
    height, width, _ = pixels.shape
    return f"P3\n{width} {height}\n255\n{' '.join(map(str, pixels.ravel()))}\n".encode()


def ppm_16(pixels: Bytes) -> bytes:
    height, width, _ = pixels.shape
    wide = (pixels.astype(np.uint16) * 257).astype(">u2")
    return f"P6\n{width} {height}\n65535\n".encode() + wide.tobytes()


def bmp(pixels: Bytes, *, top_down: bool = False) -> bytes:
    """Rows from the bottom up, blue first, padded to 4 bytes."""
    height, width, _ = pixels.shape
    pad = b"\0" * (-3 * width % 4)
    rows = pixels if top_down else pixels[::-1]
    body = b"".join(row[:, ::-1].tobytes() + pad for row in rows)
    signed_height = -height if top_down else height
    info = struct.pack("<IiiHHIIiiII", 40, width, signed_height, 1, 24, 0, len(body), 0, 0, 0, 0)
    return b"BM" + struct.pack("<IHHI", 54 + len(body), 0, 0, 54) + info + body


def bmp_header(width: int, height: int) -> bytes:
    """A BMP of 74 bytes that claims any size."""
    info = struct.pack("<IiiHHIIiiII", 40, width, height, 1, 24, 0, 0, 0, 0, 0, 0)
    return b"BM" + struct.pack("<IHHI", 74, 0, 0, 54) + info + b"\0" * 20


def tga(pixels: Bytes, *, from_top: bool, from_right: bool) -> bytes:
    """Blue first; the descriptor says in which corner the raster starts."""
    height, width, _ = pixels.shape
    raster = pixels if from_top else pixels[::-1]
    raster = raster[:, ::-1] if from_right else raster
    descriptor = (0x20 if from_top else 0) | (0x10 if from_right else 0)
    header = struct.pack("<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, width, height, 24, descriptor)
    return header + raster[..., ::-1].tobytes()


def pfm(pixels: NDArray[np.float32], *, big_endian: bool) -> bytes:
    """Rows from the bottom up; the sign of the scale says the byte order."""
    height, width, _ = pixels.shape
    body = pixels[::-1].astype(">f4" if big_endian else "<f4").tobytes()
    return f"PF\n{width} {height}\n{'1.0' if big_endian else '-1.0'}\n".encode() + body


def hdr(raster: Bytes, resolution: str) -> bytes:
    """Flat RGBE with the exponent of 1: every byte is that many 256ths of light."""
    exponent = np.full((*raster.shape[:2], 1), 128, np.uint8)
    body = np.concatenate([raster, exponent], axis=2).tobytes()
    return f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{resolution}\n".encode() + body
