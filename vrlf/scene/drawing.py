"""The scene on the GPU: what is drawn, in which order, and how a view is made of it."""

from __future__ import annotations

from math import ceil, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu import Block, Canvas, ComputePass, Device, DrawPass, Field, Mesh, Texture
from vrlf.model import Rig
from vrlf.optics.viewport import SIDES, Side, viewport
from vrlf.scene.camera import (
    AT_REST,
    Frustum,
    HeadPose,
    clip_from_world,
    eye_position_m,
    head_axes,
    panel_frustum,
    seen_frustum,
)
from vrlf.scene.foliage import blade
from vrlf.scene.garden import CROWNS, TO_SUN, Garden, plant_garden
from vrlf.scene.glyphs import TEXEL_M, summed_area
from vrlf.scene.pages import printed

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
RESOLVE = Block(
    "Resolve",
    (
        Field("ivec2", "view_px", "width and height of the view"),
        Field("int", "samples", "a side, within each pixel"),
        Field("float", "exposure", "panel drive of unit light"),
        Field("vec4", "panel_slopes", "left, bottom, right, top of the viewport"),
        Field("vec4", "seen_slopes", "the same of what the canvas shows"),
        Field("vec2", "distortion", "k1, k2 of the lens"),
    ),
)

SAMPLES = 3  # a side: leaves and strokes of print are thinner than pixels
MOST_SAMPLES = 48_000_000  # a view: 600 MB of canvas
# So that at most one pixel in a hundred reaches the panel's full drive.
EXPOSURE = 0.74


class Scene:
    """Owns all that draws the shipped scene for a rig; kept for as many frames as wanted.

    Parameters
    ----------
    device : Device
    rig : Rig
        Its viewports, bench and distortion say what each eye sees.
    samples : int
        Samples a pixel, along each side; fewer where the GPU's textures end.
    garden : Garden, optional
        Something else to draw than the shipped scene, in its light.
    """

    def __init__(
        self, device: Device, rig: Rig, *, samples: int = SAMPLES, garden: Garden | None = None
    ) -> None:
        self._device, self._rig = device, rig
        self._owned: list[Any] = []
        try:
            self._load(samples, garden or plant_garden())
        except Exception:
            self.release()
            raise

    def _load(self, samples: int, garden: Garden) -> None:
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
        self._resolve = own(ComputePass(device, "scene/resolve.comp", RESOLVE))
        self._print: Texture = own(Texture.from_array(device, table, label="print"))
        self._surfaces = own(Mesh(device, *garden.surfaces, label="surfaces"))
        # Far leaves are a few pixels long: two segments show all of their shape.
        self._leaves = [
            own(Mesh(device, *blade(segments), instances=leaves, label="leaves"))
            for segments, leaves in ((6, garden.near_leaves), (2, garden.far_leaves))
            if len(leaves)
        ]
        self._samples, size_px = canvas_size(self._rig, device.info.max_texture_px, samples)
        self._canvas = own(Canvas(device, size_px, label="scene"))
        view = viewport(self._rig, "left")
        self._view: Texture = own(Texture(device, (view.width_px, view.height_px), label="view"))

    def _own(self, part: Any) -> Any:
        self._owned.append(part)
        return part

    def render(self, side: Side, *, time_s: float = 0.0, head: HeadPose = AT_REST) -> Texture:
        """Draw what an eye sees.

        Returns
        -------
        Texture
            rgba32f of the viewport's size, linear light, row 0 at the top. It belongs to the
            scene, and the next call draws into it again.
        """
        values = _scene_values(self._rig, side, time_s, head)
        self._canvas.begin()
        self._print.bind_sampler(0)
        for program in (self._sky, self._surface, self._leaf):
            program.set(values)
        # Near things first: what is hidden is then never shaded.
        self._surface.draw(self._surfaces)
        for leaves in self._leaves:
            self._leaf.draw(leaves)
        self._sky.draw_screen()
        self._canvas.colour.bind_sampler(0)
        self._view.bind_image(0, read=False, write=True)
        self._resolve.set(_resolve_values(self._rig, side, self._view.size_px, self._samples))
        self._resolve.run(*self._view.size_px)
        self._device.check("drawing the scene")
        return self._view

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
    scene = Scene(device, rig)
    try:
        left, right = (
            np.ascontiguousarray(scene.render(side, time_s=time_s, head=head).read()[..., :3])
            for side in SIDES
        )
        return left.astype(np.float32), right.astype(np.float32)
    finally:
        scene.release()


def canvas_size(rig: Rig, max_texture_px: int, samples: int) -> tuple[int, tuple[int, int]]:
    """Samples a side that fit the GPU, and the canvas that holds both eyes' views.

    A lens that shows more than the panel's own slopes has a larger canvas, as dense as the
    panel is at its middle.

    Returns
    -------
    samples : int
        From 1 to what was asked for.
    size_px : (width, height)
        At most ``max_texture_px``, at the cost of density.
    """
    view = viewport(rig, "left")
    ratios = [(1.0, 1.0)]
    for side in SIDES:
        plain, seen = panel_frustum(rig, side).size, seen_frustum(rig, side).size
        ratios.append((seen[0] / plain[0], seen[1] / plain[1]))
    wide = view.width_px * max(across for across, _ in ratios)
    high = view.height_px * max(along for _, along in ratios)
    limit = max_texture_px / max(wide, high)
    fitting = max(1, min(samples, int(min(limit, sqrt(MOST_SAMPLES / (wide * high))))))
    scale = min(float(fitting), limit)
    return fitting, (_whole(scale * wide), _whole(scale * high))


def _whole(length: float) -> int:
    """Up to a whole pixel, but not for what a float32 ratio adds to one."""
    return max(1, ceil(length - 1e-6))


def _bounds(frustum: Frustum) -> tuple[float, float, float, float]:
    return frustum.left, frustum.bottom, frustum.right, frustum.top


def _scene_values(rig: Rig, side: Side, time_s: float, head: HeadPose) -> dict[str, Any]:
    right, up, back = ((*axis, 0.0) for axis in head_axes(head))
    sun = np.asarray(TO_SUN) / np.linalg.norm(TO_SUN)
    return {
        "clip_from_world": clip_from_world(rig, side, head),
        "eye": (*eye_position_m(rig, side, head), 1.0),
        "head_right": right,
        "head_up": up,
        "head_back": back,
        "slopes": _bounds(seen_frustum(rig, side)),
        "to_sun": (*sun, 0.0),
        "crowns": [(*crown.centre_m, crown.density) for crown in CROWNS],
        "crown_radii": [(*crown.radii_m, 0.0) for crown in CROWNS],
        "time_s": time_s,
    }


def _resolve_values(rig: Rig, side: Side, view_px: tuple[int, int], samples: int) -> dict[str, Any]:
    return {
        "view_px": view_px,
        "samples": samples,
        "exposure": EXPOSURE,
        "panel_slopes": _bounds(panel_frustum(rig, side)),
        "seen_slopes": _bounds(seen_frustum(rig, side)),
        "distortion": rig.headset.distortion or (0.0, 0.0),
    }
