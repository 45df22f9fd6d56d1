"""What the eyes are spared: on a fault the last good picture stays and fades to grey."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.optics.tile import GREY_CODE

# From a picture to grey or back: more than the 200 ms under which a change is a flash.
FADING_S = 0.4


class Fade:
    """How far the picture has given way to grey: 0 the picture, 1 grey."""

    def __init__(self) -> None:
        self.level = 0.0

    def step(self, seconds: float, *, is_faulty: bool) -> float:
        """Go on toward grey, or back; at most a tenth of the way at once, however long a
        frame took."""
        share = min(max(seconds, 0.0) / FADING_S, 0.1)
        self.level = min(max(self.level + (share if is_faulty else -share), 0.0), 1.0)
        return self.level


def faded(codes: NDArray[np.uint8], level: float) -> NDArray[Any]:
    """Codes on the way to grey, by the CPU alone: the GPU may be what failed."""
    away = GREY_CODE - codes.astype(np.float32)
    return np.floor(codes + level * away + 0.5).astype(np.uint8)
