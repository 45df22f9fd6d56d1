"""The perception operator P and its adjoint, tabulated.

Which panel pixels a retinal pixel sees, and how much, depends on where in its cell the
pixel's chief ray crosses the array, and on nothing else. So the operator of a million pixels
is a table of some thousand rows by phase, made once for a prescription and read bilinearly;
its adjoint is the same table with each entry moved to the phase of the pixel at its other
end. Perpendicular walls divide the panel by another measure: there each pixel has its row.

Measured with float64 matrices, astronaut, green, against rows that were traced for each pixel
by itself with 8192 rays (converged, dB): 64 x 64 phases lose 1.4 read by the nearest and 0.1
read bilinearly with ``matched-microlens``; 128 x 128 nearest, 0.6. What counts is how far a
landing moves from one phase to the next: 0.2 px lose 0.1 dB (matched-wide, 94 phases: 0.06;
thesis's array, 32: 0.03). 256 rays a row lose 1.1 dB, 1024 0.2, 4096 less than 0.1. The
adjoint moved between phases costs 0.04 dB against the true transpose.

A step reads both tables once: for each pixel and table, as many entries (one texel each) as its
row holds, about 25 with ``matched-microlens`` and 180 with the thesis's array. An entry takes
32 bytes (four phases, colours apart), 16 (colours alike: 20 to 30 % less time a step with
``matched-wide`` and ``matched-full`` on llvmpipe) or 12 (the nearest phase, which serves where
rows hold many pixels, and rows of single pixels).
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from vrlf.errors import InputError
from vrlf.gpu import Buffer, Device, Field
from vrlf.model import Rig
from vrlf.optics.lattice import Lattice, lattice_of
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import SIDES, Side
from vrlf.passes.fields import VIEWPORT_FIELDS, lattice_rasters, viewport_values
from vrlf.passes.phases import (
    PatchRows,
    Rows,
    Sampling,
    Turning,
    bands,
    colours_apart,
    joined,
    packed,
    patched,
    phases_per_offset,
    sampling_of,
)
from vrlf.passes.pixels import ENTRY_BYTES, packed_rows, turned
from vrlf.passes.tabulate import RowBuilder

TABLE_FIELDS = (
    *VIEWPORT_FIELDS,
    Field("ivec2", "phases", "along each side of a cell, for the left and the right eye"),
)
# What both tables may take where each pixel has its row.
_MOST_BYTES = 1_000_000_000


@dataclass
class _Table:
    """One table in the making: packed entries, and how many each row has."""

    words: list[NDArray[np.uint32]] = field(default_factory=list)
    counts: list[NDArray[np.int64]] = field(default_factory=list)

    def add(self, words: NDArray[np.uint32], counts: NDArray[np.int64]) -> None:
        """Take more rows."""
        self.words.append(words)
        self.counts.append(counts)

    def add_rows(self, rows: Rows, span: NDArray[np.int64]) -> None:
        """Take the rows from ``span[0]`` to ``span[1]``, one weight for each colour."""
        counts = np.bincount(rows.row - span[0], minlength=int(span[1] - span[0]))
        self.add(packed_rows(rows), counts)

    def add_patches(self, rows: PatchRows, apart: bool) -> None:
        """Take the rows of some patches."""
        self.add(packed(rows, apart), np.diff(rows.starts))

    def buffers(self, device: Device, label: str) -> Iterator[Buffer]:
        """Upload entries, then starts. One entry more, that no row reads: none can't be bound."""
        spare = np.zeros((1, self.words[0].shape[1]), np.uint32)
        yield Buffer(device, np.concatenate([*self.words, spare]), label=f"{label} entries")
        starts = np.cumsum(np.concatenate([[0], *self.counts])).astype(np.int32)
        yield Buffer(device, starts, label=f"{label} starts")


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
        If the tables would take more than a gigabyte, as with walls on a large panel.
    """

    forward: tuple[Buffer, Buffer]
    adjoint: tuple[Buffer, Buffer]
    crossings: Buffer

    def __init__(self, device: Device, rig: Rig, builder: RowBuilder) -> None:
        for _ in self._pieces(device, rig, builder):
            pass

    @classmethod
    def building(cls, device: Device, rig: Rig, builder: RowBuilder) -> Generator[None, None, Self]:
        """The same tables, a piece of work at a time; closed half-way it gives all back."""
        tables = cls.__new__(cls)
        yield from tables._pieces(device, rig, builder)
        return tables

    def _pieces(self, device: Device, rig: Rig, builder: RowBuilder) -> Generator[None, None, None]:
        lattice = lattice_of(rig)
        walled = lattice is not None and lattice.barriers == "perpendicular"
        self.size_px = (rig.panel.width_px, rig.panel.height_px)
        sampling = Sampling((0, 0), is_nearest=True) if walled else sampling_of(rig, lattice)
        self.phases = sampling.phases
        self.defines = {
            "PER_PIXEL": int(walled),
            "CORNERS": 1 if sampling.is_nearest else 4,
            "COLOURS_APART": int(colours_apart(rig)),
        }
        self.values: dict[str, Any] = {**viewport_values(rig), "phases": self.phases}
        forward, adjoint = _Table(), _Table()
        for side, phases in zip(SIDES, self.phases, strict=True):
            rows = yield from self._traced(rig, side, phases, builder, forward)
            if walled:
                yield from self._by_pixel(rows, forward, adjoint)
            else:
                per_offset = phases_per_offset(rig, lattice, phases)
                yield from self._by_phase(rows, phases, per_offset, forward, adjoint)
        yield from self._upload(device, rig, lattice, forward, adjoint)

    def _traced(
        self, rig: Rig, side: Side, phases: int, builder: RowBuilder, forward: _Table
    ) -> Generator[None, None, Rows]:
        """The rows of one eye; of too many pixels they are refused as soon as they are met."""
        stretches: list[Rows] = []
        found = sum(len(words) for words in forward.words)
        with closing(builder.rows(rig, side, phases, self.values["view_px"])) as tracing:
            for each in tracing:
                if each is not None:
                    stretches.append(each)
                    found += len(each.row)
                    if not phases and 2 * ENTRY_BYTES * found > _MOST_BYTES:
                        raise InputError(_too_large(rig))
                yield
        return joined(stretches)

    def _by_phase(
        self, rows: Rows, phases: int, per_offset: Float, forward: _Table, adjoint: _Table
    ) -> Generator[None, None, None]:
        yield from self._by_patch(rows, phases, forward)
        turning = Turning(rows, per_offset, phases, is_nearest=self.defines["CORNERS"] == 1)
        yield
        parts = []
        for band in bands(phases, len(rows.row)):
            parts.append(turning.lines(band))
            yield
        yield from self._by_patch(joined(parts), phases, adjoint)

    def _by_patch(self, rows: Rows, phases: int, table: _Table) -> Generator[None, None, None]:
        """Rows by phase as they are read: the nearest, or patch by patch."""
        for band in bands(phases, len(rows.row)):
            if self.defines["CORNERS"] == 1:
                lines = np.array([band.start, band.stop]) * phases
                table.add_rows(rows.take(slice(*np.searchsorted(rows.row, lines))), lines)
            else:
                table.add_patches(patched(rows, phases, band), bool(self.defines["COLOURS_APART"]))
            yield

    def _by_pixel(
        self, rows: Rows, forward: _Table, adjoint: _Table
    ) -> Generator[None, None, None]:
        width, height = self.values["view_px"]
        for band in bands(height, len(rows.row)):
            lines = np.array([band.start, band.stop]) * width
            here = rows.take(slice(*np.searchsorted(rows.row, lines)))
            forward.add_rows(here, lines)
            adjoint.add_rows(turned(rows, (width, height), band), lines)
            yield

    def _upload(
        self,
        device: Device,
        rig: Rig,
        lattice: Lattice | None,
        forward: _Table,
        adjoint: _Table,
    ) -> Generator[None, None, None]:
        with ExitStack() as undo:
            made: list[Buffer] = []
            for table, label in ((forward, "operator"), (adjoint, "adjoint")):
                for buffer in table.buffers(device, label):
                    undo.callback(buffer.release)
                    made.append(buffer)
                    yield
            self.forward, self.adjoint = (made[0], made[1]), (made[2], made[3])
            self.crossings, owners = lattice_rasters(device, rig, lattice)
            owners.release()
            if lattice is None:  # all pixels have one phase, whatever is read here
                self.crossings.release()
                nothing = np.zeros((sum(self.size_px), 4), np.float32)
                self.crossings = Buffer(device, nothing, label="no crossings")
            undo.pop_all()

    def bind(self, which: Literal["forward", "adjoint"]) -> None:
        """Bind one of the two tables."""
        entries, starts = self.forward if which == "forward" else self.adjoint
        entries.bind(0)
        starts.bind(1)
        self.crossings.bind(2)

    def release(self) -> None:
        """Give all tables back."""
        for buffer in (*self.forward, *self.adjoint, self.crossings):
            buffer.release()


def _too_large(rig: Rig) -> str:
    return (
        f"panel: found {rig.panel.width_px}x{rig.panel.height_px} pixels with array.barriers "
        f"'perpendicular', for which prefilter.method 'optimal' takes more than "
        f"{_MOST_BYTES / 1e9:g} GB (a row of the operator for each pixel), wanted a smaller panel "
        "or barriers 'converging' or 'none'"
    )
