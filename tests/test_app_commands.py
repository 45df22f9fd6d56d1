"""Each command as a user runs it on a small rig: what goes to which stream, and what is left."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import numpy as np
import pytest
from command_runs import (
    BARE,
    LENSLETS,
    call,
    exr_file,
    left_in,
    light,
    png_file,
    require_done,
    require_one_line,
    spawn,
)
from files_by_hand import asymmetric

from vrlf import __version__
from vrlf.app.main import main, vrlf
from vrlf.images import read_picture
from vrlf.model import rig_names

COMMANDS = tuple(sorted(vrlf.commands))


@pytest.fixture(scope="module")
def panel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A picture of the small rigs' panel size."""
    return exr_file(tmp_path_factory.mktemp("given") / "panel.exr", light())


# Help


@pytest.mark.parametrize("command", [(), *((name,) for name in COMMANDS)])
def test_help_is_a_result_and_names_every_option(command: tuple[str, ...]) -> None:
    outcome = require_done(call(*command, "--help"))
    assert outcome.err == ""
    assert outcome.out.startswith(f"Usage: vrlf {' '.join(command)}".rstrip())
    assert call(*command, "-h") == outcome
    if command:
        for parameter in vrlf.commands[command[0]].params:
            for name in parameter.opts:
                assert name.upper() in outcome.out.upper(), name


def test_the_list_of_commands_cuts_no_sentence_short() -> None:
    listed = [line for line in call("--help").out.splitlines() if line.startswith("  ")]
    described = {words[0]: line for line in listed if (words := line.split())}
    assert described.keys() >= set(COMMANDS)
    assert not [name for name in COMMANDS if described[name].endswith("...")]


def test_vrlf_alone_shows_its_help() -> None:
    assert call() == call("--help")


def test_version() -> None:
    assert require_done(call("--version")).out == f"vrlf, version {__version__}\n"


@pytest.mark.parametrize("command", COMMANDS)
def test_every_example_in_the_help_is_a_command_line_that_parses(command: str) -> None:
    """Up to its files, which are not there: what is refused is a file, never the command line."""
    text = call(command, "--help").out
    examples = re.findall(r"^ +(vrlf .+)$", text, re.MULTILINE)
    for example in examples:
        words = [word.strip('"') for word in re.findall(r'"[^"]*"|\S+', example)][1:]
        with vrlf.make_context("vrlf", list(words)) as context:
            name, found, rest = vrlf.resolve_command(context, words)
            assert found is not None
            found.make_context(name, list(rest))


def test_the_rig_file_in_the_help_is_a_rig(tmp_path: Path) -> None:
    text = call("rigs", "--help").out
    start = text.index("extends")
    lines = [line.strip() for line in text[start:].splitlines()]
    file = tmp_path / "mine.toml"
    file.write_text("\n".join(lines[: lines.index("")]))
    numbers = require_done(call("inspect", "-r", file, "--json")).json()
    assert numbers["left"]["cylinder_d"] == pytest.approx(-1.25, abs=0.1)  # vertex distance


def test_main_leaves_with_the_status() -> None:
    with pytest.raises(SystemExit) as left:
        main(["inspect", "-r", "no-such-rig"])
    assert left.value.code == 2


# inspect


