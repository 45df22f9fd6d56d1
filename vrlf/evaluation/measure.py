"""RMSE, PSNR and SSIM of a perceived picture, eye by eye.

Both pictures are compared in linear light, peak 1, after one least-squares gain on the
perceived one, inside a border as wide as the blur's radius plus one lenslet: further out the
panel's edge is seen, which no prefilter can mend. The formulas are those of ``metrics.fidelity``.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

from vrlf.errors import InputError
from vrlf.evaluation.metrics.fidelity import psnr_db, rmse, ssim
from vrlf.model import Rig
from vrlf.optics import limits
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.lattice import lattice_of
from vrlf.optics.viewport import Side, pitch_mm, viewport
from vrlf.renderer import Image


@dataclass(frozen=True)
class Likeness:
    """How near a perceived picture comes to the target.

    Attributes
    ----------
    rmse, psnr_db
        T 6.1 with its 1/N, and 10 log10(1 / rmse^2).
    gain
        What the perceived picture was multiplied with.
    ssim
        Mean structural similarity over the colours (Wang, Bovik, Sheikh & Simoncelli 2004, with
        their Gaussian window of 1.5 pixels), 1 for equal pictures; None where less than the
        window of 11 pixels is left inside the border.
    """

    rmse: float
    psnr_db: float
    gain: float
    ssim: float | None


def border_px(rig: Rig, side: Side) -> int:
    """The blur's radius plus one lenslet, in pixels."""
    optics, lattice = eye_optics(rig, side), lattice_of(rig)
    blur_mm = optics.pupil_mm * limits.worst_meridian(limits.blur_matrix(bench_of(rig), optics))
    lenslet_mm = 0.0 if lattice is None else lattice.pitch_mm
    return ceil((blur_mm / 2.0 + lenslet_mm) / pitch_mm(rig))


@dataclass(frozen=True)
class Compared:
    """One eye's two pictures as every metric takes them: cut to the border, equally bright.

    Attributes
    ----------
    target, seen : ndarray (h, w, 3)
        Linear light.
    gain : float
        What the perceived picture was multiplied with.
    inner : (slice, slice)
        Rows and columns of the viewport that lie inside the border.
    """

    target: NDArray[np.float64]
    seen: NDArray[np.float64]
    gain: float
    inner: tuple[slice, slice]


def require_room(rig: Rig, side: Side) -> None:
    """Refuse a viewport that is all border.

    Raises
    ------
    InputError
        If nothing is left to compare.
    """
    view, border = viewport(rig, side), border_px(rig, side)
    if 2 * border >= min(view.width_px, view.height_px):
        raise InputError(
            f"{side} eye: found a viewport of {view.width_px}x{view.height_px} pixels, wanted more "
            f"than twice the border of {border} (blur radius and one lenslet)"
        )


def compared(
    seen: Image, target: Image, rig: Rig, side: Side, *, black_level: float = 0.0
) -> Compared:
    """What one eye perceives and what it should, ready to be compared.

    Parameters
    ----------
    seen, target : ndarray (H, W, 3)
        Linear light on the panel's raster.
    black_level : float
        What the panel image shows for black; it is taken off what is seen.

    Raises
    ------
    InputError
        If the border leaves nothing of the viewport.
    """
    require_room(rig, side)
    view, border = viewport(rig, side), border_px(rig, side)
    inner = (slice(border, view.height_px - border), slice(border, view.width_px - border))
    a = seen[:, view.columns][inner].astype(np.float64) - black_level
    b = target[:, view.columns][inner].astype(np.float64)
    energy = float(np.sum(a * a))
    gain = float(np.sum(a * b)) / energy if energy > 0.0 else 1.0
    return Compared(b, gain * a, gain, inner)


def likeness(
    seen: Image, target: Image, rig: Rig, side: Side, *, black_level: float = 0.0
) -> Likeness:
    """Compare one eye's half of a perceived picture with the target.

    Parameters
    ----------
    seen, target : ndarray (H, W, 3)
        Linear light on the panel's raster.
    black_level : float
        What the panel image shows for black; it is taken off what is seen.

    Raises
    ------
    InputError
        If the border leaves nothing of the viewport.
    """
    pair = compared(seen, target, rig, side, black_level=black_level)
    error = rmse(pair.seen, pair.target)
    return Likeness(error, psnr_db(error), pair.gain, ssim(pair.seen, pair.target))
