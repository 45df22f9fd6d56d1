"""``vrlf design`` as a user runs it, on very little effort."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import pytest
from command_runs import call, left_in, require_done, require_one_line

from vrlf.app import designing
from vrlf.model import load_rig
from vrlf.studies.design.design import Task
from vrlf.studies.design.search import Effort

# One candidate and what follows it, whatever the effort is called.
LEAST = Effort(grid=1, trials=0, turned=0, polished=0)
NARROW = ("--pitch", "390", "--gap", "3", "--turn", "10", "--brightness", "1", "--workers", "1")


@pytest.fixture(autouse=True)
def _little(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(designing._EFFORTS, "quick", LEAST)
    monkeypatch.setattr(designing, "Task", partial(Task, judged_px=16, fine_px=16))


def test_a_search_leaves_a_rig_and_pictures(tmp_path: Path) -> None:
    """Checked by the whole chain on a chart, on a panel of 132 x 66 pixels."""
    folder = tmp_path / "found"
    options = ("--effort", "quick", "--check", "chart:siemens", "--panel", "132x66")
    command = ("design", "-r", "matched-full", *NARROW, *options, "-o", folder, "--json")
    told = require_done(call(*command)).json()
    names = ["best.toml", "design.json", "map.png", "sensitivity.png"]
    assert left_in(folder) == names
    assert json.loads((folder / "design.json").read_text(encoding="utf-8")) == told
    best = load_rig(str(folder / "best.toml"))
    assert best.array.pitch_um == 390.0
    assert best.prefilter.method == "optimal"
    assert best.panel == load_rig("matched-full").panel
    checked = told["best"][0]["checked"]["psnr_db"]
    assert checked > told["before"]["bare"]["checked"]["psnr_db"] + 2.0
    assert told["picture"] == "chart:siemens"
    assert -1.0 <= told["rank_correlation"] <= 1.0


def test_it_says_a_table(tmp_path: Path) -> None:
    path = tmp_path / "best.toml"
    options = ("--effort", "quick", "--check", "none", "-o", path)
    outcome = require_done(call("design", "-r", "matched-full", *NARROW, *options))
    for word in ("pitch um", "390.0", "bare", "given", "at most 0.5 dB is lost"):
        assert word in outcome.out
    assert left_in(tmp_path) == ["best.toml"]


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("--pitch", "wide"), ("--pitch", "'wide'", "300..800")),
        (("--pitch", "800..300"), ("pitch_um", "the smaller one first")),
        (("--gap", "1..60"), ("gap_mm", "60", "lens_to_panel_mm")),
        (("--gap", "nan"), ("gap_mm", "nan")),
        (("--arrays", "mla9000"), ("--arrays", '"mla9000"', "mla150-7ar")),
        (("--spacers", "thick"), ("--spacers", '"thick"', "acrylic-3")),
        (("--arrays", "fresnel-630", "--kind", "pinhole"), ("--arrays", "--kind pinhole")),
        (("--barriers", "perpendicular", "--robust", "mean"), ("--barriers", "--robust mean")),
        (("--barriers", "paper"), ("barriers", "paper")),
        (("--limits", "nowhere.toml"), ("nowhere.toml", "found no such file")),
        (("-o", "best.png"), ("best.png", "wanted a folder or a .toml")),
        (("-o", "nowhere/best.toml"), ("nowhere", "found no folder")),
        (("-r", "no-such-rig"), ("no-such-rig",)),
        (("--seed", "-1"), ("--seed", "'-1'")),
    ],
)
def test_a_wrong_input_is_one_line(
    arguments: tuple[str, ...],
    named: tuple[str, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    options = ("--check", "none", "--workers", "1")
    require_one_line(call("design", *options, *arguments), 2, *named)
    assert left_in(tmp_path) == []


def test_limits_come_from_a_file_and_options_win(tmp_path: Path) -> None:
    path = tmp_path / "limits.toml"
    path.write_text('pitch_um = [400.0, 500.0]\nbarriers = ["converging"]\n', encoding="utf-8")
    names = ("gap", "focal", "hole", "turn", "brightness", "arrays", "spacers")
    options: dict[str, object] = dict.fromkeys(names)
    found = designing.limits_of(
        {**options, "limits": str(path), "pitch": [450.0, 450.0], "barriers": ()}
    )
    assert found.pitch_um == (450.0, 450.0)
    assert found.barriers == ("converging",)
    path.write_text("pitches = 3\n", encoding="utf-8")
    require_one_line(
        call("design", "--limits", path, "--check", "none"), 2, "pitches", "unknown key"
    )


def test_a_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(designing, "find_spec", lambda _: None)
    require_one_line(
        call("design", "--check", "none"), 2, "no optuna", "pip install 'vrlf[design]'"
    )
