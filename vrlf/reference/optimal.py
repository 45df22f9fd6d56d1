"""Float64 twin of the optimal prefilter: every pixel's row of the operator traced by itself.

No phases, no half floats: the rows come from the twin of perception, pupil point by pupil
point. The steps are those of ``vrlf/solve/optimal.py``.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np

from vrlf.errors import InputError
from vrlf.model import Rig
from vrlf.optics.eye import EyeOptics, aberration_at, eye_optics
from vrlf.optics.lattice import lattice_of
from vrlf.optics.polynomial import Float
from vrlf.optics.samples import pupil_points
from vrlf.optics.tolerance import Case, cases_of
from vrlf.optics.viewport import SIDES, Side, Viewport, viewport
from vrlf.reference.perceive import Gather, Hit

# Where POGM's theta begins: its authors' 1 serves the worst of cases; with 4 the momentum that
# details need is there from the first step (see vrlf/solve/optimal.py).
FIRST_THETA = 4.0
# A pixel that receives less than this share of its light is dark.
_LEAST = 0.01
_MOST_BYTES = 2_000_000_000


class NormalEquations(Protocol):
    """All that ``descend`` asks of an operator."""

    def adjoint(self, seen: Float) -> Float:
        """P' r."""

    def normal(self, light: Float) -> Float:
        """P'P l."""


class Operator:
    """P / throughput of one eye: for each retinal pixel a window of weights on the panel.

    Attributes
    ----------
    weights : ndarray (rows, columns, H, w, 3)
        Weight of the panel pixel at each offset.
    low : (column, row)
        The least offset.
    """

    def __init__(self, rig: Rig, view: Viewport, optics: EyeOptics, rays: int) -> None:
        self.low, size = _reach(rig, view, optics, rays)
        needed = 24 * size[0] * size[1] * view.height_px * view.width_px
        if needed > _MOST_BYTES:
            raise InputError(
                f"panel: found {rig.panel.width_px}x{rig.panel.height_px} pixels, for which the "
                f"reference's operator takes {needed / 1e9:.1f} GB, wanted at most "
                f"{_MOST_BYTES / 1e9:g} GB (a smaller panel, or a GPU)"
            )
        self.weights = np.zeros((size[1], size[0], view.height_px, view.width_px, 3))
        self._shape = (view.height_px, view.width_px)
        for colour in range(3):
            if colour == 0 or optics.is_chromatic:
                self._trace(rig, view, optics, rays, colour)
        lattice = lattice_of(rig)
        self.weights /= 1.0 if lattice is None else lattice.throughput
        self._used = np.argwhere(self.weights.max(axis=(2, 3, 4)) > 0.0)

    def _trace(self, rig: Rig, view: Viewport, optics: EyeOptics, rays: int, colour: int) -> None:
        """Add the rays of one colour's path; all colours share it in an achromatic eye."""
        channels = slice(colour, colour + 1) if optics.is_chromatic else slice(0, 3)
        rows, columns = np.indices(self._shape)
        own = np.stack([columns, rows], axis=-1)
        for pixel, weight in _hits(rig, view, optics, rays, colour):
            at = pixel - own - self.low
            seen = np.all((pixel >= 0) & (pixel < (self._shape[1], self._shape[0])), axis=-1)
            # What is dark may lie outside the window, which was made for what is not.
            seen &= weight.max(axis=-1) > 0.0
            kept = (at[seen][:, 1], at[seen][:, 0], rows[seen], columns[seen])
            self.weights[(*kept, channels)] += weight[seen][:, channels]

    def apply(self, light: Float) -> Float:
        """P l."""
        seen = np.zeros(light.shape)
        for line, column in self._used:
            here, there = self._overlap(line, column)
            seen[here] += self.weights[line, column][here] * light[there]
        return seen

    def adjoint(self, seen: Float) -> Float:
        """P' r."""
        light = np.zeros(seen.shape)
        for line, column in self._used:
            here, there = self._overlap(line, column)
            light[there] += self.weights[line, column][here] * seen[here]
        return light

    def normal(self, light: Float) -> Float:
        """P'P l."""
        return self.adjoint(self.apply(light))

    def _overlap(self, line: int, column: int) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
        """The retinal pixels whose partner at an offset lies in the viewport; the partners."""
        slices = []
        offset = (line + self.low[1], column + self.low[0])
        for step, length in zip(offset, self._shape, strict=True):
            start, end = max(0, -step), min(length, length - step)
            slices.append(
                (slice(start, max(start, end)), slice(start + step, max(start, end) + step))
            )
        return (slices[0][0], slices[1][0]), (slices[0][1], slices[1][1])


