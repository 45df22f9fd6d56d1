"""From a canvas that an eye's view was drawn on to that eye's viewport of the target."""

from __future__ import annotations

from math import ceil, sqrt

from vrlf.gpu import Block, Canvas, ComputePass, Device, Field, Texture
from vrlf.model import Rig
from vrlf.optics.distortion import coefficients_of
from vrlf.optics.viewport import SIDES, Side, viewport
from vrlf.scene.camera import Frustum, panel_frustum, seen_frustum

RESOLVE = Block(
    "Resolve",
    (
        Field("ivec2", "view_px", "width and height of the view"),
        Field("int", "first_column", "where it begins on the panel"),
        Field("int", "nobodys", "columns behind it that are dark"),
        Field("int", "samples", "a side, within each pixel"),
        Field("float", "exposure", "panel drive of unit light"),
        Field("vec4", "panel_slopes", "left, bottom, right, top of the viewport"),
        Field("vec4", "seen_slopes", "the same of what the canvas shows"),
        Field("vec2", "distortion", "k1, k2 of the lens"),
    ),
)

SAMPLES = 3  # a side: leaves and strokes of print are thinner than pixels
MOST_SAMPLES = 48_000_000  # a view: 600 MB of canvas


class StereoCanvas:
    """Owns the canvas that both eyes' views are drawn on, one after the other.

    Parameters
    ----------
    device : Device
    samples : int
        Samples a pixel, along each side; fewer where the GPU's textures end. May be set anew
        between frames.
    """

    def __init__(self, device: Device, samples: int = SAMPLES) -> None:
        self._device, self.samples = device, samples
        self._taken = samples
        self._canvas: Canvas | None = None
        self._resolve = ComputePass(device, "scene/resolve.comp", RESOLVE)

    def begin(
        self, rig: Rig, clear: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    ) -> None:
        """Draw on an empty canvas of this rig's size from now on."""
        self._taken, size_px = canvas_size(rig, self._device.info.max_texture_px, self.samples)
        if self._canvas is None or self._canvas.size_px != size_px:
            self._drop_canvas()
            self._canvas = Canvas(self._device, size_px, label="scene")
        self._canvas.begin(clear)

    def resolve(self, rig: Rig, side: Side, target: Texture, exposure: float) -> None:
        """Put what was drawn into an eye's viewport of ``target`` (rgba32f, the panel's size)."""
        assert self._canvas is not None
        view = viewport(rig, side)
        nobodys = rig.panel.width_px - 2 * view.width_px if side == "left" else 0
        self._canvas.colour.bind_sampler(0)
        target.bind_image(0, read=False, write=True)
        self._resolve.set(
            {
                "view_px": (view.width_px, view.height_px),
                "first_column": view.first_column,
                "nobodys": nobodys,
                "samples": self._taken,
                "exposure": exposure,
                "panel_slopes": bounds(panel_frustum(rig, side)),
                "seen_slopes": bounds(seen_frustum(rig, side)),
                "distortion": coefficients_of(rig),
            }
        )
        self._resolve.run(view.width_px + nobodys, view.height_px)

    def _drop_canvas(self) -> None:
        if self._canvas is not None:
            self._canvas.release()
            self._canvas = None

    def release(self) -> None:
        """Give it back; the second call does nothing."""
        self._drop_canvas()
        self._resolve.release()


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


def bounds(frustum: Frustum) -> tuple[float, float, float, float]:
    """Left, bottom, right, top, as the shaders have them."""
    return frustum.left, frustum.bottom, frustum.right, frustum.top