def test_inspect_says_it_in_words_and_needs_no_gpu(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vrlf.gpu.device._create", lambda _: pytest.fail("asked for a GPU"))
    outcome = require_done(call("inspect", *LENSLETS))
    assert outcome.err == ""
    for word in ("Headset", "Left eye", "-5.00 D", "Right eye", "-3.00 / -1.50 x 35", "lenslets"):
        assert word in outcome.out


def test_inspect_has_the_names_that_scripts_rely_on() -> None:
    outcome = require_done(call("inspect", *LENSLETS, "--json"))
    assert outcome.err == ""
    numbers = outcome.json()
    eye = {"sphere_d", "cylinder_d", "axis_deg", "mean_error_d", "focus_distance_mm", "blur_mm"}
    eye |= {"blur_px", "accommodation_d"}
    array = {"throughput", "field_of_view_deg", "views", "spatial_nyquist_per_mm"}
    array |= {"depth_of_field_mm", "eyebox_mm", "best_pinhole_um", "lens_to_array_mm"}
    array |= {"reduced_gap_mm"}
    assert eye <= numbers["left"].keys()
    assert eye <= numbers["right"].keys()
    assert array <= numbers["array"].keys()
    assert {"pixels_per_degree", "virtual_image_mm"} <= numbers["display"].keys()
    assert all(isinstance(text, str) for text in numbers["warnings"])


def test_inspect_reads_prescriptions_as_written_and_set_wins() -> None:
    eyes = ("--both", "-3", "--left", "-5.00 / -1.25 x 170", "--set", "right.sphere_d=-1.5")
    flat = ("--set", "left.vertex_mm=0", "--set", "right.vertex_mm=0")
    numbers = require_done(call("inspect", *LENSLETS, *eyes, *flat, "--json")).json()
    # At vertex 0, eye relief 0 and F = 1/d the residual is the prescription itself.
    left = [numbers["left"][name] for name in ("sphere_d", "cylinder_d", "axis_deg")]
    assert left == pytest.approx([-5.0, -1.25, 170.0], abs=1e-9)  # rounding of float64
    assert numbers["right"]["mean_error_d"] == pytest.approx(-1.5, abs=1e-9)


def test_inspect_of_a_bare_panel_has_no_numbers_of_an_array() -> None:
    numbers = require_done(call("inspect", *BARE, "--json")).json()
    assert numbers["array"]["throughput"] == 1.0
    assert "none" in call("inspect", *BARE).out


# rigs


def test_rigs_lists_every_shipped_rig() -> None:
    outcome = require_done(call("rigs"))
    assert [line.split()[0] for line in outcome.out.splitlines()] == list(rig_names())
    numbers = require_done(call("rigs", "--json")).json()
    assert list(numbers["rigs"]) == list(rig_names())
    assert numbers["default"] in numbers["rigs"]
    assert all(numbers["rigs"].values())


@pytest.mark.parametrize("name", rig_names())
def test_every_shipped_rig_can_be_inspected(name: str) -> None:
    assert require_done(call("inspect", "-r", name, "--json")).json()["left"]


# chart


@pytest.mark.parametrize("name", ["logmar", "usaf1951", "siemens", "grid", "points", "marks"])
def test_chart_writes_the_panels_size_and_says_what_it_means(tmp_path: Path, name: str) -> None:
    file = tmp_path / "chart.png"
    outcome = require_done(call("chart", name, *LENSLETS, "-o", file))
    assert outcome.err == f"wrote {file}\n"
    assert outcome.out.strip()
    assert read_picture(file).shape == (64, 96, 3)
    first = file.read_bytes()
    numbers = require_done(call("chart", name, *LENSLETS, "-o", file, "--json")).json()
    assert (numbers["chart"], numbers["output"]) == (name, str(file))
    assert (numbers["width_px"], numbers["height_px"]) == (96, 64)
    assert "\n".join(numbers["notes"]) == outcome.out.rstrip("\n")
    assert file.read_bytes() == first
    assert left_in(tmp_path) == ["chart.png"]


def test_chart_and_source_chart_are_the_same_picture(tmp_path: Path) -> None:
    require_done(call("chart", "marks", *LENSLETS, "-o", tmp_path / "a.exr"))
    outcome = call(
        *("prefilter", "chart:marks", *LENSLETS, "-o", tmp_path / "b.exr"),
        *("--set", "prefilter.method=none"),
    )
    require_done(outcome)
    np.testing.assert_array_equal(
        read_picture(tmp_path / "a.exr"), read_picture(tmp_path / "b.exr")
    )


# prefilter and perceive


def test_prefilter_writes_says_and_answers(tmp_path: Path, panel: Path) -> None:
    shown, target = tmp_path / "shown.png", tmp_path / "target.exr"
    command = ("prefilter", panel, *LENSLETS, "-o", shown)
    outcome = require_done(call(*command))
    assert outcome.out == ""
    assert outcome.lines == [f"{panel}: taken as pixel for pixel", f"wrote {shown}"]
    first = shown.read_bytes()
    numbers = require_done(call(*command, "--target", target, "--json")).json()
    assert numbers == {
        "output": str(shown),
        "width_px": 96,
        "height_px": 64,
        "method": "forward",
        "target": str(target),
    }
    assert shown.read_bytes() == first
    assert left_in(tmp_path) == ["shown.png", "target.exr"]
    np.testing.assert_array_equal(read_picture(target), read_picture(panel))


@pytest.mark.parametrize("method", ["none", "forward", "optimal"])
def test_prefilter_goes_by_the_rigs_method(tmp_path: Path, method: str) -> None:
    panel = exr_file(tmp_path / "small.exr", light(size_px=(48, 32)))
    shown = tmp_path / "shown.exr"
    size = ("--set", "panel.width_px=48", "--set", "panel.height_px=32")
    how = (*size, "--set", f"prefilter.method={method}", "--json")
    outcome = require_done(call("prefilter", panel, *LENSLETS, "-o", shown, *how))
    assert outcome.json()["method"] == method
    assert np.array_equal(read_picture(shown), read_picture(panel)) == (method == "none")


def test_perceive_writes_says_and_answers(tmp_path: Path, panel: Path) -> None:
    seen = tmp_path / "seen.png"
    command = ("perceive", panel, *LENSLETS, "-o", seen, "--rays", "7")
    outcome = require_done(call(*command))
    assert outcome.out == ""
    assert re.fullmatch(r"wrote \S+seen.png\nquadrature error about 0\.\d+ RMS\n", outcome.err)
    first = seen.read_bytes()
    numbers = require_done(call(*command, "--json")).json()
    # Seven rays are few.
    assert 1e-3 < numbers.pop("quadrature_rms") < 0.2
    assert numbers == {
        "output": str(seen),
        "width_px": 96,
        "height_px": 64,
        "rays": 7,
        "exposure": "auto",
    }
    assert seen.read_bytes() == first
    assert left_in(tmp_path) == ["seen.png"]


@pytest.mark.parametrize("ending", ["png", "tif", "webp", "bmp", "jpg"])
def test_every_ending_is_that_format_and_upright(tmp_path: Path, ending: str) -> None:
    codes = np.zeros((64, 96, 3), np.uint8)
    codes[:32, :24] = (255, 0, 0)
    codes[32:, 72:] = (0, 0, 255)
    given = png_file(tmp_path / "given.png", codes)
    shown = tmp_path / f"shown.{ending}"
    outcome = require_done(call("prefilter", given, *BARE, "-o", shown))
    assert ("JPEG alters" in outcome.err) == (ending == "jpg")
    # Patches of 24 pixels are known from their means, also after JPEG's ringing.
    np.testing.assert_allclose(
        read_picture(shown).reshape(2, 32, 4, 24, 3).mean(axis=(1, 3)),
        read_picture(given).reshape(2, 32, 4, 24, 3).mean(axis=(1, 3)),
        atol=0.02,
    )


def test_an_odd_name_is_shown_so_that_a_line_stays_a_line(tmp_path: Path) -> None:
    given = png_file(tmp_path / "two\nlines.png", asymmetric())
    outcome = require_done(call("prefilter", given, *BARE, "-o", tmp_path / "b\n\x1b.png"))
    assert [line.split()[-1] for line in outcome.lines] == [
        "contain",
        ascii(str(tmp_path / "b\n\x1b.png")),
    ]
    require_one_line(call("prefilter", tmp_path / "no\nfile", *BARE, "-o", tmp_path / "c.png"), 2)


def test_bytes_that_are_no_text_are_a_name_like_any_other(tmp_path: Path) -> None:
    shown = tmp_path / os.fsdecode(b"\xfe.png")
    outcome = require_done(call("chart", "marks", *BARE, "-o", shown, "--json"))
    assert outcome.json()["output"] == str(shown)
    assert outcome.err == f"wrote {str(shown)!a}\n"
    assert shown.is_file()
    # OpenImageIO cannot be given such a name to read from.
    require_one_line(call("prefilter", shown, *BARE, "-o", tmp_path / "a.png"), 2, "not UTF-8")


# doctor


def test_doctor_is_well_here() -> None:
    outcome = require_done(call("doctor"))
    assert outcome.err == ""
    assert outcome.out.endswith("All is well.\n")
    report = require_done(call("doctor", "--json")).json()
    assert report["ok"] is True
    assert report["device"] in outcome.out
    # What the passes promise against their twins.
    assert 0.0 <= report["self_check_error"] <= 1e-4


def test_doctor_notices_a_gpu_that_computes_wrongly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vrlf.app.facts.perceive_reference", lambda panel, *_: panel * 0.5)
    outcome = call("doctor")
    assert outcome.status == 1
    assert "differs from the float64 reference" in outcome.out
    assert "update the graphics driver" in outcome.out
    assert call("doctor", "--json").json()["ok"] is False


# In a process of its own


def test_the_installed_program_keeps_its_streams_apart(tmp_path: Path, panel: Path) -> None:
    shown = tmp_path / "shown.png"
    outcome = spawn("prefilter", panel, *LENSLETS, "-o", shown, "--json")
    require_done(outcome)
    assert json.loads(outcome.out)["output"] == str(shown)
    assert outcome.lines == [f"{panel}: taken as pixel for pixel", f"wrote {shown}"]
    here = tmp_path / "here.png"
    require_done(call("prefilter", panel, *LENSLETS, "-o", here))
    assert shown.read_bytes() == here.read_bytes()


def test_text_is_plain_enough_for_any_terminal() -> None:
    environment = os.environ | {"PYTHONIOENCODING": "ascii", "LC_ALL": "C"}
    for command in (("rigs",), ("inspect", "-r", "reading-25cm"), ("--help",)):
        assert require_done(spawn(*command, env=environment)).err == ""


def test_a_wavefront_that_counts_the_error_twice_is_told(tmp_path: Path) -> None:
    rig = tmp_path / "twice.toml"
    rig.write_text(
        'extends = "bare"\n[panel]\nwidth_px = 96\nheight_px = 64\npixel_pitch_um = 78.0\n'
        "[headset]\nlens_to_panel_mm = 46.0\nlens_separation_mm = 2.5\n"
        '[left.zernike]\ndiameter_mm = 6.0\ncoefficients_um = { "2,0" = 1.0 }\n'
    )
    outcome = call("prefilter", "chart:marks", "-r", rig, "-o", tmp_path / "panel.png")
    assert outcome.status == 0
    told = [line for line in outcome.lines if line.startswith("take note: left eye")]
    assert len(told) == 1
    assert "counted twice" in told[0]
