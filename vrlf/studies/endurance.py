"""Whether anything grows while frames run: GPU objects, Python's memory, the process.

A stream of moving frames (prefiltered, perceived, read back) runs for long, prescriptions
changing on the way; what is alive is noted once everything is warm, and at the end.
"""

from __future__ import annotations

import gc
import os
import sys
import time
import tracemalloc
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from rich import box
from rich.table import Table

from vrlf.errors import InputError
from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.renderer import Image, Stream
from vrlf.studies.steps import noise_picture

FRAMES: Final = 10_000
# After this many, caches are full and allocators have settled.
WARM_AFTER: Final = 1_000
# A prescription changes this often, and back: first in the middle of so many frames, so that
# both footprints are taken at rest and with the same one.
_CHANGE_EVERY: Final = 500
_STATM = Path("/proc/self/statm")


@dataclass(frozen=True)
class Footprint:
    """What is alive after some frames.

    Attributes
    ----------
    frame : int
    gpu_objects, gpu_bytes : int
        Textures, buffers and programs that nobody has given back.
    python_bytes : int
        As Python's own tracing counts them.
    resident_bytes : int or None
        Of the process; None where the system doesn't tell.
    """

    frame: int
    gpu_objects: int
    gpu_bytes: int
    python_bytes: int
    resident_bytes: int | None


@dataclass(frozen=True)
class EnduranceReport:
    """Footprints in order, and the most that the GPU ever held at a frame's end."""

    device: str
    panel: str
    method: str
    changes: int
    seconds: float
    peak_gpu_bytes: int
    footprints: tuple[Footprint, ...]

    def to_json(self) -> dict[str, Any]:
        """For ``vrlf bench memory --json``."""
        return asdict(self)


def run_endurance(
    device: Device,
    rig: Rig,
    *,
    frames: int = FRAMES,
    warm_after: int = WARM_AFTER,
    rays: int = 4,
    progress: Callable[[str], None] | None = None,
) -> EnduranceReport:
    """Run frames and note what is alive after ``warm_after`` and after all of them; twice.

    Parameters
    ----------
    rig : Rig
        Its prefilter is what runs; another prescription comes and goes every 500 frames.
    rays : int
        For each retinal pixel, in what is perceived.

    Raises
    ------
    InputError
        If there are not more frames than it takes to warm up.
    """
    if not 0 < warm_after < frames:
        raise InputError(f"frames: found {frames}, wanted more than the {warm_after} to warm up")
    started, report = time.perf_counter(), progress or (lambda _: None)
    # Apart, for tracing keeps accounts of its own: 1 MB of the process by frame 4000.
    plain = _run(device, rig, frames, warm_after, rays, report)
    was_tracing = tracemalloc.is_tracing()
    tracemalloc.start()
    try:
        report("once more, with Python's memory traced")
        traced = _run(device, rig, frames, warm_after, rays, report)
    finally:
        if not was_tracing:
            tracemalloc.stop()
    panel = f"{rig.panel.width_px}x{rig.panel.height_px}"
    return EnduranceReport(
        device.info.renderer,
        panel,
        rig.prefilter.method,
        plain.changes,
        time.perf_counter() - started,
        max(plain.peak, traced.peak),
        tuple(
            _footprint(frame, note, int(traced.notes[frame][2]))
            for frame, note in plain.notes.items()
        ),
    )


@dataclass
class _Run:
    """What was found so far: the notes by frame, the most bytes on the GPU, the changes."""

    notes: dict[int, NDArray[np.int64]]
    peak: int = 0
    changes: int = 0


def _run(
    device: Device,
    rig: Rig,
    frames: int,
    warm_after: int,
    rays: int,
    report: Callable[[str], None],
) -> _Run:
    # Made beforehand: what notes memory must not take any.
    run = _Run({number: np.zeros(4, np.int64) for number in (warm_after, frames)})
    with Stream(device, rig, rays=rays) as stream:
        for number, live_bytes in enumerate(_frames(stream, rig, frames), start=1):
            run.peak = max(run.peak, live_bytes)
            run.changes += _is_change(number)
            if number in run.notes:
                while stream.is_changing:  # half-made tables are no growth
                    stream.begin()
                _note(device, run.notes[number])
                report(f"frame {number}: {len(device.live_objects)} GPU objects")
    return run


def _frames(stream: Stream, rig: Rig, count: int) -> Iterator[int]:
    """Frames of a picture that moves; the GPU's live bytes after each."""
    size = (rig.panel.width_px, rig.panel.height_px)
    pictures = [_with_alpha(noise_picture(*size, seed=seed)) for seed in range(3)]
    seen = np.empty((size[1], size[0], 4), np.float32)
    others = [rig, nudged(rig)]
    for number in range(1, count + 1):
        if _is_change(number):
            stream.change(others[(number // _CHANGE_EVERY + 1) % 2])
        stream.begin()
        _show(stream, stream.target, pictures[number % 3])
        stream.seen.read_into(seen)
        yield stream.device.live_bytes


def _is_change(number: int) -> bool:
    return number % _CHANGE_EVERY == _CHANGE_EVERY // 2


def _show(stream: Stream, target: Texture, picture: Image) -> None:
    target.write(picture)
    stream.show()
    stream.look()


def _with_alpha(picture: Image) -> Image:
    return np.concatenate([picture, np.ones((*picture.shape[:2], 1), np.float32)], axis=2)


def nudged(rig: Rig) -> Rig:
    """The same wearer a quarter of a dioptre later."""
    left = rig.left.model_copy(update={"sphere_d": rig.left.sphere_d - 0.25})
    return rig.model_copy(update={"left": left})


def _note(device: Device, into: NDArray[np.int64]) -> None:
    gc.collect()
    # The interpreter's cache of attribute lookups keeps some freshly made names alive: at most
    # 4096 of 60 bytes, a few more every thousand frames. They are nobody's.
    if hasattr(sys, "_clear_type_cache"):
        sys._clear_type_cache()
    into[0], into[1] = len(device.live_objects), device.live_bytes
    into[2], into[3] = tracemalloc.get_traced_memory()[0], _resident_bytes()


def _footprint(frame: int, note: NDArray[np.int64], python_bytes: int) -> Footprint:
    objects, gpu_bytes, _, resident = (int(value) for value in note)
    return Footprint(frame, objects, gpu_bytes, python_bytes, resident or None)


def _resident_bytes() -> int:
    """Of this process, from Linux's own accounts; 0 where there are none."""
    if not _STATM.exists():
        return 0
    return int(_STATM.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def endurance_table(report: EnduranceReport) -> Table:
    """Before and after, for a terminal."""
    table = Table(
        title=f"{report.device}, {report.panel}, {report.method}",
        caption=f"{report.changes} changes of prescription, {report.seconds:.0f} s; "
        f"at most {report.peak_gpu_bytes / 1e6:.1f} MB on the GPU",
        box=box.SIMPLE,
    )
    for heading in ("frame", "GPU objects", "GPU kB", "Python kB", "resident kB"):
        table.add_column(heading, justify="right")
    for at in report.footprints:
        resident = "-" if at.resident_bytes is None else f"{at.resident_bytes / 1e3:.0f}"
        table.add_row(
            str(at.frame),
            str(at.gpu_objects),
            f"{at.gpu_bytes / 1e3:.1f}",
            f"{at.python_bytes / 1e3:.1f}",
            resident,
        )
    return table
