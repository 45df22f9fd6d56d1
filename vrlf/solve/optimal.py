"""Bounded least squares over the true perception operator, on the GPU.

    minimise || P l / throughput - (black + (brightness - black) i) ||^2,  0 <= l <= 1

by accelerated projected gradient in the metric of P'P1, which bounds P'P from above where P
has no negative entry. It starts from the normalised backprojection P't / P'1 and is within the
bounds after every step. The acceleration is POGM (Taylor, Hendrickx & Glineur 2017), which
needs no sum over the picture.

Measured (astronaut, green, dB below converged after 4, 8, 16, 32 steps):

================= ================== ==================
array             POGM               FISTA
================= ================== ==================
matched-microlens 2.0 0.7 0.1 0.0    3.1 1.6 0.4 0.1
matched-wide      1.3 0.5 0.2 0.0    2.1 1.0 0.3 0.1
matched-full      1.0 0.5 0.1 0.0    1.6 0.9 0.3 0.1
thesis-minus-5d   0.6 0.2 0.1 0.0    1.0 0.5 0.1 0.0
================= ================== ==================

Restart (O'Donoghue & Candes 2015) never came into play within 64 steps. A projected conjugate
gradient gains another 0.2 dB at 8 steps, at the cost of three sums over the picture a step.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from math import sqrt
from typing import Any, Literal

import numpy as np

from vrlf.gpu import Block, ComputePass, Device, Field, Texture
from vrlf.model import Prefilter, Rig
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
    (
        *TABLE_FIELDS,
        Field("float", "least", "a pixel that receives less than this is reached by no ray"),
        Field("float", "inertia", "share of the last plain step's change that is repeated"),
        Field("float", "overshoot", "share of the step itself that is repeated"),
        Field("float", "unbounding", "share of what the bounds took away that comes back"),
    ),
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
# A pixel that receives less than this share of its light is dark. Reading between phases widens
# what rays reach by a fraction of a pixel; this takes it away again, and costs 0.01 dB.
_LEAST = 0.01


_PICTURES = ("stepped", "ahead", "residual", "reached", "curvature", "back")


@dataclass(frozen=True)
class Momentum:
    """What a step of POGM adds to the plain one."""

    inertia: float
    overshoot: float
    unbounding: float


def momenta(steps: int) -> Iterator[Momentum]:
    """The schedule of POGM (Taylor, Hendrickx & Glineur 2017), for steps of one metric."""
    theta, gamma = 1.0, 1.0
    for _ in range(steps):
        following = (1.0 + sqrt(1.0 + 4.0 * theta**2)) / 2.0
        inertia = (theta - 1.0) / following
        yield Momentum(inertia, theta / following, inertia / gamma)
        theta, gamma = following, (2.0 * theta + following - 1.0) / following


class OptimalTables:
    """The operator of one rig, made once for a prescription, and what is asked of the solver."""

    def __init__(self, device: Device, rig: Rig, builder: RowBuilder) -> None:
        self.operator = OperatorTables(device, rig, builder)
        self.ask(rig.prefilter)

    def ask(self, given: Prefilter) -> None:
        """Take other light levels and limits; the operator does not depend on them."""
        self.brightness = given.brightness
        self.black_level = given.black_level
        self.iterations = given.iterations
        self.budget_ms = given.budget_ms

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
        for done, momentum in enumerate(momenta(tables.iterations)):
            if tables.budget_ms is not None and self._elapsed_ms(started) > tables.budget_ms:
                return done
            self._descend(tables, target, shown, momentum)
        self._device.check("solving for the panel image")
        return tables.iterations

    def _elapsed_ms(self, started: float) -> float:
        self._device.finish()
        return 1e3 * (time.perf_counter() - started)

    def _make_pictures(self, tables: OptimalTables) -> None:
        size = tables.operator.size_px
        if self._pictures and self._pictures["back"].size_px != size:
            self._release_pictures()
        if not self._pictures:
            for name in _PICTURES:
                self._pictures[name] = Texture(self._device, size, label=f"optimal {name}")
            self._prepared = None
        if self._prepared is not tables:
            # P'1 and P'P1 belong to the prescription, not to the frame.
            p = self._pictures
            p["back"].write(np.ones((size[1], size[0], 4), np.float32))
            self.product(tables, "adjoint", p["back"], p["reached"])
            self.product(tables, "forward", p["back"], p["residual"])
            self.product(tables, "adjoint", p["residual"], p["curvature"])
            self._prepared = tables

    def _begin(self, tables: OptimalTables, target: Texture, shown: Texture) -> None:
        """The normalised backprojection."""
        p = self._pictures
        self.product(tables, "adjoint", target, p["back"])
        for unit, name in enumerate(("back", "reached")):
            p[name].bind_sampler(unit)
        for unit, picture in enumerate((shown, p["stepped"], p["ahead"])):
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
        self, tables: OptimalTables, target: Texture, shown: Texture, momentum: Momentum
    ) -> None:
        p = self._pictures
        self.product(tables, "forward", shown, p["residual"], target=target, subtracted=1.0)
        for unit, name in enumerate(("residual", "reached", "curvature")):
            p[name].bind_sampler(unit)
        for unit, picture in enumerate((shown, p["stepped"], p["ahead"])):
            picture.bind_image(unit, read=True, write=True)
        tables.operator.bind(tables.operator.adjoint)
        self._step.set({**tables.operator.values, "least": _LEAST, **asdict(momentum)})
        self._step.run(*tables.operator.size_px)

    def product(
        self,
        tables: OptimalTables,
        which: Literal["forward", "adjoint"],
        light: Texture,
        result: Texture,
        *,
        target: Texture | None = None,
        subtracted: float = 0.0,
    ) -> None:
        """Write P light, or P' light, less ``subtracted`` times what ``target`` means."""
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
