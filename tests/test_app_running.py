"""``vrlf bench change`` and ``bench memory`` from the command line."""

from __future__ import annotations

import pytest
from command_runs import LENSLETS, call, require_done, require_one_line


def test_change_says_how_long_frames_took() -> None:
    done = call("bench", "change", *LENSLETS, "--frames", "2", "--json")
    require_done(done)
    report = done.json()
    assert report["panel"] == "96x64"
    assert report["longest_during_ms"] >= report["during_ms"] > 0.0
    assert "during" in call("bench", "change", *LENSLETS, "--frames", "1").out


def test_memory_notes_twice() -> None:
    done = call("bench", "memory", *LENSLETS, "--frames", "1001", "--json")
    require_done(done)
    first, last = done.json()["footprints"]
    assert (first["frame"], last["frame"]) == (1000, 1001)
    assert first["gpu_objects"] == last["gpu_objects"]


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("change", "--frames", "0"), ["--frames", "'0'", "1 to"]),
        (("change", "--making-ms", "nan"), ["--making-ms", "'nan'", "1 to"]),
        (("change", "-r", "no-such-rig"), ["no-such-rig"]),
        (("memory", "--frames", "1000"), ["--frames", "'1000'", "1001 to"]),
        (("memory", "--frames", "many"), ["--frames", "'many'"]),
        (("memory", "--set", "left.sphere=-3"), ["left.sphere"]),
    ],
)
def test_wrong_input_is_one_line(arguments: tuple[str, ...], named: list[str]) -> None:
    require_one_line(call("bench", *arguments), 2, *named)
