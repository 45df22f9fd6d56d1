"""The target sharpened before the forward prefilter, by a small convolution for each eye.

The whole kernel is applied at once: behind arrays it has a rank of 5 to 20, so that separable
parts would cost as many reads, and pictures to keep them in. Four neighbours of a row made by
one invocation cut the time to a third. Software GL, two cores, 1334 x 750 pixels: 5 x 5 taps
take 75 ms, 7 x 7 115 ms, 9 x 9 160 ms, 17 x 17 445 ms.
"""

from __future__ import annotations

from math import ceil
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vrlf.gpu import Block, Buffer, ComputeVariants, Device, Field, Texture
from vrlf.model import Rig
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import SIDES
from vrlf.passes.fields import VIEWPORT_FIELDS, viewport_values

SHARPEN = Block(
    "Sharpen",
    (
        *VIEWPORT_FIELDS,
        Field("ivec4", "shifts", "right and down, from a pixel to the middle tap's, each eye", 2),
    ),
)
# As in the shader.
_PER_ROW = 4


class SharpenTables:
    """A kernel for each eye and colour on the GPU.

    Parameters
    ----------
    device : Device
    rig : Rig
    taps : ndarray (2, 3, 2 r + 1, 2 r + 1)
        Eye, colour, row, column: what the target at pixel + (column - r, row - r) + shift
        counts in the sharpened pixel.
    shift_px : array_like (2, 2)
        Whole pixels right and down, for each eye.
    """

    def __init__(self, device: Device, rig: Rig, taps: Float, shift_px: ArrayLike) -> None:
        self.size_px = (rig.panel.width_px, rig.panel.height_px)
        self.radius = taps.shape[-1] // 2
        # The shader makes several pixels of a row at once: zeros part a row from the next.
        rgba = np.zeros((2, taps.shape[-2], taps.shape[-1] + _PER_ROW - 1, 4), np.float32)
        rgba[:, :, : taps.shape[-1], :3] = np.moveaxis(taps, 1, -1)
        self.taps = Buffer(device, rgba, label="sharpening taps")
        shifts = np.zeros((2, 4), np.int32)
        shifts[:, :2] = shift_px
        self.values: dict[str, Any] = {**viewport_values(rig), "shifts": shifts}

    def release(self) -> None:
        """Give the taps back."""
        self.taps.release()


class Sharpen:
    """Owns the programs, one for each size of kernel met so far."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._programs = ComputeVariants(device, "sharpen.comp", SHARPEN)

    def run(self, tables: SharpenTables, target: Texture, sharpened: Texture) -> None:
        """Write ``target``, sharpened, into ``sharpened`` (rgba32f, the panel's size)."""
        program = self._programs.get({"RADIUS": tables.radius})
        target.bind_sampler(0)
        sharpened.bind_image(0, read=False, write=True)
        tables.taps.bind(0)
        program.set(tables.values)
        width_px, height_px = tables.values["view_px"]
        program.run(ceil(width_px / _PER_ROW), height_px, len(SIDES))
        self._device.check("sharpening")

    def release(self) -> None:
        """Give the programs back."""
        self._programs.release()
