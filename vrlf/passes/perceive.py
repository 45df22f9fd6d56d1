"""What both eyes see of a panel image."""

from __future__ import annotations

from typing import Any

from vrlf.gpu import Block, ComputePass, ComputeVariants, Device, Field, Texture
from vrlf.passes.fields import VIEWPORT_FIELDS
from vrlf.passes.rays import RAY_FIELDS, Batch, PerceiveTables

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
# Rays of one dispatch: a driver that resets after 2 s must not see more at once.
_DISPATCH_RAYS = 1 << 29


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

        Of a line it is its beginning. Blind points behind holes are kept sorted; there
        ``point`` counts in that order.
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
        per_row = width * batch.points * tables.colours * tables.cost
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
