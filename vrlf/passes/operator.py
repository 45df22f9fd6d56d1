"""The perception operator P and its adjoint, tabulated by phase.

Which panel pixels a retinal pixel sees, and how much, depends on where in its cell the
pixel's chief ray crosses the array, and on nothing else (perpendicular barriers apart, which
divide the panel by another measure). So the operator of a million pixels is a table of some
ten thousand rows, made once for a prescription; its adjoint is the same table with each
entry moved to the phase of the pixel at its other end.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.errors import InputError
from vrlf.gpu import Block, Buffer, ComputePass, Device, Field
from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.lattice import Lattice, lattice_of
from vrlf.optics.raster import cells_per_pixel, pixels_per_cell
from vrlf.optics.samples import ray_tables
from vrlf.optics.viewport import SIDES
from vrlf.passes.fields import VIEWPORT_FIELDS, lattice_rasters, viewport_values
from vrlf.passes.perceive import RAY_FIELDS, Batch, PerceiveTables

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
    Field("int", "phases_a_side", "phases along each side of a cell"),
    Field("int", "rows_an_eye", "rows of the table that belong to one eye"),
)
# Windows that are gathered at once, and read back to be packed.
_WINDOW_BYTES = 1 << 26
# Weights below this share of a row are rounding.
_NEGLIGIBLE = 1e-6
_ROWS_GROUP = 64
# Fine enough that a phase's width moves no landing by more than about 1/30 pixel.
PHASES_A_SIDE = 128


@dataclass(frozen=True)
class Rows:
    """A sparse operator by phase: row r has entries ``starts[r]`` to ``starts[r + 1]``.

    Attributes
    ----------
    starts : ndarray of int64 (rows + 1,)
    offsets : ndarray of int64 (n, 2)
        To the pixel that is read, right and down.
    weights : ndarray of float32 (n, 3)
        Of each colour.
    """

    starts: NDArray[np.int64]
    offsets: NDArray[np.int64]
    weights: NDArray[np.float32]


class OperatorTables:
    """P / throughput and its adjoint of one rig, on the GPU; made once and swapped whole."""

    def __init__(self, device: Device, rig: Rig, rays: int, builder: RowBuilder) -> None:
        if rig.array.kind != "none" and rig.array.barriers == "perpendicular":
            raise InputError(
                "prefilter.method: found 'optimal' with array.barriers 'perpendicular', wanted "
                "'converging' or 'none' (perpendicular walls have no table of phases)"
            )
        lattice = lattice_of(rig)
        self.phases_a_side = 1 if lattice is None else PHASES_A_SIDE
        self.size_px = (rig.panel.width_px, rig.panel.height_px)
        rows = builder.rows(rig, rays, self.phases_a_side)
        backward = [transposed(each, rig, lattice, self.phases_a_side) for each in rows]
        self._buffers: list[Buffer] = []
        self.forward = self._upload(device, rows, "operator")
        self.adjoint = self._upload(device, backward, "adjoint")
        self.crossings = self._crossings(device, rig, lattice)
        self.values: dict[str, Any] = {
            **viewport_values(rig),
            "phases_a_side": self.phases_a_side,
            "rows_an_eye": self.phases_a_side**2,
        }

    def _upload(self, device: Device, rows: list[Rows], label: str) -> tuple[Buffer, Buffer]:
        entries = np.concatenate([packed(each) for each in rows])
        before = np.cumsum([0] + [each.starts[-1] for each in rows[:-1]])
        starts = np.concatenate(
            [each.starts[:-1] + base for each, base in zip(rows, before, strict=True)]
            + [[len(entries)]]
        )
        pair = (
            Buffer(device, entries, label=f"{label} entries"),
            Buffer(device, starts.astype(np.int32), label=f"{label} starts"),
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


def packed(rows: Rows) -> NDArray[np.uint32]:
    """Entries as the shader unpacks them: two signed bytes and three half floats."""
    if rows.offsets.size and np.abs(rows.offsets).max() > 127:
        raise InputError(
            f"prefilter.method: found a blur of {np.abs(rows.offsets).max()} pixels to a side, "
            "wanted at most 127 for 'optimal'"
        )
    offset = rows.offsets.astype(np.int64) & 0xFF
    half = rows.weights.astype(np.float16).view(np.uint16).astype(np.int64)
    first = offset[:, 0] | offset[:, 1] << 8 | half[:, 0] << 16
    second = half[:, 1] | half[:, 2] << 16
    return np.stack([first, second], axis=-1).astype(np.uint32)


def transposed(rows: Rows, rig: Rig, lattice: Lattice | None, phases: int) -> Rows:
    """The adjoint's table: each entry at the phase of the panel pixel it reads, turned about.

    An offset n moves the phase by a C n cells; rounded to whole phases that is a turn of the
    whole grid, so no two entries of an offset meet.
    """
    row = np.repeat(np.arange(len(rows.starts) - 1), np.diff(rows.starts))
    if lattice is not None:
        step = bench_of(rig).array_from_panel * cells_per_pixel(rig, lattice)
        moved = np.rint(rows.offsets @ step.T * phases).astype(np.int64)
        column = (row % phases + moved[:, 0]) % phases
        line = (row // phases + moved[:, 1]) % phases
        row = line * phases + column
    order = np.argsort(row, kind="stable")
    starts = np.searchsorted(row[order], np.arange(len(rows.starts)))
    return Rows(starts, -rows.offsets[order], rows.weights[order])


class RowBuilder:
    """Owns the programs that tabulate, one for each kind of rig met so far."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._programs: dict[tuple[tuple[str, Any], ...], ComputePass] = {}

    def rows(self, rig: Rig, rays: int, phases: int) -> list[Rows]:
        """P / throughput of both eyes, by phase."""
        tables = PerceiveTables(self._device, rig, rays)
        try:
            low, size = _window(rig, rays)
            return [self._eye_rows(tables, eye, low, size, phases) for eye in range(2)]
        finally:
            tables.release()

    def _eye_rows(
        self,
        tables: PerceiveTables,
        eye: int,
        low: NDArray[np.int64],
        size: NDArray[np.int64],
        phases: int,
    ) -> Rows:
        window = int(size[0] * size[1]) * 3
        most = max(1, _WINDOW_BYTES // (4 * window))
        counts, offsets, weights = [], [], []
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
            dense = self._windows(tables, values, count * window)
            dense = dense.reshape(count, size[1], size[0], 3)
            dense /= tables.points * tables.throughput
            row, line, column = np.nonzero(dense.max(axis=-1) > _NEGLIGIBLE)
            counts.append(np.bincount(row, minlength=count))
            offsets.append(np.stack([column, line], axis=-1) + low)
            weights.append(dense[row, line, column])
        starts = np.concatenate([[0], np.cumsum(np.concatenate(counts))])
        return Rows(starts, np.concatenate(offsets), np.concatenate(weights))

    def _windows(
        self, tables: PerceiveTables, values: dict[str, Any], length: int
    ) -> NDArray[np.float32]:
        """Dense windows of some phases, gathered over all batches of rays."""
        program = self._program(tables.defines)
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

    def _program(self, defines: dict[str, int | float | str]) -> ComputePass:
        key = tuple(sorted(defines.items()))
        if key not in self._programs:
            self._programs[key] = ComputePass(
                self._device, "operator_rows.comp", ROWS, defines=defines
            )
        return self._programs[key]

    def release(self) -> None:
        """Give the programs back."""
        for program in self._programs.values():
            program.release()
        self._programs.clear()


def _window(rig: Rig, rays: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Least offset and size of the window that holds every landing of both eyes."""
    lattice = lattice_of(rig)
    tables = [table for side in SIDES for table in ray_tables(rig, side, rays)]
    landing = np.concatenate([table.landing_px for table in tables])
    reach = np.full(2, 2.0)
    if lattice is not None:
        reach += lattice.bend * np.abs(pixels_per_cell(rig, lattice)).sum(axis=1) / 2.0
    low = np.floor(landing.min(axis=0) - reach).astype(np.int64)
    high = np.ceil(landing.max(axis=0) + reach).astype(np.int64)
    return low, high - low + 1
