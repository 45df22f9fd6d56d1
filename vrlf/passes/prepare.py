"""The target: each eye's picture fitted into its viewport."""

from __future__ import annotations

from dataclasses import dataclass

from vrlf.gpu import Block, ComputePass, Device, Field, Texture
from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.distortion import coefficients_of
from vrlf.optics.fitting import Fit
from vrlf.optics.viewport import SIDES, axis_in_viewport_px, pitch_mm, viewport
from vrlf.passes.fields import VIEWPORT_FIELDS, viewport_values

PREPARE = Block(
    "Prepare",
    (
        *VIEWPORT_FIELDS,
        Field("int", "encoded", "1 if the pictures are sRGB encoded"),
        Field("vec4", "fits", "of each eye: start of its picture, its pixels per target pixel", 2),
        Field("ivec4", "picture_px", "of each eye: width and height of its picture", 2),
        Field("vec4", "axes_px", "of each eye: its axis in the viewport's raster", 2),
        Field("vec2", "distortion", "k1, k2 of the lens"),
        Field("float", "px_per_slope", "pixels of a unit slope"),
    ),
)


@dataclass(frozen=True)
class EyePicture:
    """A picture on the GPU and how it lies in its eye's viewport."""

    texture: Texture
    fit: Fit


class Prepare:
    """Owns the program."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._program = ComputePass(device, "prepare.comp", PREPARE)

    def run(
        self,
        rig: Rig,
        pictures: tuple[EyePicture, EyePicture],
        target: Texture,
        *,
        encoded: bool = False,
    ) -> None:
        """Write the target into ``target`` (rgba32f, the panel's size)."""
        for unit, picture in enumerate(pictures):
            picture.texture.bind_sampler(unit)
        target.bind_image(0, read=False, write=True)
        axes = [(*axis_in_viewport_px(rig, viewport(rig, side)), 0, 0) for side in SIDES]
        self._program.set(
            {
                **viewport_values(rig),
                "encoded": int(encoded),
                "fits": [(*p.fit.start_px, *p.fit.source_px) for p in pictures],
                "picture_px": [(*p.texture.size_px, 0, 0) for p in pictures],
                "axes_px": axes,
                "distortion": coefficients_of(rig),
                "px_per_slope": bench_of(rig).panel_per_slope_mm / pitch_mm(rig),
            }
        )
        self._program.run(*target.size_px)
        self._device.check("preparing the target")

    def release(self) -> None:
        """Give the program back."""
        self._program.release()
