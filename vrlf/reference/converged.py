"""The bounded optimum itself, against which a solver of few steps is judged.

Nothing here is shared with the solver on the GPU but the equations: the operator is a float64
matrix with a row for each retinal pixel, traced ray by ray by the twin of perception (no
phases, no half floats), and what is found is proved to be within 0.002 dB of the best there is
by the gap between primal and dual, whatever steps led there.

Slow, for small panels: 220x110 pixels and 2048 rays took 132 s on two cores, a picture then 4 s.
The rays count: astronaut through ``matched-microlens``, left eye, dB judged with 4096 rays, is
29.91 from 512 rays, 30.12 from 1024, 30.21 from 2048; what the solver on the GPU comes to after
300 steps is 30.24. L-BFGS-B (scipy) found the same optimum of one matrix to 1e-4 dB.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from scipy.sparse import csr_array

from vrlf.errors import InputError
from vrlf.model import Rig
from vrlf.optics.eye import EyeOptics, aberration_at, eye_optics
from vrlf.optics.lattice import lattice_of
from vrlf.optics.polynomial import Float
from vrlf.optics.samples import pupil_points
from vrlf.optics.viewport import SIDES, Side, Viewport, viewport
from vrlf.reference.perceive import Bool, Gather

# Its matrices take some gigabytes where blurred pixels see 300 others.
MOST_PIXELS: Final = 100_000
# A matrix is put together from pieces of so many entries before equal places are added up.
_PIECE: Final = 4_000_000
# Of the squared error, that the optimum may at most be better by: 0.002 dB.
_NEGLIGIBLE: Final = 5e-4
# Where the target is met exactly there is no error for that to be a share of.
_ROUNDING: Final = 1e-14
_STEPS_A_LOOK: Final = 10
_MOST_STEPS: Final = 20_000

Entries = tuple[np.ndarray[Any, np.dtype[np.int64]], np.ndarray[Any, np.dtype[np.int64]], Float]


def operator_matrices(rig: Rig, view: Viewport, optics: EyeOptics, rays: int) -> list[csr_array]:
    """P / throughput of one eye, a matrix for each colour.

    Parameters
    ----------
    rays : int
        Rays that are let through, for each retinal pixel.

    Returns
    -------
    list of three csr_array, each (pixels, pixels)
        Row: a retinal pixel of the viewport, column: a panel pixel, both counted by rows.
    """
    lattice, pixels = lattice_of(rig), view.width_px * view.height_px
    share = 1.0 if lattice is None else 1.0 / lattice.throughput
    matrices = [csr_array((pixels, pixels)) for _ in range(3)]
    for colour in range(3 if optics.is_chromatic else 1):
        channels = [colour] if optics.is_chromatic else [0, 1, 2]
        for pieces in _pieces(rig, view, optics, rays, colour, channels):
            for channel, (row, column, weight) in zip(channels, pieces, strict=True):
                added = csr_array((weight * share, (row, column)), shape=(pixels, pixels))
                matrices[channel] = matrices[channel] + added
    return matrices


def _pieces(
    rig: Rig, view: Viewport, optics: EyeOptics, rays: int, colour: int, channels: list[int]
) -> Iterator[list[Entries]]:
    """Rows, columns and weights of the channels that take one colour's path, piece by piece."""
    gather, at = Gather(rig, view, optics.benches[colour]), pupil_points(rig, optics, rays)
    slopes = aberration_at(optics.aberration[colour], at.from_centre_mm)
    kept: list[list[Entries]] = [[] for _ in channels]
    size = 0
    for u_mm, slope, within_mm in zip(at.u_mm, slopes, at.within_pixel_mm, strict=True):
        for pixel, weight in gather.hits(u_mm, slope, within_mm):
            for index, channel in enumerate(channels):
                entries = _entries(view, pixel, weight[..., channel] / len(slopes))
                kept[index].append(entries)
                size += len(entries[0])
        if size >= _PIECE:
            yield [_joined(each) for each in kept]
            kept, size = [[] for _ in channels], 0
    if size:
        yield [_joined(each) for each in kept]


def _entries(view: Viewport, pixel: Any, weight: Float) -> Entries:
    """What lies in the viewport and counts."""
    column, row = pixel[..., 0].ravel(), pixel[..., 1].ravel()
    inside = (column >= 0) & (column < view.width_px) & (row >= 0) & (row < view.height_px)
    own = np.flatnonzero(inside & (weight.ravel() > 0.0))
    return own, row[own] * view.width_px + column[own], weight.ravel()[own]


