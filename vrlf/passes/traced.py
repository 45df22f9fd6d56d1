"""What both eyes see, ray by ray: diffraction at the array, lenslets as they are made.

Beside the fast quadratures of ``vrlf/passes/perceive.py``; the twin is
``vrlf/reference/traced.py``.
"""

from __future__ import annotations

from typing import Any

from vrlf.gpu import Block, ComputePass, ComputeVariants, Device, Field, Texture
from vrlf.passes.fields import LATTICE_FIELDS, SUBPIXEL_FIELDS, VIEWPORT_FIELDS
from vrlf.passes.traced_tables import Batch, TracedTables

TRACED = Block(
    "PerceiveTraced",
    (
        *VIEWPORT_FIELDS,
        *SUBPIXEL_FIELDS,
        *LATTICE_FIELDS,
        Field("vec4", "axes_px", "both optical axes from the viewports' first pixels' centres"),
        Field("vec4", "slope_per_px", "2x2, chief rays' slopes at the array, lattice frame"),
        Field("vec4", "diffraction_unit", "lambda g / w of each colour, in cells"),
        Field("vec4", "fresnel_number", "w^2 / (lambda g) of each colour"),
        Field("vec4", "bends", "g / f of a lenslet for each colour, 0 for a hole"),
        Field("vec4", "lens_index", "of each colour, and of the gap"),
        Field("vec4", "lens_shape", "radius, thickness, to the first vertex, to the panel; mm"),
        Field("ivec2", "spread_size", "rows and columns of the table of what diffraction moves"),
        Field("float", "roots_per_unit", "its rows for each 1 of sqrt N"),
        Field("float", "edge", "nearest place to an opening's border, 1 is its centre"),
        Field("float", "half_opening", "half the width of a hole or lenslet, in cells"),
        Field("float", "pitch_mm", "of the lattice"),
        Field("float", "reduced_gap_mm", "between array and panel"),
        Field("int", "batch_points", "points of this batch, of each eye and colour"),
        Field("int", "first_row", "where this dispatch begins"),
        Field("int", "rows", "how many rows it does"),
        Field("int", "is_first", "1 if nothing has been gathered yet"),
        Field("float", "scale", "what the gathered light is multiplied with after this batch"),
    ),
)
# As in the fast pass: a driver that resets after 2 s must not see more at once.
_DISPATCH_RAYS = 1 << 28


class PerceiveTraced:
    """Owns the programs of perception ray by ray, one for each kind of rig met so far."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._programs = ComputeVariants(device, "perceive_traced.comp", TRACED)

    def run(
        self, tables: TracedTables, panel: Texture, seen: Texture, *, exposure: float = 1.0
    ) -> None:
        """Gather the light of ``panel`` into ``seen`` (rgba32f, the panel's size)."""
        program = self._programs.get(tables.defines)
        panel.bind_sampler(0)
        seen.bind_image(0, read=True, write=True)
        tables.crossings.bind(2)
        tables.owners.bind(3)
        tables.spread.bind(4)
        for index, batch in enumerate(tables.batches):
            is_last = index == len(tables.batches) - 1
            values = {
                "is_first": int(index == 0),
                "scale": exposure / tables.points if is_last else 1.0,
            }
            self._gather(program, tables, batch, values)
        self._device.check("perceiving ray by ray")

    def _gather(
        self, program: ComputePass, tables: TracedTables, batch: Batch, values: dict[str, Any]
    ) -> None:
        """One batch of points, in stretches of rows that no driver takes for a hang."""
        batch.rays.bind(0)
        batch.within.bind(1)
        width, height = tables.size_px
        rows = max(1, min(height, int(_DISPATCH_RAYS / (width * batch.points * tables.cost))))
        common = {**tables.values, "batch_points": batch.points, **values}
        for first_row in range(0, height, rows):
            here = min(rows, height - first_row)
            program.set({**common, "first_row": first_row, "rows": here})
            program.run(width, here)

    def release(self) -> None:
        """Give the programs back."""
        self._programs.release()
