"""What ``vrlf bench speed`` times at one panel size, and the least that each step must do.

Least bytes: every rgba32f picture that a step reads or writes, once, and every table that it
reads, once. Least fetches: the panel pixels that a step must look at for each of its pixels,
one texel each. No implementation gets by with less, whatever its caches; most need more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

from vrlf.gpu import Buffer, Device, Texture
from vrlf.model import Rig
from vrlf.passes import ForwardTables, PerceiveTables, Sharpen
from vrlf.passes.forward_plain import PlainForward, PlainForwardTables
from vrlf.passes.operator import ENTRY_BYTES
from vrlf.solve import Memory, Optimal, OptimalTables
from vrlf.solve.wiener import sharpen_tables
from vrlf.studies.limits import PIXEL_BYTES
from vrlf.studies.steps import (
    Clock,
    Passes,
    Releasable,
    Step,
    complete_tables,
    has_forward,
    kept,
    passes_of,
    pictures_on_gpu,
    remake,
    wall_ms,
)

# Read and written rgba32f pictures of one step of the solver: P x - t reads the picture and the
# target and writes the residual; the step reads that, P'1 and P'P1, reads and writes w and z,
# and writes the picture.
_STEP_PICTURES: Final = 11
# Of its start: P't reads the target and writes the product, which is read with P'1 again; the
# picture, w, z and the start itself are written.
_START_PICTURES: Final = 8
# A picture is read and four bytes a pixel are written.
_ENCODED_PICTURES: Final = 1 + 4 / PIXEL_BYTES
# Enough that a step's time stands out of the start's.
_STEPS_TIMED: Final = 8


@dataclass(frozen=True)
class Tools:
    """All programs, made once for all sizes."""

    passes: Passes
    plain: PlainForward
    sharpen: Sharpen
    optimal: Optimal

    @property
    def device(self) -> Device:
        """The GPU that all of them are on."""
        return self.passes.device


def tools_of(device: Device, by: ExitStack) -> Tools:
    """All programs, released when ``by`` closes."""
    return Tools(
        passes_of(device, by),
        kept(by, PlainForward(device)),
        kept(by, Sharpen(device)),
        kept(by, Optimal(device)),
    )


@dataclass(frozen=True)
class Stage:
    """One panel's pictures on the GPU, for all workloads of its size."""

    tools: Tools
    rig: Rig
    rays: int
    target: Texture
    shown: Texture
    seen: Texture
    code: Texture

    @property
    def pixels(self) -> int:
        """Of the whole panel."""
        return self.rig.panel.width_px * self.rig.panel.height_px

    def timed(
        self,
        name: str,
        work: Callable[[], object],
        pictures: float,
        *,
        table_bytes: float = 0.0,
        fetches: float = 0.0,
        rays: int | None = None,
    ) -> Step:
        """A pass on the GPU that moves so many rgba32f pictures, and tables beside."""
        least_bytes = pictures * PIXEL_BYTES * self.pixels + table_bytes
        return Step(name, self.tools.passes.clock, work, rays, least_bytes, fetches)

    def made(self, name: str, make: Callable[[], Releasable], rays: int | None = None) -> Step:
        """The making of tables, by the wall's clock."""
        return Step(f"tables {name}", wall_ms, partial(remake, self.tools.device, make), rays)


def stage_of(tools: Tools, rig: Rig, rays: int, by: ExitStack) -> Stage:
    """Pictures of a panel's size; the target holds noise, and so does the panel image."""
    device, size_px = tools.device, (rig.panel.width_px, rig.panel.height_px)
    labels = ("target", "panel image", "perceived image")
    target, shown, seen = (kept(by, Texture(device, size_px, label=label)) for label in labels)
    code = kept(by, Texture(device, size_px, kind="u1", label="codes"))
    with ExitStack() as only_now:
        eyes = pictures_on_gpu(device, rig, only_now)
        for texture in (target, shown):
            tools.passes.prepare.run(rig, eyes, texture)
        device.finish()
    return Stage(tools, rig, rays, target, shown, seen, code)


Group = Callable[[Stage, ExitStack], Iterator[Step]]


def picture_passes(stage: Stage, by: ExitStack) -> Iterator[Step]:
    """What every frame has around its prefilter."""
    passes = stage.tools.passes
    eyes = pictures_on_gpu(stage.tools.device, stage.rig, by)
    yield stage.timed("prepare", partial(passes.prepare.run, stage.rig, eyes, stage.target), 2)
    encode = partial(passes.encode.run, stage.shown, stage.code)
    yield stage.timed("encode", encode, _ENCODED_PICTURES)


def forward_passes(stage: Stage, by: ExitStack) -> Iterator[Step]:
    """The forward prefilter, what it is measured against, and a frame with it."""
    if not has_forward(stage.rig):
        return
    tools, device, rig = stage.tools, stage.tools.device, stage.rig
    tables = kept(by, ForwardTables(device, rig))
    run = partial(tools.passes.forward.run, tables, stage.target, stage.shown)
    forward = stage.timed("forward", run, 2)
    yield forward
    plain_tables = kept(by, PlainForwardTables(device, rig))
    plain = partial(tools.plain.run, plain_tables, stage.target, stage.shown)
    yield stage.timed("forward plain", plain, 2)
    yield from _frames(stage, "forward", forward, by)
    yield stage.made("forward", partial(complete_tables, tools.passes.forward, device, rig))


