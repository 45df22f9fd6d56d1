"""Faults in the window: the last good picture fades to grey, nothing flashes, it goes on."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vrlf.app.preview.fading import FADING_S, Fade, faded
from vrlf.app.preview.pacing import Effort, FrameClock, Pacer
from vrlf.optics.tile import GREY_CODE

SCRIPT = Path(__file__).with_name("preview_by_hand.py")


def found(display: str, *scenario: str) -> tuple[dict[str, Any], str]:
    """What a scenario says."""
    result = subprocess.run(
        [sys.executable, str(SCRIPT), *scenario],
        env={**os.environ, "DISPLAY": display},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    value = json.loads(result.stdout)
    assert isinstance(value, dict)
    return value, result.stderr


def test_a_fault_fades_to_grey_and_back_without_a_flash(display: str) -> None:
    value, said = found(display, "fault")
    # From a code to grey are 137 codes at most, in 24 frames of 400 ms: 6 a frame.
    assert value["largest_step"] <= 137 * (1 / 60) / FADING_S + 1
    assert value["first"] <= 7, "the last good picture is where the fade begins"
    assert value["grey_at"][0] >= 0.2 * 60
    assert value["grey_at"][-1] == 59
    assert value["is_back"]
    assert value["fault"] is None
    assert said.count("something broke") == 1
    assert "it works again" in said


def test_what_is_no_number_never_reaches_the_screen(display: str) -> None:
    value, _ = found(display, "wild")
    assert value["spots"] == [[0, 255, 0]]


def test_before_anything_was_drawn_nothing_ends_it(display: str) -> None:
    value, said = found(display, "early")
    assert value["is_alive"]
    assert "found no frame drawn so far" in said
    assert "RuntimeError: something broke" in said


def test_a_lost_gpu_ends_it_with_one_line(display: str) -> None:
    value, _ = found(display, "lost")
    assert value["error"].startswith("GPU: found its context lost")
    assert "\n" not in value["error"]


def test_a_window_without_a_size_draws_nothing(display: str) -> None:
    value, _ = found(display, "small")
    assert value["drawn_meanwhile"] == 0
    assert value["drawn_after"] > 0


def test_a_fade_takes_its_time_however_long_a_frame_was() -> None:
    fade = Fade()
    assert [fade.step(10.0, is_faulty=True) for _ in range(10)][-2:] == pytest.approx([0.9, 1.0])
    assert fade.step(1 / 60, is_faulty=False) == pytest.approx(1.0 - 1 / 60 / FADING_S)
    assert FADING_S >= 0.2
    codes = np.array([0, 30, 118, 255], np.uint8)
    assert faded(codes, 0.0).tolist() == codes.tolist()
    assert (faded(codes, 1.0) == GREY_CODE).all()


def test_the_effort_gives_way_after_a_while_and_comes_back_late() -> None:
    pacer = Pacer(16.0)
    changes = [pacer.spent(15.0) for _ in range(45)]
    assert changes.count(True) == 2
    assert pacer.effort == Effort(0.25)
    assert pacer.has_given_way
    # Neither too much nor plenty: it stays.
    assert not any(pacer.spent(10.0) for _ in range(1000))
    assert [pacer.spent(3.0) for _ in range(130)].count(True) == 1
    assert pacer.effort == Effort(0.5)
    assert not any(pacer.spent(100.0) for _ in range(19)), "a hitch changes nothing"
    assert Effort(0.125).of(64) == 8
    assert Effort(0.125).of(4, least=3) == 3
    assert Effort(0.5).of(1) == 1


def test_dropped_frames_are_those_that_came_late() -> None:
    clock = FrameClock(10.0)
    for now_s in (0.0, 0.010, 0.020, 0.051, 0.060, 0.0699):
        clock.tick(now_s)
    assert clock.dropped == 2
    assert clock.frames == 6
    clock.pause()
    clock.tick(9.0)
    assert clock.dropped == 2, "a window that rested dropped nothing"
    assert clock.percentile_ms(50) == pytest.approx(10.0, abs=0.2)


def test_many_changes_mix_no_frame_and_nothing_grows(display: str) -> None:
    """Every tenth frame with another prescription; ten thousand frames are in the README."""
    value, said = found(display, "long", "1500")
    assert said == ""
    assert (value["changes"], value["late"], value["mixed"]) == (150, 0, 0)
    assert value["drawn"] == 1500, "no frame was left out"
    first, last = value["footprints"]["1000"], value["footprints"]["1500"]
    assert last[:2] == first[:2], "GPU objects and their bytes"
    # Resident memory: of 10,000 frames less than 1 MB was measured; an allocator may step once.
    assert last[2] - first[2] < 2 * 2**20
