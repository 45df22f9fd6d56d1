"""What can be shown frame after frame: each writes the whole target for a time and a pose."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from vrlf.content.charts import draw_chart
from vrlf.content.pictures import StereoSource, join_viewports
from vrlf.content.video import Film
from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.fitting import Fit, FitMode
from vrlf.optics.viewport import SIDES, pitch_mm, viewport
from vrlf.passes import EyePicture, Prepare
from vrlf.renderer.steps import Image, fit_of, fitted
from vrlf.scene import HeadPose, ModelScene, Panorama, Scene


class Live(Protocol):
    """Something to show.

    Attributes
    ----------
    has_time, has_head : bool
        Whether what it shows depends on the time, on the head's pose.
    duration_s : float or None
        Where it begins again; None is never.
    fault : str or None
        What went wrong with its file while it was shown; the last good picture stays.
    """

    @property
    def has_time(self) -> bool: ...

    @property
    def has_head(self) -> bool: ...

    @property
    def duration_s(self) -> float | None: ...

    @property
    def fault(self) -> str | None: ...

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

    has_time, has_head = False, False
    duration_s: float | None = None
    fault: str | None = None

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

    has_time, has_head = False, False
    duration_s: float | None = None
    fault: str | None = None

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


class Drawn:
    """A scene to walk around in: the shipped garden, wind in its leaves, or a glTF file's."""

    has_head = True
    fault: str | None = None

    def __init__(self, scene: Scene | ModelScene) -> None:
        self._scene = scene
        self.duration_s, self.has_time = scene.duration_s, scene.moves

    def draw(self, target: Texture, rig: Rig, *, time_s: float, head: HeadPose) -> None:
        """See ``Live.draw``."""
        self._scene.draw(target, rig, time_s=time_s, head=head)

    def ease(self, samples: int) -> None:
        """See ``Live.ease``."""
        self._scene.canvas.samples = samples

    def release(self) -> None:
        """Give the scene back."""
        self._scene.release()


class World:
    """A panorama, for whoever turns the head."""

    has_time, has_head = False, True
    duration_s: float | None = None
    fault: str | None = None

    def __init__(self, panorama: Panorama) -> None:
        self._panorama = panorama

    def draw(self, target: Texture, rig: Rig, *, time_s: float, head: HeadPose) -> None:
        """See ``Live.draw``; it is the same at every time."""
        del time_s
        self._panorama.draw(target, rig, head=head)

    def ease(self, samples: int) -> None:
        """See ``Live.ease``."""
        self._panorama.ease(samples)

    def release(self) -> None:
        """Give the panorama back."""
        self._panorama.release()


class FilmShown:
    """A film, each eye's picture fitted into its viewport."""

    has_time, has_head = True, False

    def __init__(self, device: Device, film: Film, fit: FitMode = "contain") -> None:
        self._device, self._film, self._mode = device, film, fit
        self._prepare = Prepare(device)
        self._textures: list[Texture] = []
        self.duration_s: float | None = film.duration_s

    @property
    def fault(self) -> str | None:
        """Why the film ended before it should have."""
        return self._film.fault

    def draw(self, target: Texture, rig: Rig, *, time_s: float, head: HeadPose) -> None:
        """See ``Live.draw``; beyond its end the last frame stays."""
        del head
        if not self._textures or not self._film.is_same(time_s):
            self._upload(self._film.at(time_s))
        pictures = [
            EyePicture(
                texture, fit_of(texture.size_px, self._film.pixel_aspect, rig, side, self._mode)
            )
            for texture, side in zip(self._textures, SIDES, strict=True)
        ]
        self._prepare.run(rig, (pictures[0], pictures[1]), target, encoded=True)

    def _upload(self, pictures: tuple[Any, Any]) -> None:
        size = (pictures[0].shape[1], pictures[0].shape[0])
        while len(self._textures) < len(SIDES):
            self._textures.append(Texture(self._device, size, kind="f1", label="film"))
        for texture, picture in zip(self._textures, pictures, strict=True):
            texture.write(picture)

    def ease(self, samples: int) -> None:
        """Its pixels are filtered whole."""

    def release(self) -> None:
        """Give pictures and program back, and close the film."""
        while self._textures:
            self._textures.pop().release()
        self._prepare.release()
        self._film.release()


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
