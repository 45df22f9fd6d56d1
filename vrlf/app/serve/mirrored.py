"""The window's panel image for a phone: what ``drawing`` is without a window."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.app.encoder import Encoder
from vrlf.app.preview.loop import Preview
from vrlf.app.preview.session import Session
from vrlf.app.serve.drawing import eye_words, lens_axes, write_panel
from vrlf.app.serve.wire import Measured
from vrlf.gpu import Device
from vrlf.scene import HeadPose


class Mirrored:
    """Owns an encoder; the window is its maker's.

    Keys of the phone are the window's: what they change both show.
    """

    def __init__(self, preview: Preview, device: Device, folder: Path, rig_name: str) -> None:
        self._preview, self._folder, self._rig_name = preview, folder, rig_name
        self._encoder = Encoder(device, preview.session.rig)
        panel = preview.session.rig.panel
        self.size_px = panel.width_px, panel.height_px
        self._sent: Any = None
        self.has_latency = False

    @property
    def fault(self) -> str:
        """Why the phone's picture stands still, if it does."""
        panel = self.session.rig.panel
        is_same = (panel.width_px, panel.height_px) == self.size_px
        return "" if is_same else "the rig has another panel now: start the window again"

    @property
    def session(self) -> Session:
        """The window's."""
        return self._preview.session

    @session.setter
    def session(self, session: Session) -> None:
        self._preview.session = session

    def frame(self, _: HeadPose, passed_s: float) -> NDArray[np.uint8] | None:  # noqa: ARG002
        """The panel image of the window's last frame, if it is another one."""
        number, light = self._preview.frames.panel
        if number == self._sent or light.size_px != self.size_px:
            return None
        self._sent = number
        return self._encoder.codes(light)

    def press(self, chord: str) -> str:
        """Hand a key on to the window."""
        self._preview.take_chord(chord)
        return ""

    def prompts(self) -> tuple[str, str]:
        """For each eye its prescription."""
        return eye_words(self.session)

    def axes(self) -> tuple[float, float]:
        """Where each lens's axis meets the panel, in shares of its width: words stand there."""
        return lens_axes(self.session.rig)

    def write_panel(self, measured: Measured) -> str:
        """Write a rig with the panel that was measured; what to say of it."""
        return write_panel(measured, self.session.rig, self._folder, self._rig_name)

    def release(self) -> None:
        """Give the encoder back."""
        self._encoder.release()
