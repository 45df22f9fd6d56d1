"""The demo: its files, its numbers, its sheet; and the sheet's own promises."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_runs import (
    BARE,
    LENSLETS,
    Outcome,
    call,
    exr_file,
    left_in,
    light,
    require_done,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from vrlf.app.demo import Chain, Gain, _table
from vrlf.app.sheet import Column, _busiest_part, _wrapped, draw_sheet
from vrlf.evaluation.measure import likeness
from vrlf.images import read_picture, srgb_encode, text_size
from vrlf.model import load_rig
from vrlf.optics.viewport import Viewport

FILES = [
    "numbers.json",
    "overview.png",
    "panel.png",
    "perceived-with-optimal.png",
    "perceived-with.png",
    "perceived-without.png",
    "target.png",
]
QUICK = ("--rays", "4")
OPTIMAL = f"{LENSLETS[1]}, optimal prefilter"


@pytest.fixture(scope="module")
def scene_demo(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Outcome]:
    """The demo on the shipped scene and a small rig, in a folder that is made for it."""
    folder = tmp_path_factory.mktemp("demo") / "new" / "folder"
    return folder, call("demo", *LENSLETS, *QUICK, "-o", folder)


def codes(file: Path) -> np.ndarray:
    """8-bit codes of a PNG."""
    return np.rint(srgb_encode(read_picture(file).astype(np.float64)) * 255.0).astype(int)


def test_demo_shows_the_whole_chain(scene_demo: tuple[Path, Outcome]) -> None:
    folder, outcome = scene_demo
    require_done(outcome)
    assert left_in(folder) == FILES
    assert outcome.out.endswith(f"The picture to open: {folder / 'overview.png'}\n")
    for name in (LENSLETS[1], OPTIMAL, "matched-full", "thesis-minus-5d"):
        assert f"    {name}: left" in outcome.out
        assert f"{name}: what the eyes see (4 rays a pixel)" in outcome.lines
    for name in (
        "target",
        "panel",
        "perceived-with",
        "perceived-without",
        "perceived-with-optimal",
    ):
        assert read_picture(folder / f"{name}.png").shape == (64, 96, 3)
    numbers = json.loads((folder / "numbers.json").read_text())
    assert numbers["rays"] == 4
    for side in ("left", "right"):
        before, after = (numbers["rigs"][LENSLETS[1]][side][key] for key in ("without", "with"))
        assert after["psnr_db"] > before["psnr_db"]  # what the demo is there to show
        assert numbers["rigs"][OPTIMAL][side]["with"]["psnr_db"] > before["psnr_db"]
        # T 6.1: 10 log10 (1 / rmse^2); rounding of float64.
        assert after["psnr_db"] == pytest.approx(-20.0 * np.log10(after["rmse"]), abs=1e-9)


def test_demo_is_the_commands_one_after_the_other(
    scene_demo: tuple[Path, Outcome], tmp_path: Path
) -> None:
    folder, _ = scene_demo
    shown, target = tmp_path / "shown.exr", tmp_path / "target.exr"
    fit = ("--fit", "cover", "--target", target)
    require_done(call("prefilter", "scene", *LENSLETS, "-o", shown, *fit))
    seen = tmp_path / "seen.png"
    require_done(call("perceive", shown, *LENSLETS, *QUICK, "-o", seen))
    assert np.array_equal(codes(seen), codes(folder / "perceived-with.png"))
    bare = ("--set", "array.kind=none")
    require_done(call("perceive", target, *LENSLETS, *bare, *QUICK, "-o", seen))
    assert np.array_equal(codes(seen), codes(folder / "perceived-without.png"))


def test_demo_twice_is_the_same_bytes_and_json_is_the_numbers(
    scene_demo: tuple[Path, Outcome], tmp_path: Path
) -> None:
    folder, _ = scene_demo
    numbers = require_done(call("demo", *LENSLETS, *QUICK, "-o", tmp_path, "--json")).json()
    assert numbers.pop("overview") == str(tmp_path / "overview.png")
    assert numbers == json.loads((folder / "numbers.json").read_text())
    for name in FILES:
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name


def test_demo_takes_a_picture_of_your_own(tmp_path: Path) -> None:
    given = exr_file(tmp_path / "given.exr", light(size_px=(96, 64)))
    require_done(call("demo", *BARE, *QUICK, "--source", given, "-o", tmp_path / "out"))
    wanted = np.rint(srgb_encode(light().astype(np.float64)) * 255.0)
    # A hair beyond half a code for the GPU's float32 power.
    assert np.abs(codes(tmp_path / "out" / "target.png") - wanted).max() <= 1


def test_demo_on_a_black_picture_has_no_infinity_in_its_json(tmp_path: Path) -> None:
    given = exr_file(tmp_path / "black.exr", np.zeros((64, 96, 3), np.float32))
    command = ("demo", *BARE, *QUICK, "--source", given, "-o", tmp_path)
    numbers = require_done(call(*command, "--json")).json()
    assert numbers["rigs"][BARE[1]]["left"]["with"]["psnr_db"] is None
    written = (tmp_path / "numbers.json").read_text()
    assert "Infinity" not in written
    assert "NaN" not in written
    assert json.loads(written)["rigs"] == numbers["rigs"]
    assert "the target itself -> the target itself" in "\n".join(_table_of_equal_pictures())


def _table_of_equal_pictures() -> list[str]:
    """The demo's table for a rig that shows everybody the target itself."""
    rig, dark = load_rig(BARE[1]), np.zeros((64, 96, 3), np.float32)
    same = Gain(*(likeness(dark, dark, rig, "left") for _ in range(2)))
    return _table([Chain("bare", rig, dark, dark, dark, dark, (same, same))])


