"""What the eyes are spared: on a fault the last good picture stays and fades to grey."""

from __future__ import annotations

from contextlib import ExitStack, suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.errors import DeviceError, VrlfError
from vrlf.gpu import Device, Texture
from vrlf.gpu.screen import Screen
from vrlf.optics.tile import GREY_CODE

# From a picture to grey or back: more than the 200 ms under which a change is a flash.
FADING_S = 0.4
# Of the way at once, however long a frame took: never a jump.
_MOST_AT_ONCE = 0.1
_LOST_AFTER = 3  # faults of the GPU in a row


class Fade:
    """How far the picture has given way to grey: 0 the picture, 1 grey."""

    def __init__(self) -> None:
        self.level = 0.0

    def step(self, seconds: float, *, is_faulty: bool) -> float:
        """Go on toward grey, or back to the picture."""
        share = min(max(seconds, 0.0) / FADING_S, _MOST_AT_ONCE)
        self.level = min(max(self.level + (share if is_faulty else -share), 0.0), 1.0)
        return self.level


class Guard:
    """Stands between faults and the window.

    Attributes
    ----------
    fade : Fade
    fault : str or None
        What is wrong now.
    """

    def __init__(self, device: Device, screen: Screen) -> None:
        self._device, self._screen = device, screen
        self._held: NDArray[np.uint8] | None = None
        self._in_a_row = 0
        self.fade = Fade()
        self.fault: str | None = None

    def passed(self) -> bool:
        """A frame went well; whether one before it did not."""
        was_faulty = self.fault is not None
        self.fault, self._held, self._in_a_row = None, None, 0
        return was_faulty

    def caught(self, error: Exception, canvas: Texture | None) -> str | None:
        """Take a frame's fault and hold what ``canvas`` shows; the fault in words if it is new.

        Raises
        ------
        DeviceError
            If the GPU is lost: nothing will be drawn again.
        """
        self._in_a_row += 1
        text = words_of(error)
        is_new, self.fault = text != self.fault, text
        if self._held is None and canvas is not None:
            self._held = _read(canvas)
        if self._in_a_row >= _LOST_AFTER and self._is_lost():
            raise DeviceError(f"GPU: found its context lost ({text}), wanted it to stay") from error
        return text if is_new else None

    def show(self, size_px: tuple[int, int], passed_s: float) -> bool:
        """The last good picture on its way to grey; whether there is some way left."""
        level = self.fade.step(passed_s, is_faulty=True)
        held = self._held
        if held is None or held.shape[1::-1] != size_px:
            held, level = np.zeros((size_px[1], size_px[0], 4), np.uint8), 1.0
        # A GPU that fails at this too is tried again, until ``caught`` calls it lost.
        with suppress(DeviceError), ExitStack() as owned:
            canvas = Texture(self._device, size_px, kind="f1", label="held picture")
            owned.callback(canvas.release)
            canvas.write(faded(held, level))
            self._screen.show(canvas)
        return level < 1.0

    def _is_lost(self) -> bool:
        """Whether not even a small texture can be had."""
        try:
            Texture(self._device, (4, 4), kind="f1", label="probe").release()
        except DeviceError:
            return True
        return False


def words_of(error: Exception) -> str:
    """An error in one line; of what was not raised on purpose its kind too."""
    if isinstance(error, VrlfError):
        return str(error)
    return " ".join(f"{type(error).__name__}: {error}".split())


def _read(canvas: Texture) -> NDArray[np.uint8] | None:
    try:
        return np.asarray(canvas.read(), np.uint8)
    except DeviceError:
        return None


def faded(codes: NDArray[np.uint8], level: float) -> NDArray[Any]:
    """Codes on the way to grey, by the CPU alone: the GPU may be what failed."""
    away = GREY_CODE - codes.astype(np.float32)
    return np.floor(codes + level * away + 0.5).astype(np.uint8)
