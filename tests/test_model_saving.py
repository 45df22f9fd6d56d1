"""Rigs written back: what changed is there, and everything else is as it was, to the byte."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vrlf.errors import InputError, RigError, VrlfError
from vrlf.model import Rig, load_rig, rig_from_tables
from vrlf.model.overrides import merged
from vrlf.model.saving import new_rig_file, rig_of_text, rig_tables, rig_text, save_rig

OWN = """# My phone.
extends = "matched-microlens"   # the array I bought

[left]          # measured in May
sphere_d = -5   # an integer stays one
axis_deg = 170.0
cylinder_d = -1.25

# The right eye is the better one.
[right]
sphere_d = -4.50
zernike = { diameter_mm = 6.0, coefficients_um = { "3,-1" = 0.14 } }  # coma

[headset]
lens_separation_mm = 61.5
"""


def with_changes(rig: Rig, **tables: Any) -> Rig:
    return rig_from_tables(merged(rig_tables(rig), tables))


@pytest.fixture
def own(tmp_path: Path) -> Path:
    path = tmp_path / "own.toml"
    path.write_text(OWN)
    return path


def test_a_rig_that_is_the_same_changes_no_byte(own: Path) -> None:
    assert save_rig(own, load_rig(own), OWN) == OWN
    assert own.read_text() == OWN


def test_only_the_changed_values_change(own: Path) -> None:
    rig = with_changes(load_rig(own), left={"sphere_d": -5.25}, array={"offset_um": [12.0, -3.0]})
    text = save_rig(own, rig, OWN)
    assert own.read_text() == text
    assert load_rig(own) == rig
    kept = OWN.replace("sphere_d = -5   #", "sphere_d = -5.25   #")
    assert text.startswith(kept)
    assert text.removeprefix(kept).split() == ["[array]", "offset_um", "=", "[12.0,", "-3.0]"]


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_line_ends_and_the_mark_stay(tmp_path: Path, ends: str, mark: str) -> None:
    text = mark + OWN.replace("\n", ends)
    path = tmp_path / "own.toml"
    path.write_bytes(text.encode())
    rig = with_changes(load_rig(path), right={"pupil_mm": 4.5})
    after = save_rig(path, rig, text)
    assert path.read_bytes().decode() == after
    assert after.count("\n") == after.count(ends)
    assert after.startswith(mark + "# My phone.")
    assert load_rig(path) == rig


@pytest.mark.parametrize(
    "text",
    [
        'extends = "two-eyes"\nleft.sphere_d = -3  # dotted\n',
        'extends = "two-eyes"\nleft = { sphere_d = -3 }  # inline\n',
        'extends = "two-eyes"\n[left]\nsphere_d = -3\n[left.zernike]\ndiameter_mm = 5.0\n'
        'coefficients_um = { "4,0" = 0.2 }\n',
    ],
)
def test_other_ways_to_write_a_table(tmp_path: Path, text: str) -> None:
    path = tmp_path / "own.toml"
    path.write_text(text)
    rig = with_changes(
        load_rig(path), left={"sphere_d": -3.75, "prism_pd": [0.5, 0.0]}, right={"axis_deg": 12.0}
    )
    after = save_rig(path, rig, text)
    assert load_rig(path) == rig
    for comment in ("# dotted", "# inline"):
        assert (comment in after) == (comment in text)


def test_a_new_file_extends_the_shipped_rig(tmp_path: Path) -> None:
    rig = with_changes(load_rig("pinhole"), left={"sphere_d": -2.25})
    text = new_rig_file(tmp_path / "mine.toml", rig, "pinhole")
    assert text.split() == ["extends", "=", '"pinhole"', "[left]", "sphere_d", "=", "-2.25"]
    assert load_rig(tmp_path / "mine.toml") == rig


def test_what_another_program_wrote_is_not_overwritten(own: Path) -> None:
    rig = with_changes(load_rig(own), left={"sphere_d": -1.0})
    own.write_text(OWN + "# theirs\n")
    with pytest.raises(InputError, match="another program"):
        save_rig(own, rig, OWN)
    assert own.read_text() == OWN + "# theirs\n"


def test_shipped_rigs_are_never_written() -> None:
    from vrlf.model.shelf import shipped_rig

    path = shipped_rig("pinhole")
    with pytest.raises(InputError, match="shipped"):
        save_rig(path, load_rig("pinhole"), path.read_text())


def test_nor_through_a_link(tmp_path: Path) -> None:
    from vrlf.model.shelf import shipped_rig

    link, shipped = tmp_path / "link.toml", shipped_rig("pinhole")
    link.symlink_to(shipped)
    before = shipped.read_bytes()
    rig = with_changes(load_rig(link), left={"pupil_mm": 4.25})
    try:
        with pytest.raises(InputError, match="shipped"):
            save_rig(link, rig, link.read_text())
    finally:
        after = shipped.read_bytes()
        shipped.write_bytes(before)
    assert after == before


def test_comments_stay_where_they_were(tmp_path: Path) -> None:
    """A new key stands before what leads to the next table; array items keep theirs."""
    text = (
        'extends = "bare"\n[left]\nsphere_d = -1.0\n\n# The right eye.\n[right]\nsphere_d = -2.0\n'
        "[array]\noffset_um = [\n  1.0, # right\n  2.0, # up\n]\n"
    )
    path = tmp_path / "own.toml"
    path.write_text(text)
    rig = with_changes(load_rig(path), left={"pupil_mm": 4.0}, array={"offset_um": [3.5, 2.0]})
    after = save_rig(path, rig, text)
    assert load_rig(path) == rig
    assert after == text.replace("-1.0\n", "-1.0\npupil_mm = 4.0\n").replace("1.0, #", "3.5, #")


def test_faults_are_one_line_and_leave_the_file(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    for text in ("extends = \n", "[left\n", 'extends = "no-such-rig"\n', "[left]\nsphere = 1\n"):
        path.write_text(text)
        with pytest.raises(VrlfError) as caught:
            save_rig(path, load_rig("bare"), text)
        assert "\n" not in str(caught.value)
        assert path.read_text() == text
    gone = tmp_path / "gone.toml"
    with pytest.raises(RigError, match=r"gone\.toml"):
        save_rig(gone, load_rig("bare"), "")


def test_a_key_that_cannot_be_taken_back_is_said(own: Path) -> None:
    eye = load_rig(own).right.model_copy(update={"zernike": None})
    rig = load_rig(own).model_copy(update={"right": eye})
    with pytest.raises(RigError, match="by values alone"):
        rig_of_text(OWN, own, rig)


@settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    sphere_d=st.floats(-20, 20),
    pupil_mm=st.floats(1, 9),
    turn_deg=st.floats(-360, 360),
    offset_um=st.tuples(st.floats(-500, 500), st.floats(-500, 500)),
    method=st.sampled_from(["forward", "optimal", "none"]),
)
def test_any_numbers_come_back_as_they_were(
    own: Path, sphere_d: float, pupil_mm: float, turn_deg: float, offset_um: Any, method: str
) -> None:
    rig = with_changes(
        load_rig(own),
        left={"sphere_d": sphere_d, "pupil_mm": pupil_mm},
        array={"rotation_deg": turn_deg, "offset_um": list(offset_um)},
        prefilter={"method": method},
    )
    after = rig_of_text(OWN, own, rig)
    for line in OWN.splitlines():
        if "#" in line:
            assert line[line.index("#") :] in after


def test_a_whole_rig_as_text() -> None:
    for name in ("two-eyes", "bare", "reading-25cm"):
        rig = load_rig(name)
        import tomllib

        assert rig_from_tables(tomllib.loads(rig_text(rig))) == rig