def test_demo_works_where_nothing_is_left_to_measure(tmp_path: Path) -> None:
    given = exr_file(tmp_path / "given.exr", light(size_px=(24, 20)))
    small = ("--set", "panel.width_px=24", "--set", "panel.height_px=20")
    command = ("demo", *LENSLETS, *small, *QUICK, "--source", given, "-o", tmp_path / "out")
    outcome = require_done(call(*command))
    assert "left too small a view to measure, right too small a view to measure" in outcome.out
    assert left_in(tmp_path / "out") == FILES
    numbers = json.loads((tmp_path / "out" / "numbers.json").read_text())
    assert numbers["rigs"][LENSLETS[1]] == {"left": None, "right": None}


def test_demo_leaves_out_arrays_that_do_not_fit_the_headset(tmp_path: Path) -> None:
    near = ("--set", "headset.lens_to_panel_mm=5")
    command = ("demo", *LENSLETS, *near, *QUICK, "--source", "chart:marks")
    outcome = require_done(call(*command, "-o", tmp_path, "--json"))
    # The thesis's array stands 6 mm before the panel.
    assert list(outcome.json()["rigs"]) == [LENSLETS[1], OPTIMAL, "matched-full"]
    assert [line for line in outcome.lines if "left out" in line and "array.gap_mm" in line]


# The sheet

NOTE = "lenslets of 2.3 mm focus, 635 um apart, gap 3.6 mm, turned 23 deg"


def sheet_of(width_px: int, height_px: int, note: str = NOTE, title: str = "vrlf") -> np.ndarray:
    """A sheet of four plain columns; the panel is white, so that the pictures are seen."""
    views = tuple(Viewport(n * width_px, width_px, height_px, (0.0, 0.0)) for n in (0, 1))
    white = np.ones((height_px, 2 * width_px, 3), np.float32)
    columns = [Column(f"heading {n}", white, (note, note)) for n in range(4)]
    return draw_sheet(title, "all that is known of it", columns, (views[0], views[1]), 10.3, ["x"])


@pytest.mark.parametrize("size", [(1, 1), (2, 900), (48, 64), (667, 300), (3500, 40)])
def test_no_text_runs_into_the_next_column(size: tuple[int, int]) -> None:
    sheet = sheet_of(*size, note=f"{NOTE}; {NOTE} {'w' * 90}")
    height, width = sheet.shape[:2]
    assert max(height, width) <= 16384  # what a picture file may have
    cell = (width - 2 * 32 - 3 * 20) // 4
    paper = np.float32(0.012)
    # Below title and subtitle; the last two bands are the table and the margin.
    body = slice(120, height - 80)
    for column in range(1, 4):
        gap = 32 + column * (cell + 20) - 20
        np.testing.assert_array_equal(sheet[body, gap + 2 : gap + 18], paper)
    np.testing.assert_array_equal(sheet[:, -30:], paper)


def test_small_viewports_are_enlarged_and_large_ones_shown_as_they_are() -> None:
    def largest_white_run(sheet: np.ndarray) -> int:
        white = (sheet > 0.9).all(axis=-1)[:, 32 : (sheet.shape[1] - 124) // 4 + 32]
        return int(white.sum(axis=1).max())

    assert largest_white_run(sheet_of(48, 64)) == 480
    assert largest_white_run(sheet_of(167, 48)) == 501
    assert largest_white_run(sheet_of(667, 200)) == 667


def test_the_busiest_part_is_magnified() -> None:
    picture = np.full((60, 80, 3), 0.3, np.float32)
    picture[37:47, 51:67] = light(size_px=(16, 10))
    assert _busiest_part(picture, 16, 10) == (slice(37, 47), slice(51, 67))
    assert _busiest_part(picture, 80, 60) == (slice(0, 60), slice(0, 80))


def test_a_long_title_is_wrapped() -> None:
    long = sheet_of(667, 30, title="/".join(["a-rather-long-name-of-a-folder"] * 12))
    np.testing.assert_array_equal(long[:, -30:], np.float32(0.012))
    assert long.shape[0] > sheet_of(667, 30).shape[0]


@settings(max_examples=40, deadline=None)
@given(
    st.text(st.sampled_from("abc MWi.,-"), max_size=60),
    st.integers(60, 400),
    st.integers(0, 3),
)
def test_wrapping_loses_nothing_and_stays_inside(text: str, width_px: int, indent: int) -> None:
    lines = _wrapped(" " * indent + text.strip(), width_px, 22)
    assert "".join("".join(lines).split()) == "".join(text.split())
    # A single letter cannot be cut; 60 pixels hold any, with its indent.
    assert all(text_size(line, 22)[0] <= width_px for line in lines)
