"""Perception ray by ray, with diffraction at the array and lenslets as they are made, in float64.

Twin of ``shaders/perceive_traced.comp``. Each of N well-spread points of the pupil and of the
retinal pixel's area is traced for every retinal pixel and colour in millimetres, by the
design's backward ray (``vrlf/reference/perceive.py``), with

- the lenslet's exact refraction (``vrlf/optics/exact_lenslet.py``) instead of its thin lens's, if
  asked for; the headset's lens and the eye are ideal, that is paraxial, as ever;
- what diffraction adds (``vrlf/optics/fresnel.py``), if asked for, before the barriers, which
  stand where the ray ends.

With neither, it is plain sampling of the fast quadratures' integrals.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from vrlf.model import Rig
from vrlf.optics import fresnel, sequence
from vrlf.optics import lattice as cells
from vrlf.optics.bench import Bench, bench_of, colour_benches
from vrlf.optics.exact_lenslet import landing_mm
from vrlf.optics.eye import EyeOptics, aberration_at, eye_optics
from vrlf.optics.lattice import Lattice, lattice_of
from vrlf.optics.polynomial import Float
from vrlf.optics.samples import pupil_points
from vrlf.optics.sequence import Half
from vrlf.optics.tracing import Diffraction, Tracing, diffraction_of, lens_of, spreading
from vrlf.optics.viewport import SIDES, Viewport, panel_points_mm, viewport
from vrlf.reference.perceive import Bool, Gather, Landing, texels, trace


@dataclass(frozen=True)
class Points:
    """Of one eye and colour; shapes (n, 2), millimetres and slopes, panel frame."""

    u_mm: Float
    slope: Float
    within_mm: Float
    spread_scale: Float


def points_of(rig: Rig, optics: EyeOptics, colour: int, rays: int, half: Half = "all") -> Points:
    """The rays' points, as many as let about ``rays`` through, and M along the lattice's axes."""
    at = pupil_points(rig, optics, rays)
    v_mm = sequence.half_of(at.from_centre_mm, half)
    scale = np.zeros_like(v_mm)
    if lattice_of(rig) is not None:
        scale = spreading(rig, optics, colour, v_mm)
    return Points(
        u_mm=sequence.half_of(at.u_mm, half),
        slope=aberration_at(optics.aberration[colour], v_mm),
        within_mm=sequence.half_of(at.within_pixel_mm, half),
        spread_scale=scale,
    )


class Tracer:
    """One eye's rays from the pupil to the panel."""

    def __init__(self, rig: Rig, view: Viewport, tracing: Tracing) -> None:
        tracing.check(rig)
        self._view, self._lattice = view, lattice_of(rig)
        self._benches = colour_benches(rig)
        self._lens = lens_of(rig, tracing)
        self._diffraction: Diffraction | None = None
        if tracing.diffraction and self._lattice is not None:
            self._diffraction = diffraction_of(rig, self._lattice)
        self._gather = Gather(rig, view, bench_of(rig))

    def landing(
        self, x_mm: Float, u_mm: Float, slope: Float, scale: Float, colour: int
    ) -> tuple[Landing, Bool]:
        """Where rays from retinal points land, and which come through; see ``Landing``."""
        bench = self._benches[colour]
        at = trace(bench, self._lattice, self._view, x_mm, u_mm, slope)
        passes = np.ones(at.cell.shape[:-1], dtype=bool)
        if self._lattice is None:
            return at, passes
        passes = cells.is_open(self._lattice, at.in_cell)
        if self._lens is not None:
            from_centre_mm = at.in_cell @ self._lattice.panel_from_cell.T
            before = _slope_before(bench, x_mm, u_mm, slope)
            local, through = landing_mm(self._lens, from_centre_mm, before, colour)
            at = replace(at, panel_mm=at.array_mm - from_centre_mm + local)
            passes = passes & through
        if self._diffraction is not None:
            cells_off = diffracted_cells(
                self._diffraction, self._lattice, at.in_cell, scale, colour
            )
            at = replace(at, panel_mm=at.panel_mm + cells_off @ self._lattice.panel_from_cell.T)
        return at, passes & self._gather.in_own_area(self._lattice, at)

    def seen(self, half: Float, points: Points, x_mm: Float, colour: int) -> Float:
        """The mean light of one colour over all points, (H, w); ``half`` is (H, w, 3)."""
        total = np.zeros(half.shape[:2])
        for u_mm, slope, within_mm, scale in _each(points):
            at, passes = self.landing(x_mm + within_mm, u_mm, slope, scale, colour)
            pixel, weight = self._gather.emitting(self._gather.raster(at))
            total += (weight * texels(half, pixel))[..., colour] * passes
        return total / len(points.u_mm)


def _each(points: Points) -> Iterator[tuple[Float, ...]]:
    return zip(points.u_mm, points.slope, points.within_mm, points.spread_scale, strict=True)


def _slope_before(bench: Bench, x_mm: Float, u_mm: Float, slope: Float) -> Float:
    """beta, between headset lens and array."""
    alpha = x_mm / bench.panel_per_slope_mm + slope
    return np.asarray(alpha - bench.lens_power_per_mm * (u_mm + bench.relief_mm * alpha))


def diffracted_cells(
    diffraction: Diffraction, lattice: Lattice, in_cell: Float, scale: Float, colour: int
) -> Float:
    """How far diffraction moves rays on the panel, in cells, lattice frame; (..., 2).

    ``in_cell`` is where they pass, ``scale`` M along the lattice's axes.
    """
    number = diffraction.number[colour] * np.abs(scale)
    place = in_cell / diffraction.half_cells
    if lattice.round_holes:
        rho = np.linalg.norm(place, axis=-1, keepdims=True)
        outward = place / np.maximum(rho, 1e-12)
    else:
        rho, outward = np.abs(place), np.sign(place)
    # A shadow turned upside down has its edges on the other side.
    outward = np.where(scale < 0.0, -outward, outward)
    moved = fresnel.residual(diffraction.spread, rho, np.broadcast_to(number, outward.shape))
    return np.asarray(diffraction.unit_cells[colour] * outward * moved)


def perceive_traced(
    panel: Float, rig: Rig, rays: int, tracing: Tracing, half: Half = "all"
) -> Float:
    """What both eyes see of a panel, ray by ray.

    Parameters
    ----------
    panel : ndarray (H, W, 3)
        Linear light.
    rig : Rig
    rays : int
        Rays that are let through, about, for each retinal pixel.
    tracing : Tracing
    half : "all", "first" or "second"
        One half of the points is a quadrature of its own.

    Returns
    -------
    ndarray, shape (H, W, 3)
        Linear light, no exposure applied.

    Raises
    ------
    InputError
        If the rig has nothing for an option.
    """
    seen = np.zeros(panel.shape)
    for side in SIDES:
        view, optics = viewport(rig, side), eye_optics(rig, side)
        tracer, x_mm = Tracer(rig, view, tracing), panel_points_mm(rig, view)
        lit = panel[:, view.columns].astype(np.float64)
        for colour in range(3):
            points = points_of(rig, optics, colour, rays, half)
            seen[:, view.columns, colour] = tracer.seen(lit, points, x_mm, colour)
    return seen
