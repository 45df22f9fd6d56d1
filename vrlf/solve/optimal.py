"""Bounded least squares over the true perception operator, on the GPU.

    minimise || P l / throughput - (black + (brightness - black) i) ||^2,  0 <= l <= 1

by accelerated projected gradient (Beck & Teboulle 2009) in the metric of P'P1, which bounds
P'P from above where P has no negative entry. It starts from the normalised backprojection
P't / P'1 and is within the bounds after every step.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from vrlf.gpu import Block, ComputePass, Device, Field, Texture
from vrlf.model import Rig
from vrlf.passes.operator import TABLE_FIELDS, OperatorTables, RowBuilder

APPLY = Block(
    "Apply",
    (
        *TABLE_FIELDS,
        Field("float", "subtracted", "1 to take the target off, 0 to apply the table alone"),
        Field("float", "brightness", "what full drive of the target becomes"),
        Field("float", "black_level", "what black becomes"),
    ),
)
STEP = Block(
    "Step",
    (*TABLE_FIELDS, Field("float", "momentum", "how far the next gradient is taken ahead")),
)
START = Block(
    "Start",
    (
        Field("ivec2", "size_px", "width and height of the panel"),
        Field("float", "least", "a pixel that receives less than this is reached by no ray"),
        Field("float", "brightness", "what full drive of the target becomes"),
        Field("float", "black_level", "what black becomes"),
    ),
)
# A sum of half-float weights below this is no light at all.
_LEAST = 1e-6
# Rays of each phase when the table is made.
TABLE_RAYS = 1024


class OptimalTables:
    """The operator of one rig and the rig's brightness; made once for a prescription."""

    def __init__(self, device: Device, rig: Rig, builder: RowBuilder) -> None:
        self.operator = OperatorTables(device, rig, TABLE_RAYS, builder)
        self.brightness = rig.prefilter.brightness
        self.black_level = rig.prefilter.black_level
        self.iterations = rig.prefilter.iterations
        self.budget_ms = rig.prefilter.budget_ms

    def release(self) -> None:
        """Give the tables back."""
        self.operator.release()


class Optimal:
    """Owns the solver's programs and its pictures."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self.builder = RowBuilder(device)
        self._apply = ComputePass(device, "operator_apply.comp", APPLY)
        self._step = ComputePass(device, "operator_step.comp", STEP)
        self._start = ComputePass(device, "operator_start.comp", START)
        self._pictures: dict[str, Texture] = {}
        self._prepared: OptimalTables | None = None

    def run(self, tables: OptimalTables, target: Texture, shown: Texture) -> int:
        """Write the optimal panel image into ``shown``; the number of steps taken.

        Stops after the rig's iterations, or when its budget is used up.
        """
        self._make_pictures(tables)
        started = time.perf_counter()
        self._begin(tables, target, shown)
        t = 1.0
        for done in range(tables.iterations):
            if tables.budget_ms is not None and self._elapsed_ms(started) > tables.budget_ms:
                return done
            following = (1.0 + (1.0 + 4.0 * t * t) ** 0.5) / 2.0
            self._descend(tables, target, shown, (t - 1.0) / following)
            t = following
        self._device.check("solving for the panel image")
        return tables.iterations

    def _elapsed_ms(self, started: float) -> float:
        self._device.finish()
        return 1e3 * (time.perf_counter() - started)

    def _make_pictures(self, tables: OptimalTables) -> None:
        size = tables.operator.size_px
        if self._pictures and self._pictures["ahead"].size_px != size:
            self._release_pictures()
        if not self._pictures:
            for name in ("ahead", "residual", "inverse", "reached", "curvature", "back"):
                self._pictures[name] = Texture(self._device, size, label=f"optimal {name}")
            self._prepared = None
        if self._prepared is not tables:
            # P'1 and P'P1 belong to the prescription, not to the frame.
            p = self._pictures
            p["back"].write(np.ones((size[1], size[0], 4), np.float32))
            self._product(tables, "adjoint", p["back"], p["reached"])
            self._product(tables, "forward", p["back"], p["residual"])
            self._product(tables, "adjoint", p["residual"], p["curvature"])
            self._prepared = tables

    def _begin(self, tables: OptimalTables, target: Texture, shown: Texture) -> None:
        """The normalised backprojection, and the size of the steps."""
        p = self._pictures
        self._product(tables, "adjoint", target, p["back"])
        for unit, name in enumerate(("back", "reached", "curvature")):
            p[name].bind_sampler(unit)
        for unit, picture in enumerate((shown, p["ahead"], p["inverse"])):
            picture.bind_image(unit, read=False, write=True)
        self._start.set(
            {
                "size_px": tables.operator.size_px,
                "least": _LEAST,
                "brightness": tables.brightness,
                "black_level": tables.black_level,
            }
        )
        self._start.run(*tables.operator.size_px)

    def _descend(
        self, tables: OptimalTables, target: Texture, shown: Texture, momentum: float
    ) -> None:
        p = self._pictures
        self._product(tables, "forward", p["ahead"], p["residual"], target=target, subtracted=1.0)
        p["residual"].bind_sampler(0)
        p["inverse"].bind_sampler(1)
        shown.bind_image(0, read=True, write=True)
        p["ahead"].bind_image(1, read=True, write=True)
        tables.operator.bind(tables.operator.adjoint)
        self._step.set({**tables.operator.values, "momentum": momentum})
        self._step.run(*tables.operator.size_px)

    def _product(
        self,
        tables: OptimalTables,
        which: str,
        light: Texture,
        result: Texture,
        *,
        target: Texture | None = None,
        subtracted: float = 0.0,
    ) -> None:
        light.bind_sampler(0)
        (target or light).bind_sampler(1)
        result.bind_image(0, read=False, write=True)
        tables.operator.bind(
            tables.operator.forward if which == "forward" else tables.operator.adjoint
        )
        values: dict[str, Any] = {
            **tables.operator.values,
            "subtracted": subtracted,
            "brightness": tables.brightness,
            "black_level": tables.black_level,
        }
        self._apply.set(values)
        self._apply.run(*tables.operator.size_px)

    def _release_pictures(self) -> None:
        for picture in self._pictures.values():
            picture.release()
        self._pictures.clear()
        self._prepared = None

    def release(self) -> None:
        """Give programs and pictures back."""
        self._release_pictures()
        for step in (self.builder, self._apply, self._step, self._start):
            step.release()
