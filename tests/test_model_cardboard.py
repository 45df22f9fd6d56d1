"""Viewer profiles: published ones, every part of the format, and everything that is none."""

from __future__ import annotations

import base64
import contextlib
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vrlf.errors import InputError, RigError
from vrlf.model import FieldOfView, ViewerProfile, load_rig, read_profile
from vrlf.model.cardboard import decoded_profile
from vrlf.model.cardboard_rig import headset_table, lens_height_mm
from vrlf.model.cardboard_source import CARDBOARD_V1

# The example of Google's own Unity plugin (googlevr/cardboard-xr-plugin).
I_O_2015 = (
    "CgZHb29nbGUSEkNhcmRib2FyZCBJL08gMjAxNR0rGBU9JQHegj0qEAAASEIAAEhCAABIQgAASEJYADUpXA89"
    "OggeZnc-Ej6aPlAAYAM"
)


def message(**fields: Any) -> bytes:
    """A profile written by hand, by the field's numbers; None leaves one of the usual out."""
    usual: dict[int, Any] = {
        1: b"A maker",
        2: b"M-1",
        3: [0.0395],
        4: [0.0612],
        5: [51.0, 43.0, 47.0, 46.0],
        11: 0,
        6: [0.0331],
        7: [0.31, -0.02],
        12: 3,
    }
    for name, value in fields.items():
        usual[int(name.removeprefix("f"))] = value
    written = b""
    for number, value in usual.items():
        if isinstance(value, int):
            written += bytes([number << 3, value])
        elif isinstance(value, bytes):
            written += bytes([number << 3 | 2, len(value)]) + value
        elif value is not None:
            packed = struct.pack(f"<{len(value)}f", *value)
            repeated = number in (5, 7)
            key = bytes([number << 3 | 2, len(packed)]) if repeated else bytes([number << 3 | 5])
            written += key + packed
    return written


def text_of(raw: bytes) -> str:
    return base64.urlsafe_b64encode(raw).decode().rstrip("=")


OWN = ViewerProfile(
    vendor="A maker",
    model="M-1",
    screen_to_lens_mm=39.5,
    inter_lens_mm=61.2,
    vertical_alignment="bottom",
    tray_to_lens_mm=33.1,
    field_of_view_deg=FieldOfView(outer=51.0, inner=43.0, bottom=47.0, top=46.0),
    distortion=(0.31, -0.02),
    primary_button="indirect-touch",
)


def refused(source: str, *parts: str) -> None:
    """One line that says what was found and what was wanted."""
    with pytest.raises(InputError) as caught:
        read_profile(source)
    text = str(caught.value)
    assert text.startswith("profile: found ")
    assert ", wanted " in text
    assert "\n" not in text
    assert len(text) < 400
    for part in parts:
        assert part in text, text


# Published profiles


def test_the_first_cardboard() -> None:
    """42 mm, 60 mm, 35 mm from its tray, 40 degrees, 0.441 and 0.156, by Google's own bytes."""
    expected = ViewerProfile(
        vendor="Google, Inc.",
        model="Cardboard v1",
        screen_to_lens_mm=42.0,
        inter_lens_mm=60.0,
        vertical_alignment="bottom",
        tray_to_lens_mm=35.0,
        field_of_view_deg=FieldOfView(40.0, 40.0, 40.0, 40.0),
        distortion=(0.441, 0.156),
        primary_button="magnet",
    )
    for source in ("g.co/cardboard", "https://g.co/cardboard", "http://google.com/cardboard"):
        assert read_profile(source) == expected


def test_a_later_one() -> None:
    found = read_profile(f"https://google.com/cardboard/cfg?p={I_O_2015}")
    assert (found.vendor, found.model) == ("Google", "Cardboard I/O 2015")
    assert (found.screen_to_lens_mm, found.inter_lens_mm) == (36.4, 63.9)
    assert found.field_of_view_deg == FieldOfView(50.0, 50.0, 50.0, 50.0)
    # As single precision wrote them.
    assert found.distortion == pytest.approx((0.2416, 0.30125), abs=1e-5)
    assert found.primary_button == "indirect-touch"


