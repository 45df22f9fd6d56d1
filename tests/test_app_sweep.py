"""``vrlf sweep`` as a command: the whole way once, and each thing that can be wrong with it."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import Any

import pytest
from command_runs import DATA, call, require_one_line, require_refused
from pyarrow import parquet

from vrlf.studies.sweep.rows import checksum

SPEC = f"""
rig = "{DATA / "lenslets-turned.toml"}"
sources = "chart:siemens"
methods = ["none", "forward"]
rays = 4
panel_px = [96, 64]
[grid]
left.pupil_mm = [-1.0, 2.0]
"""


def spec(folder: Path, text: str = SPEC) -> Path:
    """The file."""
    path = folder / "spec.toml"
    path.write_text(text)
    return path


def test_a_sweep_is_done_lists_what_failed_and_is_not_done_again(tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = ("sweep", spec(tmp_path), "-o", out, "--json")
    first = call(*command, "--workers", "1")
    # Half the jobs have a pupil that none can have: they are listed, the others are there.
    assert first.status == 1
    told = first.json()
    assert (told["jobs"], told["rows"], told["computed"], told["kept"]) == (4, 2, 2, 0)
    assert [each["index"] for each in told["failed"]] == [0, 1]
    assert "left.pupil_mm: found -1.0, wanted" in told["failed"][0]["reason"]
    assert first.lines[-1].startswith("vrlf: sweep: found 2 of 4 jobs failed")
    assert any(line.startswith("job 0 failed: ") for line in first.lines)

    rows = parquet.read_table(out / "results.parquet").to_pylist()
    assert [(row["index"], row["method"]) for row in rows] == [(2, "none"), (3, "forward")]
    assert [row["checksum"] for row in rows] == [checksum(row) for row in rows]
    assert rows[0]["left_psnr_db"] != rows[1]["left_psnr_db"]
    failures = [json.loads(line) for line in (out / "failures.jsonl").read_text().splitlines()]
    assert [each["index"] for each in failures] == [0, 1]

    # The same command finds all of it there: no worker is started for it.
    again = call(*command).json()
    assert (again["rows"], again["computed"], again["kept"]) == (2, 0, 2)
    other = spec(tmp_path, SPEC.replace("rays = 4", "rays = 5"))
    require_one_line(call("sweep", other, "-o", out), 2, "another sweep's results", "--restart")


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("sources = []", ("sources: found none, wanted at least one",)),
        ("surces = 'scene'", ("surces: found an unknown key", '"sources"')),
        (SPEC + "\nboth.gap = { from = 1, to = 1, count = 2 }", ("grid.both.gap", "empty range")),
        (SPEC.replace("pupil_mm", "pupil_m"), ("left.pupil_m: found an unknown key", "pupil_mm")),
        (SPEC.replace("[-1.0, 2.0]", "['wide']"), ("left.pupil_mm: found ", "wanted a number")),
        (SPEC.replace("chart:siemens", "chart:simens"), ("'simens'", "siemens")),
        (SPEC.replace("chart:siemens", "no-such.png"), ("no-such.png", "no such file")),
        (SPEC.replace("rays = 4", "metrics = 'beauty'"), ("'beauty'", "psnr_db")),
        (SPEC.replace("lenslets-turned", "nowhere"), ("nowhere.toml", "no such file")),
        ("sources = ", ("syntax error",)),
    ],
)
def test_a_wrong_file_is_one_line_and_makes_nothing(
    tmp_path: Path, text: str, names: tuple[str, ...]
) -> None:
    require_one_line(call("sweep", spec(tmp_path, text), "-o", tmp_path / "out"), 2, *names)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("address", "reason"),
    # Port 9 of the loopback: nobody listens.
    [("tcp://127.0.0.1:9", "127.0.0.1:9"), ("nonsense", "port"), ("foo://host:1", "scheme")],
)
def test_an_unreachable_scheduler_is_one_line_and_makes_nothing(
    tmp_path: Path, address: str, reason: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vrlf.studies.sweep.cluster._CONNECT_S", 0.5)
    given = ("sweep", spec(tmp_path), "-o", tmp_path / "out", "--scheduler", address)
    require_one_line(call(*given), 2, "--scheduler: found no answer from", reason, "tcp://host:")
    assert not (tmp_path / "out").exists()


def test_workers_beside_a_scheduler_are_refused(tmp_path: Path) -> None:
    given = ("sweep", spec(tmp_path), "-o", tmp_path / "out", "--workers", "2")
    require_one_line(call(*given, "--scheduler", "tcp://127.0.0.1:9"), 2, "--workers")
    require_one_line(call("sweep", spec(tmp_path)), 2, "--output")
    require_one_line(call(*given[:-1], "0"), 2, "found '0', wanted a whole number from 1")


def test_a_missing_extra_is_named_with_its_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    find = importlib.util.find_spec

    def without(name: str, *more: Any) -> Any:
        return None if name in ("distributed", "pyarrow") else find(name, *more)

    monkeypatch.setattr(importlib.util, "find_spec", without)
    outcome = call("sweep", spec(tmp_path), "-o", tmp_path / "out")
    require_one_line(outcome, 1, "no distributed and no pyarrow", "pip install 'vrlf[sweep]'")


def test_ctrl_c_says_how_to_go_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("vrlf.app.sweeping.run_sweep", interrupted)
    outcome = call("sweep", spec(tmp_path), "-o", tmp_path / "out")
    require_refused(outcome, 1, "interrupted; 0 of 4 jobs are kept", "the same command goes on")


def test_an_output_that_is_a_file_is_refused(tmp_path: Path) -> None:
    path = spec(tmp_path)
    require_one_line(call("sweep", path, "-o", path), 2, "found a file of that name")
