"""What a change of prescription does to frames that run: how long each takes, and which is which.

Frames are timed one by one, to completion, before, while and after another prescription's
tables are made. None is dropped: each is shown, with the old tables or the new.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np
from rich import box
from rich.table import Table

from vrlf.errors import InputError
from vrlf.gpu import Device
from vrlf.model import Rig
from vrlf.renderer import Stream
from vrlf.studies.endurance import nudged
from vrlf.studies.steps import noise_picture

FRAMES: Final = 60
# So many frames of a change are waited for, however long its tables take.
_MOST_FRAMES: Final = 20_000


@dataclass(frozen=True)
class ChangeReport:
    """Frame times in milliseconds.

    Attributes
    ----------
    before_ms, during_ms, after_ms : float
        Medians over frames without and with work on what comes.
    longest_before_ms, longest_during_ms : float
        The longest frame.
    frames_until_new : int
        Frames with the old prescription after the new one was wanted.
    seconds_until_new : float
    at_once_ms : float
        What making the tables in one go takes, which a frame would have to wait for.
    """

    device: str
    panel: str
    method: str
    making_ms: float | None
    before_ms: float
    during_ms: float
    after_ms: float
    longest_before_ms: float
    longest_during_ms: float
    frames_until_new: int
    seconds_until_new: float
    at_once_ms: float

    def to_json(self) -> dict[str, Any]:
        """For ``vrlf bench change --json``."""
        return asdict(self)


def run_change(
    device: Device,
    rig: Rig,
    *,
    frames: int = FRAMES,
    making_ms: float | None = None,
    progress: Callable[[str], None] | None = None,
) -> ChangeReport:
    """Time frames around a change of a quarter dioptre.

    Parameters
    ----------
    frames : int
        Timed before and after the change, each.
    making_ms : float, optional
        Time that each frame gives to what comes; without it ``Stream`` decides.

    Raises
    ------
    InputError
        If there are no frames.
    """
    if frames < 1:
        raise InputError(f"frames: found {frames}, wanted 1 or more")
    size = (rig.panel.width_px, rig.panel.height_px)
    other = nudged(rig)
    with Stream(device, rig, making_ms=making_ms) as stream:
        # The first stream compiles every program; what is timed begins after it.
        at_once = _at_once_ms(device, other)
        stream.target.write(noise_picture(*size, seed=1))
        before = [_frame_ms(stream) for _ in range(frames + 2)][2:]
        stream.change(other)
        during: list[float] = []
        started = time.perf_counter()
        while stream.is_changing and len(during) < _MOST_FRAMES:
            during.append(_frame_ms(stream))
            if progress is not None and len(during) % 100 == 0:
                progress(f"{len(during)} frames while tables are made")
        waited = time.perf_counter() - started
        after = [_frame_ms(stream) for _ in range(frames)]
    return ChangeReport(
        device.info.renderer,
        f"{size[0]}x{size[1]}",
        rig.prefilter.method,
        making_ms,
        float(np.median(before)),
        float(np.median(during)),
        float(np.median(after)),
        max(before),
        max(during),
        len(during) - 1,
        waited,
        at_once,
    )


def _frame_ms(stream: Stream) -> float:
    started = time.perf_counter()
    stream.begin()
    stream.show()
    stream.device.finish()
    return 1e3 * (time.perf_counter() - started)


def _at_once_ms(device: Device, rig: Rig) -> float:
    started = time.perf_counter()
    Stream(device, rig).release()
    device.finish()
    return 1e3 * (time.perf_counter() - started)


def change_table(report: ChangeReport) -> Table:
    """The report for a terminal."""
    table = Table(
        title=f"{report.device}, {report.panel}, {report.method}",
        caption=f"{report.frames_until_new} frames, {report.seconds_until_new:.2f} s until the "
        f"new prescription showed; at once it would have held one frame for "
        f"{report.at_once_ms:.0f} ms",
        box=box.SIMPLE,
        min_width=72,
    )
    for heading in ("frames", "median ms", "longest ms"):
        table.add_column(heading, justify="right")
    table.add_row("before", f"{report.before_ms:.2f}", f"{report.longest_before_ms:.2f}")
    table.add_row("during", f"{report.during_ms:.2f}", f"{report.longest_during_ms:.2f}")
    table.add_row("after", f"{report.after_ms:.2f}", "")
    return table
