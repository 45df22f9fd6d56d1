"""``vrlf compare`` as a user runs it."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from command_runs import call, exr_file, light, png_file, require_done, require_one_line, spawn
from extras import needs_cvvdp
from files_by_hand import pfm

from vrlf.evaluation.metrics import METRICS, Viewing, false_colour, score
from vrlf.images import read_channels, read_codes, read_picture


@pytest.fixture
def pair(tmp_path: Path) -> tuple[Path, Path]:
    """Linear light, and the same with every third row darker."""
    reference = light()
    test = reference.copy()
    test[::3] *= np.float32(0.6)
    return exr_file(tmp_path / "a.exr", reference), exr_file(tmp_path / "b.exr", test)


def test_three_metrics_unless_told(pair: tuple[Path, Path]) -> None:
    found = require_done(call("compare", *pair, "--json")).json()
    pictures = [read_picture(path) for path in pair]
    wanted = score(["rmse", "psnr_db", "ssim"], *pictures, Viewing(10.3, 500.0)).values
    assert {name: found[name] for name in METRICS if name in found} == wanted
    assert (found["width_px"], found["height_px"]) == (96, 64)
    assert (found["pixels_per_degree"], found["peak_nit"], found["black_nit"]) == (10.3, 500, 0)
    assert (found["failed"], found["undefined"], found["map"]) == ({}, {}, None)


def test_which_picture_is_which_counts(pair: tuple[Path, Path]) -> None:
    there = require_done(call("compare", *pair, "--metric", "light", "--json")).json()
    back = require_done(call("compare", *pair[::-1], "--metric", "light", "--json")).json()
    assert there["light"] == pytest.approx(1 / back["light"])
    assert there["light"] < 0.95


def test_the_text_has_a_line_for_each(pair: tuple[Path, Path]) -> None:
    done = require_done(call("compare", *pair, "--metric", "psnr_db", "--metric", "flip"))
    assert [line.split()[0] for line in done.out.splitlines()] == ["PSNR", "FLIP"]
    assert done.out.splitlines()[0].endswith(" dB")


def test_equal_pictures_have_no_psnr(pair: tuple[Path, Path]) -> None:
    found = require_done(call("compare", pair[0], pair[0], "--json")).json()
    assert (found["rmse"], found["psnr_db"], found["ssim"]) == (0.0, None, 1.0)
    assert "infinite" in found["undefined"]["psnr_db"]
    assert "equal" in require_done(call("compare", pair[0], pair[0])).out


def test_png_is_decoded_and_exr_is_not(tmp_path: Path) -> None:
    """Code 188 is half of full light, by the sRGB formula, to within half a code."""
    codes = np.full((16, 20, 3), 188, np.uint8)
    png = png_file(tmp_path / "half.png", codes)
    exr = exr_file(tmp_path / "half.exr", np.full((16, 20, 3), 0.5, np.float32))
    found = require_done(call("compare", png, exr, "--metric", "rmse", "--json")).json()
    assert found["rmse"] == pytest.approx(((188 / 255 + 0.055) / 1.055) ** 2.4 - 0.5, abs=1e-6)


def test_a_map_as_colours_and_as_numbers(pair: tuple[Path, Path], tmp_path: Path) -> None:
    for name in ("map.exr", "map.png"):
        require_done(call("compare", *pair, "--metric", "flip", "--map", tmp_path / name))
    pictures = [read_picture(path) for path in pair]
    wanted = score(["flip"], *pictures, Viewing(10.3, 500.0)).maps["flip"]["flip"]
    numbers = read_channels(tmp_path / "map.exr")
    assert list(numbers) == ["flip"]
    assert numbers["flip"] == pytest.approx(wanted, abs=1e-6)
    assert np.array_equal(read_codes(tmp_path / "map.png"), false_colour(wanted))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--metric", "rsme"], ("'rsme'", "rmse, psnr_db, ssim, flip, cvvdp_jod, hdr_vdp")),
        (["--ppd", "0"], ("--ppd", "above 0")),
        (["--ppd", "nan"], ("--ppd", "above 0")),
        (["--peak-nit", "-5"], ("--peak-nit", "above 0")),
        (["--black-nit", "-0.1"], ("--black-nit", "from 0")),
        (["--map", "m.png"], ("--map", "no metric that has a map", "flip, cvvdp_jod, hdr_vdp")),
        (
            ["--metric", "flip", "--metric", "hdr_vdp", "--map", "m.exr"],
            ("--map", "flip and hdr_vdp"),
        ),
        (["--metric", "hdr_vdp", "--map", "m.png"], ("m.png", "wanted .exr for hdr_vdp")),
        (["--metric", "flip", "--map", "m.gif"], ("m.gif", ".exr")),
        (["--metric", "flip", "--map", "no-such-folder/m.png"], ("no folder",)),
    ],
)
def test_what_was_asked_for_wrongly(
    arguments: list[str], said: tuple[str, ...], pair: tuple[Path, Path]
) -> None:
    require_one_line(call("compare", *pair, *arguments), 2, *said)


def test_pictures_that_cannot_be_compared(pair: tuple[Path, Path], tmp_path: Path) -> None:
    smaller = exr_file(tmp_path / "small.exr", light(size_px=(95, 64)))
    require_one_line(call("compare", pair[0], smaller), 2, "small.exr", "95x64", "96x64", "a.exr")
    require_one_line(call("compare", pair[0], tmp_path / "none.png"), 2, "none.png", "no such file")
    spoilt = light()
    spoilt[3, 4, 1] = np.nan
    broken = tmp_path / "nan.pfm"
    broken.write_bytes(pfm(spoilt, big_endian=False))
    require_one_line(call("compare", pair[0], broken), 2, "nan.pfm", "found 1 values")


def test_a_missing_extra_leaves_the_others(
    pair: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setitem(sys.modules, "flip_evaluator", None)
    both = call("compare", *pair, "--metric", "flip", "--metric", "rmse", "--json")
    assert both.status == 0
    assert both.json()["rmse"] > 0.0
    assert "flip" not in both.json()
    (line,) = both.lines
    assert "pip install 'vrlf[flip]'" in line
    assert both.json()["failed"]["flip"] in line
    require_one_line(call("compare", *pair, "--metric", "flip"), 2, "pip install 'vrlf[flip]'")
    place = tmp_path / "map.png"
    mapped = call("compare", *pair, "--metric", "flip", "--metric", "rmse", "--map", place)
    assert mapped.status == 2
    assert not place.exists()


@needs_cvvdp
def test_cvvdp_in_a_process_of_its_own(pair: tuple[Path, Path], tmp_path: Path) -> None:
    """Its libraries write where they like; a user's standard output holds the result alone."""
    place = tmp_path / "heat.png"
    done = spawn(
        *("compare", *pair, "--metric", "cvvdp_jod", "--map", place, "--json"), timeout_s=120
    )
    assert done.status == 0, done.err
    assert 5.0 < json.loads(done.out)["cvvdp_jod"] < 10.0
    assert done.lines == [f"wrote {place}"]
    assert read_codes(place).shape == (64, 96, 3)


def test_hdr_vdp_with_its_two_maps(pair: tuple[Path, Path], tmp_path: Path) -> None:
    place = tmp_path / "map.exr"
    viewing = ("--ppd", "20", "--peak-nit", "150", "--black-nit", "0.2")
    found = require_done(
        call("compare", *pair, "--metric", "hdr_vdp", *viewing, "--map", place, "--json")
    ).json()
    pictures = [read_picture(path) for path in pair]
    wanted = score(["hdr_vdp"], *pictures, Viewing(20.0, 150.0, 0.2))
    assert found["hdr_vdp"] == wanted.values["hdr_vdp"]
    assert set(found["hdr_vdp"]) == {"q_mos", "q", "p_det", "c_max"}
    maps = read_channels(place)
    assert sorted(maps) == ["P", "S"]
    assert maps["P"].max() == pytest.approx(found["hdr_vdp"]["p_det"], abs=1e-6)
    assert maps["S"] == pytest.approx(wanted.maps["hdr_vdp"]["S"], rel=1e-6)
    same = call("compare", pair[0], pair[0], "--metric", "hdr_vdp", "--json")
    assert require_done(same).json()["hdr_vdp"]["p_det"] == 0.0
