"""What ``vrlf bench`` times: the passes on the GPU, the making of their tables, the twins."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from typing import Final, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu import Device, GpuTimer, Texture
from vrlf.model import Rig
from vrlf.optics.fitting import Fit, fit_picture
from vrlf.optics.lateral import forward_changes
from vrlf.optics.viewport import SIDES, viewport
from vrlf.passes import (
    Encode,
    EyePicture,
    Forward,
    Perceive,
    PerceiveTables,
    Prepare,
    forward_tables,
)
from vrlf.reference.encode import encode
from vrlf.reference.forward import forward
from vrlf.reference.perceive import perceive
from vrlf.reference.prepare import prepare

Image = NDArray[np.float32]

# The twin takes a second a ray; the GPU is timed at as few beside it, so that like meets like.
TWIN_RAYS: Final = 2
# A twin's name is that of its step with this before it.
TWIN: Final = "float64 "
_FEW_RAYS = f"perceive ({TWIN_RAYS} rays)"

Clock = Callable[[Callable[[], object]], float]


@dataclass(frozen=True)
class Step:
    """Something to be timed, the clock (in ms) that it is timed with, and the least it must do.

    ``least_bytes`` are moved and ``least_fetches`` texels fetched whatever a pass is like inside;
    0 where nothing can be said.
    """

    name: str
    clock: Clock
    work: Callable[[], object]
    rays: int | None = None
    least_bytes: float = 0.0
    least_fetches: float = 0.0

    def once_ms(self) -> float:
        """Do it once."""
        return self.clock(self.work)


def wall_ms(work: Callable[[], object]) -> float:
    """Do it once, by the clock on the wall."""
    started = time.perf_counter()
    work()
    return 1e3 * (time.perf_counter() - started)


def gpu_clock(device: Device) -> Clock:
    """The GPU's own clock; it waits for what was asked of the GPU before."""
    timer = GpuTimer(device)

    def gpu_ms(work: Callable[[], object]) -> float:
        with timer.measure():
            work()
        return timer.milliseconds

    return gpu_ms


class Releasable(Protocol):
    """What an owner gives back."""

    def release(self) -> None:
        """Give it back."""


_Owned = TypeVar("_Owned", bound=Releasable)


def kept(by: ExitStack, item: _Owned) -> _Owned:
    """``item``, released when ``by`` closes."""
    by.callback(item.release)
    return item


@dataclass(frozen=True)
class Passes:
    """One of each, for all panels."""

    device: Device
    clock: Clock
    prepare: Prepare
    forward: Forward
    perceive: Perceive
    encode: Encode


def passes_of(device: Device, by: ExitStack) -> Passes:
    """All passes, released when ``by`` closes."""
    return Passes(
        device,
        gpu_clock(device),
        kept(by, Prepare(device)),
        kept(by, Forward(device)),
        kept(by, Perceive(device)),
        kept(by, Encode(device)),
    )


def gpu_steps(passes: Passes, rig: Rig, ray_counts: Sequence[int], by: ExitStack) -> list[Step]:
    """The passes in a frame's order, each on what the one before has left, then the tables.

    ``ray_counts`` holds the rays of ``perceive`` and, beside a twin, ``TWIN_RAYS``. Textures and
    tables are released when ``by`` closes.
    """
    device, clock, size_px = passes.device, passes.clock, (rig.panel.width_px, rig.panel.height_px)
    labels = ("target", "panel image", "perceived image")
    target, shown, seen = (kept(by, Texture(device, size_px, label=label)) for label in labels)
    code = kept(by, Texture(device, size_px, kind="u1", label="codes"))
    eyes = pictures_on_gpu(device, rig, by)
    steps = [Step("prepare", clock, partial(passes.prepare.run, rig, eyes, target))]
    if has_forward(rig):
        tables = kept(by, forward_tables(device, rig))
        steps.append(Step("forward", clock, partial(passes.forward.run, tables, target, shown)))
    light = shown if has_forward(rig) else target
    for count, name in zip(ray_counts, ("perceive", _FEW_RAYS), strict=False):
        rays = kept(by, PerceiveTables(device, rig, count))
        work = partial(passes.perceive.run, rays, light, seen)
        steps.append(Step(name, clock, work, count))
    steps.append(Step("encode", clock, partial(passes.encode.run, seen, code)))
    return steps + _table_steps(passes.forward, device, rig, ray_counts[0])


