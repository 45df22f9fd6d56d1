"""Rows of the perception operator, traced on the GPU a piece at a time."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu import Block, Buffer, ComputePass, ComputeVariants, Device, Field
from vrlf.model import Rig
from vrlf.optics.bench import widest_bend
from vrlf.optics.lateral import lateral_reach_px
from vrlf.optics.lattice import lattice_of
from vrlf.optics.raster import half_cell_px
from vrlf.optics.samples import ray_tables
from vrlf.optics.subpixels import layout
from vrlf.optics.viewport import SIDES, Side
from vrlf.passes.fields import VIEWPORT_FIELDS
from vrlf.passes.phases import Rows, table_rays
from vrlf.passes.rays import RAY_FIELDS, Batch, PerceiveTables

ROWS = Block(
    "Rows",
    (
        *VIEWPORT_FIELDS,
        *RAY_FIELDS,
        Field("ivec2", "window_low", "least offset that a window holds"),
        Field("ivec2", "window_px", "columns and rows of a window"),
        Field("vec2", "moved_cells", "how far the lattice lies off the one that phases are of"),
        Field("int", "phases_a_side", "phases along each side of a cell; 0: a row is a pixel"),
        Field("int", "first_row", "where this dispatch begins"),
        Field("int", "row_count", "how many rows it takes"),
        Field("int", "eye", "0 left, 1 right"),
    ),
)
# Windows that are gathered at once, and read back to be packed: some milliseconds.
_WINDOW_BYTES = 1 << 23
# Rays of a row in one dispatch, and rows where the CPU traces them: 64 x 512 rays take a
# core 5 ms.
_STRETCH_RAYS = 512
_SOFTWARE_ROWS = 64
# Weights below this share of a row are rounding.
_NEGLIGIBLE = 1e-6
# Weights below this share of the row's largest, colour by colour, are shared out among the others:
# matched-microlens has 18 entries a row then, not 21, matched-wide 9, not 10, and both lose less
# than 0.01 dB.
_FAINT = 0.01
_ROWS_GROUP = 64
_NOT_MOVED = np.zeros(2)


@dataclass(frozen=True)
class _Windows:
    """Where an eye's rays land, and how its rows are counted."""

    eye: int
    low: NDArray[np.int64]
    size: NDArray[np.int64]
    phases: int
    rows: range
    moved_cells: NDArray[np.float64]

    @property
    def area(self) -> int:
        """Offsets in a window."""
        return int(self.size[0] * self.size[1])


class Stretch(NamedTuple):
    """Whole rows, from ``span[0]`` to ``span[1]``, whether anything is in them or not."""

    rows: Rows
    span: tuple[int, int]


