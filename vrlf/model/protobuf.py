"""The wire format of protocol buffers, as little of it as a viewer profile needs.

Protocol Buffers Documentation, "Encoding": a message is a row of fields, each a key (a varint:
the field's number times 8 plus its wire type) and a value. Strict: whatever does not end where
the bytes end is refused.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import IntEnum
from typing import Final, NamedTuple

_LONGEST_VARINT: Final = 10  # bytes: 64 bits, seven in each


class Wire(IntEnum):
    """How a field's value is written; 3 and 4, groups, are gone from the format."""

    VARINT = 0
    FIXED64 = 1
    BYTES = 2
    FIXED32 = 5


class WireField(NamedTuple):
    """A field: ``value`` is a number for a varint, else the value's own bytes."""

    number: int
    wire: Wire
    value: int | bytes


class WireError(ValueError):
    """The bytes are no message; the text says what was found in them."""


def fields_of(message: bytes) -> Iterator[WireField]:
    """The fields of a message, in the order of its bytes.

    Raises
    ------
    WireError
        Where the message ends within a field, or holds a wire type that there is not.
    """
    at = 0
    while at < len(message):
        key, at = _varint(message, at)
        number, kind = key >> 3, key & 7
        if number == 0 or kind not in set(Wire):
            raise WireError(f"a field {number} of the wire type {kind}, which there is not")
        wire = Wire(kind)
        if wire is Wire.VARINT:
            value, at = _varint(message, at)
            yield WireField(number, wire, value)
            continue
        length = {Wire.FIXED32: 4, Wire.FIXED64: 8}.get(wire)
        if length is None:
            length, at = _varint(message, at)
        if at + length > len(message):
            raise WireError(f"{len(message)} bytes, cut short within the field {number}")
        yield WireField(number, wire, message[at : at + length])
        at += length


def _varint(message: bytes, at: int) -> tuple[int, int]:
    """A number in groups of seven bits, the least first, and where it ends."""
    value = 0
    for place in range(_LONGEST_VARINT):
        if at + place >= len(message):
            raise WireError(f"{len(message)} bytes, cut short within a number")
        byte = message[at + place]
        value |= (byte & 0x7F) << 7 * place
        if byte < 0x80:
            return value, at + place + 1
    raise WireError("a number of more than ten bytes")
