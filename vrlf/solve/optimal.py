"""Bounded least squares over the true perception operator, on the GPU.

    minimise || P l / throughput - (black + (brightness - black) i) ||^2,  0 <= l <= 1

by accelerated projected gradient in the metric of P'P1, which bounds P'P from above where P
has no negative entry. It starts from the normalised backprojection P't / P'1 and is within the
bounds after every step. The acceleration is POGM (Taylor, Hendrickx & Glineur 2017), which
needs no sum over the picture.

Measured (a face out of astronaut, 160 pixels an eye, all colours; dB below converged after 8, 10,
12 and 16 steps), with theta from 1 on, as published, and from 4 on, as here:

================= =================== ===================
array             from 1              from 4
================= =================== ===================
matched-microlens 1.3 0.9 0.7 0.4     1.0 0.7 0.5 0.3
matched-wide      1.0 0.7 0.6 0.4     0.7 0.5 0.5 0.3
matched-full      1.2 1.0 0.8 0.5     1.0 0.7 0.6 0.4
thesis-minus-5d   0.5 0.4 0.3 0.2     0.4 0.3 0.2 0.1
thesis-table-8-1  0.3 0.2 0.1 0.0     0.2 0.1 0.1 0.0
================= =================== ===================

From 3, 6 and 9 on it is up to 0.2 dB worse (matched-microlens, 8 steps); longer steps than the
metric's own diverge; a sharper start is worth 0.06 dB after six steps. Against POGM from 1 FISTA
loses 0.3 to 0.9 dB at 8 steps, and a projected conjugate gradient gains 0.2, at the cost of three
sums over the picture a step.
Restart (O'Donoghue & Candes 2015) never came into play within 64 steps.

With a tolerance a step is the same but for one more product, V x (``vrlf/passes/tolerant.py``):
three tables are read, not two, 1.9 times the entries with matched-wide. Steps are counted as
without. Pictures that many cases can agree on hold fewer details, and those take the most steps:
eight are as good as sixteen (matched-wide, in all the figures of ``vrlf bench tolerance`` within
0.1 dB). Measured on two cores of software GL, 334x188, frames without and with in turn: 16 steps
take 1.34 times as long as 16 without (1.24 by the clock), 8 steps 0.69 times; with
matched-microlens, whose entries are 1.4 times as many, 1.14 (1.12) and 0.60.
"""

from __future__ import annotations

import time

from vrlf.gpu import Block, ComputePass, ComputeVariants, Device, Field, Texture
from vrlf.passes.operator import TABLE_FIELDS
from vrlf.reference.optimal import FIRST_THETA
from vrlf.solve.memory import Memory
from vrlf.solve.tables import OptimalTables, TableBuilder

STEP = Block(
    "Step",
    (
        *TABLE_FIELDS,
        Field("float", "least", "a pixel that receives less than this is reached by no ray"),
        Field("float", "most_theta", "where a still picture's momentum stops growing"),
    ),
)
START = Block(
    "Start",
    (
        Field("ivec2", "size_px", "width and height of the panel"),
        Field("float", "least", "a pixel that receives less than this is reached by no ray"),
        Field("float", "brightness", "what full drive of the target becomes"),
        Field("float", "black_level", "what black becomes"),
        Field("float", "trust", "mean square of a change that leaves half of what was added"),
        Field("float", "first_theta", "where the momentum of a cold start begins"),
    ),
)
# A pixel that receives less than this share of its light is dark. The nearest phase reaches a
# fraction of a pixel farther than the pixel's own; this takes it away again, and costs 0.01 dB.
_LEAST = 0.01
# Where the start changed by this much (mean square over a pixel's neighbours and colours) half of
# what the last frame's steps had added is kept. Measured (two steps a frame, theta from 1 on), dB
# over cold in a pan of 0.25 px, of 1 px and after a cut: 1e-3 gives 3.1, 1.5, 0.0
# (matched-microlens) and 1.1, 0.3, 0.0 (matched-wide); 2e-3 3.2, 1.8, 0.0 and 1.2, 0.4, 0.0; 8e-3
# 3.3, 2.2, 0.1 and 1.2, 0.5, -0.3. All of it kept whatever changed loses up to 4 dB after a cut.
_TRUST = 2e-3
# What is near a pixel: this many to each side.
_NEAR = 1
# A still picture's momentum stops growing after some fifty steps, long after it has converged.
_MOST_THETA = 25.0


