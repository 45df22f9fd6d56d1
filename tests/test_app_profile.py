"""``vrlf profile``: what it says, and the rig it writes."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_runs import call, left_in, require_done, require_one_line
from test_model_cardboard import message, text_of

from vrlf.model import load_rig

V1 = "g.co/cardboard"


def test_what_it_says() -> None:
    text = require_done(call("profile", V1)).out
    for part in ("Google, Inc. Cardboard v1", "42 mm", "60 mm", "35 mm", "k1 0.441, k2 0.156"):
        assert part in text
    # 750 rows of 78 um are 58.5 mm: 35 mm from the edge is 5.75 above the middle.
    assert "+5.75 mm" in text


def test_in_json() -> None:
    found = require_done(call("profile", V1, "--bezel-mm", "3", "--json")).json()
    assert found["headset"] == {
        "lens_to_panel_mm": 42.0,
        "lens_separation_mm": 60.0,
        "lens_height_mm": 2.75,
        "distortion": [0.441, 0.156],
    }
    assert found["field_of_view_deg"] == {"outer": 40.0, "inner": 40.0, "bottom": 40.0, "top": 40.0}
    # tan 40 deg = 0.8391 = r (1 + 0.441 r^2 + 0.156 r^4) at r = 0.67874; times 42 mm.
    assert found["field_on_panel_mm"]["inner"] == pytest.approx(28.5069, abs=1e-4)
    shown = 0.678736 * (1 + 0.441 * 0.678736**2 + 0.156 * 0.678736**4)
    assert shown == pytest.approx(0.8391, abs=1e-4)


def test_the_rig_it_writes(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    outcome = require_done(call("profile", V1, "-o", file))
    assert "mine.toml" in outcome.err
    rig = load_rig(file)
    assert (rig.headset.lens_to_panel_mm, rig.headset.lens_height_mm) == (42.0, 5.75)
    assert rig.headset.distortion == (0.441, 0.156)
    assert rig.array == load_rig("matched-microlens").array
    assert left_in(tmp_path) == ["mine.toml"]


def test_beside_a_rig_of_ones_own(tmp_path: Path) -> None:
    (tmp_path / "rigs").mkdir()
    own = tmp_path / "phone.toml"
    own.write_text('extends = "bare"\n[panel]\nheight_px = 1000\npixel_pitch_um = 50.0\n')
    file = tmp_path / "rigs" / "viewer.toml"
    require_done(call("profile", V1, "-r", own, "-o", file, "--bezel-mm", "2"))
    assert 'extends = "../phone.toml"' in file.read_text()
    assert load_rig(file).headset.lens_height_mm == 8.0


def test_a_field_that_the_lens_does_not_reach() -> None:
    """r - r^3 is at most 0.385: 40 degrees are 0.839."""
    source = text_of(message(f7=[-1.0, 0.0], f5=[20.0, 40.0, 20.0, 20.0]))
    found = require_done(call("profile", source, "--json")).json()
    assert found["field_on_panel_mm"]["inner"] is None
    assert found["field_on_panel_mm"]["outer"] > 0.0
    require_done(call("profile", source))


@pytest.mark.parametrize("name", ["Evil \x1b[2J\nsecond", "\u202eabc"])
def test_a_makers_name_is_only_text(tmp_path: Path, name: str) -> None:
    """It stands in a comment of the file and on the screen: nothing in it may act there."""
    file = tmp_path / "mine.toml"
    source = text_of(message(f1=name.encode()))
    outcome = require_done(call("profile", source, "-o", file))
    assert "\x1b" not in outcome.out
    assert "\u202e" not in outcome.out
    assert load_rig(file).headset.lens_to_panel_mm == 39.5


def test_faults(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    require_one_line(call("profile", "https://example.com", "-o", file), 2, "profile", "example")
    require_one_line(call("profile", V1, "-o", tmp_path / "mine.txt"), 2, ".toml")
    require_one_line(call("profile", V1, "-o", tmp_path / "no" / "a.toml"), 2, "no folder")
    require_one_line(call("profile", V1, "-r", "nosuch", "-o", file), 2, "nosuch")
    for wrong in ("-1", "nan", "1e9"):
        require_one_line(call("profile", V1, "--bezel-mm", wrong, "-o", file), 2, "--bezel-mm")
    # An array that does not fit before this lens.
    own = tmp_path / "own.toml"
    own.write_text('extends = "matched-microlens"\n[array]\ngap_mm = 45.0\n')
    require_one_line(call("profile", V1, "-r", own, "-o", file), 2, "array.gap_mm")
    assert left_in(tmp_path) == ["own.toml"]
