"""The perception operator P and its adjoint, tabulated by phase.

Which panel pixels a retinal pixel sees, and how much, depends on where in its cell the
pixel's chief ray crosses the array, and on nothing else (perpendicular barriers apart, which
divide the panel by another measure). So the operator of a million pixels is a table of some
thousand rows, made once for a prescription and read bilinearly; its adjoint is the same
table with each entry moved to the phase of the pixel at its other end.

Measured with float64 matrices, astronaut, green, against rows that were traced for each pixel
by itself with 8192 rays (converged, dB): 64 x 64 phases lose 1.4 read by the nearest and 0.1
read bilinearly with ``matched-microlens``; 128 x 128 nearest, 0.6. What counts is how far a
landing moves from one phase to the next: 0.2 px lose 0.1 dB (matched-wide, 94 phases: 0.06;
thesis's array, 32: 0.03). 256 rays a row lose 1.1 dB, 1024 0.2, 4096 less than 0.1. The
adjoint moved between phases costs 0.04 dB against the true transpose.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.errors import InputError
from vrlf.gpu import Block, Buffer, ComputePass, ComputeVariants, Device, Field
from vrlf.model import Rig
from vrlf.optics.lattice import Lattice, lattice_of
from vrlf.optics.raster import pixels_per_cell
from vrlf.optics.samples import ray_tables
from vrlf.optics.viewport import SIDES, Side
from vrlf.passes.fields import VIEWPORT_FIELDS, lattice_rasters, viewport_values
from vrlf.passes.perceive import RAY_FIELDS, Batch, PerceiveTables
from vrlf.passes.phases import (
    PatchRows,
    PhaseRows,
    packed,
    patched,
    phases_a_side,
    phases_per_offset,
    table_rays,
    transposed,
)

ROWS = Block(
    "Rows",
    (
        *RAY_FIELDS,
        Field("ivec2", "window_low", "least offset that a window holds"),
        Field("ivec2", "window_px", "columns and rows of a window"),
        Field("int", "phases_a_side", "phases along each side of a cell"),
        Field("int", "first_phase", "where this dispatch begins"),
        Field("int", "phase_count", "how many phases it takes"),
        Field("int", "eye", "0 left, 1 right"),
    ),
)
TABLE_FIELDS = (
    *VIEWPORT_FIELDS,
    Field("ivec2", "phases", "along each side of a cell, for the left and the right eye"),
)
# Windows that are gathered at once, and read back to be packed.
_WINDOW_BYTES = 1 << 26
# Weights below this share of a row are rounding.
_NEGLIGIBLE = 1e-6
_ROWS_GROUP = 64


class OperatorTables:
    """P / throughput and its adjoint of one rig, on the GPU; made once and swapped whole.

    Parameters
    ----------
    device : Device
    rig : Rig
    builder : RowBuilder
        Whose programs do the work.

    Raises
    ------
    InputError
        If the barriers are perpendicular.
    """

    def __init__(self, device: Device, rig: Rig, builder: RowBuilder) -> None:
        if rig.array.kind != "none" and rig.array.barriers == "perpendicular":
            raise InputError(
                "prefilter.method: found 'optimal' with array.barriers 'perpendicular', wanted "
                "'converging' or 'none' (perpendicular walls have no table of phases)"
            )
        lattice = lattice_of(rig)
        self.size_px = (rig.panel.width_px, rig.panel.height_px)
        self.phases = [phases_a_side(rig, side, lattice) for side in SIDES]
        forward, adjoint = [], []
        for side, phases in zip(SIDES, self.phases, strict=True):
            rows = builder.rows(rig, side, phases)
            forward.append(patched(rows, phases))
            turned = transposed(rows, phases_per_offset(rig, lattice, phases), phases)
            adjoint.append(patched(turned, phases))
        self._buffers: list[Buffer] = []
        self.forward = self._upload(device, forward, "operator")
        self.adjoint = self._upload(device, adjoint, "adjoint")
        self.crossings = self._crossings(device, rig, lattice)
        self.values: dict[str, Any] = {
            **viewport_values(rig),
            "phases": self.phases,
        }

    def _upload(self, device: Device, rows: list[PatchRows], label: str) -> tuple[Buffer, Buffer]:
        # One entry more, that no row reads: a buffer can't be empty.
        entries = np.concatenate([*(packed(each) for each in rows), np.zeros((1, 8), np.uint32)])
        right = rows[1].starts + rows[0].starts[-1]
        starts = np.concatenate([rows[0].starts[:-1], right]).astype(np.int32)
        pair = (
            Buffer(device, entries, label=f"{label} entries"),
            Buffer(device, starts, label=f"{label} starts"),
        )
        self._buffers += pair
        return pair

    def _crossings(self, device: Device, rig: Rig, lattice: Lattice | None) -> Buffer:
        if lattice is None:
            nothing = np.zeros((sum(self.size_px), 4), np.float32)
            self._buffers.append(Buffer(device, nothing, label="no crossings"))
            return self._buffers[-1]
        crossings, owners = lattice_rasters(device, rig, lattice)
        owners.release()
        self._buffers.append(crossings)
        return crossings

    def bind(self, pair: tuple[Buffer, Buffer]) -> None:
        """Bind one of the two tables."""
        pair[0].bind(0)
        pair[1].bind(1)
        self.crossings.bind(2)

    def release(self) -> None:
        """Give all tables back."""
        for buffer in self._buffers:
            buffer.release()


class RowBuilder:
    """Owns the programs that tabulate, one for each kind of rig met so far."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._programs = ComputeVariants(device, "operator_rows.comp", ROWS)

    def rows(self, rig: Rig, side: Side, phases: int) -> PhaseRows:
        """P / throughput of one eye, by phase."""
        rays = table_rays(phases, max(len(ray_tables(rig, each, 1)) for each in SIDES))
        tables = PerceiveTables(self._device, rig, rays)
        try:
            low, size = _window(rig, side, rays)
            return self._eye_rows(tables, SIDES.index(side), low, size, phases)
        finally:
            tables.release()

    def _eye_rows(
        self,
        tables: PerceiveTables,
        eye: int,
        low: NDArray[np.int64],
        size: NDArray[np.int64],
        phases: int,
    ) -> PhaseRows:
        """Dense windows of as many phases as fit, and what is not dark in them."""
        area = int(size[0] * size[1])
        most = max(1, _WINDOW_BYTES // (12 * area))
        phase, offsets, weights = [], [], []
        for first in range(0, phases**2, most):
            count = min(most, phases**2 - first)
            values = {
                "window_low": low,
                "window_px": size,
                "phases_a_side": phases,
                "first_phase": first,
                "phase_count": count,
                "eye": eye,
            }
            dense = self._windows(tables, values, count * area * 3).reshape(-1, 3)
            least = _NEGLIGIBLE * tables.points * tables.throughput
            lit = np.flatnonzero(
                (dense[:, 0] > least) | (dense[:, 1] > least) | (dense[:, 2] > least)
            )
            phase.append(lit // area + first)
            place = lit % area
            offsets.append(np.stack([place % size[0], place // size[0]], axis=-1) + low)
            weights.append(dense[lit] / np.float32(tables.points * tables.throughput))
        return PhaseRows(np.concatenate(phase), np.concatenate(offsets), np.concatenate(weights))

    def _windows(
        self, tables: PerceiveTables, values: dict[str, Any], length: int
    ) -> NDArray[np.float32]:
        """Dense windows of some phases, gathered over all batches of rays."""
        program = self._programs.get(tables.defines)
        windows = Buffer(self._device, np.zeros(length, np.float32), label="windows")
        try:
            windows.bind(5)
            for batch in tables.batches:
                self._gather(program, tables, batch, values)
            self._device.check("tabulating the operator")
            return np.asarray(windows.read(np.float32), dtype=np.float32)
        finally:
            windows.release()

    def _gather(
        self, program: ComputePass, tables: PerceiveTables, batch: Batch, values: dict[str, Any]
    ) -> None:
        batch.rays.bind(0)
        batch.within.bind(1)
        batch.bins.bind(4)
        rays = {
            field.name: tables.values[field.name]
            for field in RAY_FIELDS
            if field.name in tables.values
        }
        program.set(
            {
                **rays,
                **batch.bin_values,
                "points": batch.points,
                "batch_first": 0,
                "batch_points": batch.points,
                **values,
            }
        )
        program.run_linear(values["phase_count"], _ROWS_GROUP)

    def release(self) -> None:
        """Give the programs back."""
        self._programs.release()


def _window(rig: Rig, side: Side, rays: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Least offset and size of the window that holds every landing of an eye."""
    lattice = lattice_of(rig)
    landing = np.concatenate([table.landing_px for table in ray_tables(rig, side, rays)])
    # A sampled ray lands up to half a pixel off, a mean covers up to a pixel.
    reach = np.full(2, 2.0)
    if lattice is not None:
        reach += lattice.bend * np.abs(pixels_per_cell(rig, lattice)).sum(axis=1) / 2.0
    low = np.floor(landing.min(axis=0) - reach).astype(np.int64)
    high = np.ceil(landing.max(axis=0) + reach).astype(np.int64)
    return low, high - low + 1