class Optimal:
    """Owns the solver's programs, and the pictures of a cold run."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self.builder = TableBuilder(device)
        self._steps = ComputeVariants(device, "operator_step.comp", STEP)
        self._starts = ComputeVariants(device, "operator_start.comp", START)
        self._memory = Memory(device)

    def run(self, tables: OptimalTables, target: Texture, shown: Texture) -> int:
        """Write the optimal panel image into ``shown``; the number of steps taken.

        Always from a cold start: equal targets give equal bytes, whatever came before. Stops
        after the rig's iterations, or when its budget is used up.
        """
        self._memory.forget()
        steps, budget_ms = tables.iterations, tables.budget_ms
        return self.frame(self._memory, tables, target, shown, steps=steps, budget_ms=budget_ms)

    def frame(
        self,
        memory: Memory,
        tables: OptimalTables,
        target: Texture,
        shown: Texture,
        *,
        steps: int,
        budget_ms: float | None = None,
    ) -> int:
        """Write the panel image of a stream's next frame; the number of steps taken.

        Goes on from where ``memory`` stands, wherever the target still stands there; where it
        changed, and with new tables everywhere, the start is cold. Nothing is read back.

        Parameters
        ----------
        memory : Memory
            Of this stream alone.
        steps : int
            0 shows the start.
        budget_ms : float, optional
            No step begins after it; the GPU is waited for after each one.
        """
        started = time.perf_counter()
        self._begin(memory, tables, target, shown)
        operator = tables.operator
        residual = self.builder.products.ready(operator, levels=tables.levels)
        varied = self.builder.products.varied(operator) if operator.is_tolerant else None
        step = self._steps.get(
            {**operator.defines, "SIGNED": 0, "TOLERANT": int(operator.is_tolerant)}
        )
        step.set({**operator.values, "least": _LEAST, "most_theta": _MOST_THETA})
        for done in range(steps):
            if budget_ms is not None and self._elapsed_ms(started) > budget_ms:
                return done
            residual.run("forward", memory.sought, target, memory.product)
            if varied is not None:
                varied.run("variance", memory.sought, memory.sought, memory.varied)
                memory.varied.bind_sampler(3)
            self._descend(step, memory, tables, shown)
        self._device.check("solving for the panel image")
        return steps

    def _elapsed_ms(self, started: float) -> float:
        self._device.finish()
        return 1e3 * (time.perf_counter() - started)

    def _begin(
        self, memory: Memory, tables: OptimalTables, target: Texture, shown: Texture
    ) -> None:
        """The normalised backprojection, and what the last frame's steps had added to it."""
        is_warm = memory.turn(tables)
        self.builder.products.apply(tables.operator, "adjoint", target, memory.product)
        for unit, picture in enumerate((memory.product, tables.reached, memory.before)):
            picture.bind_sampler(unit)
        shown.bind_image(0, read=False, write=True)
        memory.stepped.bind_image(1, read=True, write=True)
        memory.ahead.bind_image(2, read=True, write=True)
        memory.begun.bind_image(3, read=False, write=True)
        memory.sought.bind_image(4, read=False, write=True)
        start = self._starts.get({"WARM": int(is_warm), "NEAR": _NEAR})
        start.set(
            {
                "size_px": tables.operator.size_px,
                "least": _LEAST,
                "brightness": tables.levels.brightness,
                "black_level": tables.levels.black_level,
                "trust": _TRUST,
                "first_theta": FIRST_THETA,
            }
        )
        start.run(*tables.operator.size_px)

    def _descend(
        self, step: ComputePass, memory: Memory, tables: OptimalTables, shown: Texture
    ) -> None:
        """From the residual one step on."""
        for unit, picture in enumerate((memory.product, tables.reached, tables.curvature)):
            picture.bind_sampler(unit)
        shown.bind_image(0, read=False, write=True)
        memory.stepped.bind_image(1, read=True, write=True)
        memory.ahead.bind_image(2, read=True, write=True)
        memory.sought.bind_image(3, read=False, write=True)
        tables.operator.bind("adjoint")
        step.run(*tables.operator.size_px)

    def release(self) -> None:
        """Give programs and pictures back."""
        for item in (self.builder, self._steps, self._starts, self._memory):
            item.release()
