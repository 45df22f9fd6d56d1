"""``vrlf bench tolerance``: its table and numbers, and wrong input."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_runs import call, require_done, require_one_line

QUICK = ("bench", "tolerance", "--panel", "110x60", "--cases", "2")
# Few cases: tables are made in a fraction of the time.
RIG = """extends = "matched-full"
[tolerance]
array_um = 15.0
pupil_shift_mm = 1.0
pupil_mm = [4.0, 6.0]
focus_d = 0.25
draws = 3
"""


def test_it_says_what_a_tolerance_gains_and_costs(tmp_path: Path) -> None:
    (tmp_path / "off.toml").write_text(RIG)
    named = ("-r", str(tmp_path / "off.toml"))
    outcome = call(*QUICK, *named, "--iterations", "6", "--rays", "32", "--json")
    require_done(outcome)
    results = {each["method"]: each for each in outcome.json()["results"]}
    assert list(results) == ["bare", "plain", "tolerant"]
    for each in results.values():
        assert each["worst_db"] <= each["mean_db"]
    # Corrected is sharper than bare where nothing is off, and only what was solved took time.
    assert results["plain"]["nominal_db"] > results["bare"]["nominal_db"] + 3.0
    assert results["tolerant"]["nominal_db"] > results["bare"]["nominal_db"] + 3.0
    (gain,) = outcome.json()["gains"]
    plain, tolerant = results["plain"], results["tolerant"]
    assert gain["cost_db"] == plain["nominal_db"] - tolerant["nominal_db"]
    assert gain["mean_db"] == tolerant["mean_db"] - plain["mean_db"]
    assert gain["worst_db"] == tolerant["worst_db"] - plain["worst_db"]
    assert results["bare"]["ms"] is None
    assert results["plain"]["ms"] > 0.0


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (("-r", "matched-full", "--cases", "0"), "--cases"),
        (
            ("-r", "matched-full", "--panel", "20x10"),
            "--panel: found viewports of 10x10 pixels",
        ),
        (("-r", "nope"), 'rig: found the unknown name "nope"'),
        (("-r", "matched-full", "--source", "missing.jpg"), "missing.jpg: found no such file"),
    ],
)
def test_wrong_input_is_one_line(wrong: tuple[str, ...], said: str) -> None:
    outcome = call(*QUICK, *wrong)
    require_one_line(outcome, 2, said)
