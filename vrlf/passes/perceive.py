"""What both eyes see of a panel image."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import ceil
from typing import Any

import numpy as np

from vrlf.gpu import Block, Buffer, ComputePass, ComputeVariants, Device, Field, Texture
from vrlf.model import Rig
from vrlf.optics.bench import Bench, bench_of
from vrlf.optics.lattice import Lattice, lattice_of
from vrlf.optics.samples import (
    RayTable,
    footprint_pixels,
    footprint_scale,
    ray_tables,
    uses_area_means,
)
from vrlf.optics.viewport import SIDES, pitch_mm
from vrlf.passes.bins import BinGrid, grid_over, loop_turns, sort_into, visits_per_ray
from vrlf.passes.fields import (
    LATTICE_FIELDS,
    SUBPIXEL_FIELDS,
    VIEWPORT_FIELDS,
    lattice_rasters,
    lattice_values,
    subpixel_values,
    vec2_rows,
    viewport_values,
)

# What shaders/include/rays.glsl needs.
RAY_FIELDS = (
    *SUBPIXEL_FIELDS,
    *LATTICE_FIELDS,
    Field("float", "bend", "g / f of a lenslet, 0 for a hole"),
    Field("float", "footprint_px", "side of a retinal pixel's image at one pupil point"),
    Field("float", "whole_at_array", "a pixel's rays pass one lenslet within this of its centre"),
    Field("float", "whole_at_barrier", "and land in one area within this of its centre"),
    Field("vec2", "bin_origin", "corner of the grid of bins, in cells"),
    Field("vec2", "bin_cells", "size of a bin, in cells"),
    Field("ivec2", "bin_count", "columns and rows of bins"),
    Field("int", "points", "rays in each table"),
    Field("int", "batch_first", "where this batch begins"),
    Field("int", "batch_points", "how many rays it has"),
)
PERCEIVE = Block(
    "Perceive",
    (
        *VIEWPORT_FIELDS,
        *RAY_FIELDS,
        Field("int", "first_row", "where this dispatch begins"),
        Field("int", "rows", "how many rows it has"),
        Field("int", "is_first", "1 if nothing has been gathered yet"),
        Field("float", "scale", "what the gathered light is multiplied with after this batch"),
    ),
)
_KINDS = {"none": 0, "microlens": 1, "pinhole": 2}
# Software GL ends all loops of an invocation after 65,535 turns, without a word.
_LOOP_TURNS = 49152
# It counts the turns of neighbouring invocations together where they go different ways, as
# they do from hole to hole: as many as its widest vectors hold.
_SOFTWARE_LANES = 16
# What is left of them for finding the holes; a finer mask is sampled blindly.
_HOLE_TURNS = 16384
# Rays of one dispatch: a driver that resets after 2 s must not see more at once.
_DISPATCH_RAYS = 1 << 29


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


class PerceiveTables:
    """All that perception needs of one rig, made once and swapped whole.

    Parameters
    ----------
    device : Device
    rig : Rig
    rays : int
        Rays that are let through, about, for each retinal pixel.
    """

    def __init__(self, device: Device, rig: Rig, rays: int) -> None:
        lattice, bench = lattice_of(rig), bench_of(rig)
        tables = [ray_tables(rig, side, rays) for side in SIDES]
        # Two eyes of which one is chromatic: the other's colours share one table, three times.
        self.colours = max(len(each) for each in tables)
        tables = [each * (self.colours // len(each)) for each in tables]
        self.points = len(tables[0][0].landing_px)
        self.defines: dict[str, int | float | str] = {
            "ARRAY": _KINDS[rig.array.kind],
            "COLOURS": self.colours,
            "AREA_MEANS": int(uses_area_means(bench, lattice)),
            # A point sample fetches one pixel, whatever the footprint.
            "FOOTPRINT_PX": _footprint_px(bench, lattice),
        }
        self.size_px = (rig.panel.width_px, rig.panel.height_px)
        self.throughput = 1.0 if lattice is None else lattice.throughput
        self.values = {
            **viewport_values(rig),
            **subpixel_values(rig),
            **lattice_values(rig, lattice),
            **_footprint_values(rig, lattice),
            "bend": 0.0 if lattice is None else lattice.bend,
        }
        flat = [table for each in tables for table in each]
        self.crossings, self.owners = lattice_rasters(device, rig, lattice)
        self.batches = [
            _batch(device, [_part(t, lattice, bench.array_from_panel, part) for t in flat], lattice)
            for part in _parts(self.points, self.colours * _turns(device, bench, lattice))
        ]

    def release(self) -> None:
        """Give all tables back."""
        for batch in self.batches:
            batch.release()
        self.crossings.release()
        self.owners.release()


def _footprint_values(rig: Rig, lattice: Lattice | None) -> dict[str, float]:
    """How far from a cell's centre all rays of a retinal pixel stay together."""
    bench = bench_of(rig)
    # A square of no size is a point; the floor keeps the mean's quotient finite.
    side = abs(footprint_scale(bench, lattice))
    whole_at_array = whole_at_barrier = 0.0
    if lattice is not None:
        spread = float(np.abs(lattice.cell_from_panel[0]).sum()) * pitch_mm(rig) / 2.0
        whole_at_array = 0.5 - spread * bench.array_from_panel
        whole_at_barrier = 0.5 - spread * lattice.barrier_scale * side
    return {
        "footprint_px": max(side, 1e-3),
        "whole_at_array": whole_at_array,
        "whole_at_barrier": whole_at_barrier,
    }


