"""The newest frame, from the process that draws to the process that sends; neither waits.

Shared memory holds three slots. The drawer fills one that is not the newest and then names it; the
sender copies the newest and looks whether its number stayed the same while it did (a sequence lock:
odd while being written). With three slots a copy is disturbed only where two more frames are
finished during it, and then there is a newer one to take.
"""

from __future__ import annotations

import struct
import time
from dataclasses import dataclass
from multiprocessing.shared_memory import SharedMemory
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

_SLOTS = 3
# Of all: the newest slot's number, the beat of the drawer, the frames so far.
_HEAD = struct.Struct("<qdq")
# Of a slot: its lock, the frame's number, width, height, then times.
_SLOT = struct.Struct("<qqiidddd")
_SLOT_BYTES = 64
assert _SLOT.size <= _SLOT_BYTES


@dataclass(frozen=True)
class Stamp:
    """What a frame was made from, and when.

    Attributes
    ----------
    number : int
        Counted from 1.
    size_px : (width, height)
    sensor_ms : float
        Of the turn that it was drawn for, by the phone's clock; NaN without one.
    heard_s, began_s, ended_s : float
        When that turn was heard, when the frame's work began and ended: this machine's clock.
    """

    number: int
    size_px: tuple[int, int]
    sensor_ms: float
    heard_s: float
    began_s: float
    ended_s: float


class Slots:
    """Owns a block of shared memory, or a view of another process's."""

    def __init__(self, most_pixels: int, *, name: str | None = None) -> None:
        self.most_pixels = most_pixels
        self._slot_bytes = _SLOT_BYTES + 3 * most_pixels
        size = _SLOT_BYTES + _SLOTS * self._slot_bytes
        self._is_owner = name is None
        self._memory = SharedMemory(name=name, create=name is None, size=size if not name else 0)
        self._lock = 0
        if self._is_owner:
            _HEAD.pack_into(self._buffer, 0, -1, time.monotonic(), 0)

    @property
    def name(self) -> str:
        """For the other process."""
        return self._memory.name

    @property
    def _buffer(self) -> memoryview:
        buffer = self._memory.buf
        assert buffer is not None
        return buffer

    # The drawer's side

    def beat(self) -> None:
        """Say that the drawer is alive, whether there is a new frame or not."""
        newest, _, frames = _HEAD.unpack_from(self._buffer, 0)
        _HEAD.pack_into(self._buffer, 0, newest, time.monotonic(), frames)

    def put(self, codes: NDArray[np.uint8], stamp: Stamp) -> None:
        """Make a frame the newest.

        Parameters
        ----------
        codes : ndarray, shape (height, width, 3)
        stamp : Stamp
        """
        if codes.size > 3 * self.most_pixels:  # it would run over into the next slot
            raise ValueError(f"found {codes.size} bytes, wanted at most {3 * self.most_pixels}")
        newest, _, frames = _HEAD.unpack_from(self._buffer, 0)
        slot = (newest + 1) % _SLOTS
        start = self._start(slot)
        self._lock += 2
        times = (stamp.sensor_ms, stamp.heard_s, stamp.began_s, stamp.ended_s)
        whole = (stamp.number, *stamp.size_px, *times)
        _SLOT.pack_into(self._buffer, start, self._lock - 1, *whole)
        begin = start + _SLOT_BYTES
        np.frombuffer(self._buffer, np.uint8, codes.size, begin)[:] = codes.reshape(-1)
        _SLOT.pack_into(self._buffer, start, self._lock, *whole)
        _HEAD.pack_into(self._buffer, 0, slot, time.monotonic(), frames + 1)

    # The sender's side

    @property
    def beat_s(self) -> float:
        """When the drawer last said that it is alive."""
        return float(_HEAD.unpack_from(self._buffer, 0)[1])

    @property
    def frames(self) -> int:
        """How many there were so far."""
        return int(_HEAD.unpack_from(self._buffer, 0)[2])

    def newest(self) -> tuple[Stamp, bytes] | None:
        """The newest frame, row by row from the top, three bytes a pixel; None before any."""
        for _ in range(_SLOTS):
            slot = _HEAD.unpack_from(self._buffer, 0)[0]
            if slot < 0:
                return None
            start = self._start(slot)
            lock, number, width, height, *times = _SLOT.unpack_from(self._buffer, start)
            if lock % 2:
                continue
            begin = start + _SLOT_BYTES
            data = bytes(self._buffer[begin : begin + 3 * width * height])
            if _SLOT.unpack_from(self._buffer, start)[0] == lock:
                return Stamp(number, (width, height), *times), data
        return None

    def _start(self, slot: int) -> int:
        return _SLOT_BYTES + slot * self._slot_bytes

    def forget_name(self) -> None:
        """Once the other process has it open: whoever is killed then, nothing stays behind."""
        if self._is_owner:
            self._memory.unlink()
            self._is_owner = False

    def release(self) -> None:
        """Give the memory back; the owner's leaves the system."""
        self._memory.close()
        self.forget_name()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.release()
