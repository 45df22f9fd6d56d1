"""The rays of perception on the GPU: tables of points, of lines or of holes' points.

Which of them serve is ``vrlf/optics/quadrature.py``'s to say. All tables of a rig are cut
into batches that no driver's loop limit stops.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu import Buffer, Device, Field
from vrlf.model import Rig
from vrlf.optics.bench import bench_of, bends_apart, colour_benches, is_lateral
from vrlf.optics.eye import eye_optics
from vrlf.optics.holes import HoleTable, hole_points, hole_table
from vrlf.optics.lattice import Lattice, lattice_of
from vrlf.optics.lines import line_table
from vrlf.optics.polynomial import Float
from vrlf.optics.quadrature import Quadrature, colours_of, quadrature_of
from vrlf.optics.samples import RayTable, ray_tables
from vrlf.optics.sequence import Half, half_of
from vrlf.optics.viewport import SIDES
from vrlf.passes.bins import BinGrid, grid_over, loop_turns, sort_into, visits_per_ray
from vrlf.passes.fields import (
    LATERAL_FIELDS,
    LATTICE_FIELDS,
    SUBPIXEL_FIELDS,
    crossing_rasters,
    lateral_values,
    lattice_defines,
    lattice_values,
    subpixel_defines,
    subpixel_values,
    vec2_rows,
    viewport_values,
)

# Two eyes of three colours.
_SETS = 6
# What shaders/include/rays.glsl needs.
RAY_FIELDS = (
    *SUBPIXEL_FIELDS,
    *LATTICE_FIELDS,
    *LATERAL_FIELDS,
    Field("float", "bend", "g / f of a lenslet, 0 for a hole; with BENDS it is each line's own"),
    Field("int", "most_pieces", "into which a stretch of a line can be cut"),
    Field(
        "vec4",
        "hole_maps",
        "of each set: cells to pupil radii, to pixels; middle, share",
        3 * _SETS,
    ),
    Field(
        "vec4",
        "hole_seen",
        "of each set: where the pupil's centre is seen, and how far about",
        _SETS,
    ),
    Field("vec2", "bin_origin", "corner of the grid of bins, in cells"),
    Field("vec2", "bin_cells", "size of a bin, in cells"),
    Field("ivec2", "bin_count", "columns and rows of bins"),
    Field("int", "points", "rays in each table"),
    Field("int", "batch_first", "where this batch begins"),
    Field("int", "batch_points", "how many rays it has"),
)
ARRAY_KINDS = {"none": 0, "microlens": 1, "pinhole": 2}
# Software GL ends all loops of an invocation after 65,535 turns, without a word.
_LOOP_TURNS = 49152
# It counts the turns of neighbouring invocations together where they go different ways, as
# they do from bin to bin: as many as its widest vectors hold.
_SOFTWARE_LANES = 16
# What is left of them for finding the holes; a finer mask is sampled blindly.
_HOLE_TURNS = 16384
_NO_BINS: dict[str, Any] = {"bin_origin": (0, 0), "bin_cells": (1, 1), "bin_count": (0, 0)}


@dataclass(frozen=True)
class Batch:
    """Rays that one dispatch gathers: their tables on the GPU, and their bins."""

    points: int
    rays: Buffer
    within: Buffer
    bins: Buffer
    bin_values: dict[str, Any]

    def release(self) -> None:
        """Give the tables back."""
        for buffer in (self.rays, self.within, self.bins):
            buffer.release()


@dataclass(frozen=True)
class _Rows:
    """One table as it is uploaded.

    Attributes
    ----------
    rays : ndarray (n, 4 or 8)
    within : ndarray (n, 2)
    crossings : ndarray (n, 2)
        Where blind points cross the array, place in the pixel included, in cells.
    """

    rays: Float
    within: Float
    crossings: Float

    def part(self, part: slice) -> _Rows:
        return _Rows(self.rays[part], self.within[part], self.crossings[part])


@dataclass(frozen=True)
class _Sets:
    """The tables of all eyes and colours, what they share, and what an entry costs."""

    tables: list[_Rows]
    values: dict[str, Any]
    turns: int
    cost: float


class PerceiveTables:
    """All that perception needs of one rig, made once and swapped whole.

    Parameters
    ----------
    device : Device
    rig : Rig
    rays : int
        Rays that are let through, about, for each retinal pixel.
    half : "all", "first" or "second"
        One half of the rays is a quadrature of its own.

    Attributes
    ----------
    points : int
        Entries of each table; what is gathered over all of them is ``points`` times the mean.
    cost : float
        Rays that a retinal pixel visits for each entry, about.
    """

    def __init__(self, device: Device, rig: Rig, rays: int, half: Half = "all") -> None:
        lattice = lattice_of(rig)
        quadrature = quadrature_of(rig, rays)
        # Two eyes of which one is chromatic: the other's colours share one table, three times.
        self.colours = max(len(colours_of(rig, side)) for side in SIDES)
        sets = _sets(device, rig, lattice, quadrature, rays, half, self.colours)
        self.points = len(sets.tables[0].rays)
        self.cost = sets.cost
        self.defines: dict[str, int | float | str] = {
            "ARRAY": ARRAY_KINDS[rig.array.kind],
            "COLOURS": self.colours,
            "BY_HOLE": int(quadrature == "holes"),
            **subpixel_defines(rig),
            "LATERAL": int(is_lateral(rig)),
            **lattice_defines(lattice),
            "BENDS": int(bends_apart(rig)),
        }
        self.size_px = (rig.panel.width_px, rig.panel.height_px)
        self.throughput = 1.0 if lattice is None else lattice.throughput
        self.values = {
            **viewport_values(rig),
            **subpixel_values(rig),
            **lattice_values(rig, lattice),
            **lateral_values(rig, [bench.panel_from_retina for bench in colour_benches(rig)]),
            **sets.values,
            "bend": bench_of(rig).bend,
        }
        grid_of = lattice if quadrature == "points" else None
        scales = [bench.array_from_retina for bench in colour_benches(rig)]
        if not is_lateral(rig):
            scales = scales[:1]
        crossings = [(scale, None) for scale in scales]
        self.crossings, self.owners = crossing_rasters(device, rig, lattice, crossings)
        self.batches = [
            _batch(device, [table.part(part) for table in sets.tables], grid_of)
            for part in _parts(self.points, self.colours * sets.turns)
        ]

    def release(self) -> None:
        """Give all tables back."""
        for batch in self.batches:
            batch.release()
        self.crossings.release()
        self.owners.release()


def _sets(
    device: Device,
    rig: Rig,
    lattice: Lattice | None,
    quadrature: Quadrature,
    rays: int,
    half: Half,
    colours: int,
) -> _Sets:
    nothing = {
        "most_pieces": 0,
        "hole_maps": np.zeros((3 * _SETS, 4)),
        "hole_seen": np.zeros((_SETS, 4)),
    }
    if lattice is None or quadrature == "points":
        return _point_sets(device, rig, lattice, rays, half, colours, nothing)
    if quadrature == "lines":
        return _line_sets(rig, rays, half, colours, nothing)
    return _hole_sets(rig, lattice, rays, half, colours, nothing)


def _point_sets(
    device: Device,
    rig: Rig,
    lattice: Lattice | None,
    rays: int,
    half: Half,
    colours: int,
    values: dict[str, Any],
) -> _Sets:
    eyes = [ray_tables(rig, side, rays) for side in SIDES]
    flat = [table for each in eyes for table in each * (colours // len(each))]
    # A bare panel's pixels are averaged whole: there is no place in them to fold in.
    folded = lattice is not None and is_lateral(rig)
    tables = [_point_rows(table, half, folded) for table in flat]
    if lattice is None:
        return _Sets(tables, values, 1, 1.0)
    lanes = _SOFTWARE_LANES if device.info.is_software else 1
    turns = visits_per_ray(lattice.hole_reach, lattice.least_pitch) * lanes
    return _Sets(tables, values, turns, lattice.opening)


def _point_rows(table: RayTable, half: Half, folded: bool) -> _Rows:
    """A table of blind points; what a place in the pixel moves stands apart, or in the ray."""
    phi, psi = half_of(table.array_cells, half), half_of(table.landing_px, half)
    within, moved = half_of(table.within_pixel, half), half_of(table.within_cells, half)
    if folded:  # it moves each colour by another measure
        rays = np.concatenate([phi + moved, psi + half_of(table.within_landing_px, half)], axis=1)
        return _Rows(rays, np.zeros_like(within), phi + moved)
    return _Rows(np.concatenate([phi, psi], axis=1), within, phi + moved)


def _line_sets(rig: Rig, rays: int, half: Half, colours: int, values: dict[str, Any]) -> _Sets:
    tables = [
        [line_table(rig, eye_optics(rig, side), c, rays, half) for c in colours_of(rig, side)]
        for side in SIDES
    ]
    flat = [table for each in tables for table in each * (colours // len(each))]
    bends = [bench.bend for bench in colour_benches(rig)[:colours]] * len(SIDES)
    # Shader tables are of one length; what a shorter one lacks weighs nothing.
    longest = max(len(table.share) for table in flat)
    rows = []
    for table, bend in zip(flat, bends, strict=True):
        share = table.share * (longest / len(table.share))
        both = np.concatenate([table.crossing_cells, table.landing_px], axis=1)
        within = np.stack([share, np.full_like(share, bend)], axis=-1)
        fill = ((0, longest - len(share)), (0, 0))
        rows.append(_Rows(np.pad(both, fill), np.pad(within, fill), np.zeros((longest, 0))))
    pieces = max(table.pieces for table in flat)
    return _Sets(rows, values | {"most_pieces": pieces}, 1 + pieces, max(1.0, rays / longest))


def _hole_sets(
    rig: Rig, lattice: Lattice, rays: int, half: Half, colours: int, values: dict[str, Any]
) -> _Sets:
    optics = [eye_optics(rig, side) for side in SIDES]
    # The eye that needs more points sets the number for both.
    points = max(
        (hole_points(rig, lattice, each, rays, half) for each in optics), key=lambda each: len(each)
    )
    eyes = [
        [hole_table(rig, each, colour, points) for colour in colours_of(rig, side)]
        for side, each in zip(SIDES, optics, strict=True)
    ]
    flat = [table for each in eyes for table in each * (colours // len(each))]
    maps, seen = np.zeros((_SETS, 3, 4)), np.zeros((_SETS, 4))
    for index, table in enumerate(flat):
        maps[index, 0] = table.pupil_from_cells.ravel()
        maps[index, 1] = table.px_from_cells.ravel()
        maps[index, 2] = [*table.centre_px, table.share, 0.0]
        seen[index] = [*table.centre_cells, *table.reach_cells]
    nowhere = np.zeros_like(points[:, :2])
    rows = [
        _Rows(np.concatenate([t.in_pupil, t.landing_px], axis=1), nowhere, nowhere) for t in flat
    ]
    holes = max(_most_holes(table, lattice.least_pitch) for table in flat)
    cost = max(float(np.prod(2.0 * table.reach_cells)) for table in flat)
    return _Sets(rows, values | {"hole_maps": maps.reshape(-1, 4), "hole_seen": seen}, holes, cost)


def _most_holes(table: HoleTable, least_pitch: float) -> int:
    """Holes that a pixel's search can meet, and its loops' own turns."""
    a_side = np.floor(2.0 * table.reach_cells / least_pitch) + 1.0
    return int(np.prod(a_side + 1.0)) + 1


def _parts(points: int, turns_per_point: int) -> list[slice]:
    """The table cut into batches that no loop limit stops."""
    most = max(1, _LOOP_TURNS // turns_per_point)
    count = ceil(points / most)
    edges = np.linspace(0, points, count + 1).astype(int)
    return [slice(int(a), int(b)) for a, b in pairwise(edges)]


def _bins(tables: list[_Rows], lattice: Lattice | None) -> BinGrid | None:
    """The grid that blind points behind a mask are sorted into; None where no search pays."""
    if lattice is None:
        return None
    grid = grid_over([table.crossings for table in tables], lattice.hole_reach)
    turns = loop_turns(grid, lattice.hole_reach, lattice.least_pitch)
    return grid if turns * max(1, len(tables) // 2) <= _HOLE_TURNS else None


def _batch(device: Device, tables: list[_Rows], lattice: Lattice | None) -> Batch:
    """Upload a batch; behind a mask (``lattice``) blind points are sorted into bins."""
    rays: list[NDArray[np.float64]] = [table.rays for table in tables]
    within = [table.within for table in tables]
    starts = np.zeros(1, np.int32)
    bin_values = _NO_BINS
    grid = _bins(tables, lattice)
    if grid is not None:
        sorting = [sort_into(grid, table.crossings) for table in tables]
        rays = [each[order] for each, (order, _) in zip(rays, sorting, strict=True)]
        within = [each[order] for each, (order, _) in zip(within, sorting, strict=True)]
        count = len(rays[0])
        starts = np.concatenate([s + i * count for i, (_, s) in enumerate(sorting)])
        bin_values = {
            "bin_origin": grid.origin,
            "bin_cells": grid.size,
            "bin_count": grid.count,
        }
    return Batch(
        points=len(rays[0]),
        rays=Buffer(device, np.concatenate(rays).astype(np.float32), label="rays"),
        within=Buffer(device, vec2_rows(np.concatenate(within)), label="places in the pixel"),
        bins=Buffer(device, starts.astype(np.int32), label="bins"),
        bin_values=bin_values,
    )
