"""What goes over the socket: frames one way, small JSON messages the other.

A frame is ``HEAD`` and then its pixels, row by row from the top, red, green, blue, in one of
``ENCODINGS``. Every message of a phone is checked here, and only here; what does not fit closes
its socket.
"""

from __future__ import annotations

import json
import math
import struct
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from vrlf.app.serve.slots import Stamp

# No message of a phone is longer.
MOST_MESSAGE_BYTES: Final = 4096
RAW, DEFLATE = "raw", "deflate"
ENCODINGS: Final = (RAW, DEFLATE)
# Magic, version, encoding, number, width, height; then, ms: the sensor's time by the phone's
# clock, and how long the turn waited for a frame, the frame for its drawing, its encoding.
HEAD: Final = struct.Struct("<2sBBIHHd3f")
# Parts of a deflated frame; before them their lengths.
STRIPS: Final = 4
_LENGTHS: Final = struct.Struct(f"<{STRIPS}I")
_MAGIC, _VERSION = b"VF", 1
# Prefiltered light is close to noise: a higher level gains 2 % of bytes and costs twice the time.
_LEVEL = 1


class MessageError(ValueError):
    """A message that no phone of ours sends; its text is for the log."""


@dataclass(frozen=True)
class Hello:
    """What a phone says of its screen, in its first message.

    Attributes
    ----------
    css_px : (width, height)
        Of the whole screen, in the page's pixels.
    ratio : float
        Device pixels for each of those.
    can_inflate : bool
        Whether it unpacks ``DEFLATE``.
    """

    css_px: tuple[float, float]
    ratio: float
    can_inflate: bool = True

    @property
    def device_px(self) -> tuple[int, int]:
        """About the screen's own pixels, the long side first."""
        sides = sorted((round(side * self.ratio) for side in self.css_px), reverse=True)
        return sides[0], sides[1]

    def may_have(self, width_px: int, height_px: int) -> bool:
        """Whether this may be a screen of so many pixels, however it is turned.

        Browsers tell whole pixels of the page, rounded or upward: 1080 by 2400 at a ratio of 2.625
        is told as 412 by 915. The page itself measures exactly, once it fills the screen.
        """
        sides = zip(sorted(self.css_px), sorted((width_px, height_px)), strict=True)
        return all(abs(css * self.ratio - px) < self.ratio for css, px in sides)


@dataclass(frozen=True)
class Shown:
    """A frame is on the canvas.

    Attributes
    ----------
    number : int
    photon_ms : float or None
        From the sensor's time to the frame's being shown.
    """

    number: int
    photon_ms: float | None


@dataclass(frozen=True)
class Turn:
    """W3C's angles, the screen's own, and the sensor's time by the phone's clock."""

    alpha_deg: float
    beta_deg: float
    gamma_deg: float
    screen_deg: float
    at_ms: float


@dataclass(frozen=True)
class Pressed:
    """A key, a pad's button or a tap, by the name of the preview's table."""

    chord: str


@dataclass(frozen=True)
class Measured:
    """A panel by what the phone reports and a card that was held against it."""

    size_px: tuple[int, int]
    pixel_pitch_um: float


@dataclass(frozen=True)
class Beat:
    """Asks whether somebody is there; is answered."""


Message = Hello | Shown | Turn | Pressed | Measured | Beat


def message_of(text: str | bytes) -> Message:
    """Read a phone's message.

    Raises
    ------
    MessageError
        If it is none.
    """
    if not isinstance(text, str):
        raise MessageError("bytes for a message")
    try:
        found = json.loads(text, parse_constant=_no_number)
    except (ValueError, RecursionError) as error:
        raise MessageError("no JSON") from error
    if not isinstance(found, dict):
        raise MessageError("no object")
    read = _READERS.get(str(found.get("t")))
    if read is None:
        raise MessageError("unknown kind")
    return read(found)


def _no_number(name: str) -> float:
    raise ValueError(name)


def _number(found: Mapping[str, Any], key: str, least: float, most: float) -> float:
    value: Any = found.get(key)
    if type(value) not in (int, float) or not math.isfinite(value) or not least <= value <= most:
        raise MessageError(f"{key} is no number from {least:g} to {most:g}")
    return float(value)


