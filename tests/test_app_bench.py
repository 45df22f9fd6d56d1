"""``vrlf bench`` and its commands, on panels small enough to wait for."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from command_runs import LENSLETS, call, left_in, require_done, require_one_line

import vrlf.studies.bench as bench
from vrlf.errors import InputError
from vrlf.gpu import Device
from vrlf.studies import plots, speed
from vrlf.studies.limits import Limits
from vrlf.studies.steps import Step
from vrlf.studies.workloads import Stage

SIZES = ((96, 64), (120, 80))


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two small panels instead of the three that take minutes."""
    whole = bench.run_bench

    def run_small(device: Device, **options: object) -> bench.BenchReport:
        return whole(device, sizes=SIZES, budget_s=1.0, **options)  # type: ignore[arg-type]

    monkeypatch.setattr("vrlf.app.benching.run_bench", run_small)


@pytest.mark.usefixtures("small")
def test_bench_has_the_names_that_scripts_rely_on() -> None:
    outcome = require_done(call("bench", *LENSLETS, "--rays", "4", "--runs", "3", "--json"))
    report = outcome.json()
    assert isinstance(report["device"], str)
    for result in report["results"]:
        assert {"name", "panel", "ms", "p95_ms", "runs"} <= result.keys()
        assert 0.0 <= result["ms"] <= result["p95_ms"]
        assert result["runs"] == 3
    names = {result["name"] for result in report["results"]}
    assert {"prepare", "forward", "perceive", "encode"} <= names
    assert {result["panel"] for result in report["results"]} == {"96x64", "120x80"}
    # Progress, a line for each result, goes to standard error.
    assert len(outcome.lines) == len(report["results"])


@pytest.mark.usefixtures("small")
def test_bench_says_it_in_a_table() -> None:
    outcome = require_done(call("bench", *LENSLETS, "--rays", "4", "--runs", "3"))
    assert re.search(r"96x64 +\w+", outcome.out)
    assert re.search(r"perceive.* [0-9.]+ ", outcome.out)
    assert all(len(line) <= 80 for line in outcome.out.splitlines())