# Every way to give one


@pytest.mark.parametrize(
    "around",
    [
        "https://google.com/cardboard/cfg?p={}",
        "http://www.google.com/cardboard/cfg?p={}",
        "google.com/cardboard/cfg?p={}",
        "HTTPS://GOOGLE.com/cardboard/cfg/?a=1&p={}&b=2",
        "{}",
        "  {}==\n",
    ],
)
def test_addresses_and_their_text(around: str, tmp_path: Path) -> None:
    source = around.format(text_of(message()))
    assert read_profile(source) == OWN
    file = tmp_path / "code.txt"
    file.write_text(source)
    assert read_profile(str(file)) == OWN


def test_plain_base64_and_percent_signs() -> None:
    plain = base64.b64encode(message(f1=b"\xef\xbf\xbf\xef\xbf\xbe>>>")).decode()
    assert "/" in plain
    wanted = replace(OWN, vendor="\uffff\ufffe>>>")
    assert read_profile(f"google.com/cardboard/cfg?p={plain}") == wanted
    assert read_profile(f"google.com/cardboard/cfg?p={plain.replace('/', '%2F')}") == wanted


@pytest.mark.parametrize("header", [False, True])
def test_files_of_bytes(tmp_path: Path, header: bool) -> None:
    raw = message()
    file = tmp_path / "current_device_params"
    mark = bytes.fromhex("35587a2b") + len(raw).to_bytes(4, "big")
    file.write_bytes(mark + raw if header else raw)
    assert read_profile(str(file)) == OWN
    assert read_profile(file.name, tmp_path) == OWN


def test_fields_in_any_order_twice_unpacked_and_unknown() -> None:
    """What a reader of the format must take: the last of two, single numbers, strangers."""
    single = b"".join(b"\x3d" + struct.pack("<f", k) for k in (0.31, -0.02))
    stranger = b"\x50\x01" + b"\xc2\x3e\x03abc" + b"\xc9\x3e" + bytes(8)
    raw = stranger + single + message(f7=None, f2=b"old") + b"\x12\x03M-1"
    assert decoded_profile(raw) == OWN


def test_what_may_be_left_out() -> None:
    bare = message(f1=None, f2=None, f5=None, f7=None, f11=None, f12=None)
    found = decoded_profile(bare)
    assert (found.vendor, found.model, found.field_of_view_deg) == ("", "", None)
    assert found.distortion == (0.0, 0.0)
    assert (found.vertical_alignment, found.primary_button) == ("bottom", "magnet")
    assert decoded_profile(message(f7=[0.25])).distortion == (0.25, 0.0)


# How high the axes are


def test_height_of_the_axes() -> None:
    """60 mm of panel: 33.1 mm above its lower edge is 3.1 above its middle, less the border."""
    assert lens_height_mm(OWN, 60.0) == 3.1
    assert lens_height_mm(OWN, 60.0, bezel_mm=4.0) == -0.9
    hung = replace(OWN, vertical_alignment="top")
    assert lens_height_mm(hung, 60.0) == -3.1
    assert lens_height_mm(hung, 60.0, bezel_mm=4.0) == 0.9
    centred = decoded_profile(message(f11=1, f6=None))
    assert centred.tray_to_lens_mm is None
    assert lens_height_mm(centred, 60.0, bezel_mm=4.0) == 0.0


# In rigs


