"""The perception operator P and its adjoint, tabulated.

Which panel pixels a retinal pixel sees, and how much, depends on where in its cell the
pixel's chief ray crosses the array, and on nothing else. So the operator of a million pixels
is a table of some ten thousand rows by phase, made once for a prescription; its adjoint is the
same table with each entry moved to the phase of the pixel at its other end. Layouts of which
neighbouring pixels differ have such rows for each place of their period. Perpendicular walls
divide the panel by another measure, colours that the headset's lens magnifies differently land
elsewhere in each pixel, and where the pitch varies no two cells are alike: there each pixel has
its row.

Measured (dB after 16 steps, matched-microlens, astronaut and coffee): 213 x 213 phases of which
the nearest is read lose 0.05 to 0.08 against 85 x 85 that are read bilinearly, but a row holds
18 entries of 8 bytes, not 27 of 32. A product took 0.85 ms on an H200 (1334x750) where a pixel's
invocation walked through its bilinear row, 0.18 where eight shared it, 0.08 with these rows.

A step reads both tables once: for each pixel and table, as many entries (one texel each) as its
row holds, 18 with ``matched-microlens`` and 208 with the thesis's array.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from vrlf.errors import InputError
from vrlf.gpu import GROUP_PX, Buffer, Device, Field
from vrlf.model import Rig
from vrlf.optics.bench import is_lateral
from vrlf.optics.lattice import Lattice, lattice_of
from vrlf.optics.subpixels import layout
from vrlf.optics.viewport import SIDES
from vrlf.passes.fields import (
    VIEWPORT_FIELDS,
    lattice_rasters,
    subpixel_defines,
    viewport_values,
)
from vrlf.passes.phases import (
    Rows,
    Turning,
    bands,
    joined,
    packed,
    phases_per_offset,
    sampling_of,
    signed,
)
from vrlf.passes.pixels import turned
from vrlf.passes.tabulate import RowBuilder, Stretch
from vrlf.passes.tolerant import (
    mean_phases,
    mean_rows,
    spread_of_cases,
    variance_phases,
    variance_rows,
)

TABLE_FIELDS = (
    *VIEWPORT_FIELDS,
    Field("ivec2", "phases", "along each side of a cell, for the left and the right eye"),
)
ENTRY_BYTES = 8
# What both tables may take where each pixel has its row.
_MOST_BYTES = 1_000_000_000
# Parts of a table that are uploaded in a piece of work: some hundred kB.
_UPLOADS = 4
# Invocations that share a row on a GPU, so that they read what lies side by side; of short rows
# too many find nothing to do. Measured on an H200, 1334x750, 10 steps in ms with 1, 2, 4, 8:
# matched-wide (9 entries a row) 1.28 1.14 1.41 2.81; matched-microlens (17) 4.04 2.41 1.79 3.23;
# matched-full (17) 2.03 1.56 1.70; thesis's array (208) 17.5 10.7 10.9 12.9; Table 8.1 (89)
# 7.8 5.1 4.9 5.8.
_LANES, _SHORT_LANES, _SHORT_ROW = 4, 2, 12


Tracing = Generator[Stretch | None, None, None]


@dataclass
class _Table:
    """One table in the making: pairs of packed entries, and how many pairs each row has."""

    words: list[NDArray[np.uint32]] = field(default_factory=list)
    pairs: list[NDArray[np.int64]] = field(default_factory=list)

    def add(self, rows: Rows, span: tuple[int, int]) -> None:
        """Take the rows from ``span[0]`` to ``span[1]``, each filled up to a whole pair."""
        counts = np.bincount(rows.row - span[0], minlength=span[1] - span[0])
        pairs = (counts + 1) // 2
        words = np.zeros((2 * int(pairs.sum()), 2), np.uint32)
        # How many entries were put in before an entry's own row to fill others up.
        filled = np.cumsum(2 * pairs - counts) - (2 * pairs - counts)
        words[np.arange(len(rows.row)) + filled[rows.row - span[0]]] = packed(rows)
        self.words.append(words.reshape(-1, 4))
        self.pairs.append(pairs)

    @property
    def entries(self) -> int:
        """All of them."""
        return 2 * sum(len(words) for words in self.words)

    @property
    def entries_a_row(self) -> float:
        """On average."""
        return self.entries / max(sum(len(pairs) for pairs in self.pairs), 1)

    def buffers(
        self, device: Device, label: str, undo: ExitStack
    ) -> Generator[None, None, tuple[Buffer, Buffer]]:
        """Upload entries, then starts, a part at a time; ``undo`` gives them back.

        One pair more, that no row reads: none can't be bound.
        """
        nbytes = ENTRY_BYTES * (self.entries + 2)
        entries = Buffer.reserved(device, nbytes, label=f"{label} entries")
        undo.callback(entries.release)
        at, spare = 0, np.zeros((1, 4), np.uint32)
        for number, words in enumerate([*self.words, spare]):
            entries.write_part(words, at)
            at += words.nbytes
            if number % _UPLOADS == 0:
                yield
        starts = np.cumsum(np.concatenate([[0], *self.pairs])).astype(np.int32)
        made = Buffer(device, starts, label=f"{label} starts")
        undo.callback(made.release)
        yield
        return entries, made


class OperatorTables:
    """P / throughput and its adjoint of one rig, on the GPU; made once and swapped whole.

    With a tolerance they are the mean over its cases, and ``variance`` is what the cases add to
    P'P beyond it.

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
    variance: tuple[Buffer, Buffer] | None
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
        by_pixel = is_lateral(rig) or (lattice is not None and _is_nowhere_alike(lattice))
        self.size_px = (rig.panel.width_px, rig.panel.height_px)
        self.phases = (0, 0) if by_pixel else sampling_of(rig, lattice)
        if rig.tolerance is not None:
            self.phases = mean_phases(*self.phases)
        if rig.tolerance is not None and by_pixel:
            raise InputError(f"tolerance: found it beside {_own_rows(rig)}, wanted one of the two")
        self.values: dict[str, Any] = {**viewport_values(rig), "phases": self.phases}
        self.variance_values = self.values
        forward, adjoint, variance = _Table(), _Table(), _Table()
        if rig.tolerance is not None:
            yield from self._of_many(rig, lattice, builder, forward, adjoint, variance)
        else:
            yield from self._of_one(rig, lattice, builder, forward, adjoint)
        lanes = _lanes(device, forward)
        # The width of a group that holds as many lanes for each of its pixels, too.
        self.defines = {
            "PER_PIXEL": int(by_pixel),
            "LANES": lanes,
            "GROUP_LANES": lanes * GROUP_PX,
            **subpixel_defines(rig),
        }
        yield from self._upload(device, rig, lattice, forward, adjoint, variance)

    def _of_one(
        self,
        rig: Rig,
        lattice: Lattice | None,
        builder: RowBuilder,
        forward: _Table,
        adjoint: _Table,
    ) -> Generator[None, None, None]:
        """The rig's own operator and its adjoint."""
        for side, phases in zip(SIDES, self.phases, strict=True):
            tracing = builder.rows(rig, side, phases, self.values["view_px"])
            if phases == 0:
                yield from self._by_pixel(rig, tracing, forward, adjoint)
            else:
                yield from self._by_phase(rig, lattice, phases, tracing, forward, adjoint)

    def _by_phase(
        self,
        rig: Rig,
        lattice: Lattice | None,
        phases: int,
        tracing: Tracing,
        forward: _Table,
        adjoint: _Table,
    ) -> Generator[None, None, None]:
        """One eye's rows, and the adjoint's from them."""
        turning = Turning(
            phases_per_offset(rig, lattice, phases), phases, layout(rig.panel.subpixels).period
        )

        def take(stretch: Stretch) -> None:
            forward.add(*stretch)
            turning.take(stretch.rows)

        yield from _traced(tracing, take)
        entries = yield from turning.join()
        for band in bands(layout(rig.panel.subpixels).places * phases, entries):
            adjoint.add(turning.lines(band), (band.start * phases, band.stop * phases))
            yield

    def _of_many(
        self,
        rig: Rig,
        lattice: Lattice | None,
        builder: RowBuilder,
        forward: _Table,
        adjoint: _Table,
        variance: _Table,
    ) -> Generator[None, None, None]:
        """The mean over all cases of a tolerance, and its variance."""
        view_px, of_variance = self.values["view_px"], []
        for side, phases in zip(SIDES, self.phases, strict=True):
            spread = yield from spread_of_cases(rig, side, builder, view_px)
            tracing = mean_rows(rig, side, phases, spread, builder, view_px)
            yield from self._by_phase(rig, lattice, phases, tracing, forward, adjoint)
            few = variance_phases(rig, phases, spread)
            rows = yield from variance_rows(rig, side, few, spread, builder, view_px)
            count = layout(rig.panel.subpixels).places * few**2
            for band in bands(count, len(rows.row)):
                variance.add(signed(rows.between(band)), (band.start, band.stop))
                yield
            of_variance.append(few)
        self.variance_values = {**self.values, "phases": tuple(of_variance)}

    def _by_pixel(
        self, rig: Rig, tracing: Tracing, forward: _Table, adjoint: _Table
    ) -> Generator[None, None, None]:
        """Of too many pixels the rows are refused as soon as they are met."""
        stretches: list[Rows] = []
        width, height = self.values["view_px"]

        def take(stretch: Stretch) -> None:
            forward.add(*stretch)
            stretches.append(stretch.rows)
            if 2 * ENTRY_BYTES * forward.entries > _MOST_BYTES:
                raise InputError(_too_large(rig))

        yield from _traced(tracing, take)
        rows = joined(stretches)
        for band in bands(height, len(rows.row)):
            lines = band.start * width, band.stop * width
            adjoint.add(turned(rows, (width, height), band), lines)
            yield

    def _upload(
        self,
        device: Device,
        rig: Rig,
        lattice: Lattice | None,
        forward: _Table,
        adjoint: _Table,
        variance: _Table,
    ) -> Generator[None, None, None]:
        with ExitStack() as undo:
            self.forward = yield from forward.buffers(device, "operator", undo)
            self.adjoint = yield from adjoint.buffers(device, "adjoint", undo)
            self.variance = None
            if rig.tolerance is not None:
                self.variance = yield from variance.buffers(device, "variance", undo)
            self.crossings, owners = lattice_rasters(device, rig, lattice)
            owners.release()
            if lattice is None:  # all pixels have one phase, whatever is read here
                self.crossings.release()
                nothing = np.zeros((sum(self.size_px), 4), np.float32)
                self.crossings = Buffer(device, nothing, label="no crossings")
            undo.pop_all()

    @property
    def is_tolerant(self) -> bool:
        """Whether it stands for many cases."""
        return self.variance is not None

    def bind(self, which: Literal["forward", "adjoint", "variance"]) -> None:
        """Bind one of the tables."""
        tables = {"forward": self.forward, "adjoint": self.adjoint, "variance": self.variance}
        table = tables[which]
        assert table is not None, "a rig without a tolerance has no variance"
        entries, starts = table
        entries.bind(0)
        starts.bind(1)
        self.crossings.bind(2)

    def release(self) -> None:
        """Give all tables back."""
        for buffer in (*self.forward, *self.adjoint, *(self.variance or ()), self.crossings):
            buffer.release()


