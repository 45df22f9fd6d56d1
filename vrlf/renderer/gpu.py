"""The steps on a GPU, picture by picture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from vrlf.content.pictures import StereoSource
from vrlf.errors import InputError
from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.optics.fitting import FitMode
from vrlf.optics.lateral import forward_changes
from vrlf.passes import (
    Encode,
    EyePicture,
    Forward,
    Perceive,
    PerceiveTables,
    Prepare,
    Sharpen,
    forward_tables,
)
from vrlf.renderer.steps import (
    DEFAULT_RAYS,
    Exposure,
    Image,
    check_rays,
    checked_image,
    exposure_factor,
    fitted,
    operator_key,
)
from vrlf.solve import Optimal, OptimalTables
from vrlf.solve.wiener import sharpen_tables


@dataclass
class _Kept:
    """Tables of the last rig, kept until another one comes."""

    key: Any
    tables: Any


class GpuRenderer:
    """The steps on a GPU. Owns the device unless one is given; release it or use ``with``.

    What depends on the prescription alone is made when a rig is first met and kept until
    another rig comes.
    """

    def __init__(self, device: Device | None = None) -> None:
        self._owns_device = device is None
        self.device = Device.headless() if device is None else device
        self._prepare: Prepare | None = None
        self._forward = Forward(self.device)
        self._perceive = Perceive(self.device)
        self._encode: Encode | None = None
        self._optimal: Optimal | None = None
        self._sharpen: Sharpen | None = None
        self._kept: dict[str, _Kept] = {}
        self._released = False

    def target(self, source: StereoSource, rig: Rig, fit: FitMode = "contain") -> Image:
        """See ``Renderer.target``."""
        self._require_size(rig)
        if source.panel is not None:
            return np.clip(source.panel, 0.0, 1.0)
        self.device.make_current()
        if self._prepare is None:
            self._prepare = Prepare(self.device)
        pictures, fits = fitted(source, rig, fit)
        with _Textures(self.device) as make:
            eyes = [
                EyePicture(make.holding(picture, "picture"), place)
                for picture, place in zip(pictures, fits, strict=True)
            ]
            target = make.panel(rig, "target")
            self._prepare.run(rig, (eyes[0], eyes[1]), target)
            return _rgb(target)

    def prefilter(self, target: Image, rig: Rig) -> Image:
        """See ``Renderer.prefilter``."""
        target = checked_image(target, rig, "target")
        method = rig.prefilter.method
        self._require_size(rig)
        unchanged = not forward_changes(rig) and not rig.prefilter.wiener
        if method == "none" or (method == "forward" and unchanged):
            return np.array(target, dtype=np.float32)
        self.device.make_current()
        if method == "optimal":
            return self._solve(target, rig)
        with _Textures(self.device) as make:
            light = make.holding(target, "target")
            if rig.prefilter.wiener:
                light = self._sharpened(light, rig, make.panel(rig, "sharpened target"))
            if not forward_changes(rig):
                return _rgb(light)
            tables = self._tables("forward", rig, lambda: forward_tables(self.device, rig))
            shown = make.panel(rig, "panel image")
            self._forward.run(tables, light, shown)
            return _rgb(shown)

    def _sharpened(self, target: Texture, rig: Rig, sharpened: Texture) -> Texture:
        """The target after Wiener sharpening; the program is made when first needed."""
        if self._sharpen is None:
            self._sharpen = Sharpen(self.device)
        tables = self._tables(
            "sharpen",
            rig,
            lambda: sharpen_tables(self.device, rig, self._forward, self._perceive),
        )
        self._sharpen.run(tables, target, sharpened)
        return sharpened

    def _solve(self, target: Image, rig: Rig) -> Image:
        """The optimal panel image; the solver's programs are made when first needed."""
        if self._optimal is None:
            self._optimal = Optimal(self.device)
        builder = self._optimal.builder
        tables = self._tables(
            "optimal", operator_key(rig), lambda: OptimalTables(self.device, rig, builder)
        )
        tables.ask(rig.prefilter)
        with _Textures(self.device) as make:
            shown = make.panel(rig, "panel image")
            self._optimal.run(tables, make.holding(target, "target"), shown)
            return _rgb(shown)

    def perceive(
        self, panel: Image, rig: Rig, *, rays: int = DEFAULT_RAYS, exposure: Exposure = "auto"
    ) -> Image:
        """See ``Renderer.perceive``."""
        panel = checked_image(panel, rig, "panel image")
        check_rays(rays)
        self._require_size(rig)
        self.device.make_current()
        tables = self._tables(
            "perceive", (operator_key(rig), rays), lambda: PerceiveTables(self.device, rig, rays)
        )
        with _Textures(self.device) as make:
            seen = make.panel(rig, "perceived image")
            light = make.holding(panel, "panel image")
            self._perceive.run(tables, light, seen, exposure=exposure_factor(rig, exposure))
            return _rgb(seen)

    def perceive_with_error(
        self, panel: Image, rig: Rig, *, rays: int = DEFAULT_RAYS, exposure: Exposure = "auto"
    ) -> tuple[Image, float]:
        """``perceive``, and how far off its quadrature is, about: RMS over pixels and colours.

        The rays are traced in two halves, each well spread by itself; what is seen is their
        mean. Half the RMS difference between them would be the mean's own error if theirs
        were independent. They lie between each other, so that their errors cancel in the mean
        sooner than that: the estimate errs on the safe side.
        """
        panel = checked_image(panel, rig, "panel image")
        check_rays(rays)
        if rays < 2:
            raise InputError(f"rays: found {rays}, wanted at least 2 (an error takes two halves)")
        self._require_size(rig)
        self.device.make_current()
        factor = exposure_factor(rig, exposure)
        with _Textures(self.device) as make:
            seen = make.panel(rig, "perceived image")
            light = make.holding(panel, "panel image")
            halves = []
            for half in ("first", "second"):
                tables = self._tables(
                    f"perceive {half}",
                    (operator_key(rig), rays),
                    partial(PerceiveTables, self.device, rig, rays, half),
                )
                self._perceive.run(tables, light, seen, exposure=factor)
                halves.append(_rgb(seen))
        difference = np.subtract(halves[0], halves[1], dtype=np.float64)
        mean = np.asarray((halves[0] + halves[1]) / 2, dtype=np.float32)
        return mean, float(np.sqrt(np.mean(difference**2))) / 2.0

    def encode(self, light: Image, *, dither: bool = False) -> NDArray[np.uint8]:
        """See ``Renderer.encode``."""
        self.device.make_current()
        if self._encode is None:
            self._encode = Encode(self.device)
        with _Textures(self.device) as make:
            source = make.holding(light, "light")
            code = make.texture(source.size_px, "u1", "codes")
            self._encode.run(source, code, dither=dither)
            return np.asarray(code.read()[..., :3], dtype=np.uint8)

    def _require_size(self, rig: Rig) -> None:
        """Refuse a panel too large for the GPU before anything is made for it."""
        self.device.require_texture_size(rig.panel.width_px, rig.panel.height_px, "panel")

    def _tables(self, step: str, key: Any, make: Callable[[], Any]) -> Any:
        kept = self._kept.get(step)
        if kept is not None and kept.key == key:
            return kept.tables
        tables = make()
        if kept is not None:
            kept.tables.release()
        self._kept[step] = _Kept(key, tables)
        return tables

    def release(self) -> None:
        """Give everything back, the device too if it is this renderer's own."""
        if self._released:
            return
        self._released = True
        # OpenGL releases by number: in another renderer's context that number is another's.
        self.device.make_current()
        for kept in self._kept.values():
            kept.tables.release()
        self._kept.clear()
        for step in (
            self._prepare,
            self._encode,
            self._optimal,
            self._sharpen,
            self._forward,
            self._perceive,
        ):
            if step is not None:
                step.release()
        if self._owns_device:
            self.device.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.release()


class _Textures:
    """Textures of one step, released together whatever happens."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._made: list[Texture] = []

    def texture(self, size_px: tuple[int, int], kind: str, label: str) -> Texture:
        self._made.append(Texture(self._device, size_px, kind=kind, label=label))
        return self._made[-1]

    def panel(self, rig: Rig, label: str) -> Texture:
        return self.texture((rig.panel.width_px, rig.panel.height_px), "f4", label)

    def holding(self, image: NDArray[Any], label: str) -> Texture:
        pixels = np.ascontiguousarray(image, dtype=np.float32)
        self._device.require_texture_size(image.shape[1], image.shape[0], label)
        self._made.append(Texture.from_array(self._device, pixels, label=label))
        return self._made[-1]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for texture in self._made:
            texture.release()


def _rgb(texture: Texture) -> Image:
    return np.ascontiguousarray(texture.read()[..., :3], dtype=np.float32)
