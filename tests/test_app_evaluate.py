"""``vrlf evaluate``: its numbers, its files, how it goes on, and what goes wrong."""

from __future__ import annotations

import csv
import json
import os
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

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
    require_one_line,
    require_refused,
)

import vrlf
import vrlf.files
from vrlf.evaluation.measure import likeness
from vrlf.images import read_picture, srgb_encode
from vrlf.model import Rig, load_rig
from vrlf.renderer import GpuRenderer, bare_rig

RAYS = 16
# The two methods whose tables take no time.
QUICK = ("--method", "none", "--method", "forward")
PLAIN = ("--metric", "rmse", "--metric", "psnr_db", "--metric", "ssim", "--rays", str(RAYS))
METHODS = ("none", "forward", "optimal")
FILES = ["cases", "report.html", "results.csv", "results.json", "rigs"]


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A picture of the small rigs' panel size: taken pixel for pixel."""
    smooth = light(size_px=(12, 8)).repeat(8, axis=0).repeat(8, axis=1)
    return exr_file(tmp_path_factory.mktemp("given") / "blocks.exr", np.ascontiguousarray(smooth))


@pytest.fixture(scope="module")
def done(source: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Outcome]:
    """One source before one rig, all metrics but those of libraries that take long to load."""
    folder = tmp_path_factory.mktemp("done") / "new" / "folder"
    metrics = ("rmse", "psnr_db", "ssim", "contrast", "fringe", "light", "acuity", "mtf50", "mtf")
    words = [word for name in metrics for word in ("--metric", name)]
    outcome = call("evaluate", source, *LENSLETS, "-o", folder, *words, "--rays", "16", "--json")
    return folder, require_done(outcome)


def judged(target: np.ndarray, rig: Rig, method: str, renderer: GpuRenderer) -> list[Any]:
    """What independent calls of the steps say of a method, eye by eye."""
    prefilter = rig.prefilter.model_copy(update={"method": method})
    filtered = rig.model_copy(update={"prefilter": prefilter})
    panel = vrlf.prefilter(target, filtered, renderer=renderer)
    seen_by = bare_rig(rig) if method == "none" else rig
    seen = vrlf.perceive(panel, seen_by, rays=RAYS, renderer=renderer)
    return [likeness(seen, target, rig, side) for side in ("left", "right")]


def test_numbers_are_those_of_the_steps_by_themselves(
    done: tuple[Path, Outcome], source: Path
) -> None:
    numbers = done[1].json()
    rig, target = load_rig(LENSLETS[1]), read_picture(source)
    with GpuRenderer() as renderer:
        for method in METHODS:
            for side, wanted in zip(
                ("left", "right"), judged(target, rig, method, renderer), strict=True
            ):
                found = numbers[side][method]
                # Equal input gives equal bytes, so nothing is left to tolerate.
                for name in ("rmse", "psnr_db", "ssim", "gain"):
                    assert found[name] == getattr(wanted, name), (side, method, name)
    assert numbers["throughput"] == 1.0
    assert (numbers["source"], numbers["rig"]) == (str(source), LENSLETS[1])
    assert numbers["left"]["optimal"]["psnr_db"] > numbers["left"]["none"]["psnr_db"] + 3.0


def test_json_and_csv_hold_the_same(done: tuple[Path, Outcome]) -> None:
    folder, outcome = done
    numbers = outcome.json()
    assert numbers.pop("report") == str(folder / "report.html")
    assert numbers == json.loads((folder / "results.json").read_text())
    with (folder / "results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["eye"], row["method"]) for row in rows] == [
        (side, method) for side in ("left", "right") for method in METHODS
    ]
    for row in rows:
        values = numbers[row["eye"]][row["method"]]
        assert float(row["psnr_db"]) == values["psnr_db"]
        acuity = values["acuity"]
        assert row["acuity.logmar"] == ("" if acuity is None else repr(acuity["logmar"]))
        for frequency, kept in values["mtf"].items():
            assert float(row[f"mtf.{frequency}"]) == kept


