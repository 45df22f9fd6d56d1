"""Linear light to 8-bit sRGB."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu import Block, Buffer, ComputePass, Device, Field, Texture
from vrlf.images import srgb_decode

CODES = 256

ENCODE = Block(
    "Encode",
    (
        Field("ivec2", "size_px", "width and height of the picture"),
        Field("int", "dither", "1 to spread the rounding error as fine noise"),
    ),
)


class Encode:
    """Owns the program and its table of thresholds."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._program = ComputePass(device, "encode.comp", ENCODE)
        self._thresholds = Buffer(device, threshold_table(), label="sRGB thresholds")

    def run(self, light: Texture, code: Texture, *, dither: bool = False) -> None:
        """Write the codes of ``light`` (rgba32f) into ``code`` (four 8-bit integers)."""
        light.bind_sampler(0)
        code.bind_image(0, read=False, write=True)
        self._thresholds.bind(0)
        self._program.set({"size_px": light.size_px, "dither": int(dither)})
        self._program.run(*light.size_px)
        self._device.check("encoding")

    def release(self) -> None:
        """Give program and table back."""
        self._program.release()
        self._thresholds.release()


def threshold_table() -> NDArray[np.float32]:
    """255 thresholds, one place unused, then the 256 values that the codes stand for.

    For ``shaders/include/srgb_codes.glsl``.
    """
    values = srgb_decode(np.arange(CODES) / (CODES - 1.0))
    return np.concatenate([rounding_thresholds(), [2.0], values]).astype(np.float32)


def rounding_thresholds() -> NDArray[np.float32]:
    """Least float32 value that is shown as code k + 1, shape (255,).

    Comparing with these is exact whatever a GPU's ``pow`` does: a float32 value reaches the
    threshold if and only if its exact encoding rounds up.
    """
    exact = srgb_decode((np.arange(CODES - 1) + 0.5) / (CODES - 1.0))
    nearest = exact.astype(np.float32)
    above = np.nextafter(nearest, np.float32(2.0))
    return np.where(nearest.astype(np.float64) >= exact, nearest, above)
