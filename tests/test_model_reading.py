"""Rig files: finding, reading, extending and overriding them."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vrlf.errors import InputError, RigError
from vrlf.model import (
    DEFAULT_RIG,
    Rig,
    lens_power_d,
    load_rig,
    parse_prescription,
    rig_names,
    rig_summary,
)

VECTORS = sorted((Path(__file__).parent / "data").glob("*.toml"))

SMALL = """
[panel]
width_px = 96
height_px = 64
pixel_pitch_um = 78.0
[headset]
lens_to_panel_mm = 46.0
[array]
kind = "microlens"
pitch_um = 390.0
gap_mm = 3.0
focal_mm = 1.95
[left]
sphere_d = -5.0
pupil_mm = 5.0
[right]
sphere_d = 2.5
"""


@pytest.fixture
def small(tmp_path: Path) -> Path:
    path = tmp_path / "small.toml"
    path.write_text(SMALL, encoding="utf-8")
    return path


def message(source: str | Path, **options: object) -> str:
    with pytest.raises(InputError) as caught:
        load_rig(source, **options)  # type: ignore[arg-type]
    text = str(caught.value)
    assert "\n" not in text
    assert "found" in text
    assert "wanted" in text
    return text


# --- Shipped rigs and vectors


@pytest.mark.parametrize("name", rig_names())
def test_shipped_rigs_load_and_say_what_they_are(name: str) -> None:
    assert isinstance(load_rig(name), Rig)
    # One line of a listing: long enough to inform, short enough for a terminal.
    assert 20 < len(rig_summary(name)) < 100


def test_the_shelf_holds_what_is_promised() -> None:
    assert set(rig_names()) == {
        "bare",
        "lensless",
        "matched-full",
        "matched-microlens",
        "matched-wide",
        "pinhole",
        "reading-25cm",
        "thesis-minus-5d",
        "thesis-table-8-1",
        "two-eyes",
    }
    assert DEFAULT_RIG in rig_names()


def plane_of_focus_mm(rig: Rig) -> float:
    """Where the left eye focuses before the headset lens, for an eye relief of 0."""
    return 1000.0 / (lens_power_d(rig.headset) - rig.left.sphere_d)


@pytest.mark.parametrize(
    "name", ["matched-full", "matched-wide", "pinhole", "lensless", "reading-25cm"]
)
def test_matched_arrays_image_the_panel_onto_the_plane_of_focus(name: str) -> None:
    rig = load_rig(name)
    lens_to_array_mm = rig.headset.lens_to_panel_mm - rig.array.gap_mm
    vergence = 1.0 / rig.array.gap_mm + 1.0 / (lens_to_array_mm - plane_of_focus_mm(rig))
    # The files give focal lengths in hundredths of a millimetre.
    assert rig.array.focal_mm == pytest.approx(1.0 / vergence, abs=0.006)


@pytest.mark.parametrize("name", ["matched-microlens", "matched-wide", "lensless", "reading-25cm"])
def test_the_eyebox_covers_the_pupil(name: str) -> None:
    rig = load_rig(name)
    # Without eye relief m is the distance d from lens to panel.
    eyebox_mm = rig.array.pitch_um / 1000.0 * rig.headset.lens_to_panel_mm / rig.array.gap_mm
    assert eyebox_mm >= rig.left.pupil_mm


def test_table_8_1_focuses_where_the_thesis_says() -> None:
    # 1e-9 mm: the file gives 16 digits of the sphere.
    assert plane_of_focus_mm(load_rig("thesis-table-8-1")) == pytest.approx(33.0, abs=1e-9)


def test_extending_rigs_change_only_what_they_say() -> None:
    base, two = load_rig("matched-microlens"), load_rig("two-eyes")
    assert two.array == base.array
    assert two.headset == base.headset
    assert (two.left.sphere_d, two.left.cylinder_d, two.left.axis_deg) == (-4.5, -1.75, 30.0)
    assert (two.right.sphere_d, two.right.cylinder_d, two.right.axis_deg) == (2.25, -1.0, 115.0)
    assert two.left.vertex_mm == 0.0


def test_holes_can_be_turned_into_lenslets() -> None:
    assert load_rig("pinhole", overrides=["array.kind=microlens"]).array.kind == "microlens"


@pytest.mark.parametrize("path", VECTORS, ids=lambda path: path.stem)
def test_vectors_load(path: Path) -> None:
    assert isinstance(load_rig(path), Rig)
    assert path.with_suffix(".npz").is_file()


def test_there_are_vectors() -> None:
    assert len(VECTORS) >= 7


def test_an_unknown_name_lists_the_shelf() -> None:
    text = message("matched-microlense")
    assert 'did you mean "matched-microlens"?' in text
    assert all(name in text for name in rig_names())
    assert "bare" in message("")
    with pytest.raises(InputError):
        rig_summary("nothing-of-the-kind")


# --- Files


def test_a_path_may_be_text_or_path_and_relative(
    small: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(small.parent)
    assert load_rig("small.toml") == load_rig(small) == load_rig("./small.toml")


def test_a_byte_order_mark_is_no_error(small: Path) -> None:
    small.write_text(SMALL, encoding="utf-8-sig")
    assert load_rig(small).left.sphere_d == -5.0


def test_files_that_are_no_rigs(tmp_path: Path) -> None:
    assert "no such file" in message(tmp_path / "none.toml")
    assert "found a folder" in message(tmp_path)
    assert "NUL" in message("a\0/b.toml")
    path = tmp_path / "odd.toml"
    path.write_bytes(b"[panel]\nname = '\xff'\n")
    assert "not UTF-8 in line 2" in message(path)
    path.write_text("[panel]\nwidth_px = = 3\n", encoding="utf-8")
    assert "at line 2" in message(path)
    path.write_text("x = " + "[" * 100_000, encoding="utf-8")
    assert "too deep" in message(path)
    path.write_text("x = " + "9" * 10_000, encoding="utf-8")
    assert "too long" in message(path)
    path.write_bytes(b"#" * (2**20 + 1))
    assert "more than 1 MiB" in message(path)
    path.write_text("", encoding="utf-8")
    for table in ("panel", "headset", "left", "right"):
        assert f"{table}: found nothing, wanted a table [{table}]" in message(path)


def test_whatever_the_system_refuses_is_said(small: Path) -> None:
    assert "found Not a directory, wanted a readable file" in message(small / "rig.toml")


def test_messages_name_the_file_and_those_it_extends(small: Path) -> None:
    child = small.with_name("child.toml")
    child.write_text('extends = "small.toml"\n[left]\npupil_mm = 0\n', encoding="utf-8")
    assert message(child).startswith(f"{child} extends {small}: left.pupil_mm: found 0")


# --- extends


def test_extends_is_relative_to_the_file_and_merges_deeply(small: Path) -> None:
    folder = small.parent / "people"
    folder.mkdir()
    child = folder / "ann.toml"
    child.write_text('extends = "../small.toml"\n[left]\nsphere_d = -3.25\n', encoding="utf-8")
    rig = load_rig(child)
    assert rig.left.sphere_d == -3.25
    assert rig.left.pupil_mm == 5.0
    assert rig.right.sphere_d == 2.5


def test_extends_takes_a_shipped_rig(tmp_path: Path) -> None:
    child = tmp_path / "mine.toml"
    child.write_text('extends = "two-eyes"\n[right]\npupil_mm = 3\n', encoding="utf-8")
    rig = load_rig(child)
    assert rig.right.pupil_mm == 3.0
    assert rig.right.axis_deg == 115.0
    assert rig.array == load_rig("matched-microlens").array


def test_extends_that_leads_nowhere(tmp_path: Path) -> None:
    first, second = tmp_path / "first.toml", tmp_path / "second.toml"
    first.write_text('extends = "second.toml"\n', encoding="utf-8")
    second.write_text('extends = "./first.toml"\n', encoding="utf-8")
    assert "doesn't lead back" in message(first)
    first.write_text('extends = "./first.toml"\n', encoding="utf-8")
    assert "doesn't lead back" in message(first)
    first.write_text("extends = 3\n", encoding="utf-8")
    assert "extends: found 3, wanted a shipped rig's name" in message(first)
    first.write_text('extends = "matched"\n', encoding="utf-8")
    assert "unknown name" in message(first)
    first.write_text('extends = "gone.toml"\n', encoding="utf-8")
    assert "gone.toml: found no such file" in message(first)
    first.write_text('extends = "a\\u0000b.toml"\n', encoding="utf-8")
    assert "NUL" in message(first)


def test_extends_has_a_depth_limit(tmp_path: Path) -> None:
    for i in range(20):
        (tmp_path / f"{i}.toml").write_text(f'extends = "{i + 1}.toml"\n', encoding="utf-8")
    assert "at most 8 files" in message(tmp_path / "0.toml")


# --- Overrides and prescriptions


def test_overrides_are_toml_and_the_last_wins(small: Path) -> None:
    rig = load_rig(
        small,
        overrides=[
            "left.sphere_d=-3.5",
            "left.sphere_d = -.25",
            "right.accommodation=best",
            'panel.subpixels="full"',
            "right.prism_pd=[1, -2]",
            "right.chromatic=true",
            "left.zernike.diameter_mm=6",
            "left.zernike.coefficients_um.'3,-1'=0.1",
            'left.zernike.coefficients_um."4,0" = 0.2',
        ],
    )
    assert rig.left.sphere_d == -0.25
    assert rig.right.accommodation == "best"
    assert rig.panel.subpixels == "full"
    assert rig.right.prism_pd == (1.0, -2.0)
    assert rig.right.chromatic is True
    assert rig.left.zernike is not None
    assert rig.left.zernike.terms == (((3, -1), 0.1), ((4, 0), 0.2))


@pytest.mark.parametrize(
    "text", ["left.sphere_d", "=3", "left..sphere_d=3", "", "left.x\n=3", "'=3"]
)
def test_what_is_no_assignment(small: Path, text: str) -> None:
    assert "wanted table.key=value such as" in message(small, overrides=[text])


def test_wrong_overrides_are_worded_like_wrong_keys(small: Path) -> None:
    assert 'wanted "sphere_d"' in message(small, overrides=["left.sphere=3"])
    assert 'found "minus", wanted a number' in message(small, overrides=["left.sphere_d=minus"])
    assert "found nan, wanted a number" in message(small, overrides=["left.sphere_d=nan"])
    # The second line of an override must not become a second key.
    assert "--set" in message(small, overrides=["left.sphere_d=1\nright.sphere_d=2"])


def test_prescriptions_set_sphere_cylinder_axis_and_nothing_else(small: Path) -> None:
    before = load_rig(small)
    rig = load_rig(small, left="-5.25 / -1.25 x 170", right="pl")
    assert (rig.left.sphere_d, rig.left.cylinder_d, rig.left.axis_deg) == (-5.25, -1.25, 170.0)
    assert rig.left.pupil_mm == before.left.pupil_mm
    assert rig.right == before.right.model_copy(update={"sphere_d": 0.0})


def test_one_eye_wins_over_both_and_overrides_over_all(small: Path) -> None:
    rig = load_rig(
        small, both="-1.50 / -0.50 x 20", right="+2 / +1 x 5", overrides=["left.axis_deg=7"]
    )
    assert (rig.left.sphere_d, rig.left.axis_deg) == (-1.5, 7.0)
    assert (rig.right.sphere_d, rig.right.cylinder_d, rig.right.axis_deg) == (2.0, 1.0, 5.0)


def test_a_prescription_replaces_the_cylinder_that_was_there() -> None:
    rig = load_rig("two-eyes", left="-2")
    assert (rig.left.cylinder_d, rig.left.axis_deg) == (0.0, 0.0)


def test_all_wrong_options_are_named_at_once(small: Path) -> None:
    text = message(small, left="-5 / -1", right="five", overrides=["foo"])
    assert "--left prescription: found a cylinder without its axis" in text
    assert '--right prescription: found "five"' in text
    assert '--set: found "foo"' in text


def test_eyes_may_come_from_the_command_line_alone(tmp_path: Path) -> None:
    hardware = tmp_path / "hardware.toml"
    hardware.write_text(SMALL[: SMALL.index("[left]")], encoding="utf-8")
    with pytest.raises(RigError) as caught:
        load_rig(hardware)
    assert len(caught.value.problems) == 2
    assert load_rig(hardware, both="-4").right.sphere_d == parse_prescription("-4")[0]


@given(st.text(max_size=30))
def test_no_text_is_a_number_and_sets_a_key_at_once(text: str) -> None:
    with pytest.raises(InputError) as caught:
        load_rig("bare", overrides=[text, f"left.sphere_d={text}"])
    assert str(caught.value).isprintable()
