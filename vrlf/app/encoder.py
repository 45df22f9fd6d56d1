"""A picture on the GPU as the codes that files hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.passes import Encode


class Encoder:
    """Owns the encode pass and the picture it writes into."""

    def __init__(self, device: Device, rig: Rig) -> None:
        size = (rig.panel.width_px, rig.panel.height_px)
        self._code = Texture(device, size, kind="u1", label="encoded")
        try:
            self._encode = Encode(device)
        except BaseException:
            self._code.release()
            raise

    def codes(self, light: Texture) -> NDArray[np.uint8]:
        """8-bit sRGB."""
        self._encode.run(light, self._code)
        return np.ascontiguousarray(self._code.read()[..., :3])

    def release(self) -> None:
        """Give both back."""
        self._encode.release()
        self._code.release()
