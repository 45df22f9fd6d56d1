"""Footprints: what a sub-pixel's samples cover in the target of the forward prefilter.

While all samples of a sub-pixel cross one cell and the eye is a sphero-cylinder (and a prism),
the way from panel to target is one affine map: a step of h pixels on the panel is a step of

    J h,  J = r I + D A      A: cells crossed per panel pixel, D: pixels moved per cell

(r is 1, or what a lens of glass makes of a colour's magnification)

in the target (``vrlf/optics/inverse.py``). So the k x k samples are a skewed grid there, the same
for every sub-pixel but for where it lies, and the mean of their bilinear reads is one weighted
sum over the texels of a small window. A texel is then read once, not once for each sample that
it serves. It is the same sum in another order, not an approximation of it.

The default rig's 9 samples span 0.4 x 1.1 pixels: 4 x 4 texels, 4 gathers of 2 x 2 in place of 9.

A wavefront bends that grid: the displacement is a polynomial D(t) of the place t in the cell, of
the degree n - 1 for an order n. With s the place in pixels from where the lenslet stands, t = A s,
it is one of the same degree in s, whose x is the same down a column of samples and whose y along a
row, whatever the lattice's turn. So

    D(A s) = sum_i c_i(s_y) s_x^i

has its c_i worked out once for a row: for the order 8 and three samples 36 + 3 * 7 products, not
3 * 36. That is exact too. A Taylor series about the middle would not do: for 0.7 um of spherical
aberration with coma it is 0.05 pixels off to the second order and 0.005 to the third. How far
apart samples land now depends on the place, so each pixel's need is looked at once for a
prescription (``shaders/forward_kinds.comp``), and ``window_for`` chooses among windows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vrlf.optics import polynomial
from vrlf.optics.inverse import InverseMap
from vrlf.optics.polynomial import Float

# Float32 may move a sample by less than this; a window without room for it would lose light.
_ROUNDING_PX = 1e-4
# A row that is straight to this moves no light that a float32 sum of nine samples keeps.
_STRAIGHT_PX = 1e-9
# With wavefronts, in gathers: by how much a sample is cheaper in a footprint than alone, and what a
# footprint costs before its samples. Measured on software GL with 3 x 3 and 4 x 4 samples. Wider
# windows took twice as long: the compiler left their loops as they are.
_SAMPLE_SAVES, _FOOTPRINT_COSTS, _MOST_CURVED_GATHERS = 2.7, 3.0, 6
_MOST_GATHERS = 16  # a shader keeps all weights of a window, 4 each of these, in registers


@dataclass(frozen=True)
class Footprints:
    """The footprints of all sub-pixels of a rig.

    Attributes
    ----------
    steps_px : ndarray (n, 4)
        For each map: right and down in the target from one sample to the next along a row,
        then down a column.
    window : (columns, rows)
        Texels that hold any sub-pixel's footprint, wherever it lies: even numbers, for one
        gather takes 2 x 2.
    aligned : bool
        Whether rows and columns of samples stay rows and columns in the target.
    """

    steps_px: Float
    window: tuple[int, int]
    aligned: bool


def sample_grid(rectangle_px: Float, grid: int) -> Float:
    """First sample's place from the pixel's centre, and the step to the next, (x, y, dx, dy).

    Parameters
    ----------
    rectangle_px : ndarray (4,)
        Left, top, right and bottom of a colour's emitting area in its pixel.
    grid : int
        Samples along a side.
    """
    corner, step = rectangle_px[:2] - 0.5, (rectangle_px[2:] - rectangle_px[:2]) / grid
    return np.concatenate([corner + 0.5 * step, step])


def footprints(
    maps: list[InverseMap], crossed_per_px: list[Float], samples: list[Float], grid: int
) -> Footprints | None:
    """The footprints of a rig, or None where reading sample by sample is better.

    Parameters
    ----------
    maps : list of InverseMap
        Of each eye and colour.
    crossed_per_px : list of ndarray (2, 2)
        Of each: cells that chief rays move at the array for a pixel to the right and down on the
        panel.
    samples : list of ndarray (4,)
        ``sample_grid`` of each map's sub-pixel.
    grid : int
        Samples along a side of a sub-pixel.
    """
    if any(polynomial.degree(c) > 1 for each in maps for c in each.displacement_px):
        return None
    steps = []
    for each, crossed, sample in zip(maps, crossed_per_px, samples, strict=True):
        jacobian = each.retina_from_panel * np.eye(2) + _moved_per_cell(each) @ crossed
        steps.append((jacobian * sample[2:]).T.ravel())
    steps_px = np.array(steps)
    reach_px = (grid - 1) * (np.abs(steps_px[:, :2]) + np.abs(steps_px[:, 2:])).max(axis=0)
    window = window_of(reach_px)
    skew_px = (grid - 1) * np.abs(steps_px[:, 1:3]).max()
    made = Footprints(steps_px, window, aligned=bool(skew_px <= _STRAIGHT_PX))
    return made if pays(made, 0.0, grid) else None


def pays(made: Footprints, cut_share: float, grid: int) -> bool:
    """Whether footprints, and then the cut share of pixels by samples, are less work.

    One gather in ten must be saved, to pay for the weights and the second program.
    """
    count = gathers(made.window)
    return count <= min((0.9 - cut_share) * grid**2, _MOST_GATHERS)


def window_of(reach_px: Float) -> tuple[int, int]:
    """Texels a side that hold footprints of this reach from first to last sample, (2,); even.

    A sample at x weighs the texels nearer than 1. The window begins at floor(first sample), so
    its texel n is that far from the last one, wherever they lie, if n >= reach + 2.
    """
    columns, rows = 2.0 * np.ceil((np.ceil(reach_px + _ROUNDING_PX) + 2.0) / 2.0)
    return int(columns), int(rows)


def gathers(window: tuple[int, int]) -> int:
    """Reads of 2 x 2 texels that cover a window."""
    return window[0] // 2 * (window[1] // 2)


def _moved_per_cell(each: InverseMap) -> Float:
    """D: the linear part of a map's displacement, shape (2, 2), right and down by rows."""
    linear = [polynomial.padded(c, 2) for c in each.displacement_px]
    return np.array([[c[1, 0], c[0, 1]] for c in linear])


