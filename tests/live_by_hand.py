"""Something to show that is known exactly: random light, another one at each time and pose."""

from __future__ import annotations

from typing import Any

import numpy as np
import pass_rigs
from numpy.typing import NDArray

from vrlf.gpu import Texture
from vrlf.model import Rig
from vrlf.scene import HeadPose


def light_at(rig: Rig, time_s: float = 0.0, head: HeadPose | None = None) -> NDArray[np.float32]:
    """What is shown at a time, on the panel's raster."""
    yaw = 0.0 if head is None else head.yaw_deg
    light = pass_rigs.picture(rig, round(1000 * time_s + 10 * abs(yaw)))
    if rig.panel.width_px % 2:
        light[:, rig.panel.width_px // 2] = 0.0
    return light


class Known:
    """A ``Live`` that counts how often it was drawn."""

    def __init__(self, *, is_still: bool = True) -> None:
        self.has_time = self.has_head = not is_still
        self.duration_s: float | None = None
        self.fault: str | None = None
        self.drawn, self.released = 0, False
        self.fails: Exception | None = None

    def draw(self, target: Texture, rig: Rig, *, time_s: float, head: HeadPose) -> None:
        if self.fails is not None:
            raise self.fails
        self.drawn += 1
        light: NDArray[Any] = light_at(rig) if not self.has_time else light_at(rig, time_s, head)
        target.write(light)

    def ease(self, samples: int) -> None:
        pass

    def release(self) -> None:
        self.released = True
