"""The world all around from a picture: 360 degrees, for both eyes one or for each its own."""

from __future__ import annotations

from math import ceil, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu import Block, ComputePass, Device, Field, Texture
from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.distortion import coefficients_of
from vrlf.optics.viewport import SIDES, axis_in_viewport_px, pitch_mm, viewport
from vrlf.passes.fields import VIEWPORT_FIELDS, viewport_values
from vrlf.scene.camera import HeadPose, head_axes

PANORAMA = Block(
    "Panorama",
    (
        *VIEWPORT_FIELDS,
        Field("int", "samples", "a side, within each pixel"),
        Field("vec4", "axes_px", "of each eye: its axis in the viewport's raster", 2),
        Field("vec4", "head_right", "the head's own right in the world"),
        Field("vec4", "head_up", "its up"),
        Field("vec4", "head_back", "and the way it does not look"),
        Field("vec2", "distortion", "k1, k2 of the lens"),
        Field("float", "px_per_slope", "pixels of a unit slope"),
    ),
)
_MOST_SAMPLES = 6


class Panorama:
    """Owns the pictures and the program.

    Parameters
    ----------
    device : Device
    left, right : ndarray of float32, shape (H, 2 H, 3)
        Linear light, equirectangular: the middle column is straight ahead of a head that is not
        turned, the right quarter to its right, row 0 overhead. One and the same array for a
        world without depth. Kept as 16-bit floats.
    """

    def __init__(
        self, device: Device, left: NDArray[np.float32], right: NDArray[np.float32]
    ) -> None:
        self._device, self._eased = device, _MOST_SAMPLES
        self._owned: list[Any] = []
        try:
            self._program: ComputePass = self._own(
                ComputePass(device, "scene/panorama.comp", PANORAMA)
            )
            first = self._upload(left)
            self._worlds = (first, first if right is left else self._upload(right))
        except BaseException:
            self.release()
            raise

    def _own(self, item: Any) -> Any:
        self._owned.append(item)
        return item

    def _upload(self, light: NDArray[np.float32]) -> Texture:
        half = np.clip(light, 0.0, 1.0).astype(np.float16)
        texture: Texture = self._own(Texture.from_array(self._device, half, label="panorama"))
        return texture

    def ease(self, samples: int) -> None:
        """At most so many samples a pixel, along each side."""
        self._eased = min(max(samples, 1), _MOST_SAMPLES)

    def draw(self, target: Texture, rig: Rig, *, head: HeadPose) -> None:
        """Write what both eyes see into all of ``target`` (rgba32f, the panel's size).

        The world has no place to walk to: of the pose only the turn counts.
        """
        for unit, world in enumerate(self._worlds):
            world.bind_sampler(unit)
        target.bind_image(0, read=False, write=True)
        samples = min(samples_for(rig, self._worlds[0].size_px[0]), self._eased)
        self._program.set(panorama_values(rig, head, samples))
        self._program.run(*target.size_px)
        self._device.check("drawing the panorama")

    def release(self) -> None:
        """Give all of it back."""
        while self._owned:
            self._owned.pop().release()


def samples_for(rig: Rig, width_px: int) -> int:
    """Samples a side that leave out none of the panorama's pixels straight ahead."""
    px_per_radian = width_px / (2.0 * pi)
    wanted = px_per_radian * pitch_mm(rig) / bench_of(rig).panel_per_slope_mm
    return min(max(ceil(wanted), 2), _MOST_SAMPLES)


def panorama_values(rig: Rig, head: HeadPose, samples: int) -> dict[str, Any]:
    """For ``PANORAMA``."""
    right, up, back = ((*axis, 0.0) for axis in head_axes(head))
    return {
        **viewport_values(rig),
        "samples": samples,
        "axes_px": [(*axis_in_viewport_px(rig, viewport(rig, side)), 0, 0) for side in SIDES],
        "head_right": right,
        "head_up": up,
        "head_back": back,
        "distortion": coefficients_of(rig),
        "px_per_slope": bench_of(rig).panel_per_slope_mm / pitch_mm(rig),
    }
