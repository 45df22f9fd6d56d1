"""The scene on the GPU: what is drawn, in which order, and how a view is made of it."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu import Block, Device, DrawPass, Field, Mesh, Texture
from vrlf.model import Rig
from vrlf.optics.viewport import SIDES, Side, viewport
from vrlf.scene.camera import (
    AT_REST,
    HeadPose,
    clip_from_world,
    eye_position_m,
    head_axes,
    seen_frustum,
)
from vrlf.scene.foliage import blade
from vrlf.scene.garden import CROWNS, TO_SUN, Garden, plant_garden
from vrlf.scene.glyphs import TEXEL_M, summed_area
from vrlf.scene.pages import printed
from vrlf.scene.stereo import SAMPLES, StereoCanvas, bounds

SCENE = Block(
    "Scene",
    (
        Field("mat4", "clip_from_world", "view and projection of the eye"),
        Field("vec4", "eye", "where it is, metres"),
        Field("vec4", "head_right", "the head's own right in the world"),
        Field("vec4", "head_up", "its up"),
        Field("vec4", "head_back", "and the way it does not look"),
        Field("vec4", "slopes", "left, bottom, right, top of what the canvas shows"),
        Field("vec4", "to_sun", "unit vector"),
        Field(
            "vec4", "crowns", "centre of each shading ellipsoid; optical depth, 1/m", len(CROWNS)
        ),
        Field("vec4", "crown_radii", "its half axes, metres", len(CROWNS)),
        Field("float", "time_s", "moves leaves and clouds"),
    ),
)
# So that at most one pixel in a hundred reaches the panel's full drive.
EXPOSURE = 0.74


class Scene:
    """Owns all that draws the shipped scene; kept for as many frames as wanted.

    Parameters
    ----------
    device : Device
    samples : int
        Samples a pixel, along each side; fewer where the GPU's textures end.
    garden : Garden, optional
        Something else to draw than the shipped scene, in its light.

    Attributes
    ----------
    moves : bool
        Whether the time counts.
    duration_s : None
        Wind and clouds never begin again.
    """

    moves = True
    duration_s: float | None = None

    def __init__(
        self, device: Device, *, samples: int = SAMPLES, garden: Garden | None = None
    ) -> None:
        self._device = device
        self._owned: list[Any] = []
        try:
            self._load(garden or plant_garden())
            self.canvas: StereoCanvas = self._own(StereoCanvas(device, samples))
        except Exception:
            self.release()
            raise

    def _load(self, garden: Garden) -> None:
        device = self._device
        table, mean = summed_area(printed())
        defines: dict[str, int | float | str] = {
            "CROWNS": len(CROWNS),
            "TEXEL_M": repr(TEXEL_M),
            "PRINT_MEAN": repr(mean),
        }
        own = self._own
        self._sky, self._surface, self._leaf = (
            own(DrawPass(device, f"scene/{n}.vert", f"scene/{n}.frag", SCENE, defines=defines))
            for n in ("sky", "surface", "leaf")
        )
        self._print: Texture = own(Texture.from_array(device, table, label="print"))
        self._surfaces = own(Mesh(device, *garden.surfaces, label="surfaces"))
        # Far leaves are a few pixels long: two segments show all of their shape.
        self._leaves = [
            own(Mesh(device, *blade(segments), instances=leaves, label="leaves"))
            for segments, leaves in ((6, garden.near_leaves), (2, garden.far_leaves))
            if len(leaves)
        ]

    def _own(self, part: Any) -> Any:
        self._owned.append(part)
        return part

    def draw(
        self, target: Texture, rig: Rig, *, time_s: float = 0.0, head: HeadPose = AT_REST
    ) -> None:
        """Draw what both eyes see into all of ``target`` (rgba32f, the panel's size).

        Linear light, row 0 at the top. The rig's viewports, bench and distortion say what each
        eye sees; it may be another one each time.
        """
        for side in SIDES:
            values = _scene_values(rig, side, time_s, head)
            self.canvas.begin(rig)
            self._print.bind_sampler(0)
            for program in (self._sky, self._surface, self._leaf):
                program.set(values)
            # Near things first: what is hidden is then never shaded.
            self._surface.draw(self._surfaces)
            for leaves in self._leaves:
                self._leaf.draw(leaves)
            self._sky.draw_screen()
            self.canvas.resolve(rig, side, target, EXPOSURE)
        self._device.check("drawing the scene")

    def release(self) -> None:
        """Give all of it back; the second call does nothing."""
        while self._owned:
            self._owned.pop().release()


def render_stereo(
    device: Device, rig: Rig, *, time_s: float = 0.0, head: HeadPose = AT_REST
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """What both eyes see of the shipped scene.

    Parameters
    ----------
    device : Device
    rig : Rig
    time_s : float
        Moves leaves and clouds; the same time gives the same picture.
    head : HeadPose

    Returns
    -------
    left, right : ndarray of float32, shape (viewport height, viewport width, 3)
        Linear light in 0 to 1, row 0 at the top.
    """
    size = (rig.panel.width_px, rig.panel.height_px)
    with ExitStack() as owned:
        target = Texture(device, size, label="target")
        owned.callback(target.release)
        scene = Scene(device)
        owned.callback(scene.release)
        scene.draw(target, rig, time_s=time_s, head=head)
        light = target.read()[..., :3].astype(np.float32)
    left, right = (
        np.ascontiguousarray(light[:, view.first_column : view.first_column + view.width_px])
        for view in (viewport(rig, side) for side in SIDES)
    )
    return left, right


def _scene_values(rig: Rig, side: Side, time_s: float, head: HeadPose) -> dict[str, Any]:
    right, up, back = ((*axis, 0.0) for axis in head_axes(head))
    sun = np.asarray(TO_SUN) / np.linalg.norm(TO_SUN)
    return {
        "clip_from_world": clip_from_world(rig, side, head),
        "eye": (*eye_position_m(rig, side, head), 1.0),
        "head_right": right,
        "head_up": up,
        "head_back": back,
        "slopes": bounds(seen_frustum(rig, side)),
        "to_sun": (*sun, 0.0),
        "crowns": [(*crown.centre_m, crown.density) for crown in CROWNS],
        "crown_radii": [(*crown.radii_m, 0.0) for crown in CROWNS],
        "time_s": time_s,
    }
