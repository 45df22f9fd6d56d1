"""How near the perceived picture comes to the target, live, some frames late."""

from __future__ import annotations

from math import isfinite
from typing import Any

from vrlf.evaluation.live import LiveLikeness, borders_px, live_likeness
from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.optics.viewport import Side
from vrlf.passes.squares import Squares


class Likening:
    """Owns the pass, and remembers what it was last asked and what it found."""

    def __init__(self, device: Device) -> None:
        self._squares = Squares(device)
        self._asked: Any = None
        self._rig: Rig | None = None
        self._borders = (0, 0)
        self.found: dict[Side, LiveLikeness] = {}

    @property
    def is_waiting(self) -> bool:
        """Whether a number is still to come."""
        return self._squares.is_waiting

    def update(self, version: int, rig: Rig, seen: Texture, target: Texture) -> None:
        """Once a frame in which all of ``seen`` is there: measure it, if ``version`` is another."""
        if rig != self._rig:
            self._rig, self._borders = rig, borders_px(rig)
        if version != self._asked:
            self._squares.run(rig, seen, target, self._borders)
            self._asked = version
        self._poll()

    def _poll(self) -> None:
        sums = self._squares.poll()
        if sums is not None:
            self.found = live_likeness(sums)

    def forget(self) -> None:
        """Nothing whole is seen, or it is not meant to be like the target."""
        self._squares.poll()
        self.found, self._asked = {}, None

    @property
    def words(self) -> str:
        """For the window's lower edge; empty where there is nothing to say."""
        return "   ".join(f"{side} {_said(each)}" for side, each in self.found.items())

    def release(self) -> None:
        """Give the pass back."""
        self._squares.release()


def _said(each: LiveLikeness) -> str:
    if not isfinite(each.psnr_db):
        return "the target itself"
    return f"{each.psnr_db:.1f} dB (RMSE {each.rmse:.4f})"
