"""How far a perceived picture is from the target, as sums that are read without a wait."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu import Block, Buffer, ComputePass, Device, Field, Texture
from vrlf.gpu.compute import GROUP_PX
from vrlf.model import Rig
from vrlf.optics.viewport import SIDES
from vrlf.passes.fields import VIEWPORT_FIELDS, viewport_values

SQUARES = Block(
    "Squares",
    (
        *VIEWPORT_FIELDS,
        Field("ivec2", "borders", "of the left and the right eye: pixels left out at each side"),
    ),
)
# For each eye: enough to fill a large GPU, few enough to be read back in no time.
_GROUPS: Final = 128
_BEHIND: Final = 3  # frames in flight
Borders = tuple[int, int]


@dataclass(frozen=True)
class Sums:
    """What was summed, and over which pixels.

    Attributes
    ----------
    values : ndarray, shape (2, 3)
        Of each eye, with t the target and d = seen - t: the sums of t t, t d and d d.
    rig, borders
        As ``Squares.run`` was given them.
    """

    values: NDArray[np.float64]
    rig: Rig
    borders: Borders


@dataclass
class _Pending:
    buffer: Buffer
    rig: Rig
    borders: Borders
    age: int = 0


class Squares:
    """Owns the program, and the buffers in which results wait until the GPU has made them."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._behind = 0 if device.info.is_software else _BEHIND
        self._program = ComputePass(device, "squares.comp", SQUARES, defines={"GROUPS": _GROUPS})
        self._pending: deque[_Pending] = deque()
        self._spare: list[Buffer] = []

    @property
    def is_waiting(self) -> bool:
        """Whether a result is still to come."""
        return bool(self._pending)

    def run(self, rig: Rig, seen: Texture, target: Texture, borders: Borders) -> None:
        """Sum both eyes' pixels inside their borders; ``poll`` has the result some frames later.

        Parameters
        ----------
        seen, target : Texture
            On the panel's raster.
        borders : (int, int)
            Pixels left out at each side, of the left eye and of the right one. A border that
            leaves nothing makes sums of 0.
        """
        nbytes = len(SIDES) * _GROUPS * 16
        if not self._spare:
            self._spare.append(Buffer.reserved(self._device, nbytes, label="sums of squares"))
        buffer = self._spare.pop()
        self._pending.append(_Pending(buffer, rig, borders))
        target.bind_sampler(0)
        seen.bind_sampler(1)
        buffer.bind(0)
        self._program.set({**viewport_values(rig), "borders": borders})
        self._program.run(_GROUPS * GROUP_PX, GROUP_PX, len(SIDES))
        self._device.check("summing squares")

    def poll(self) -> Sums | None:
        """Once a frame: the newest sums that are there without a wait, if new ones are."""
        newest = None
        while self._pending and self._pending[0].age >= self._behind:
            newest = self._pending.popleft()
            self._spare.append(newest.buffer)
        for each in self._pending:
            each.age += 1
        if newest is None:
            return None
        partial = np.asarray(newest.buffer.read(np.float32), np.float64)
        values = partial.reshape(len(SIDES), _GROUPS, 4).sum(axis=1)[:, :3]
        return Sums(values, newest.rig, newest.borders)

    def release(self) -> None:
        """Give program and buffers back."""
        self._program.release()
        self._spare.extend(each.buffer for each in self._pending)
        self._pending.clear()
        while self._spare:
            self._spare.pop().release()
