"""``vrlf eye`` as a user runs it."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_runs import BARE, LENSLETS, call, left_in, require_done, require_one_line

from vrlf.studies import plots

SMALL = ("--set", "left.pupil_mm=3", "--set", "right.pupil_mm=3")


def test_it_draws_and_says_its_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vrlf.gpu.device._create", lambda _: pytest.fail("asked for a GPU"))
    file = tmp_path / "eye.png"
    outcome = require_done(call("eye", *LENSLETS, *SMALL, "-o", file, "--json"))
    assert outcome.err == ""
    assert file.read_bytes().startswith(b"\x89PNG")
    assert left_in(tmp_path) == ["eye.png"]
    numbers = outcome.json()
    assert numbers.keys() == {"left", "right"}
    for eye in numbers.values():
        assert {"rms_um", "higher_order_rms_um", "sphere_d", "cylinder_d", "axis_deg"} <= eye.keys()
        for name in ("strehl", "half_light_arcmin", "geometric_half_light_arcmin"):
            assert eye[name].keys() == {"red", "green", "blue"}
        assert 0.0 < eye["strehl"]["green"] < 1.0
    inspected = require_done(call("inspect", *LENSLETS, *SMALL, "--json")).json()
    assert numbers["right"]["axis_deg"] == pytest.approx(inspected["right"]["axis_deg"])


def test_without_a_file_it_says_them_in_words() -> None:
    outcome = require_done(call("eye", *BARE, *SMALL, "--left", "-0.5", "--right", "plano"))
    for word in ("Left eye", "-0.5", "Right eye", "Strehl", "465 nm", "arcmin", "RMS"):
        assert word in outcome.out


def test_a_perfect_eye_has_a_strehl_ratio_of_1() -> None:
    numbers = require_done(call("eye", "--alone", "--both", "plano", *SMALL, "--json")).json()
    assert numbers["left"]["rms_um"] == 0.0
    assert list(numbers["left"]["strehl"].values()) == pytest.approx([1.0, 1.0, 1.0], abs=1e-9)


def test_alone_is_without_the_headset() -> None:
    """A lensless headset at 46 mm leaves 21.7 D; the eye itself has nothing wrong with it."""
    narrow = ("--set", "left.pupil_mm=1", "--set", "right.pupil_mm=1")
    rig = ("-r", "lensless", "--both", "plano", "--set", "array.kind=none", *narrow)
    before = require_done(call("eye", *rig, "--json")).json()["left"]
    alone = require_done(call("eye", *rig, "--alone", "--json")).json()["left"]
    assert before["sphere_d"] == pytest.approx(1000.0 / 46.0)
    assert alone["sphere_d"] == 0.0


def test_what_is_odd_in_a_wavefront_is_said() -> None:
    doubled = 'left.zernike={diameter_mm=5.0,coefficients_um={"2,0"=0.3}}'
    outcome = require_done(call("eye", *BARE, *SMALL, "--both", "-1", "--set", doubled, "--json"))
    assert any("take note: left eye" in line for line in outcome.lines)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("-o", "eye.jpg"), ("eye.jpg", "'.jpg'", ".png or .svg")),
        (("-o", "eye"), ("eye", "'none'", ".png or .svg")),
        (("-o", "nowhere/eye.png"), ("nowhere/eye.png", "found no folder")),
        (("-r", "no-such-rig"), ("no-such-rig", "matched-microlens")),
        (("--letter", "0"), ("--letter", "'0'", "above 0")),
        (("--letter", "nan"), ("--letter", "'nan'")),
        (("--letter", "big"), ("--letter", "'big'")),
        (("extra",), ("extra", "vrlf eye --help")),
        (("--both", "-40", "-o", "eye.png"), ("left eye", "found a blur", "wanted at most")),
    ],
)
def test_a_wrong_input_is_one_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
    named: tuple[str, ...],
) -> None:
    monkeypatch.chdir(tmp_path)
    require_one_line(call("eye", *arguments), 2, *named)
    assert left_in(tmp_path) == []


def test_without_matplotlib_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plots, "find_spec", lambda _: None)
    require_one_line(call("eye", "-o", tmp_path / "eye.png"), 2, "-o", "pip install 'vrlf[plots]'")
    assert left_in(tmp_path) == []
    require_done(call("eye", *BARE, *SMALL, "--json"))  # numbers need none