def test_the_folder_holds_pictures_rigs_and_versions(done: tuple[Path, Outcome]) -> None:
    folder, outcome = done
    assert left_in(folder) == FILES
    versions = outcome.json()["versions"]
    assert {"vrlf", "python", "gpu", "numpy", "scikit-image"} <= versions.keys()
    (rig_file,) = (folder / "rigs").iterdir()
    assert load_rig(rig_file) == load_rig(LENSLETS[1])
    assert tomllib.loads(rig_file.read_text())["left"]["sphere_d"] == -5.0
    seen = list(folder.rglob("left-seen.png"))
    assert len(seen) == 3
    assert all(read_picture(path).shape == (64, 48, 3) for path in seen)
    report = (folder / "report.html").read_text()
    for words in (*versions.values(), "lens_to_panel_mm = 46.0", "Left eye", "Right eye"):
        assert words in report


def test_what_an_eye_reads_and_resolves_gets_better(done: tuple[Path, Outcome]) -> None:
    numbers = done[1].json()
    for side in ("left", "right"):
        none, optimal = numbers[side]["none"], numbers[side]["optimal"]
        # Not even the largest letters that have room are read through the blur.
        assert none["acuity"] is None
        assert optimal["acuity"]["logmar"] <= 1.0
        assert optimal["mtf50"] > none["mtf50"]
        assert none["mtf"]["0"] == 1.0


def test_light_is_what_is_left_of_the_target(source: Path, tmp_path: Path) -> None:
    holes = ("--set", "array.kind=pinhole", "--set", "array.aperture_um=195")
    words = ("--metric", "light", *QUICK, "--rays", "64")
    outcome = require_done(
        call("evaluate", source, *LENSLETS, *holes, *words, "-o", tmp_path, "--json")
    )
    numbers = outcome.json()
    assert numbers["throughput"] == pytest.approx(0.25)  # holes of half the pitch
    for side in ("left", "right"):
        # The eye blurs and the panel's edges leak, but the light of a bare panel is all there.
        assert numbers[side]["none"]["light"] == pytest.approx(1.0, abs=0.1)
        assert 0.15 < numbers[side]["forward"]["light"] < 0.28


def test_the_black_level_is_taken_off_before_the_gain(source: Path, tmp_path: Path) -> None:
    raised = ("--set", "prefilter.black_level=0.2", "--set", "prefilter.brightness=0.8")
    words = ("--method", "forward", "--method", "optimal", *PLAIN)
    numbers = require_done(
        call("evaluate", source, *LENSLETS, *raised, *words, "-o", tmp_path, "--json")
    ).json()
    rig = load_rig(LENSLETS[1], overrides=raised[1::2])
    rig = rig.model_copy(
        update={"prefilter": rig.prefilter.model_copy(update={"method": "optimal"})}
    )
    target = read_picture(source)
    with GpuRenderer() as renderer:
        seen = vrlf.perceive(
            vrlf.prefilter(target, rig, renderer=renderer), rig, rays=RAYS, renderer=renderer
        )
    for side in ("left", "right"):
        wanted = likeness(seen - np.float32(0.2), target, rig, side)
        # The level is taken off in 64 bits there and in 32 here.
        assert numbers[side]["optimal"]["rmse"] == pytest.approx(wanted.rmse, rel=1e-5)
        # 0.8 - 0.2 of the target is what is left of its contrast.
        assert numbers[side]["optimal"]["gain"] == pytest.approx(1.0 / 0.6, rel=0.05)
    # It acts on ``optimal`` alone.
    assert numbers["left"]["forward"]["gain"] < 1.5


def test_several_sources_and_rigs_are_cases(source: Path, tmp_path: Path) -> None:
    words = ("chart:grid", *LENSLETS, *BARE, *PLAIN, "--method", "none", "--method", "forward")
    outcome = require_done(call("evaluate", source, *words, "-o", tmp_path, "--json"))
    cases = outcome.json()["cases"]
    assert [(case["source"], case["rig"]) for case in cases] == [
        (name, rig) for name in (str(source), "chart:grid") for rig in (LENSLETS[1], BARE[1])
    ]
    for case in cases:
        assert case["left"].keys() == {"none", "forward"}
    bare = cases[1]["left"]
    assert bare["none"] == bare["forward"]  # nothing to do for it without an array
    table = call("evaluate", source, *words, "-o", tmp_path)
    assert require_done(table).out.count("forward") == 8
    assert all(len(line) <= 80 for line in table.out.splitlines()[:-1])


# Going on


