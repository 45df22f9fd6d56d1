"""``vrlf bench`` on panels small enough to wait for."""

from __future__ import annotations

import re

import pytest
from command_runs import LENSLETS, call, require_done

import vrlf.studies.bench as bench
from vrlf.gpu import Device

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
