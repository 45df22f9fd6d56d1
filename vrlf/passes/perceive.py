"""What both eyes see of a panel image."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import Any

from vrlf.gpu import Block, ComputePass, ComputeVariants, Device, Field, Texture
from vrlf.passes.fields import VIEWPORT_FIELDS
from vrlf.passes.rays import RAY_FIELDS, Batch, PerceiveTables

PERCEIVE = Block(
    "Perceive",
    (
        *VIEWPORT_FIELDS,
        *RAY_FIELDS,
        Field("ivec2", "patch_first", "column and row of the viewport where this dispatch begins"),
        Field("int", "patch_stride", "pixels from one that it does to the next, both ways"),
        Field("int", "rows", "how many rows it does"),
        Field("int", "is_first", "1 if nothing has been gathered yet"),
        Field("float", "scale", "what the gathered light is multiplied with after this batch"),
    ),
)


@dataclass(frozen=True)
class Patch:
    """Some of the pixels, in each eye's viewport: one of ``stride`` both ways.

    Attributes
    ----------
    first_px : (column, row)
        In the viewport's raster.
    stride : int
    rows : int or None
        How many of its rows; None for all.
    """

    first_px: tuple[int, int] = (0, 0)
    stride: int = 1
    rows: int | None = None


WHOLE = Patch()
# Rays of one dispatch: a driver that resets after 2 s must not see more at once.
_DISPATCH_RAYS = 1 << 29


class Perceive:
    """Owns the programs of the perception pass, one for each kind of rig met so far."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._programs = ComputeVariants(device, "perceive.comp", PERCEIVE)

    def run(
        self,
        tables: PerceiveTables,
        panel: Texture,
        seen: Texture,
        *,
        exposure: float = 1.0,
        patch: Patch = WHOLE,
    ) -> None:
        """Gather the light of ``panel`` into ``seen`` (rgba32f, the panel's size).

        ``exposure`` multiplies what is seen. Pixels beside the ``patch`` stay as they are; each
        has the same value in every patch that holds it.
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
            self._gather(program, tables, batch, patch, values)
        self._device.check("perceiving")

    def trace(self, tables: PerceiveTables, point: int, landing: Texture) -> None:
        """Write where one ray of the tables lands, for tests: place in the cell, then pixels.

        Of a line it is its beginning. Blind points behind holes are kept sorted; there
        ``point`` counts in that order.
        """
        program = self._programs.get({**tables.defines, "TRACE": 1})
        landing.bind_image(0, read=True, write=True)
        values = {"is_first": 1, "scale": 1.0, "batch_first": point}
        self._gather(program, tables, tables.batches[0], WHOLE, values)
        self._device.check("tracing")

    def _gather(
        self,
        program: ComputePass,
        tables: PerceiveTables,
        batch: Batch,
        patch: Patch,
        values: dict[str, Any],
    ) -> None:
        """One batch of rays, in stretches of rows that no driver takes for a hang."""
        batch.rays.bind(0)
        batch.within.bind(1)
        tables.crossings.bind(2)
        tables.owners.bind(3)
        batch.bins.bind(4)
        width, height = _patch_px(tables, patch)
        if width == 0:
            return
        per_row = width * batch.points * tables.colours * tables.cost
        rows = max(1, min(height, int(_DISPATCH_RAYS / per_row)))
        common = {
            **tables.values,
            **batch.bin_values,
            "points": batch.points,
            "batch_points": batch.points,
            "patch_stride": patch.stride,
            **values,
        }
        for first_row in range(0, height, rows):
            first = (patch.first_px[0], patch.first_px[1] + patch.stride * first_row)
            here = min(rows, height - first_row)
            program.set({**common, "patch_first": first, "rows": here})
            program.run(width, here)

    def release(self) -> None:
        """Give the programs back."""
        self._programs.release()


def _patch_px(tables: PerceiveTables, patch: Patch) -> tuple[int, int]:
    """Columns, those of both eyes and those that are nobody's, and rows of a patch."""
    width, height = tables.size_px
    view_width = tables.values["view_px"][0]
    columns = 2 * ceil((view_width - patch.first_px[0]) / patch.stride)
    rows = ceil((height - patch.first_px[1]) / patch.stride)
    nobodys = width - 2 * view_width
    return columns + nobodys, rows if patch.rows is None else min(rows, patch.rows)
