"""Whatever is typed: the status is 0 or 2, with one line of complaint and never a traceback."""

from __future__ import annotations

import json
import math
import tempfile
from pathlib import Path
from typing import Any

from command_runs import DATA, LENSLETS, Outcome, call, require_one_line
from hypothesis import example, given, settings
from hypothesis import strategies as st

from vrlf.model.rig import rig_json_schema

RIG = (DATA / "lenslets-turned.toml").read_text()
QUICK = settings(max_examples=120, deadline=None)


def keys_of_rigs() -> list[str]:
    """Every ``table.key`` that a rig may have."""
    schema = rig_json_schema()
    keys = []
    for table, node in schema["properties"].items():
        name = node.get("$ref", "").rsplit("/", 1)[-1]
        keys += [f"{table}.{key}" for key in schema["$defs"].get(name, {}).get("properties", {})]
    assert "left.sphere_d" in keys
    assert "array.gap_mm" in keys
    return keys


numbers = st.one_of(
    st.floats().map(repr),
    st.integers(-(10**6), 10**6).map(str),
    st.sampled_from(["0", "-0", "1e-300", "1e300", "1e999", "nan", "-inf", "0x10", "1_0", ".5"]),
)
values = st.one_of(
    numbers,
    st.lists(numbers, max_size=3).map(lambda items: f"[{', '.join(items)}]"),
    st.sampled_from(["true", "none", "pinhole", "microlens", '"full"', "{}", "[]", "''", "{a=1}"]),
    st.text(max_size=12),
)


def require_0_or_2(outcome: Outcome) -> None:
    """Either one JSON object of finite numbers and no complaint, or one line and no result."""
    if outcome.status != 0:
        require_one_line(outcome, 2)
        return
    assert outcome.err == ""
    for number in leaves(outcome.json()):
        assert not isinstance(number, float) or math.isfinite(number)


def leaves(value: Any) -> list[Any]:
    """All that stands in a JSON value."""
    if isinstance(value, dict):
        return [leaf for each in value.values() for leaf in leaves(each)]
    if isinstance(value, list):
        return [leaf for each in value for leaf in leaves(each)]
    return [value]


@QUICK
@given(st.lists(st.tuples(st.sampled_from(keys_of_rigs()), values), min_size=1, max_size=3))
def test_any_value_of_any_key(changes: list[tuple[str, str]]) -> None:
    options = [part for key, value in changes for part in ("--set", f"{key}={value}")]
    require_0_or_2(call("inspect", *LENSLETS, "--json", *options))


@QUICK
@given(st.text(max_size=30))
@example("left.sphere_d")
@example("=")
@example(".=1")
@example('""=1')
@example("left..sphere_d=1")
@example("left.sphere_d=" + "[" * 5000)
@example("left.sphere_d=" + "9" * 5000)
@example("a." * 2000 + "b=1")
@example("left.sphere_d=1\nleft.pupil_mm=2")
@example('left.zernike.coefficients_um."2,0"=nan')
@example("extends=bare")
def test_any_text_behind_set(text: str) -> None:
    require_0_or_2(call("inspect", *LENSLETS, "--json", "--set", text))


prescription_like = st.text(st.sampled_from("0123456789+-/.,x× DSdscylaxisplno°−"), max_size=24)


@QUICK
@given(st.one_of(st.text(max_size=30), prescription_like))
@example("-5.00 / -1.25 x 170")
@example("-5")
@example("--help")
@example("9" * 5000)
def test_any_text_as_a_prescription(text: str) -> None:
    for option in ("--left", "--both"):
        # As one word, so that what begins with a dash is the option's value.
        require_0_or_2(call("inspect", *LENSLETS, "--json", f"{option}={text}"))


@QUICK
@given(
    st.lists(
        st.tuples(
            st.integers(0, len(RIG)), st.integers(0, 12), st.one_of(st.binary(max_size=6), numbers)
        ),
        min_size=1,
        max_size=3,
    )
)
def test_any_damage_to_a_rig_file(cuts: list[tuple[int, int, bytes | str]]) -> None:
    text = RIG.encode()
    for start, length, put in cuts:
        middle = put.encode() if isinstance(put, str) else put
        text = text[:start] + middle + text[start + length :]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "rig.toml"
        file.write_bytes(text)
        require_0_or_2(call("inspect", "-r", file, "--json"))


@QUICK
@given(st.lists(st.text(max_size=8), max_size=4))
def test_any_words(words: list[str]) -> None:
    outcome = call(*words)
    assert outcome.status in (0, 2)
    if outcome.status == 2:
        require_one_line(outcome, 2)


@QUICK
@given(st.binary(max_size=200), st.sampled_from(["png", "exr", "jpg", "bmp", "hdr", "tif"]))
def test_any_bytes_as_a_picture(data: bytes, ending: str) -> None:
    magic = {
        "png": b"\x89PNG\r\n\x1a\n",
        "exr": b"\x76\x2f\x31\x01\x02\0\0\0",
        "jpg": b"\xff\xd8\xff\xe0",
        "bmp": b"BM",
        "hdr": b"#?RADIANCE\n",
        "tif": b"II*\0",
    }
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"picture.{ending}"
        file.write_bytes(magic[ending] + data)
        outcome = call("perceive", file, *LENSLETS, "-o", Path(folder) / "out.png")
        require_one_line(outcome, 2, "picture.")
        assert not (Path(folder) / "out.png").exists()


def test_the_schema_is_json_all_through() -> None:
    """The fuzz takes its keys from it."""
    assert json.loads(json.dumps(rig_json_schema())) == rig_json_schema()