def _footprint_px(bench: Bench, lattice: Lattice | None) -> int:
    """Pixels a side that an area mean fetches."""
    return footprint_pixels(bench, lattice) if uses_area_means(bench, lattice) else 1


def _turns(device: Device, bench: Bench, lattice: Lattice | None) -> int:
    """Loop turns that a ray may cost a pixel, at most."""
    if lattice is None or lattice.kind != "pinhole":
        pixels = _footprint_px(bench, lattice)
        # Two by two are unrolled; more are loops of their own.
        return 1 if pixels <= 2 else 1 + pixels + pixels**2
    lanes = _SOFTWARE_LANES if device.info.is_software else 1
    return visits_per_ray(lattice.half_aperture) * lanes


def _parts(points: int, turns_per_point: int) -> list[slice]:
    """The table cut into batches that no loop limit stops."""
    most = max(1, _LOOP_TURNS // turns_per_point)
    count = ceil(points / most)
    edges = np.linspace(0, points, count + 1).astype(int)
    return [slice(int(a), int(b)) for a, b in pairwise(edges)]


@dataclass(frozen=True)
class _Part:
    """A stretch of a table, and where its rays cross the array (in cells, place included)."""

    rays: np.ndarray[Any, np.dtype[np.float64]]
    within: np.ndarray[Any, np.dtype[np.float64]]
    crossings: np.ndarray[Any, np.dtype[np.float64]]


def _part(table: RayTable, lattice: Lattice | None, array_from_panel: float, part: slice) -> _Part:
    phi, psi, within = (
        values[part] for values in (table.array_cells, table.landing_px, table.within_pixel)
    )
    crossings = phi
    if lattice is not None:
        crossings = phi + array_from_panel * within @ table.cells_per_px.T
    return _Part(np.concatenate([phi, psi], axis=1), within, crossings)


def _bins(parts: list[_Part], lattice: Lattice | None) -> BinGrid | None:
    """The grid that holes' rays are sorted into; None where no search pays."""
    if lattice is None or lattice.kind != "pinhole":
        return None
    grid = grid_over([part.crossings for part in parts], lattice.half_aperture)
    turns = loop_turns(grid, lattice.half_aperture)
    return grid if turns * max(1, len(parts) // 2) <= _HOLE_TURNS else None


def _batch(device: Device, parts: list[_Part], lattice: Lattice | None) -> Batch:
    """Upload a batch; behind a mask its rays are sorted into bins."""
    rays = [part.rays for part in parts]
    within = [part.within for part in parts]
    starts = np.zeros(1, np.int32)
    bin_values: dict[str, Any] = {"bin_origin": (0, 0), "bin_cells": (1, 1), "bin_count": (0, 0)}
    grid = _bins(parts, lattice)
    if grid is not None:
        sorted_parts = [sort_into(grid, part.crossings) for part in parts]
        rays = [each[order] for each, (order, _) in zip(rays, sorted_parts, strict=True)]
        within = [each[order] for each, (order, _) in zip(within, sorted_parts, strict=True)]
        count = len(rays[0])
        starts = np.concatenate([s + i * count for i, (_, s) in enumerate(sorted_parts)])
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


class Perceive:
    """Owns the programs of the perception pass, one for each kind of rig met so far."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._programs = ComputeVariants(device, "perceive.comp", PERCEIVE)

    def run(
        self, tables: PerceiveTables, panel: Texture, seen: Texture, *, exposure: float = 1.0
    ) -> None:
        """Gather the light of ``panel`` into ``seen`` (rgba32f, the panel's size).

        ``exposure`` multiplies what is seen.
        """
        program = self._programs.get({**tables.defines, "TRACE": 0})
        panel.bind_sampler(0)
        seen.bind_image(0, read=True, write=True)
        for index, batch in enumerate(tables.batches):
            is_last = index == len(tables.batches) - 1
            values = {
                "is_first": int(index == 0),
                "scale": exposure / tables.points if is_last else 1.0,
                "batch_first": 0,
            }
            self._gather(program, tables, batch, values)
        self._device.check("perceiving")

    def trace(self, tables: PerceiveTables, point: int, landing: Texture) -> None:
        """Write where one ray of the tables lands, for tests: place in the cell, then pixels.

        Holes keep their rays sorted; there ``point`` counts in that order.
        """
        program = self._programs.get({**tables.defines, "TRACE": 1})
        landing.bind_image(0, read=True, write=True)
        values = {"is_first": 1, "scale": 1.0, "batch_first": point}
        self._gather(program, tables, tables.batches[0], values)
        self._device.check("tracing")

    def _gather(
        self, program: ComputePass, tables: PerceiveTables, batch: Batch, values: dict[str, Any]
    ) -> None:
        """One batch of rays, in stretches of rows that no driver takes for a hang."""
        width, height = tables.size_px
        batch.rays.bind(0)
        batch.within.bind(1)
        tables.crossings.bind(2)
        tables.owners.bind(3)
        batch.bins.bind(4)
        per_row = width * batch.points * tables.colours * tables.throughput
        rows = max(1, min(height, int(_DISPATCH_RAYS / per_row)))
        common = {
            **tables.values,
            **batch.bin_values,
            "points": batch.points,
            "batch_points": batch.points,
            **values,
        }
        for first_row in range(0, height, rows):
            program.set({**common, "first_row": first_row, "rows": rows})
            program.run(width, min(rows, height - first_row))

    def release(self) -> None:
        """Give the programs back."""
        self._programs.release()