class RowBuilder:
    """Owns the programs that tabulate, one for each kind of rig met so far."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._programs = ComputeVariants(device, "operator_rows.comp", ROWS)

    def rows(
        self,
        rig: Rig,
        side: Side,
        phases: int,
        view_px: tuple[int, int],
        *,
        rays: int | None = None,
        span: range | None = None,
        moved_cells: NDArray[np.float64] = _NOT_MOVED,
    ) -> Generator[Stretch | None, None, None]:
        """P / throughput of one eye, stretch by stretch; None is a rest within one.

        Parameters
        ----------
        phases : int
            Along each side of a cell, for each place of the layout's period; 0 for a row for
            each pixel of the viewport.
        rays : int, optional
            That each row is made of; as many as the rows leave time for, if not given.
        span : range, optional
            The rows that are wanted; all, if not given.
        moved_cells : ndarray (2,), optional
            How far the rig's lattice lies off another one, whose phases are meant.
        """
        places = layout(rig.panel.subpixels).places
        count = places * phases**2 if phases else view_px[0] * view_px[1]
        if rays is None:
            rays = table_rays(count, max(len(ray_tables(rig, each, 1)) for each in SIDES))
        low, size = _window(rig, side, rays)
        wanted = span or range(count)
        windows = _Windows(SIDES.index(side), low, size, phases, wanted, moved_cells)
        tables = PerceiveTables(self._device, rig, rays)
        try:
            yield None
            yield from self._stretches(tables, windows)
        finally:
            tables.release()

    def _stretches(
        self, tables: PerceiveTables, windows: _Windows
    ) -> Generator[Stretch | None, None, None]:
        """Dense windows of as many rows as fit, and what is not dark in them."""
        most = max(1, _WINDOW_BYTES // (12 * windows.area))
        if self._device.info.is_software:
            most = min(most, _SOFTWARE_ROWS)
        scale = tables.points * tables.throughput
        for first in windows.rows[::most]:
            count = min(most, windows.rows.stop - first)
            dense = yield from self._dense(tables, windows, first, count)
            yield None
            place, weights = lit(dense.reshape(count, windows.area, 3), _NEGLIGIBLE * scale)
            row, within = np.divmod(place, windows.area)
            offsets = np.stack([within % windows.size[0], within // windows.size[0]], axis=-1)
            rows = Rows(row + first, offsets + windows.low, weights / np.float32(scale))
            yield Stretch(rows, (first, first + count))

    def _dense(
        self, tables: PerceiveTables, windows: _Windows, first: int, count: int
    ) -> Generator[None, None, NDArray[np.float32]]:
        """Windows of some rows, gathered over all batches of rays; (rows x offsets, 3)."""
        nothing = np.zeros(3 * count * windows.area, np.float32)
        buffer = Buffer(self._device, nothing, label="windows")
        values = {
            "window_low": windows.low,
            "window_px": windows.size,
            "moved_cells": windows.moved_cells,
            "phases_a_side": windows.phases,
            "first_row": first,
            "row_count": count,
            "eye": windows.eye,
        }
        try:
            for batch in tables.batches:
                for stretch in self._parts(tables, batch):
                    buffer.bind(5)
                    self._gather(tables, batch, stretch, values)
                    # Frames that run meanwhile wait for what they are given, and no longer.
                    self._device.finish()
                    yield
            self._device.check("tabulating the operator")
            return np.asarray(buffer.read(np.float32), dtype=np.float32).reshape(-1, 3)
        finally:
            buffer.release()

    def _parts(self, tables: PerceiveTables, batch: Batch) -> list[range]:
        """Stretches of a batch's rays; those in bins are visited bin by bin, all at once."""
        if batch.bin_values["bin_count"][0]:
            return [range(batch.points)]
        step = max(1, int(_STRETCH_RAYS / tables.cost))
        return [range(a, min(a + step, batch.points)) for a in range(0, batch.points, step)]

    def _gather(
        self, tables: PerceiveTables, batch: Batch, stretch: range, values: dict[str, Any]
    ) -> None:
        batch.rays.bind(0)
        batch.within.bind(1)
        tables.crossings.bind(2)
        tables.owners.bind(3)
        batch.bins.bind(4)
        fields = {field.name for field in (*VIEWPORT_FIELDS, *RAY_FIELDS)}
        program = self._program(tables)
        program.set(
            {
                **{name: tables.values[name] for name in fields & set(tables.values)},
                **batch.bin_values,
                "points": batch.points,
                "batch_first": stretch.start,
                "batch_points": len(stretch),
                **values,
            }
        )
        program.run_linear(values["row_count"], _ROWS_GROUP)

    def _program(self, tables: PerceiveTables) -> ComputePass:
        return self._programs.get(tables.defines)

    def release(self) -> None:
        """Give the programs back."""
        self._programs.release()


def lit(
    dense: NDArray[np.float32], negligible: float
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Where windows of shape (rows, offsets, 3) are lit, and how brightly.

    What is too faint to be kept is given to what is: a row keeps its light in each colour.
    """
    rows, area = dense.shape[:2]
    is_lit = np.zeros((rows, area), np.bool_)
    for colour in range(3):
        light = dense[..., colour]
        is_lit |= light > np.maximum(_FAINT * light.max(axis=1), negligible)[:, None]
    place = np.flatnonzero(is_lit)
    kept, row = dense.reshape(-1, 3)[place], place // area
    for colour in range(3):
        whole = dense[..., colour].sum(axis=1)
        left = np.bincount(row, kept[:, colour], minlength=rows)
        share = np.divide(whole, left, out=np.ones(rows), where=left > 0.0)
        kept[:, colour] *= share[row].astype(np.float32)
    return place, kept


def _window(rig: Rig, side: Side, rays: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Least offset and size of the window that holds every landing of an eye."""
    lattice = lattice_of(rig)
    landing = np.concatenate([table.landing_px for table in ray_tables(rig, side, rays)])
    # A sampled ray lands up to half a pixel off, a mean covers up to a pixel.
    reach = np.full(2, 2.0)
    if lattice is not None:
        reach += widest_bend(rig) * lattice.widest_pitch * half_cell_px(rig, lattice)
    reach += lateral_reach_px(rig, side)
    low = np.floor(landing.min(axis=0) - reach).astype(np.int64)
    high = np.ceil(landing.max(axis=0) + reach).astype(np.int64)
    return low, high - low + 1
