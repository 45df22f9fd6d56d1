"""``vrlf render``: what the other commands write, frame by frame; stopped, it goes on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_runs import LENSLETS, SIZE_PX, call
from films_by_hand import make_film

from vrlf.app import rendering
from vrlf.content.video import Film
from vrlf.images import read_codes, read_picture, write_encoded, write_picture

SCENE = ("scene", *LENSLETS, "--rays", "16", "--fps", "4")


def bytes_of(folder: Path) -> dict[str, bytes]:
    return {each.name: each.read_bytes() for each in folder.iterdir()}


@pytest.fixture
def picture(tmp_path: Path) -> str:
    codes = np.random.default_rng(8).integers(0, 256, (*SIZE_PX[::-1], 3), np.uint8)
    write_encoded(tmp_path / "target.png", codes)
    return str(tmp_path / "target.png")


def test_a_frame_is_what_the_other_commands_write(tmp_path: Path, picture: str) -> None:
    whats = "panel,perceived,uncorrected,target"
    out = tmp_path / "out"
    given = (picture, *LENSLETS, "--rays", "32", "--frames", "2", "--what", whats)
    assert call("render", *given, "-o", out).status == 0
    exact = tmp_path / "exact"
    assert call("render", *given, "--format", "exr", "-o", exact).status == 0
    panel, seen, bare = (str(tmp_path / name) for name in ("p.exr", "s.png", "b.png"))
    assert call("prefilter", picture, *LENSLETS, "-o", panel).status == 0
    assert call("perceive", panel, *LENSLETS, "--rays", "32", "-o", seen).status == 0
    without = ("--set", "array.kind=none", "--rays", "32")
    assert call("perceive", picture, *LENSLETS, *without, "-o", bare).status == 0
    for index in (1, 2):
        name = f"_{index:06d}"
        np.testing.assert_array_equal(read_picture(exact / f"panel{name}.exr"), read_picture(panel))
        for what, wanted in (("perceived", seen), ("uncorrected", bare), ("target", picture)):
            found = read_codes(out / f"{what}{name}.png")
            np.testing.assert_array_equal(found, read_codes(wanted))


@pytest.mark.parametrize("method", ["forward", "optimal"])
def test_stopped_it_goes_on_to_the_same_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, method: str
) -> None:
    method_keys = ("--set", f"prefilter.method={method}", "--set", "prefilter.iterations=2")
    job = (*SCENE, *method_keys, "--path", "orbit", "--what", "panel,perceived")
    given = (*job, "--frames", "4")
    whole, stopped = tmp_path / "whole", tmp_path / "stopped"
    assert call("render", *given, "-o", whole).status == 0
    write, count = rendering._write, 0

    def interrupted(*arguments: Any) -> None:
        nonlocal count
        count += 1
        if count == 4:  # within the second frame
            raise KeyboardInterrupt
        write(*arguments)

    monkeypatch.setattr(rendering, "_write", interrupted)
    outcome = call("render", *given, "-o", stopped)
    assert (outcome.status, outcome.lines[-1]) == (1, "vrlf: interrupted")
    assert len(bytes_of(stopped)) == 1 + 3
    monkeypatch.setattr(rendering, "_write", write)
    outcome = call("render", *given, "-o", stopped, "--json")
    assert outcome.json()["kept"] == 1
    assert bytes_of(stopped) == bytes_of(whole)
    frames = [value for name, value in bytes_of(whole).items() if name.startswith("panel")]
    assert len(set(frames)) == 4, "the head moves"
    # More frames of the same job: what is there is kept.
    outcome = call("render", *job, "--frames", "5", "-o", whole, "--json")
    assert outcome.status == 0, outcome.err
    assert outcome.json() == {"output": [str(whole)], "frames": 5, "rendered": 1, "kept": 4}


def test_another_jobs_frames_are_not_mixed_in(tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert call("render", *SCENE, "--frames", "1", "-o", out).status == 0
    before = bytes_of(out)
    changed = ("--set", "left.sphere_d=-1.25")
    outcome = call("render", *SCENE, *changed, "--frames", "1", "-o", out)
    assert outcome.status == 2
    assert len(outcome.lines) == 1
    assert "wanted an empty folder, or --restart" in outcome.err
    assert bytes_of(out) == before
    assert call("render", *SCENE, *changed, "--frames", "1", "-o", out, "--restart").status == 0
    assert bytes_of(out)["panel_000001.png"] != before["panel_000001.png"]


def test_films_in_and_out(tmp_path: Path) -> None:
    source = make_film(tmp_path / "in_sbs.mkv", 6)
    given = (str(source), *LENSLETS, "--rays", "16", "--frames", "3", "--fps", "12.5")
    frames, film = tmp_path / "frames", tmp_path / "out.mkv"
    assert call("render", *given, "--what", "panel,target", "-o", frames).status == 0
    outcome = call("render", *given, "--what", "panel,target", "-o", film, "--json")
    assert outcome.json()["output"] == [str(tmp_path / f"out_{w}.mkv") for w in ("panel", "target")]
    for what in ("panel", "target"):
        back = Film(tmp_path / f"out_{what}.mkv", layout="mono")
        for index in range(3):
            codes = read_codes(frames / f"{what}_{index + 1:06d}.png")
            np.testing.assert_array_equal(back.at((index + 0.1) / 12.5)[0], codes)
        back.release()
    assert not (tmp_path / "out.mkv.frames").exists()
    # Every second frame of the source; its left half to the left eye.
    targets = [read_codes(frames / f"target_{k:06d}.png") for k in (1, 2, 3)]
    assert not np.array_equal(targets[0], targets[1])
    one = call("prefilter", str(source), *LENSLETS, "-o", tmp_path / "p.png")
    assert one.status == 0, one.err
    np.testing.assert_array_equal(
        read_codes(tmp_path / "p.png"), read_codes(frames / "panel_000001.png")
    )


def test_panoramas_and_charts(tmp_path: Path) -> None:
    world = np.random.default_rng(2).random((32, 64, 3)).astype(np.float32)
    write_picture(tmp_path / "a_360.exr", world)
    for source in (str(tmp_path / "a_360.exr"), "chart:marks"):
        out = tmp_path / Path(source).stem.replace(":", "-")
        given = (source, *LENSLETS, "--what", "target", "--frames", "3", "--path", "orbit")
        outcome = call("render", *given, "--fps", "1", "-o", out)
        assert outcome.status == 0, outcome.err
        kinds = {path.read_bytes() for path in out.glob("*.png")}
        assert len(kinds) == (3 if "360" in source else 1)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--frames", "0"), "--frames"),
        (("--frames", "2", "--what", "panel,all"), "found 'all', wanted some of panel"),
        (("--frames", "2", "--fps", "nan"), "--fps"),
        (("--frames", "2", "--start", "-1"), "--start"),
        (("--frames", "2", "--path", "nowhere"), "--path: found nowhere"),
        (("--frames", "2", "--rays", "0"), "--rays"),
    ],
)
def test_wrong_input_is_one_line_and_nothing_is_made(
    tmp_path: Path, arguments: tuple[str, ...], said: str
) -> None:
    outcome = call("render", "scene", *LENSLETS, *arguments, "-o", tmp_path / "out")
    assert outcome.status == 2
    assert len(outcome.lines) == 1
    assert said in outcome.err
    assert not (tmp_path / "out").exists()


def test_a_place_that_cannot_hold_it(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for place, more in ((tmp_path / "file", ()), (tmp_path / "no" / "out.mkv", ())):
        outcome = call("render", "scene", *LENSLETS, "--frames", "1", "-o", place, *more)
        assert outcome.status == 2
        assert len(outcome.lines) == 1
    outcome = call(
        "render", "scene", *LENSLETS, "--frames", "1", "-o", tmp_path / "x.mkv", "--format", "exr"
    )
    assert (outcome.status, len(outcome.lines)) == (2, 1)


def test_files_of_the_users_are_never_taken_away(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    kept = ["panel_1_final.png", "target_2.png", "notes.txt"]
    for name in (*kept, "panel_000007.png"):
        (out / name).write_text(name)
    outcome = call("render", *SCENE, "--frames", "1", "-o", out)
    assert outcome.status == 2
    assert "found numbered frames" in outcome.lines[-1]
    assert sorted(bytes_of(out)) == sorted([*kept, "panel_000007.png"])
    assert call("render", *SCENE, "--frames", "1", "-o", out, "--restart").status == 0
    assert sorted(bytes_of(out)) == sorted([*kept, "panel_000001.png", "render.json"])


def test_a_second_file_is_a_pictures_alone(tmp_path: Path) -> None:
    film = make_film(tmp_path / "in.mkv", 2)
    second = ("--right-source", film)
    outcome = call("prefilter", film, *second, *LENSLETS, "-o", tmp_path / "p.png")
    assert (outcome.status, len(outcome.lines)) == (2, 1)
    assert "--right-source" in outcome.err
    assert not (tmp_path / "p.png").exists()


@pytest.mark.parametrize("source", ["nosuch.png", "http://127.0.0.1:9/film.mp4", "n" * 400])
def test_a_source_that_is_not_there_leaves_nothing(tmp_path: Path, source: str) -> None:
    outcome = call("render", source, *LENSLETS, "--frames", "1", "-o", tmp_path / "out")
    assert outcome.status == 2
    assert len(outcome.lines) == 1
    assert not (tmp_path / "out").exists()