def _joined(entries: list[Entries]) -> Entries:
    rows, columns, weights = zip(*entries, strict=True)
    return np.concatenate(rows), np.concatenate(columns), np.concatenate(weights)


def bounded_least_squares(matrix: csr_array, wanted: Float) -> Float:
    """The x within [0, 1] that minimises || A x - b ||^2, proved to be; 0 where no row reaches.

    Accelerated projected gradient (Beck & Teboulle 2009) with restart (O'Donoghue & Candes 2015)
    in the metric of A'A1, until the gap says that it is done: f is convex, so no y within the
    bounds has f(y) below f(x) + f'(x) (y - x), and the least of that is known (Jaggi 2013).

    Parameters
    ----------
    matrix : csr_array (n, n)
        No entry below 0.
    wanted : ndarray (n,)

    Raises
    ------
    ArithmeticError
        If the gap does not close.
    """
    back = csr_array(matrix.T)
    curvature = back @ (matrix @ np.ones(len(wanted)))
    is_reached = curvature > 0.0
    step = np.divide(1.0, curvature, out=np.zeros_like(curvature), where=is_reached)
    x = ahead = np.where(is_reached, np.clip(wanted, 0.0, 1.0), 0.0)
    momentum = 1.0
    for count in range(_MOST_STEPS):
        if count % _STEPS_A_LOOK == 0 and _is_optimal(matrix, back, wanted, x, is_reached):
            return x
        down = back @ (matrix @ ahead - wanted)
        following = np.clip(ahead - step * down, 0.0, 1.0)
        if down @ (following - x) > 0.0:  # momentum leads uphill
            momentum = 1.0
        grown = (1.0 + np.sqrt(1.0 + 4.0 * momentum**2)) / 2.0
        ahead = following + (momentum - 1.0) / grown * (following - x)
        x, momentum = following, grown
    raise ArithmeticError(f"bounded least squares: no optimum within {_MOST_STEPS} steps")


def _is_optimal(
    matrix: csr_array, back: csr_array, wanted: Float, x: Float, is_reached: Bool
) -> bool:
    """Whether nothing within the bounds is better by more than a negligible share."""
    residual = matrix @ x - wanted
    slope = back @ residual
    gap = np.sum(np.where(slope > 0.0, slope * x, slope * (x - 1.0))[is_reached])
    return bool(gap <= _NEGLIGIBLE * 0.5 * float(residual @ residual) + _ROUNDING * len(x))


Matrices = dict[Side, list[csr_array]]


def require_small(rig: Rig) -> None:
    """Refuse a panel too large to wait for, or whose matrices no memory holds."""
    width, height = rig.panel.width_px, rig.panel.height_px
    if width * height > MOST_PIXELS:
        raise InputError(
            f"panel: found {width}x{height} pixels, for which the converged solution takes too "
            f"long, wanted at most {MOST_PIXELS} pixels in all (440x220)"
        )


def converging_matrices(rig: Rig, rays: int) -> Matrices:
    """The matrices of both eyes, traced once for all pictures of a rig.

    Raises
    ------
    InputError
        If the panel is too large to wait for.
    """
    require_small(rig)
    return {
        side: operator_matrices(rig, viewport(rig, side), eye_optics(rig, side), rays)
        for side in SIDES
    }


def converged(target: Float, rig: Rig, matrices: Matrices) -> Float:
    """The panel image that no other within the bounds beats.

    Parameters
    ----------
    target : ndarray (H, W, 3)
        Linear light on the panel's raster.
    matrices : dict
        The rig's, of ``converging_matrices``.

    Returns
    -------
    ndarray, shape (H, W, 3)
        In [0, 1]; a middle column of an odd width is dark.
    """
    given, shown = rig.prefilter, np.zeros(target.shape)
    for side in SIDES:
        view = viewport(rig, side)
        meant = target[:, view.columns].astype(np.float64)
        meant = given.black_level + (given.brightness - given.black_level) * meant
        for channel, matrix in enumerate(matrices[side]):
            solved = bounded_least_squares(matrix, meant[..., channel].ravel())
            shown[:, view.columns, channel] = solved.reshape(view.height_px, view.width_px)
    return shown
