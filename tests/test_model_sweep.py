"""A sweep's file: what it may say, and one line for what it may not."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from vrlf.errors import RigError
from vrlf.model.sweep import SweepSpec, places, read_sweep, sweep_from_tables


def spec(text: str) -> SweepSpec:
    """A sweep of one chart."""
    return sweep_from_tables(tomllib.loads(f'sources = "chart:siemens"\n{text}'), source="a.toml")


def test_grid_and_sample_are_counted_and_written_either_way() -> None:
    found = spec(
        """
        methods = ["none", "optimal"]
        [grid]
        array.gap_mm = { from = 4, to = 8, count = 5 }
        "both.sphere_d" = [-5.0, -3.5]
        array.offset_um = [[0.0, 0.0], [10.0, -20.0], [5.0, 5.0]]
        [sample]
        count = 7
        "left.pupil_mm" = { from = 2, to = 6 }
        array.pitch_um = { from = 200.0, to = 800.0, log = true }
        """
    )
    assert found.count == 2 * 5 * 2 * 3 * 7
    assert found.grid["array.gap_mm"] == (4, 5, 6, 7, 8)
    assert all(isinstance(value, int) for value in found.grid["array.gap_mm"])
    assert found.sample is not None
    assert list(found.sample.keys) == ["left.pupil_mm", "array.pitch_um"]
    assert found.sample.keys["array.pitch_um"].log


def test_a_range_meets_both_ends_and_steps_evenly() -> None:
    found = spec("[grid]\nleft.sphere_d = { from = -1.0, to = 0.5, count = 4 }")
    assert found.grid["left.sphere_d"] == (-1.0, -0.5, 0.0, 0.5)


def test_both_is_left_and_right() -> None:
    assert places("both.pupil_mm") == [("left", "pupil_mm"), ("right", "pupil_mm")]
    assert places('left.zernike.coefficients_um."2,0"') == [
        ("left", "zernike", "coefficients_um", "2,0")
    ]


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("ray = 3", 'ray: found an unknown key, wanted "rays"'),
        ('methods = ["best"]', "methods: found ["),
        ("methods = []", "methods: found none, wanted at least one"),
        ("rays = 0", "rays: found 0, wanted a whole number"),
        ("panel_px = [220]", "panel_px: found [220], wanted width and height"),
        ("grid = 3", "grid: found 3, wanted a table [grid]"),
        ("[grid]\narray.gap_mm = []", "grid.array.gap_mm: found an empty list"),
        ("[grid]\narray.gap_mm = 4", "grid.array.gap_mm: found 4, wanted a list of values or"),
        ("[grid]\narray.gap_mm = [4, 4]", "wanted each value once"),
        ("[grid]\narray.gap_mm = [nan]", "grid.array.gap_mm: found [nan]"),
        (
            "[grid]\narray.gap_mm = { from = 4, to = 4, count = 3 }",
            "grid.array.gap_mm: found an empty range from 4 to 4, wanted from below to",
        ),
        ("[grid]\narray.gap_mm = { from = 4, to = 5, count = 1 }", "gap_mm.count: found 1"),
        ("[grid]\narray.gap_mm = { from = 4, to = 5, step = 1 }", "found an unknown key"),
        ("[grid]\narray.gap_mm = { from = 4, count = 2 }", "gap_mm.to: found nothing"),
        ("[grid]\narray = [1]", 'found "array", wanted a key of the rig with its table'),
        ('[grid]\n"a b.c" = [1]', "wanted a key of the rig with its table"),
        (
            "[grid]\nboth.sphere_d = [1]\nleft.sphere_d = [2]",
            "left.sphere_d: found it beside both.sphere_d, wanted each key once",
        ),
        ("[sample]\ncount = 3", "sample: found no key to sample"),
        ("[sample]\ncount = 0\nleft.pupil_mm = { from = 2, to = 3 }", "sample.count: found 0"),
        ("[sample]\nleft.pupil_mm = { from = 2, to = 3 }", "sample.count: found nothing"),
        ("[sample]\ncount = 2\nleft.pupil_mm = { from = 3, to = 2 }", "found an empty range"),
        (
            "[sample]\ncount = 2\nleft.sphere_d = { from = -3, to = 2, log = true }",
            "sample.left.sphere_d.from: found -3, wanted a number above 0 beside log",
        ),
        ("panel_px = [9, 9]\n[grid]\npanel.width_px = [5]", "panel_px: found it beside"),
        (
            "[grid]\nleft.pupil_mm = { from = 1.0, to = 2, count = 100000 }\n"
            "right.pupil_mm = { from = 1.0, to = 2, count = 100000 }",
            "grid: found 30000000000 jobs, wanted at most",
        ),
    ],
)
def test_what_is_wrong_is_named_in_one_line(text: str, complaint: str) -> None:
    with pytest.raises(RigError) as caught:
        spec(text)
    assert str(caught.value).startswith("a.toml: ")
    assert complaint in str(caught.value)
    assert "\n" not in str(caught.value)


def test_no_sources_and_no_file_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RigError, match="sources: found none, wanted at least one"):
        sweep_from_tables({"sources": []})
    with pytest.raises(RigError, match="sources: found nothing"):
        sweep_from_tables({})
    with pytest.raises(RigError, match="found no such file, wanted a sweep's file"):
        read_sweep(tmp_path / "none.toml")
