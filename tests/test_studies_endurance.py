"""What is alive is noted, and nothing that frames leave behind stays unseen."""

from __future__ import annotations

import json

import pass_rigs
import pytest
from rich.console import Console

from vrlf.errors import InputError
from vrlf.gpu import Device, Texture
from vrlf.renderer import Stream
from vrlf.studies import endurance
from vrlf.studies.endurance import endurance_table, run_endurance

RIG = pass_rigs.SMALL["coma-lenslets"]


def test_nothing_grows(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    # A change of prescription every 40 frames: four between the notes, an even number.
    monkeypatch.setattr(endurance, "_CHANGE_EVERY", 40)
    report = run_endurance(device, RIG, frames=240, warm_after=80)
    warm, last = report.footprints
    assert (warm.frame, last.frame, report.changes) == (80, 240, 6)
    assert last.gpu_objects == warm.gpu_objects > 10
    assert last.gpu_bytes == warm.gpu_bytes > 1000
    assert report.peak_gpu_bytes >= last.gpu_bytes
    # Python keeps some dozens of freed objects for reuse, of 60 bytes each.
    assert abs(last.python_bytes - warm.python_bytes) < 20_000


def test_a_leak_is_seen(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    kept: list[Texture] = []
    show = Stream.show

    def leaking(self: Stream) -> None:
        kept.append(Texture(self.device, (16, 8), label="forgotten"))
        show(self)

    monkeypatch.setattr(Stream, "show", leaking)
    try:
        report = run_endurance(device, RIG, frames=30, warm_after=10)
    finally:
        for texture in kept:
            texture.release()
    warm, last = report.footprints
    assert last.gpu_objects == warm.gpu_objects + 20
    assert last.gpu_bytes == warm.gpu_bytes + 20 * 16 * 8 * 16
    assert last.python_bytes > warm.python_bytes + 20 * 200


def test_the_report_reads_and_keeps(device: Device) -> None:
    report = run_endurance(device, RIG, frames=6, warm_after=3)
    kept = json.loads(json.dumps(report.to_json()))
    assert kept["method"] == "forward"
    assert [each["frame"] for each in kept["footprints"]] == [3, 6]
    console = Console(width=100)
    with console.capture() as capture:
        console.print(endurance_table(report))
    assert "GPU objects" in capture.get()


@pytest.mark.parametrize("frames", [0, 10])
def test_too_few_frames_are_refused(device: Device, frames: int) -> None:
    with pytest.raises(InputError, match=f"frames: found {frames}, wanted more than the 10"):
        run_endurance(device, RIG, frames=frames, warm_after=10)