def sharpening(stage: Stage, by: ExitStack) -> Iterator[Step]:
    """The Wiener sharpening before ``forward``."""
    tools, passes = stage.tools, stage.tools.passes
    make = partial(sharpen_tables, tools.device, stage.rig, passes.forward, passes.perceive)
    tables = kept(by, make())
    yield stage.timed("sharpen", partial(tools.sharpen.run, tables, stage.target, stage.seen), 2)
    yield stage.made("sharpen", make)


def perception(stage: Stage, by: ExitStack) -> Iterator[Step]:
    """What both eyes see."""
    tables = kept(by, PerceiveTables(stage.tools.device, stage.rig, stage.rays))
    work = partial(stage.tools.passes.perceive.run, tables, stage.shown, stage.seen)
    fetches = _ray_fetches(stage, tables)
    yield stage.timed("perceive", work, 2, fetches=fetches, rays=stage.rays)
    make = partial(PerceiveTables, stage.tools.device, stage.rig, stage.rays)
    yield stage.made("perceive", make, stage.rays)


def _ray_fetches(stage: Stage, tables: PerceiveTables) -> float:
    """A ray fetches one pixel at least; of a chromatic eye's colours each has its own."""
    return tables.points * tables.cost * tables.colours * stage.pixels


def optimal_passes(stage: Stage, by: ExitStack) -> Iterator[Step]:
    """The solver: its start, a step, a whole solve, and a frame with it."""
    optimal, device, rig = stage.tools.optimal, stage.tools.device, stage.rig
    memory = kept(by, Memory(device))
    tables = kept(by, OptimalTables(device, rig, optimal.builder))
    (p_bytes, p_fetches), (back_bytes, back_fetches) = (
        _least_of_table(buffers, stage.pixels)
        for buffers in (tables.operator.forward, tables.operator.adjoint)
    )

    def solve(steps: int) -> None:
        memory.forget()
        optimal.frame(memory, tables, stage.target, stage.shown, steps=steps)

    def steps_of(name: str, count: int, *, start: int = 1) -> Step:
        return stage.timed(
            name,
            partial(solve, count),
            start * _START_PICTURES + count * _STEP_PICTURES,
            table_bytes=start * back_bytes + count * (p_bytes + back_bytes),
            fetches=start * back_fetches + count * (p_fetches + back_fetches),
        )

    clock, iterations = stage.tools.passes.clock, rig.prefilter.iterations
    whole = steps_of(f"optimal, {iterations} steps", iterations)
    yield steps_of("optimal start", 0)
    clock_a_step = partial(_a_step_ms, clock, partial(solve, 0))
    yield replace(
        steps_of("optimal step", 1, start=0), clock=clock_a_step, work=partial(solve, _STEPS_TIMED)
    )
    yield whole
    yield from _frames(stage, "optimal", whole, by)
    yield stage.made("optimal", partial(OptimalTables, device, rig, optimal.builder))


def _a_step_ms(clock: Clock, start: Callable[[], object], work: Callable[[], object]) -> float:
    """What a solve of some steps takes longer than its start, shared out among the steps."""
    return max(0.0, (clock(work) - clock(start)) / _STEPS_TIMED)


def _least_of_table(buffers: Sequence[Buffer], pixels: int) -> tuple[float, float]:
    """Bytes of one of the operator's tables, and the texels fetched where it is applied."""
    entries, starts = buffers
    # A row of so many entries on average; the last pair and the last start belong to none.
    entries_a_row = (entries.nbytes / ENTRY_BYTES - 2.0) / (starts.nbytes / 4 - 1.0)
    return entries.nbytes + starts.nbytes, entries_a_row * pixels


def _frames(stage: Stage, method: str, prefilter: Step, by: ExitStack) -> Iterator[Step]:
    """Whole frames: a target on the GPU becomes 8-bit codes; and is looked at beside."""
    passes = stage.tools.passes
    rays = kept(by, PerceiveTables(stage.tools.device, stage.rig, stage.rays))

    def frame() -> None:
        prefilter.work()
        passes.encode.run(stage.shown, stage.code)

    def seen_frame() -> None:
        frame()
        passes.perceive.run(rays, stage.shown, stage.seen)

    table_bytes, fetches = prefilter.least_bytes, prefilter.least_fetches
    yield stage.timed(
        f"frame {method}", frame, _ENCODED_PICTURES, table_bytes=table_bytes, fetches=fetches
    )
    yield stage.timed(
        f"frame {method}, seen",
        seen_frame,
        _ENCODED_PICTURES + 2,
        table_bytes=table_bytes,
        fetches=fetches + _ray_fetches(stage, rays),
        rays=stage.rays,
    )


GROUPS: Final[tuple[Group, ...]] = (
    picture_passes,
    forward_passes,
    sharpening,
    perception,
    optimal_passes,
)