# bench speed


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Limits that are given and the passes around the prefilter alone."""
    monkeypatch.setattr(speed, "measured_limits", lambda _: Limits(2.0, 0.5))
    monkeypatch.setattr(speed, "GROUPS", speed.GROUPS[:1])


@pytest.mark.usefixtures("quick")
def test_speed_keeps_numbers_and_a_plot(tmp_path: Path) -> None:
    plot = tmp_path / "speed.png"
    sizes = ("--sizes", "40x24,64x40,600x400", "--max-megapixels", "0.01")
    outcome = require_done(
        call("bench", "speed", *LENSLETS, *sizes, "--runs", "2", "--json", "--plot", plot)
    )
    report = outcome.json()
    assert report["limits"] == {"copy_gb_per_s": 2.0, "fetch_g_per_s": 0.5}
    assert [(r["panel"], r["name"]) for r in report["results"]] == [
        (panel, name) for panel in ("40x24", "64x40") for name in ("prepare", "encode")
    ]
    assert all(result["runs"] == 2 for result in report["results"])
    assert plot.read_bytes().startswith(b"\x89PNG")


@pytest.mark.usefixtures("quick")
def test_speed_says_it_in_a_table() -> None:
    outcome = require_done(call("bench", "speed", *LENSLETS, "--sizes", "40X24", "--runs", "1"))
    assert re.search(r"40x24 +prepare +[0-9.]+ .* %", outcome.out)
    assert all(len(line) <= 80 for line in outcome.out.splitlines())


@pytest.mark.parametrize(
    ("arguments", "panels"),
    [
        # What software GL has no patience for is measured only where it is asked for.
        ([], ["667x375", "1334x750"]),
        (["--max-megapixels", "0.3"], ["667x375"]),
        (["--sizes", "2000x800"], ["2000x800"]),
    ],
)
def test_default_sizes_end_where_software_gl_gets_slow(
    arguments: list[str], panels: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def one(stage: Stage, _: ExitStack) -> Iterator[Step]:
        yield stage.timed("step", lambda: None, 2)

    monkeypatch.setattr(speed, "measured_limits", lambda _: Limits(2.0, 0.5))
    monkeypatch.setattr(speed, "GROUPS", (one,))
    monkeypatch.setattr("vrlf.app.benching.default_megapixels", lambda _: 1.1)
    report = require_done(call("bench", "speed", *arguments, "--runs", "1", "--json")).json()
    assert [result["panel"] for result in report["results"]] == panels


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--sizes", "40"], ["--sizes", "'40'", "440x220"]),
        (["--sizes", "40x24,0x3"], ["--sizes", "'0x3'"]),
        (["--sizes", "40x-24"], ["--sizes", "'40x-24'"]),
        (["--sizes", ""], ["--sizes", "''"]),
        (["--max-megapixels", "nan"], ["--max-megapixels", "'nan'"]),
        (["--max-megapixels", "0"], ["--max-megapixels", "'0'"]),
        (["--max-megapixels", "much"], ["--max-megapixels", "'much'"]),
        (["--runs", "0"], ["--runs", "'0'", "from 1"]),
        (["--rays", "x"], ["--rays", "'x'"]),
        (["-r", "no-such-rig"], ["no-such-rig"]),
        (["--max-megapixels", "1e-4"], ["sizes", "0.0001 megapixels"]),
        (["--plot", "speed.pdf"], ["speed.pdf", ".png or .svg"]),
        (["--plot", "nowhere/speed.png"], ["nowhere/speed.png", "found no folder"]),
        (["--plot", ""], ["'none'"]),
    ],
)
def test_speed_refuses_in_one_line(arguments: list[str], named: list[str]) -> None:
    require_one_line(call("bench", "speed", *arguments), 2, *named)


@pytest.mark.parametrize("command", ["speed", "quality"])
def test_a_plot_wants_matplotlib_before_anything_is_measured(
    command: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(plots, "find_spec", lambda _: None)
    outcome = call("bench", command, "--plot", tmp_path / "plot.png")
    require_one_line(outcome, 2, "--plot", "matplotlib", "vrlf[plots]")
    assert left_in(tmp_path) == []


# bench quality

SMALL_QUALITY = ("bench", "quality", *LENSLETS, "--panel", "132x66", "--rays", "16")


def test_quality_keeps_numbers_and_a_plot(tmp_path: Path) -> None:
    plot = tmp_path / "quality.svg"
    chart = ("--source", "chart:siemens", "--iterations", "1", "--iterations", "3")
    report = require_done(call(*SMALL_QUALITY, *chart, "--json", "--plot", plot)).json()
    assert (report["panel"], report["rays"]) == ("132x66", 16)
    assert [(r["method"], r["iterations"]) for r in report["results"]] == [
        ("none", None),
        ("forward", None),
        ("forward + wiener", None),
        ("optimal", 1),
        ("optimal", 3),
    ]
    assert all(r["picture"] == "chart:siemens" for r in report["results"])
    assert b"<svg" in plot.read_bytes()[:1000]


def test_full_is_the_rigs_own_panel(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = dict[str, Any]()

    def spy(_: Any, rigs: Any, *__: Any, **___: Any) -> None:
        sizes.update({n: (r.panel.width_px, r.panel.height_px) for n, r in rigs.items()})
        raise InputError("enough: nothing is to be measured")

    monkeypatch.setattr("vrlf.app.judging.run_quality", spy)
    call("bench", "quality", "-r", "bare", "--full")
    assert sizes == {"bare": (1334, 750)}
    call("bench", "quality", "-r", "bare")
    assert sizes == {"bare": (440, 220)}


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["-r", "no-such-rig"], ["no-such-rig"]),
        (["--iterations", "-3"], ["--iterations", "'-3'"]),
        (["--panel", "440"], ["--panel", "'440'"]),
        (["--panel", "440x"], ["--panel", "'440x'"]),
        (["--panel", "9999999x2"], ["--panel", "'9999999x2'"]),
        (["--panel", "440x220", "--full"], ["--full", "--panel"]),
        (["--plot", "quality.jpg"], ["quality.jpg", ".png or .svg"]),
        (["--plot", "nowhere/quality.svg"], ["found no folder"]),
        (["--full", "--converged", "--source", "chart:grid"], ["1334x750", "100000"]),
    ],
)
def test_quality_refuses_in_one_line(arguments: list[str], named: list[str]) -> None:
    require_one_line(call("bench", "quality", *arguments), 2, *named)


def test_quality_refuses_a_picture_that_is_not_there() -> None:
    outcome = call(*SMALL_QUALITY, "--source", "nowhere.png")
    assert outcome.status == 2
    assert "nowhere.png" in outcome.lines[-1]


# bench frames


def test_frames_measures_cold_and_warm() -> None:
    report = require_done(
        call(
            *("bench", "frames", *LENSLETS, "--panel", "132x66", "--rays", "16"),
            *("--source", "chart:siemens", "--cut-to", "chart:grid"),
            *("--steps", "1", "--frames", "2", "--json"),
        )
    ).json()
    assert {result["start"] for result in report["results"]} == {"cold", "warm"}
    assert all(len(result["psnr_db"]) == 2 for result in report["results"])


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["-r", "no-such-rig"], ["no-such-rig"]),
        (["--frames", "1"], ["--frames", "'1'", "from 2"]),
        (["--steps", "-1"], ["--steps", "'-1'"]),
        (["--panel", "axb"], ["--panel", "'axb'"]),
        (["--rays", "0"], ["--rays", "'0'"]),
        (["--cut-to", "chart:nothing"], ["nothing"]),
    ],
)
def test_frames_refuses_in_one_line(arguments: list[str], named: list[str]) -> None:
    quick = ("bench", "frames", "--source", "chart:grid", "--panel", "132x66")
    outcome = call(*quick, *arguments)
    require_one_line(outcome, 2, *named)