def test_a_rig_names_its_profile(tmp_path: Path) -> None:
    (tmp_path / "viewer.bin").write_bytes(message())
    own = tmp_path / "own.toml"
    own.write_text(
        'extends = "bare"\n[panel]\nheight_px = 800\npixel_pitch_um = 75.0\n'
        '[headset]\nprofile = "viewer.bin"\nlens_separation_mm = 63.5\n'
    )
    headset = load_rig(own).headset
    assert (headset.lens_to_panel_mm, headset.lens_height_mm) == (39.5, 3.1)
    assert headset.distortion == (0.31, -0.02)
    assert headset.lens_separation_mm == 63.5  # what the file says itself wins
    # A file on top, with another panel: the axes are as high above the edge as before.
    top = tmp_path / "top.toml"
    top.write_text('extends = "own.toml"\n[panel]\nheight_px = 400\n')
    assert load_rig(top).headset.lens_height_mm == pytest.approx(33.1 - 15.0)
    changed = load_rig(own, overrides=["headset.profile=g.co/cardboard", "panel.height_px=640"])
    assert changed.headset.lens_height_mm == pytest.approx(35.0 - 24.0)
    assert changed.headset.lens_separation_mm == 60.0  # laid over the file's


@pytest.mark.parametrize("value", ["3", "[1]", "{a = 1}", "true", '"nothing here"'])
def test_a_rig_with_a_wrong_profile(value: str) -> None:
    with pytest.raises(RigError, match=r"bare.*: headset\.profile: found .*, wanted "):
        load_rig("bare", overrides=[f"headset.profile={value}"])


def test_a_profile_beside_a_panel_that_is_none() -> None:
    for wrong in ("panel.height_px=true", f"panel.height_px={'9' * 400}", "panel.height_px=a"):
        with pytest.raises(RigError, match=r"panel\.height_px: found"):
            load_rig("bare", overrides=["headset.profile=g.co/cardboard", wrong])


# What is none


@pytest.mark.parametrize(
    "source",
    [
        "",
        "nothing",
        "https://example.com/cardboard/cfg?p=CgZH",
        "https://google.com.example.org/cardboard/cfg?p=CgZH",
        "ftp://google.com/cardboard/cfg?p=CgZH",
        "https://google.com/search?q=cardboard",
        "goo.gl/Cbrdp5",
        "g.co/cardboard/x",
        "no/such/file.bin",
        "http://[::1/cardboard",
        "a\0b",
        "C:\\viewer.bin",
        "https://google.com/cardboard/cfg",
        "https://google.com/cardboard/cfg?p=",
        "https://google.com/cardboard/cfg?q=CgZH",
    ],
)
def test_what_is_no_profile(source: str) -> None:
    refused(source, "google.com/cardboard/cfg?p=")


def test_what_is_no_base64() -> None:
    refused("google.com/cardboard/cfg?p=!!!", "base64", "!!!")
    refused("google.com/cardboard/cfg?p=CgZHb", "5 letters", "whole bytes")


@pytest.mark.parametrize("size", [1025, 100_000])
def test_what_is_too_large(tmp_path: Path, size: int) -> None:
    refused(text_of(bytes(size)), "at most 1024 bytes")
    refused(f"google.com/cardboard/cfg?p={text_of(bytes(size))}", "at most 1024 bytes")
    file = tmp_path / "large"
    file.write_bytes(bytes(size))
    refused(str(file), "at most 1024 bytes")
    file.write_bytes(bytes.fromhex("35587a2b") + size.to_bytes(4, "big") + bytes(size))
    refused(str(file), "at most 1024 bytes")


def test_files_that_are_none(tmp_path: Path) -> None:
    refused(str(tmp_path), "the folder")
    empty = tmp_path / "empty"
    empty.write_bytes(b" \n")
    refused(str(empty), "nothing in")
    empty.write_bytes(bytes.fromhex("35587a2b0000"))
    refused(str(empty), "0 bytes", "its header says 0")
    short = tmp_path / "short"
    short.write_bytes(bytes.fromhex("35587a2b") + (80).to_bytes(4, "big") + message()[:50])
    refused(str(short), "50 bytes", "its header says 80")


def outcome(raw: bytes) -> ViewerProfile | str:
    """The profile, or the complaint, which is one line."""
    try:
        return decoded_profile(raw)
    except InputError as error:
        return str(error)