def _whole(found: Mapping[str, Any], key: str, least: int, most: int) -> int:
    value = _number(found, key, least, most)
    if value != int(value):
        raise MessageError(f"{key} is not whole")
    return int(value)


def _hello(found: Mapping[str, Any]) -> Hello:
    css = _number(found, "width", 1, 32768), _number(found, "height", 1, 32768)
    return Hello(css, _number(found, "ratio", 0.1, 16), found.get("inflates", True) is True)


def _shown(found: Mapping[str, Any]) -> Shown:
    has_photon = found.get("photon") is not None
    photon_ms = _number(found, "photon", 0, 1e6) if has_photon else None
    return Shown(_whole(found, "number", 0, 2**32 - 1), photon_ms)


def _turn(found: Mapping[str, Any]) -> Turn:
    alpha, beta, gamma, screen = (
        _number(found, key, -720, 720) for key in ("alpha", "beta", "gamma", "screen")
    )
    return Turn(alpha, beta, gamma, screen, _number(found, "at", 0, 1e15))


def _pressed(found: Mapping[str, Any]) -> Pressed:
    chord = found.get("chord")
    if not isinstance(chord, str) or not 1 <= len(chord) <= 24 or not chord.isascii():
        raise MessageError("chord is no key's name")
    return Pressed(chord)


def _measured(found: Mapping[str, Any]) -> Measured:
    size = _whole(found, "width", 2, 16384), _whole(found, "height", 2, 16384)
    return Measured(size, _number(found, "pitch_um", 1, 1000))


_READERS: Final[Mapping[str, Callable[[Mapping[str, Any]], Message]]] = {
    "hello": _hello,
    "shown": _shown,
    "turn": _turn,
    "key": _pressed,
    "panel": _measured,
    "beat": lambda _: Beat(),
}


def strips(data: bytes, encoding: str) -> list[bytes]:
    """A frame's pixels in the parts that are encoded by themselves, so that cores share them."""
    if encoding == RAW:
        return [data]
    length = -(-len(data) // STRIPS)
    return [data[start : start + length] for start in range(0, STRIPS * length, length)]


def encoded(strip: bytes) -> bytes:
    """A part of a frame, smaller."""
    return zlib.compress(strip, _LEVEL)


def joined(parts: Sequence[bytes]) -> bytes:
    """What goes over the link for encoded parts: their lengths, then they themselves."""
    return b"".join((_LENGTHS.pack(*(len(part) for part in parts)), *parts))


def frame_head(stamp: Stamp, encoding: str, encode_ms: float) -> bytes:
    """What stands before a frame's pixels."""
    has_turn = not math.isnan(stamp.sensor_ms)
    waited_ms = 1e3 * (stamp.began_s - stamp.heard_s) if has_turn else 0.0
    drawn_ms = 1e3 * (stamp.ended_s - stamp.began_s)
    number = stamp.number % 2**32
    return HEAD.pack(
        _MAGIC, _VERSION, ENCODINGS.index(encoding), number, *stamp.size_px, stamp.sensor_ms,
        waited_ms, drawn_ms, encode_ms,
    )  # fmt: skip


class Link:
    """What one phone's link has carried: chooses the encoding that it carries faster.

    The time of a frame is from the start of its encoding until the phone says that it is shown.
    The slower encoding is tried again from time to time: a link changes.
    """

    TRIED_EVERY = 90
    _SMOOTHING = 0.25

    def __init__(self, encodings: tuple[str, ...] = ENCODINGS) -> None:
        self._encodings = encodings
        self._ms: dict[str, float] = {}
        self._sent = 0
        self.can_inflate = True

    def choose(self) -> str:
        """The encoding of the next frame."""
        if not self.can_inflate:
            return RAW
        self._sent += 1
        untried = [each for each in self._encodings if each not in self._ms]
        if untried:
            return untried[0]
        best = min(self._encodings, key=lambda each: self._ms[each])
        others = [each for each in self._encodings if each != best]
        return others[0] if others and self._sent % self.TRIED_EVERY == 0 else best

    def took(self, encoding: str, milliseconds: float) -> None:
        """A frame was shown."""
        before = self._ms.get(encoding, milliseconds)
        self._ms[encoding] = before + self._SMOOTHING * (milliseconds - before)

    @property
    def milliseconds(self) -> Mapping[str, float]:
        """Of each encoding, smoothed."""
        return dict(self._ms)