def _traced(tracing: Tracing, take: Callable[[Stretch], None]) -> Generator[None, None, None]:
    """All rows of one eye, a stretch at a time."""
    with closing(tracing):
        for stretch in tracing:
            if stretch is not None:
                take(stretch)
            yield


def _is_nowhere_alike(lattice: Lattice) -> bool:
    return lattice.barriers == "perpendicular" or lattice.is_varying


def _lanes(device: Device, table: _Table) -> int:
    """How many invocations share a row: one where the CPU does the work."""
    if device.info.is_software:
        return 1
    return _LANES if table.entries_a_row > _SHORT_ROW else _SHORT_LANES


def _own_rows(rig: Rig) -> str:
    """Why each pixel has a row of its own."""
    if is_lateral(rig):
        return "headset.glass with an eye relief, which magnifies the colours differently"
    return "a pitch that varies" if rig.array.varies else "array.barriers 'perpendicular'"


def _too_large(rig: Rig) -> str:
    remedy = "barriers 'converging' or 'none'"
    if is_lateral(rig):
        remedy = "the method 'forward'"
    elif rig.array.varies:
        remedy = "array.pitch_growth_per_cm2 [0, 0]"
    return (
        f"panel: found {rig.panel.width_px}x{rig.panel.height_px} pixels with {_own_rows(rig)}, "
        f"for which prefilter.method 'optimal' takes more than {_MOST_BYTES / 1e9:g} GB (a row of "
        f"the operator for each pixel), wanted a smaller panel or {remedy}"
    )
