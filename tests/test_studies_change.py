"""The study of a change: frames are counted and timed, whole, and the report holds together."""

from __future__ import annotations

import json

import pass_rigs
import pytest
from rich.console import Console

from vrlf.errors import InputError
from vrlf.gpu import Device
from vrlf.studies.change import change_table, run_change

RIG = pass_rigs.SMALL["coma-lenslets"]


def test_a_change_takes_frames_and_ends(device: Device) -> None:
    before = device.live_objects
    said: list[str] = []
    report = run_change(device, RIG, frames=3, making_ms=1e-6, progress=said.append)
    assert device.live_objects == before
    # The forward tables alone had to be made, a piece a frame.
    assert report.frames_until_new >= 1
    assert report.longest_during_ms >= report.during_ms > 0.0
    assert report.seconds_until_new * 1e3 >= report.longest_during_ms
    assert json.loads(json.dumps(report.to_json()))["method"] == "forward"
    console = Console(width=100)
    with console.capture() as capture:
        console.print(change_table(report))
    assert "until the new prescription" in " ".join(capture.get().split())


def test_no_frames_are_refused(device: Device) -> None:
    with pytest.raises(InputError, match="frames: found 0, wanted 1 or more"):
        run_change(device, RIG, frames=0)