class Many:
    """The operators of all cases of a tolerance; all that a solver needs of them is their means.

    Parameters
    ----------
    cases : list of Case
        ``vrlf.optics.tolerance.cases_of``.
    """

    def __init__(self, cases: list[Case], side: Side, rays: int) -> None:
        self._weights = [case.weight for case in cases]
        self._operators = [
            Operator(case.rig, viewport(case.rig, side), eye_optics(case.rig, side), rays)
            for case in cases
        ]

    def adjoint(self, seen: Float) -> Float:
        """The mean of P' r."""
        return self._mean([operator.adjoint(seen) for operator in self._operators])

    def normal(self, light: Float) -> Float:
        """The mean of P'P l."""
        return self._mean([operator.normal(light) for operator in self._operators])

    def _mean(self, values: list[Float]) -> Float:
        pairs = zip(self._weights, values, strict=True)
        return np.asarray(sum(weight * value for weight, value in pairs))


def _hits(rig: Rig, view: Viewport, optics: EyeOptics, rays: int, colour: int) -> Iterator[Hit]:
    """The hits of all pupil points, each with its share of the mean."""
    gather, at = Gather(rig, view, optics.benches[colour]), pupil_points(rig, optics, rays)
    slopes = aberration_at(optics.aberration[colour], at.from_centre_mm)
    for u_mm, slope, within_mm in zip(at.u_mm, slopes, at.within_pixel_mm, strict=True):
        for pixel, weight in gather.hits(u_mm, slope, within_mm):
            yield pixel, weight / len(slopes)


def _reach(
    rig: Rig, view: Viewport, optics: EyeOptics, rays: int
) -> tuple[tuple[int, int], tuple[int, int]]:
    """Least offset that any ray lands at, and the size of the window that holds them all."""
    rows, columns = np.indices((view.height_px, view.width_px))
    own = np.stack([columns, rows], axis=-1)
    low, high = np.full(2, 10**6), np.full(2, -(10**6))
    for colour in range(3 if optics.is_chromatic else 1):
        for pixel, weight in _hits(rig, view, optics, rays, colour):
            offset = (pixel - own)[weight.max(axis=-1) > 0.0]
            if len(offset):
                low = np.minimum(low, offset.min(axis=0))
                high = np.maximum(high, offset.max(axis=0))
    low, high = np.minimum(low, 0), np.maximum(high, 0)
    size = high - low + 1
    return (int(low[0]), int(low[1])), (int(size[0]), int(size[1]))


def optimal(target: Float, rig: Rig, rays: int) -> Float:
    """The panel image that minimises what is left between target and perception, in [0, 1].

    Parameters
    ----------
    target : ndarray (H, W, 3)
        Linear light on the panel's raster.
    rays : int
        For each retinal pixel, in the operator.
    """
    shown = np.zeros(target.shape)
    given = rig.prefilter
    for side in SIDES:
        view = viewport(rig, side)
        operator = Many(cases_of(rig), side, rays)
        meant = target[:, view.columns].astype(np.float64)
        meant = given.black_level + (given.brightness - given.black_level) * meant
        shown[:, view.columns] = descend(operator, meant, given.iterations)
    return shown


def descend(operator: NormalEquations, meant: Float, iterations: int) -> Float:
    """Projected gradient in the metric of P'P1, by POGM (Taylor, Hendrickx & Glineur 2017).

    With x the picture within the bounds, w the plain step from it and z the place that the
    bounds are laid on; Kim & Fessler 2018 write it in these letters.
    """
    ones = np.ones(meant.shape)
    reached = operator.adjoint(ones)
    lit = reached > _LEAST
    curvature = np.where(lit, operator.normal(ones), np.inf)
    back = operator.adjoint(meant)
    x = np.clip(np.where(lit, back / np.where(lit, reached, 1.0), 0.0), 0.0, 1.0)
    w, z, theta, gamma = x, x, FIRST_THETA, 1.0
    for _ in range(iterations):
        following = (1.0 + np.sqrt(1.0 + 4.0 * theta**2)) / 2.0
        w_next = x - (operator.normal(x) - back) / curvature
        z = (
            w_next
            + (theta - 1.0) / following * (w_next - w)
            + theta / following * (w_next - x)
            + (theta - 1.0) / (gamma * following) * (z - x)
        )
        w, x = w_next, np.clip(z, 0.0, 1.0)
        theta, gamma = following, (2.0 * theta + following - 1.0) / following
    return x
