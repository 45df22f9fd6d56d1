"""What can be shown frame after frame: each writes the whole target for a time and a pose."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from vrlf.content.charts import draw_chart
from vrlf.content.pictures import StereoSource, join_viewports
from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.fitting import Fit, FitMode
from vrlf.optics.viewport import SIDES, pitch_mm, viewport
from vrlf.passes import EyePicture, Prepare
from vrlf.renderer.steps import Image, fitted
from vrlf.scene import HeadPose, Scene


class Live(Protocol):
    """Something to show.

    Attributes
    ----------
    is_still : bool
        Whether it is the same at every time and pose.
    duration_s : float or None
        Where it begins again; None is never.
    """

    @property
    def is_still(self) -> bool: ...

    @property
    def duration_s(self) -> float | None: ...

    def draw(self, target: Texture, rig: Rig, *, time_s: float, head: HeadPose) -> None:
        """Write what both eyes should perceive at this time into all of ``target``.

        rgba32f of the panel's size, linear light from 0 to 1, row 0 at the top, nobody's column
        dark. The rig may be another one each time.
        """

    def ease(self, samples: int) -> None:
        """Samples a pixel, along each side, from now on; less is faster."""

    def release(self) -> None:
        """Give it back."""


class Picture:
    """A picture for each eye, fitted into its viewport."""

    is_still = True
    duration_s: float | None = None

    def __init__(self, device: Device, source: StereoSource, fit: FitMode = "contain") -> None:
        self._device, self._source, self._mode = device, source, fit
        self._prepare = Prepare(device)
        self._key: Any = None
        self._textures: list[Texture] = []
        self._fits: tuple[Fit, ...] = ()

    def draw(self, target: Texture, rig: Rig, *, time_s: float, head: HeadPose) -> None:
        """See ``Live.draw``; time and pose are all one to it."""
        del time_s, head
        whole = self._source.panel
        if whole is not None and whole.shape[1::-1] == target.size_px:
            target.write(np.clip(whole, 0.0, 1.0))
            return
        self._fit(rig)
        left, right = (
            EyePicture(texture, fit)
            for texture, fit in zip(self._textures, self._fits, strict=True)
        )
        self._prepare.run(rig, (left, right), target)

    def _fit(self, rig: Rig) -> None:
        """Pictures on the GPU, anew where panel or headset are others."""
        key = (rig.panel, rig.headset, rig.array)
        if key == self._key:
            return
        self._drop()
        pictures, self._fits = fitted(self._source, rig, self._mode)
        for picture in pictures:
            self._textures.append(Texture.from_array(self._device, picture, label="picture"))
        self._key = key

    def _drop(self) -> None:
        self._key = None
        while self._textures:
            self._textures.pop().release()

    def ease(self, samples: int) -> None:
        """Its pixels are filtered whole."""

    def release(self) -> None:
        """Give pictures and program back."""
        self._drop()
        self._prepare.release()


class Chart:
    """A chart at the panel's exact pixels."""

    is_still = True
    duration_s: float | None = None

    def __init__(self, name: str) -> None:
        self._name = name

    def draw(self, target: Texture, rig: Rig, *, time_s: float, head: HeadPose) -> None:
        """See ``Live.draw``."""
        del time_s, head
        target.write(chart_light(self._name, rig))

    def ease(self, samples: int) -> None:
        """Its pixels are exact."""

    def release(self) -> None:
        """It keeps nothing."""


class Garden:
    """The shipped scene, wind in its leaves."""

    is_still = False
    duration_s: float | None = None

    def __init__(self, device: Device) -> None:
        self._scene = Scene(device)

    def draw(self, target: Texture, rig: Rig, *, time_s: float, head: HeadPose) -> None:
        """See ``Live.draw``."""
        self._scene.draw(target, rig, time_s=time_s, head=head)

    def ease(self, samples: int) -> None:
        """See ``Live.ease``."""
        self._scene.canvas.samples = samples

    def release(self) -> None:
        """Give the scene back."""
        self._scene.release()


def chart_light(name: str, rig: Rig) -> Image:
    """A chart in both viewports, on the panel's raster."""
    left, right = (draw_chart(name, **viewport_size(rig, side), eye=side).image for side in SIDES)
    light = join_viewports(left, right, (rig.panel.width_px, rig.panel.height_px))
    return np.asarray(light, np.float32)


def viewport_size(rig: Rig, side: Any) -> dict[str, Any]:
    """What a chart must know of a viewport."""
    view = viewport(rig, side)
    ppd = bench_of(rig).panel_per_slope_mm * np.pi / 180.0 / pitch_mm(rig)
    return {
        "width_px": view.width_px,
        "height_px": view.height_px,
        "pixels_per_degree": float(ppd),
    }
