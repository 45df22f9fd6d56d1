"""What can be shown frame after frame."""

from __future__ import annotations

from typing import Protocol

from vrlf.content.pictures import StereoSource
from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.optics.fitting import FitMode
from vrlf.passes import EyePicture, Prepare
from vrlf.renderer.steps import fitted
from vrlf.scene import HeadPose


class Live(Protocol):
    """What can be shown frame after frame."""

    is_still: bool

    def draw(self, target: Texture, rig: Rig, *, time_s: float, head: HeadPose) -> None:
        """Write what both eyes should perceive at this time into all of ``target``."""

    def release(self) -> None:
        """Give it back."""


class Picture:
    """A picture for each eye."""

    is_still = True

    def __init__(self, device: Device, source: StereoSource, fit: FitMode = "contain") -> None:
        self._device, self._source, self._fit = device, source, fit
        self._prepare = Prepare(device)

    def draw(self, target: Texture, rig: Rig, *, time_s: float, head: HeadPose) -> None:
        pictures, fits = fitted(self._source, rig, self._fit)
        eyes = [
            EyePicture(Texture.from_array(self._device, p, label="picture"), f)
            for p, f in zip(pictures, fits, strict=True)
        ]
        self._prepare.run(rig, (eyes[0], eyes[1]), target)
        for e in eyes:
            e.texture.release()

    def release(self) -> None:
        self._prepare.release()
