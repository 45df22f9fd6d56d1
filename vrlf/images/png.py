"""Finds the faults of a PNG before libpng does, which prints its own line to standard error."""

from __future__ import annotations

import os
import struct
import zlib
from typing import BinaryIO

_SIGNATURE = b"\x89PNG\r\n\x1a\n"


def png_fault(path: str | os.PathLike[str]) -> str | None:
    """Say why libpng would refuse the file.

    Parameters
    ----------
    path : path
        A readable file of any kind.

    Returns
    -------
    str or None
        The fault in words; None for a sound PNG and for a file that is no PNG.

    Raises
    ------
    OSError
        The file cannot be read.
    """
    with open(path, "rb") as file:
        if file.read(len(_SIGNATURE)) != _SIGNATURE:
            return None
        return _chunk_fault(file, os.fstat(file.fileno()).st_size)


def _chunk_fault(file: BinaryIO, size_bytes: int) -> str | None:
    """Walk the chunks from behind the signature to IEND (PNG, third edition, 5.3)."""
    first = True
    while True:
        header = file.read(8)
        if len(header) < 8:
            return "a truncated PNG"
        length, kind = struct.unpack(">I4s", header)
        if not (kind.isalpha() and kind[2:3].isupper()):  # 5.4: letters, the third upper-case
            return "a damaged PNG (the name of a chunk)"
        if length + 4 > size_bytes - file.tell():  # before reading: a length can claim 4 GiB
            return "a truncated PNG"
        body = file.read(length + 4)
        data, checksum = body[:length], struct.unpack(">I", body[length:])[0]
        # An upper-case first letter marks a chunk that no reader can do without.
        if kind[:1].isupper() and zlib.crc32(kind + data) != checksum:
            return f"a damaged PNG (checksum of its {kind.decode('ascii', 'replace')} chunk)"
        if first:
            fault = _header_fault(kind, data)
            if fault is not None:
                return fault
            first = False
        if kind == b"IEND":
            return None


def _header_fault(kind: bytes, data: bytes) -> str | None:
    if kind != b"IHDR" or len(data) != 13:
        return "a PNG without a header"
    width, height = struct.unpack(">II", data[:8])
    return f"a PNG of {width}x{height} pixels" if 0 in (width, height) else None
