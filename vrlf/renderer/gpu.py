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
from vrlf.optics.sequence import Half
from vrlf.optics.tracing import Tracing
from vrlf.passes import (
    Encode,
    EyePicture,
    Forward,
    Perceive,
    PerceiveTables,
    PerceiveTraced,
    Prepare,
    Sharpen,
    TracedTables,
    forward_tables,
)
from vrlf.renderer.steps import (
    DEFAULT_RAYS,
    PLAIN,
    Exposure,
    Image,
    check_rays,
    checked_image,
    exposure_factor,
    fitted,
    operator_key,
)
from vrlf.renderer.textures import Textures, rgb
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
        self._traced: PerceiveTraced | None = None
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
        with Textures(self.device) as make:
            eyes = [
                EyePicture(make.holding(picture, "picture"), place)
                for picture, place in zip(pictures, fits, strict=True)
            ]
            target = make.panel(rig, "target")
            self._prepare.run(rig, (eyes[0], eyes[1]), target)
            return rgb(target)

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
        with Textures(self.device) as make:
            light = make.holding(target, "target")
            if rig.prefilter.wiener:
                light = self._sharpened(light, rig, make.panel(rig, "sharpened target"))
            if not forward_changes(rig):
                return rgb(light)
            tables = self._tables("forward", rig, lambda: forward_tables(self.device, rig))
            shown = make.panel(rig, "panel image")
            self._forward.run(tables, light, shown)
            return rgb(shown)

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
        with Textures(self.device) as make:
            shown = make.panel(rig, "panel image")
            self._optimal.run(tables, make.holding(target, "target"), shown)
            return rgb(shown)

    def perceive(
        self,
        panel: Image,
        rig: Rig,
        *,
        rays: int = DEFAULT_RAYS,
        exposure: Exposure = "auto",
        tracing: Tracing = PLAIN,
    ) -> Image:
        """See ``Renderer.perceive``."""
        return self._looked(panel, rig, rays, exposure, tracing, ("all",))[0]

    def perceive_with_error(
        self,
        panel: Image,
        rig: Rig,
        *,
        rays: int = DEFAULT_RAYS,
        exposure: Exposure = "auto",
        tracing: Tracing = PLAIN,
    ) -> tuple[Image, float]:
        """``perceive``, and how far off its quadrature is, about: RMS over pixels and colours.

        The rays are traced in two halves, each well spread by itself; what is seen is their
        mean. Half the RMS difference between them would be the mean's own error if theirs
        were independent. They lie between each other, so that their errors cancel in the mean
        sooner than that: the estimate errs on the safe side.
        """
        check_rays(rays)
        if rays < 2:
            raise InputError(f"rays: found {rays}, wanted at least 2 (an error takes two halves)")
        halves = self._looked(panel, rig, rays, exposure, tracing, ("first", "second"))
        difference = np.subtract(halves[0], halves[1], dtype=np.float64)
        mean = np.asarray((halves[0] + halves[1]) / 2, dtype=np.float32)
        return mean, float(np.sqrt(np.mean(difference**2))) / 2.0

    def _looked(
        self,
        panel: Image,
        rig: Rig,
        rays: int,
        exposure: Exposure,
        tracing: Tracing,
        halves: tuple[Half, ...],
    ) -> list[Image]:
        """What is seen by each of these halves of the rays."""
        panel = checked_image(panel, rig, "panel image")
        check_rays(rays)
        tracing.check(rig)
        self._require_size(rig)
        self.device.make_current()
        factor = exposure_factor(rig, exposure)
        seen_by = []
        with Textures(self.device) as make:
            seen = make.panel(rig, "perceived image")
            light = make.holding(panel, "panel image")
            for half in halves:
                if tracing:
                    self._trace(rig, rays, tracing, half, light, seen, factor)
                else:
                    tables = self._rays(rig, rays, half)
                    self._perceive.run(tables, light, seen, exposure=factor)
                seen_by.append(rgb(seen))
        return seen_by

    def _rays(self, rig: Rig, rays: int, half: Half) -> PerceiveTables:
        """The fast quadratures' tables."""
        make = partial(PerceiveTables, self.device, rig, rays, half)
        tables: PerceiveTables = self._tables(f"perceive {half}", (operator_key(rig), rays), make)
        return tables

    def _trace(
        self,
        rig: Rig,
        rays: int,
        tracing: Tracing,
        half: Half,
        light: Texture,
        seen: Texture,
        exposure: float,
    ) -> None:
        """Ray by ray; the program is made when first needed."""
        if self._traced is None:
            self._traced = PerceiveTraced(self.device)
        make = partial(TracedTables, self.device, rig, rays, tracing, half)
        tables = self._tables(f"trace {half}", (operator_key(rig), rays, tracing), make)
        self._traced.run(tables, light, seen, exposure=exposure)

    def encode(self, light: Image, *, dither: bool = False) -> NDArray[np.uint8]:
        """See ``Renderer.encode``."""
        self.device.make_current()
        if self._encode is None:
            self._encode = Encode(self.device)
        with Textures(self.device) as make:
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
            self._traced,
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
