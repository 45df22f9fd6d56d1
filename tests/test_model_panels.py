"""Panels of real phones and headsets, and what a rig says of its panel."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from vrlf.errors import RigError
from vrlf.model import Panel, load_rig, rig_from_tables
from vrlf.model.reading import load_rig_text
from vrlf.model.saving import rig_of_text
from vrlf.model.shelf import names_on
from vrlf.resources import assets_dir

RIG = """
[panel]
width_px = 90
height_px = 40
pixel_pitch_um = 60.0
peak_nit = 80.0
wavelengths_nm = [620.0, 530.0, 450.0]
primaries = { red = [0.7, 0.3], green = [0.2, 0.7], blue = [0.1, 0.1], white = [0.3, 0.3] }

[headset]
lens_to_panel_mm = 46.0

[left]
sphere_d = -1.0

[right]
sphere_d = -2.0
"""


@pytest.mark.parametrize("name", names_on("panels"))
def test_every_shipped_panel_is_whole_and_says_where_it_is_from(name: str) -> None:
    panel = load_rig("bare", overrides=[f"panel.extends={name}"]).panel
    text = (assets_dir() / "panels" / f"{name}.toml").read_text(encoding="utf-8")
    assert panel.width_px > panel.height_px
    # The published density, in the file's own words.
    density = 25_400.0 / panel.pixel_pitch_um
    quoted = [word for word in text.split() if word.isdigit() and abs(int(word) - density) < 1.0]
    assert quoted, f"{name}: {density:.1f} ppi"
    assert ".com" in text or ".de" in text


def test_a_panel_takes_the_place_of_the_whole_panel_below(tmp_path: Path) -> None:
    (tmp_path / "below.toml").write_text(RIG)
    (tmp_path / "rig.toml").write_text(
        'extends = "below.toml"\n[panel]\nextends = "quest-2"\nbits = 10\n'
    )
    panel = load_rig(tmp_path / "rig.toml").panel
    assert (panel.width_px, panel.height_px, panel.peak_nit) == (3664, 1920, 100.0)
    assert panel.bits == 10
    # Nothing of the panel below shines through.
    assert panel.wavelengths_nm == (610.0, 545.0, 465.0)
    assert panel.primaries is None


def test_what_a_file_says_of_its_own_panel_wins_whatever_comes_first(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(RIG.replace("peak_nit", 'extends = "iphone-6"\npeak_nit'))
    rig = load_rig(tmp_path / "rig.toml")
    assert (rig.panel.width_px, rig.panel.peak_nit) == (90, 80.0)
    assert rig.panel.subpixels == "rgb-stripe"


def test_on_the_command_line_a_later_change_wins() -> None:
    first = load_rig("bare", overrides=["panel.bits=10", "panel.extends=iphone-x"])
    second = load_rig("bare", overrides=["panel.extends=iphone-x", "panel.bits=10"])
    assert (first.panel.bits, second.panel.bits) == (8, 10)
    assert first.panel.subpixels == second.panel.subpixels == "pentile-diamond"


@pytest.mark.parametrize("name", ["iphone-7", 6, ["iphone-6"]])
def test_an_unknown_panel_is_one_line(name: Any) -> None:
    with pytest.raises(RigError, match=r"panel\.extends: found .*wanted a path .*one of") as caught:
        rig_from_tables({"panel": {"extends": name}})
    assert len(caught.value.problems) == 1


def test_a_rig_with_a_shipped_panel_is_saved_by_what_differs(tmp_path: Path) -> None:
    text = 'extends = "bare"\n\n[panel]\nextends = "galaxy-s4" # mine\n'
    path = tmp_path / "rig.toml"
    rig = load_rig_text(text, path)
    brighter = rig.model_copy(update={"panel": rig.panel.model_copy(update={"peak_nit": 300.0})})
    after = rig_of_text(text, path, brighter)
    assert after == text + "peak_nit = 300.0\n"


@pytest.mark.parametrize(
    ("key", "value", "wanted"),
    [
        ("peak_nit", 0.0, "a number from 1 to 100000"),
        ("bits", 9, "one of 8, 10"),
        ("primaries", {"red": [0.1, 0.2, 0.3]}, "a list of 2 numbers from 0 to 1"),
        ("primaries", [0.3, 0.3], "a table [panel.primaries]"),
    ],
)
def test_an_impossible_panel_is_one_line_a_key(key: str, value: Any, wanted: str) -> None:
    size = {"width_px": 60, "height_px": 30, "pixel_pitch_um": 78.0}
    with pytest.raises(RigError) as caught:
        rig_from_tables({"panel": size | {key: value}})
    problems = [each for each in caught.value.problems if each.startswith(f"panel.{key}")]
    assert problems[0].endswith(f"wanted {wanted}")


def test_a_panel_that_says_nothing_has_eight_bits() -> None:
    panel = Panel(width_px=60, height_px=30, pixel_pitch_um=78.0)
    assert (panel.bits, panel.peak_nit, panel.primaries) == (8, 500.0, None)
