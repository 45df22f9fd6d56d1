"""The points of perception ray by ray, and all else that it needs of a rig."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import ceil
from typing import Any

import numpy as np

from vrlf.gpu import Buffer, Device
from vrlf.model import Rig
from vrlf.optics.bench import Bench, bench_of, colour_benches
from vrlf.optics.exact_lenslet import ExactLenslet
from vrlf.optics.eye import aberration_at, eye_optics
from vrlf.optics.fresnel import EDGE
from vrlf.optics.lattice import Lattice, lattice_of
from vrlf.optics.polynomial import Float
from vrlf.optics.quadrature import colours_of
from vrlf.optics.samples import pupil_points, ray_table
from vrlf.optics.sequence import Half, half_of
from vrlf.optics.tracing import Diffraction, Tracing, diffraction_of, lens_of, spreading
from vrlf.optics.viewport import (
    RASTER_FLIP,
    SIDES,
    Side,
    axis_in_viewport_px,
    pitch_mm,
    viewport,
)
from vrlf.passes.fields import (
    lattice_defines,
    lattice_rasters,
    lattice_values,
    subpixel_defines,
    subpixel_values,
    vec2_rows,
    viewport_values,
)
from vrlf.passes.rays import ARRAY_KINDS

# Software GL ends all loops of an invocation after 65,535 turns, without a word; a point takes
# up to four for its colours, two times for two loops.
_BATCH_POINTS = 6144
# Of a blocked ray a test is all the work, of one that passes a refraction or a look-up for each
# colour.
_BLOCKED_COST = 0.2


@dataclass(frozen=True)
class Batch:
    """Points that one dispatch gathers."""

    points: int
    rays: Buffer
    within: Buffer

    def release(self) -> None:
        """Give the tables back."""
        self.rays.release()
        self.within.release()


class TracedTables:
    """All that tracing ray by ray needs of one rig, made once.

    Parameters
    ----------
    device : Device
    rig : Rig
    rays : int
        Rays that are let through, about, for each retinal pixel.
    tracing : Tracing
    half : "all", "first" or "second"
        One half of the points is a quadrature of its own.

    Raises
    ------
    InputError
        If the rig has nothing for an option.
    """

    def __init__(
        self, device: Device, rig: Rig, rays: int, tracing: Tracing, half: Half = "all"
    ) -> None:
        tracing.check(rig)
        lattice = lattice_of(rig)
        self._sets = max(len(colours_of(rig, side)) for side in SIDES)
        self.size_px = (rig.panel.width_px, rig.panel.height_px)
        diffraction = None
        if tracing.diffraction and lattice is not None:
            diffraction = diffraction_of(rig, lattice)
        lens = lens_of(rig, tracing)
        self.defines = _defines(rig, self._sets, tracing, lens)
        self.values = {
            **viewport_values(rig),
            **subpixel_values(rig),
            **lattice_values(rig, lattice),
            **_slope_values(rig, lattice),
            **_diffraction_values(diffraction),
            **_lens_values(lens),
        }
        sets = _point_sets(rig, lattice, rays, tracing, half, self._sets)
        self.points = len(sets[0][0])
        open_share = 1.0 if lattice is None else lattice.throughput
        # Rays that a retinal pixel costs for each point, about.
        self.cost = self._sets * (_BLOCKED_COST + 3.0 / self._sets * open_share)
        self.crossings, self.owners = lattice_rasters(device, rig, lattice)
        table = np.zeros((1, 1)) if diffraction is None else diffraction.spread.values
        self.spread = Buffer(device, table.astype(np.float32), label="diffraction's map")
        edges = np.linspace(0, self.points, ceil(self.points / _BATCH_POINTS) + 1).astype(int)
        self.batches = [_batch(device, sets, slice(int(a), int(b))) for a, b in pairwise(edges)]

    def release(self) -> None:
        """Give all tables back."""
        for batch in self.batches:
            batch.release()
        for buffer in (self.crossings, self.owners, self.spread):
            buffer.release()


def _defines(
    rig: Rig, sets: int, tracing: Tracing, lens: ExactLenslet | None
) -> dict[str, int | float | str]:
    return {
        "ARRAY": ARRAY_KINDS[rig.array.kind],
        "SETS": sets,
        "DIFFRACTION": int(tracing.diffraction),
        "EXACT": int(tracing.exact),
        "CURVED_FIRST": int(lens is not None and lens.curved == "eye"),
        **subpixel_defines(rig),
        **lattice_defines(lattice_of(rig)),
    }


def _slope_values(rig: Rig, lattice: Lattice | None) -> dict[str, Any]:
    bench = bench_of(rig)
    axes = [axis_in_viewport_px(rig, viewport(rig, side)) - 0.5 for side in SIDES]
    per_px = bench.relief_factor / bench.panel_per_slope_mm * pitch_mm(rig) * RASTER_FLIP
    values = {
        "axes_px": np.concatenate(axes),
        "slope_per_px": np.zeros(4),
        "pitch_mm": 0.0,
        "bends": np.zeros(4),
        "reduced_gap_mm": bench.reduced_gap_mm,
    }
    if lattice is None:
        return values
    turn = lattice.cell_from_panel * lattice.pitch_mm
    return values | {
        "slope_per_px": (turn @ per_px).ravel(),
        "pitch_mm": lattice.pitch_mm,
        "bends": [*(each.bend for each in colour_benches(rig)), 0.0],
    }


def _diffraction_values(diffraction: Diffraction | None) -> dict[str, Any]:
    if diffraction is None:
        unit, number, size, roots, half = np.zeros(4), np.zeros(4), (0, 0), 1.0, 0.5
    else:
        unit = np.append(diffraction.unit_cells, 0.0)
        number = np.append(diffraction.number, 0.0)
        size, roots = diffraction.spread.values.shape, diffraction.spread.roots_per_unit
        half = diffraction.half_cells
    return {
        "diffraction_unit": unit,
        "fresnel_number": number,
        "spread_size": size,
        "roots_per_unit": roots,
        "half_opening": half,
        "edge": EDGE,
    }


def _lens_values(lens: ExactLenslet | None) -> dict[str, Any]:
    if lens is None:
        return {"lens_index": np.ones(4), "lens_shape": np.zeros(4)}
    shape = (lens.radius_mm, lens.thickness_mm, lens.to_plane_mm, lens.to_panel_mm)
    return {"lens_index": (*lens.index, lens.gap_index), "lens_shape": shape}


def _point_sets(
    rig: Rig, lattice: Lattice | None, rays: int, tracing: Tracing, half: Half, sets: int
) -> list[tuple[Float, Float]]:
    """Rays (n, 8) and places in the pixel (n, 2) of each eye and colour."""
    tables = []
    for side in SIDES:
        colours = colours_of(rig, side)
        # An eye whose colours share their points beside a chromatic one repeats them.
        each = [_points(rig, side, lattice, c, rays, tracing, half) for c in colours]
        tables += each * (sets // len(each))
    return tables


def _points(
    rig: Rig,
    side: Side,
    lattice: Lattice | None,
    colour: int,
    rays: int,
    tracing: Tracing,
    half: Half,
) -> tuple[Float, Float]:
    bench, optics = bench_of(rig), eye_optics(rig, side)
    table, at = (
        ray_table(rig, bench, lattice, optics, colour, rays),
        pupil_points(rig, optics, rays),
    )
    slope, scale = np.zeros_like(at.u_mm), np.zeros_like(at.u_mm)
    if lattice is not None:
        slope = _own_slope(
            bench, lattice, at.u_mm, aberration_at(optics.aberration[colour], at.from_centre_mm)
        )
        if tracing.diffraction:
            scale = spreading(rig, optics, colour, at.from_centre_mm)
    rows = np.concatenate([table.array_cells, table.landing_px, slope, scale], axis=1)
    return half_of(rows, half), half_of(table.within_pixel, half)


def _own_slope(bench: Bench, lattice: Lattice, u_mm: Float, aberration: Float) -> Float:
    """The slope before the array without the retinal point's part, lattice frame."""
    slope = bench.relief_factor * aberration - bench.lens_power_per_mm * u_mm
    return np.asarray(slope @ (lattice.cell_from_panel * lattice.pitch_mm).T)


def _batch(device: Device, sets: list[tuple[Float, Float]], part: slice) -> Batch:
    rays = np.concatenate([each[0][part] for each in sets]).astype(np.float32)
    within = np.concatenate([each[1][part] for each in sets])
    return Batch(
        points=part.stop - part.start,
        rays=Buffer(device, rays, label="traced rays"),
        within=Buffer(device, vec2_rows(within), label="places in the pixel"),
    )