def fitting(kinds: NDArray[np.uint8], window: tuple[int, int]) -> NDArray[np.bool_]:
    """Which pixels have footprints that this window holds.

    Parameters
    ----------
    kinds : ndarray (H, W)
        0 of pixels that show nothing, 1 of cut ones, else columns + 16 rows of texels that their
        footprints need.
    """
    columns, rows = kinds % 16, kinds // 16
    return np.asarray((rows > 0) & (columns <= window[0]) & (rows <= window[1]))


def window_for(
    kinds: NDArray[np.uint8], grid: int, view_px: tuple[int, int]
) -> tuple[int, int] | None:
    """The window with which wavefronts' pixels are least work, or None if samples alone are.

    Parameters
    ----------
    kinds : ndarray (H, W)
        As in ``fitting``.
    grid : int
        Samples along a side of a sub-pixel.
    view_px : (width, height)
        Of a viewport; no window is larger.
    """
    even = range(2, 2 * _MOST_CURVED_GATHERS + 1, 2)
    windows = [(x, y) for x in even if x <= view_px[0] for y in even if y <= view_px[1]]
    counts = np.bincount(kinds.ravel(), minlength=256)
    codes = np.arange(256, dtype=np.uint8)

    def saved(window: tuple[int, int]) -> float:
        gain = _SAMPLE_SAVES * grid**2 - _FOOTPRINT_COSTS - gathers(window)
        return float(gain * counts[fitting(codes, window)].sum())

    best = max(
        (each for each in windows if gathers(each) <= _MOST_CURVED_GATHERS), key=saved, default=None
    )
    return best if best is not None and saved(best) > 0.0 else None