def has_forward(rig: Rig) -> bool:
    """Whether ``forward`` does anything; the image of a bare panel is its target, as a rule."""
    return forward_changes(rig)


def _table_steps(forward: Forward, device: Device, rig: Rig, rays: int) -> list[Step]:
    """What a change of prescription costs: tables made, on the GPU, and given back."""
    steps = []
    if has_forward(rig):
        work = partial(remake, device, partial(complete_tables, forward, device, rig))
        steps.append(Step("tables forward", wall_ms, work))
    work = partial(remake, device, partial(PerceiveTables, device, rig, rays))
    return [*steps, Step("tables perceive", wall_ms, work, rays)]


def complete_tables(forward: Forward, device: Device, rig: Rig) -> Releasable:
    """Tables with the list of what is cut, as a first frame would find them."""
    tables = forward_tables(device, rig)
    forward.complete(tables)
    return tables


def remake(device: Device, make: Callable[[], Releasable]) -> None:
    """Make tables until they are on the GPU, and give them back."""
    tables = make()
    device.finish()
    tables.release()


def _pictures(rig: Rig) -> tuple[tuple[Image, Image], tuple[Fit, Fit]]:
    """A picture of the viewport's size for each eye, and its place."""
    views = [viewport(rig, side) for side in SIDES]
    left, right = (
        noise_picture(view.width_px, view.height_px, seed) for seed, view in enumerate(views)
    )
    fits = [fit_picture((view.width_px, view.height_px), 1.0, view) for view in views]
    return (left, right), (fits[0], fits[1])


def pictures_on_gpu(device: Device, rig: Rig, by: ExitStack) -> tuple[EyePicture, EyePicture]:
    """A picture for each eye, on the GPU until ``by`` closes."""
    left, right = (
        EyePicture(kept(by, Texture.from_array(device, picture, label="picture")), fit)
        for picture, fit in zip(*_pictures(rig), strict=True)
    )
    return left, right


def twin_steps(rig: Rig) -> list[Step]:
    """The float64 twins; behind the first, the panel itself is noise."""
    (left, right), fits = _pictures(rig)
    pictures = (left.astype(np.float64), right.astype(np.float64))
    panel = noise_picture(rig.panel.width_px, rig.panel.height_px, 2).astype(np.float64)
    steps = [Step(TWIN + "prepare", wall_ms, partial(prepare, pictures, fits, rig))]
    if has_forward(rig):
        steps.append(Step(TWIN + "forward", wall_ms, partial(forward, panel, rig)))
    few = partial(perceive, panel, rig, TWIN_RAYS)
    return [
        *steps,
        Step(TWIN + _FEW_RAYS, wall_ms, few, TWIN_RAYS),
        Step(TWIN + "encode", wall_ms, partial(encode, panel)),
    ]


def noise_picture(width_px: int, height_px: int, seed: int) -> Image:
    """Noise whose amplitude falls as 1/f like that of natural scenes (Field 1987).

    Returns
    -------
    ndarray of float32, shape (height_px, width_px, 3)
        Linear light in [0, 1], mean about 1/2; the same for the same seed.
    """
    rng = np.random.default_rng(seed)
    rows, columns = np.fft.fftfreq(height_px)[:, None], np.fft.rfftfreq(width_px)
    frequency = np.hypot(rows, columns).astype(np.float32)
    frequency[0, 0] = np.inf  # no mean: it is put in below
    picture = np.empty((height_px, width_px, 3), np.float32)
    for channel in range(3):
        white = rng.standard_normal((height_px, width_px), dtype=np.float32)
        noise = np.fft.irfft2(np.fft.rfft2(white) / frequency, s=white.shape)
        # Five in a hundred values lie beyond two deviations and are clipped.
        picture[..., channel] = 0.5 + 0.25 * noise / max(float(noise.std()), 1e-12)
    return np.clip(picture, 0.0, 1.0)