class Counted:
    """Counts the panel images that are made; fails at one of them."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.methods: list[str] = []
        self.error: BaseException | None = None
        whole = GpuRenderer.prefilter

        def counting(renderer: GpuRenderer, target: Any, rig: Rig) -> Any:
            self.methods.append(rig.prefilter.method)
            if self.error is not None and rig.prefilter.method == "forward":
                raise self.error
            return whole(renderer, target, rig)

        monkeypatch.setattr(GpuRenderer, "prefilter", counting)

    def since(self) -> list[str]:
        """Methods of the panel images made since this was asked last."""
        made, self.methods = self.methods, []
        return made


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> Counted:
    """Counts the panel images that are made."""
    return Counted(monkeypatch)


def test_finished_cases_are_not_computed_again(
    source: Path, tmp_path: Path, counted: Counted
) -> None:
    words: Sequence[str | Path] = (
        *("evaluate", source, *LENSLETS, *PLAIN, *QUICK, "-o", tmp_path, "--json"),
    )
    first = require_done(call(*words))
    assert counted.since() == ["none", "forward"]
    pages = {name: (tmp_path / name).read_bytes() for name in FILES if "." in name}
    again = require_done(call(*words))
    assert counted.since() == []
    assert "2 of 2 cases are finished already" in again.err
    assert again.out == first.out
    assert pages == {name: (tmp_path / name).read_bytes() for name in pages}

    # One whose picture was damaged is computed again; so is all for another rig of that name.
    (damaged,) = tmp_path.glob("cases/*--forward--*/left-seen.png")
    damaged.write_bytes(damaged.read_bytes()[:-20])
    assert require_done(call(*words)).out == first.out
    assert counted.since() == ["forward"]
    other = require_done(call(*words, "--set", "left.pupil_mm=4"))
    assert counted.since() == ["none", "forward"]
    assert other.json()["left"]["none"]["rmse"] < first.json()["left"]["none"]["rmse"]
    more = require_done(call(*words, "--rays", "17"))
    assert counted.since() == ["none", "forward"]
    assert more.out != first.out


def test_other_versions_are_other_cases(
    source: Path, tmp_path: Path, counted: Counted, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ("evaluate", source, *LENSLETS, *PLAIN, "-o", tmp_path, "--method", "none")
    require_done(call(*words))
    monkeypatch.setattr("vrlf.studies.evaluate_report.__version__", "99.0")
    require_done(call(*words))
    assert counted.since() == ["none", "none"]


def test_a_stopped_run_goes_on(source: Path, tmp_path: Path, counted: Counted) -> None:
    words = ("evaluate", source, *LENSLETS, *PLAIN, *QUICK, "-o", tmp_path)
    counted.error = KeyboardInterrupt()
    require_refused(call(*words), 1, "interrupted")
    assert counted.since() == ["none", "forward"]
    assert left_in(tmp_path) == ["cases"]
    counted.error = None
    require_done(call(*words))
    assert counted.since() == ["forward"]


def test_a_case_that_fails_is_listed_and_the_others_go_on(
    source: Path, tmp_path: Path, counted: Counted
) -> None:
    words = ("evaluate", source, *LENSLETS, *PLAIN, *QUICK, "-o", tmp_path, "--json")
    counted.error = RuntimeError("the lamp\nwent out")
    outcome = call(*words)
    assert outcome.status == 1
    (failed,) = outcome.json()["failed"]
    assert (failed["method"], failed["source"]) == ("forward", str(source))
    assert "the lamp went out" in failed["reason"]
    assert outcome.lines[-1].startswith("failed: ")
    assert outcome.lines[-1].endswith("unexpected RuntimeError: the lamp went out")
    assert outcome.json()["left"].keys() == {"none"}
    assert "the lamp went out" in (tmp_path / "report.html").read_text()
    counted.error = None
    counted.since()
    assert require_done(call(*words)).json()["failed"] == []
    assert counted.since() == ["forward"]


def test_a_missing_library_is_named_once(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "flip_evaluator", None)
    outcome = require_done(
        call(
            *("evaluate", source, *LENSLETS, *PLAIN, *QUICK, "--metric", "flip"),
            *("-o", tmp_path, "--json"),
        )
    )
    assert outcome.err.count("vrlf[flip]") == 1
    numbers = outcome.json()
    assert len(numbers["notes"]) == 1
    assert "pip install 'vrlf[flip]'" in numbers["notes"][0]
    assert numbers["left"]["none"].keys() == {"rmse", "psnr_db", "ssim", "gain"}


def test_without_matplotlib_there_are_no_plots(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vrlf.studies.evaluate_report.have_matplotlib", lambda: False)
    outcome = require_done(call("evaluate", source, *LENSLETS, *PLAIN, *QUICK, "-o", tmp_path))
    assert outcome.err.count("vrlf[plots]") == 1
    report = (tmp_path / "report.html").read_text()
    assert "image/svg" not in report
    assert "vrlf[plots]" in report


# What goes wrong


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        ((), ("SOURCE", "vrlf evaluate --help")),
        (("nope.png",), ("nope.png",)),
        (("{source}", "nope.png"), ("nope.png",)),
        (("chart:eiffel",), ("eiffel", "logmar")),
        (("{source}", "chart:eiffel"), ("eiffel", "logmar")),
        (("{source}", "-r", "nope"), ("nope", "matched-microlens")),
        (("{source}", *LENSLETS, "-r", "missing.toml"), ("missing.toml", "no such file")),
        (("{source}", *LENSLETS, "--set", "left.pupil_mm=0"), ("left.pupil_mm", "above 0")),
        (
            ("{source}", *LENSLETS, "--set", "left.pupil_mm=12", "--set", "left.sphere_d=-20"),
            ("border", "left eye", "toml"),
        ),
        (("{source}", "--method", "magic"), ("magic", "optimal")),
        (("{source}", "--metric", "beauty"), ("beauty", "psnr_db")),
        (("{source}", "--rays", "0"), ("--rays",)),
        (("{source}", "scene", *LENSLETS, "--right-source", "x.png"), ("--right-source", "2")),
    ],
)
def test_wrong_input_is_one_line_and_nothing_is_made(
    source: Path, tmp_path: Path, arguments: tuple[str, ...], names: tuple[str, ...]
) -> None:
    words = [word.format(source=source) for word in arguments]
    outcome = call("evaluate", *words, "-o", tmp_path / "out")
    require_refused(outcome, 2, *names)
    assert left_in(tmp_path) == []


def test_no_folder_is_named(source: Path) -> None:
    require_one_line(call("evaluate", source), 2, "--output")


@pytest.mark.parametrize("place", ["file", "file/below", "taken"])
def test_a_wrong_place_is_refused_before_any_work(source: Path, tmp_path: Path, place: str) -> None:
    (tmp_path / "file").write_text("a file")
    (tmp_path / "taken" / "report.html").mkdir(parents=True)
    outcome = call("evaluate", source, *LENSLETS, "-o", tmp_path / place)
    require_one_line(outcome, 2, place.split("/")[-1], "wanted")
    assert left_in(tmp_path) == ["file", "taken"]
    assert left_in(tmp_path / "taken") == ["report.html"]


def test_a_disk_that_fills_up_leaves_whole_cases(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, counted: Counted
) -> None:
    written: list[int] = []

    def full_after_ten(descriptor: int, data: Any) -> int:
        written.append(descriptor)
        if len(written) > 10:
            raise OSError(28, "No space left on device")
        return write(descriptor, data)

    write = os.write
    words = ("evaluate", source, *LENSLETS, *PLAIN, *QUICK, "-o", tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(vrlf.files.os, "write", full_after_ten)
        require_refused(call(*words), 1, "No space left", "wanted")
    assert left_in(tmp_path) == ["cases"]
    assert not list(tmp_path.rglob(".vrlf-*"))
    assert counted.since() == ["none", "forward"]
    # The first case was whole and is kept; the second had pictures but no record.
    require_done(call(*words))
    assert counted.since() == ["forward"]


def test_the_report_shows_what_was_seen(done: tuple[Path, Outcome], source: Path) -> None:
    (target,) = done[0].glob("cases/*--target--*/right.png")
    codes = np.rint(srgb_encode(read_picture(target).astype(np.float64)) * 255.0)
    wanted = np.rint(srgb_encode(read_picture(source)[:, 48:].astype(np.float64)) * 255.0)
    # A hair beyond half a code for the GPU's float32 power.
    assert np.abs(codes - wanted).max() <= 1
