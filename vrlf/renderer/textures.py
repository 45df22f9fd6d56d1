"""Textures of one step of the GPU's renderer."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.renderer.steps import Image


class Textures:
    """Textures of one step, released together whatever happens."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._made: list[Texture] = []

    def texture(self, size_px: tuple[int, int], kind: str, label: str) -> Texture:
        """An empty one."""
        self._made.append(Texture(self._device, size_px, kind=kind, label=label))
        return self._made[-1]

    def panel(self, rig: Rig, label: str) -> Texture:
        """An empty one of the panel's size."""
        return self.texture((rig.panel.width_px, rig.panel.height_px), "f4", label)

    def holding(self, image: NDArray[Any], label: str) -> Texture:
        """One with a picture in it."""
        pixels = np.ascontiguousarray(image, dtype=np.float32)
        self._device.require_texture_size(image.shape[1], image.shape[0], label)
        self._made.append(Texture.from_array(self._device, pixels, label=label))
        return self._made[-1]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for texture in self._made:
            texture.release()


def rgb(texture: Texture) -> Image:
    """What a texture holds, without its fourth channel."""
    return np.ascontiguousarray(texture.read()[..., :3], dtype=np.float32)
