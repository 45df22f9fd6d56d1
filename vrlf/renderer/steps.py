"""What a renderer takes and gives, whoever it is, and the checks on it."""

from __future__ import annotations

from typing import Literal, Protocol, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vrlf.content.pictures import StereoSource
from vrlf.errors import InputError
from vrlf.images import resize_area
from vrlf.model import Array, Prefilter, Rig
from vrlf.optics.fitting import Fit, FitMode, fit_picture
from vrlf.optics.lattice import lattice_of
from vrlf.optics.samples import MAX_POINTS
from vrlf.optics.tracing import Tracing
from vrlf.optics.viewport import SIDES, Side, axis_in_viewport_px, viewport

Image = NDArray[np.float32]
Exposure = Literal["auto", "none"]
DEFAULT_RAYS = 256
# Perception by the fast quadratures.
PLAIN = Tracing()
# A picture more than this many times larger than its place is averaged down before the GPU
# filters it: a kernel of a thousand taps a side would serve nobody.
_MOST_SOURCE_PX = 8.0


class Renderer(Protocol):
    """The steps, whoever takes them. Pictures are linear light, (H, W, 3) on the panel's raster."""

    def target(self, source: StereoSource, rig: Rig, fit: FitMode = "contain") -> Image:
        """What both eyes should perceive."""

    def prefilter(self, target: Image, rig: Rig) -> Image:
        """The panel image, by the rig's own method."""

    def perceive(
        self,
        panel: Image,
        rig: Rig,
        *,
        rays: int = DEFAULT_RAYS,
        exposure: Exposure = "auto",
        tracing: Tracing = PLAIN,
    ) -> Image:
        """What both eyes see; ray by ray where ``tracing`` asks for more than thin lenses."""

    def encode(self, light: Image, *, dither: bool = False) -> NDArray[np.uint8]:
        """8-bit sRGB."""


def exposure_factor(rig: Rig, exposure: Exposure) -> float:
    """``auto`` makes up for the light that the array takes; ``none`` shows it as it is."""
    if exposure not in get_args(Exposure):
        raise InputError(f"exposure: found {exposure!r}, wanted 'auto' or 'none'")
    lattice = lattice_of(rig)
    if exposure == "none" or lattice is None:
        return 1.0
    return 1.0 / lattice.throughput


def fitted(
    source: StereoSource, rig: Rig, mode: FitMode
) -> tuple[tuple[Image, Image], tuple[Fit, Fit]]:
    """Both pictures, averaged down where they are far too large, and their places."""
    pictures, fits = [], []
    for side, picture in zip(SIDES, (source.left, source.right), strict=True):
        height, width = picture.shape[:2]
        fit = fit_of((width, height), source.pixel_aspect, rig, side, mode)
        shrink = [max(1.0, ratio / _MOST_SOURCE_PX) for ratio in fit.source_px]
        if max(shrink) > 1.0:
            size = (max(1, round(width / shrink[0])), max(1, round(height / shrink[1])))
            picture = resize_area(picture, *size)
            aspect = source.pixel_aspect * (width / size[0]) / (height / size[1])
            fit = fit_of(size, aspect, rig, side, mode)
        pictures.append(picture)
        fits.append(fit)
    return (pictures[0], pictures[1]), (fits[0], fits[1])


def fit_of(
    size_px: tuple[int, int], pixel_aspect: float, rig: Rig, side: Side, mode: FitMode
) -> Fit:
    """Where a picture of that size lies in an eye's viewport."""
    view = viewport(rig, side)
    x, y = axis_in_viewport_px(rig, view)
    return fit_picture(size_px, pixel_aspect, view, mode, (float(x), float(y)))


def checked_image(image: ArrayLike, rig: Rig, what: str) -> Image:
    """A picture on the panel's raster as float32, or an error that says what it is instead."""
    try:
        with np.errstate(over="ignore"):  # what is too large for 32 bits is refused below
            array = np.asarray(image, dtype=np.float32)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{what}: found no array of numbers ({error}), wanted one") from None
    wanted = (rig.panel.height_px, rig.panel.width_px, 3)
    if array.shape != wanted:
        found = "x".join(str(n) for n in array.shape) or "a single number"
        raise InputError(
            f"{what}: found {found}, wanted an array of {wanted[0]}x{wanted[1]}x3 "
            "(height, width, RGB) like the rig's panel"
        )
    bad = int(np.count_nonzero(~np.isfinite(array)))
    if bad:
        raise InputError(f"{what}: found {bad} values that are no finite number, wanted none")
    return array


def check_rays(rays: int) -> None:
    """Refuse a number of rays that means nothing, or that no table holds."""
    if isinstance(rays, bool) or not isinstance(rays, int) or not 1 <= rays <= MAX_POINTS:
        raise InputError(f"rays: found {rays}, wanted a whole number from 1 to {MAX_POINTS}")


def operator_key(rig: Rig) -> Rig:
    """What the perception operator depends on: all of a rig but the prefilter's settings."""
    return rig.model_copy(update={"prefilter": Prefilter()})


def bare_rig(rig: Rig) -> Rig:
    """The same headset and eyes before the panel without its array: what is uncorrected."""
    return rig.model_copy(update={"array": Array(kind="none")})
