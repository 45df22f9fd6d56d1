"""The Python interface: a rig in, a panel image out, and what each eye then sees.

    >>> import numpy as np, vrlf
    >>> rig = vrlf.load_rig("matched-microlens", both="-5.00")
    >>> target = np.full((rig.panel.height_px, rig.panel.width_px, 3), 0.5, np.float32)
    >>> panel = vrlf.prefilter(target, rig)
    >>> seen = vrlf.perceive(panel, rig)
    >>> vrlf.inspect(rig)["left"]["blur_px"]
    17.69...

Pictures are linear light, shape (height, width, 3), row 0 at the top, on the panel's
raster: the left half is the left eye's. Each call makes a GPU context of its own and gives
it back; ``Renderer`` keeps one over many calls.
"""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from vrlf.model import Rig, load_rig
from vrlf.optics.inspect import inspect_rig
from vrlf.optics.tracing import Tracing
from vrlf.renderer import DEFAULT_RAYS, Exposure, GpuRenderer, Image, checked_image

Renderer = GpuRenderer

__all__ = ["Renderer", "Rig", "inspect", "load_rig", "perceive", "prefilter"]


def prefilter(target: ArrayLike, rig: Rig, *, renderer: GpuRenderer | None = None) -> Image:
    """The panel image that makes both eyes perceive a target.

    Parameters
    ----------
    target : array_like, shape (panel height, panel width, 3)
        Linear light; 0 is dark, 1 the panel's full drive.
    rig : Rig
        From ``load_rig``; its ``prefilter.method`` says how.
    renderer : Renderer, optional
        Keeps the GPU context and the rig's tables over many calls.

    Returns
    -------
    ndarray of float32, shape (panel height, panel width, 3)
        Linear light.

    Raises
    ------
    InputError
        If the target has another shape, or values that are no finite numbers.
    DeviceError
        Without a usable GPU.
    """
    image = checked_image(target, rig, "target")
    if renderer is not None:
        return renderer.prefilter(image, rig)
    with GpuRenderer() as own:
        return own.prefilter(image, rig)


def perceive(
    panel: ArrayLike,
    rig: Rig,
    *,
    rays: int = DEFAULT_RAYS,
    exposure: Exposure = "auto",
    diffraction: bool = False,
    exact: bool = False,
    renderer: GpuRenderer | None = None,
) -> Image:
    """What both eyes see of a panel image.

    Parameters
    ----------
    panel : array_like, shape (panel height, panel width, 3)
        Linear light.
    rig : Rig
        From ``load_rig``.
    rays : int
        Rays that the array lets through, for each retinal pixel.
    exposure : "auto" or "none"
        ``auto`` divides by the array's throughput.
    diffraction : bool
        Trace ray by ray, each spread as its hole or lenslet diffracts it: slower.
    exact : bool
        Trace ray by ray through plano-convex lenslets instead of thin lenses: slower.
    renderer : Renderer, optional
        Keeps the GPU context and the rig's tables over many calls.

    Returns
    -------
    ndarray of float32, shape (panel height, panel width, 3)
        Linear light, both eyes side by side, upright.

    Raises
    ------
    InputError
        If the panel image has another shape, or values that are no finite numbers, or
        ``rays`` is not positive, or the rig has no array that diffracts, no lenslets to be exact.
    DeviceError
        Without a usable GPU.
    """
    tracing = Tracing(diffraction=diffraction, exact=exact)
    tracing.check(rig)
    image = checked_image(panel, rig, "panel image")
    if renderer is not None:
        return renderer.perceive(image, rig, rays=rays, exposure=exposure, tracing=tracing)
    with GpuRenderer() as own:
        return own.perceive(image, rig, rays=rays, exposure=exposure, tracing=tracing)


def inspect(rig: Rig) -> dict[str, Any]:
    """All numbers that follow from a rig; the keys are those of ``vrlf inspect --json``.

    Returns
    -------
    dict
        ``left``, ``right``, ``array``, ``display``, ``warnings``; needs no GPU.
    """
    return inspect_rig(rig)