def test_cut_anywhere_it_is_refused_or_lacks_its_end() -> None:
    """Of the first Cardboard's 75 bytes: what is cut within a field or lacks a length is none."""
    whole = {}
    for length in range(len(CARDBOARD_V1)):
        found = outcome(CARDBOARD_V1[:length])
        if isinstance(found, ViewerProfile):
            whole[length] = found
        else:
            assert "cut short" in found or ": found no " in found
    # Behind the last length there are ends of fields: distortion, alignment, button.
    assert list(whole) == [61, 71, 73]
    assert [each.distortion[0] for each in whole.values()] == [0.0, 0.441, 0.441]


NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    ("fields", "parts"),
    [
        ({"f3": None}, ("no screen_to_lens_distance",)),
        ({"f4": None}, ("no inter_lens_distance",)),
        ({"f6": None}, ("no tray_to_lens_distance",)),
        ({"f3": [NAN]}, ("screen_to_lens_distance", "not finite")),
        ({"f3": [-INF]}, ("screen_to_lens_distance", "not finite")),
        ({"f3": [39.0]}, ("39000 mm", "5 to 500 mm")),
        ({"f3": [-0.04]}, ("-40 mm",)),
        ({"f3": [3.0e38]}, ("3e+41 mm",)),
        ({"f4": [0.0]}, ("0 mm", "10 to 200 mm")),
        ({"f6": [0.5]}, ("500 mm", "0 to 300 mm")),
        ({"f5": [40.0, 40.0]}, ("2 angles", "four")),
        ({"f5": [40.0, 40.0, -1.0, 40.0]}, ("-1 degrees",)),
        ({"f5": [90.0, 40.0, 40.0, 40.0]}, ("90 degrees",)),
        ({"f5": [NAN] * 4}, ("not finite",)),
        ({"f7": [0.1, 0.2, 0.3]}, ("3 distortion", "at most two")),
        ({"f7": [0.1, 101.0]}, ("101", "-100 to 100")),
        ({"f7": b"abc"}, ("distortion_coefficients", "32-bit")),
        ({"f11": 3}, ("vertical_alignment 3", "0 to 2")),
        ({"f12": 9}, ("primary_button 9", "0 to 3")),
        ({"f1": b"\xff\xfe"}, ("vendor", "UTF-8")),
        ({"f3": 7}, ("screen_to_lens_distance of the wire type 0",)),
        ({"f12": b"x"}, ("primary_button of the wire type 2",)),
        ({"f5": 7}, ("left_eye_field_of_view_angles", "32-bit")),
    ],
)
def test_what_describes_no_viewer(fields: dict[str, Any], parts: tuple[str, ...]) -> None:
    refused(text_of(message(**fields)), *parts)


def test_what_is_no_message() -> None:
    refused(text_of(message() + b"\x03"), "field 0 of the wire type 3")
    refused(text_of(message() + b"\x0b" + bytes(8)), "wire type 3")
    refused(text_of(message() + b"\x58" + b"\xff" * 11), "ten bytes")
    refused(text_of(message() + b"\x0a\xff\xff\xff\xff\x0f"), "cut short")


@settings(max_examples=400, deadline=None)
@given(raw=st.binary(max_size=120))
def test_any_bytes_give_a_profile_or_one_line(raw: bytes) -> None:
    found = outcome(raw)
    if isinstance(found, ViewerProfile):
        assert headset_table(found, 60.0)["lens_to_panel_mm"] == found.screen_to_lens_mm
    else:
        assert "\n" not in found


@settings(max_examples=400, deadline=None)
@given(place=st.integers(0, 200), value=st.integers(0, 255))
def test_one_wrong_byte_gives_a_profile_or_one_line(place: int, value: int) -> None:
    raw = bytearray(message())
    raw[place % len(raw)] = value
    found = outcome(bytes(raw))
    if isinstance(found, ViewerProfile):
        assert 5.0 <= found.screen_to_lens_mm <= 500.0
    else:
        assert "\n" not in found


@settings(max_examples=300, deadline=None)
@given(text=st.text(max_size=80))
def test_any_text_is_refused_in_one_line_or_taken(text: str) -> None:
    for source in (text, f"google.com/cardboard/cfg?p={text}"):
        with contextlib.suppress(InputError):
            assert isinstance(read_profile(source), ViewerProfile)
