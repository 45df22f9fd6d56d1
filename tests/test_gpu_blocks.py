"""Uniform blocks: the declared layout against std140's rules and against the driver."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vrlf.errors import ShaderError
from vrlf.gpu import Block, ComputePass, Device, Field, Struct, Texture, compute

LAMP = Struct(
    "Lamp",
    (
        Field("float", "size", "first, so that the vec2 is moved up"),
        Field("vec2", "place", "8"),
        Field("int", "kind", "16"),
        Field("vec4", "colour", "32"),
        Field("float", "gain", "48; the size goes up to 64"),
    ),
)
ALL = Block(
    "All",
    (
        Field("float", "a", "0"),
        Field("vec2", "b", "8: aligned to its size"),
        Field("int", "c", "16"),
        Field("ivec2", "d", "24"),
        Field("float", "e", "32"),
        Field("vec4", "f", "48"),
        Field("ivec4", "g", "64"),
        Field("int", "h", "80"),
        Field("mat4", "m", "96"),
        Field("ivec4", "n", "160", 2),
        Field("float", "o", "192"),
        Field(LAMP, "lamps", "208", 3),
        Field("vec2", "p", "400: nothing else between"),
    ),
)
VALUES: dict[str, Any] = {
    "a": 1.5,
    "b": (2.0, 3.0),
    "c": 4,
    "d": (5, -6),
    "e": 7.25,
    "f": (8.0, 9.0, 10.0, 11.0),
    "g": (12, 13, 14, -15),
    "h": 16,
    "m": np.arange(20.0, 36.0).reshape(4, 4),
    "n": [(40, 41, 42, 43), (44, 45, 46, 47)],
    "o": 48.5,
    "lamps": [
        {
            "size": 50.0 + i,
            "place": (60.0 + i, 70.0 + i),
            "kind": 80 + i,
            "colour": (90.0 + i, 100.0 + i, 110.0 + i, 120.0 + i),
            "gain": 130.0 + i,
        }
        for i in range(3)
    ],
    "p": (140.0, 141.0),
}


def offsets(dtype: np.dtype[Any]) -> dict[str, int]:
    """Byte offset of each member."""
    assert dtype.fields is not None
    return {name: int(field[1]) for name, field in dtype.fields.items()}


def test_offsets_follow_std140() -> None:
    assert offsets(ALL.dtype) == {
        "a": 0,
        "b": 8,
        "c": 16,
        "d": 24,
        "e": 32,
        "f": 48,
        "g": 64,
        "h": 80,
        "m": 96,
        "n": 160,
        "o": 192,
        "lamps": 208,
        "p": 400,
    }
    assert ALL.dtype.itemsize == 416
    lamp = {"size": 0, "place": 8, "kind": 16, "colour": 32, "gain": 48}
    assert (offsets(LAMP.dtype), LAMP.dtype.itemsize) == (lamp, 64)


@pytest.mark.parametrize(
    ("kind", "offset", "size"),
    [
        ("float", 4, 16),
        ("int", 4, 16),
        ("vec2", 8, 16),
        ("ivec2", 8, 16),
        ("vec4", 16, 32),
        ("ivec4", 16, 32),
        ("mat4", 16, 80),
    ],
)
def test_each_type_is_aligned(kind: str, offset: int, size: int) -> None:
    block = Block("B", (Field("float", "first", ""), Field(kind, "second", "")))
    assert (offsets(block.dtype)["second"], block.dtype.itemsize) == (offset, size)


def shader(body: str) -> str:
    """A compute shader that writes vec4 number i with ``put(i, value)``."""
    return f"""
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;
layout(binding = 0, rgba32f) writeonly uniform image2D found;
void put(int i, vec4 value) {{ imageStore(found, ivec2(i, 0), value); }}
void main() {{
    if (gl_GlobalInvocationID.xy != uvec2(0)) return;
    {body}
}}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where compute passes take their shaders from."""
    monkeypatch.setattr(compute, "shaders_dir", lambda: tmp_path)
    return tmp_path


def test_the_driver_reads_each_member_where_numpy_put_it(device: Device, folder: Path) -> None:
    body = """
    put(0, vec4(a, b, c)); put(1, vec4(d, e, h)); put(2, f); put(3, vec4(g));
    for (int i = 0; i < 4; i++) put(4 + i, m[i]);
    put(8, vec4(n[0])); put(9, vec4(n[1])); put(10, vec4(o, p, 0.0));
    for (int i = 0; i < 3; i++) {
        put(11 + 2 * i, vec4(lamps[i].size, lamps[i].place, lamps[i].kind));
        put(12 + 2 * i, lamps[i].colour + vec4(0.0, 0.0, 0.0, lamps[i].gain));
    }
    """
    (folder / "all.comp").write_text('#include "block/All"\n' + shader(body), encoding="utf-8")
    program, found = ComputePass(device, "all.comp", ALL), Texture(device, (17, 1))
    program.set(VALUES)
    found.bind_image(0, read=False, write=True)
    program.run(1)
    rows = [[1.5, 2, 3, 4], [5, -6, 7.25, 16], [8, 9, 10, 11], [12, 13, 14, -15]]
    rows += np.arange(20.0, 36.0).reshape(4, 4).tolist()  # a numpy row is a GLSL column
    rows += [[40, 41, 42, 43], [44, 45, 46, 47], [48.5, 140, 141, 0]]
    for i in range(3):
        rows.append([50 + i, 60 + i, 70 + i, 80 + i])
        rows.append([90 + i, 100 + i, 110 + i, 250 + 2 * i])
    np.testing.assert_array_equal(found.read()[0], rows)
    program.release()
    found.release()


def test_a_drifted_declaration_is_refused(device: Device, folder: Path) -> None:
    text = "layout(std140, binding = 0) uniform B { vec4 a; };\n" + shader("put(0, a);")
    (folder / "drift.comp").write_text(text, encoding="utf-8")
    block = Block("B", (Field("vec4", "a", ""), Field("vec4", "b", "the shader lacks it")))
    with pytest.raises(ShaderError, match=r"drift\.comp: block B has 16 bytes .* 32 in Python"):
        ComputePass(device, "drift.comp", block)


def test_a_shader_without_its_block_is_refused(device: Device, folder: Path) -> None:
    (folder / "idle.comp").write_text(shader("put(0, vec4(1.0));"), encoding="utf-8")
    with pytest.raises(ShaderError, match=r"idle\.comp: uses nothing of its block B"):
        ComputePass(device, "idle.comp", Block("B", (Field("float", "a", ""),)))


def test_pack_refuses_missing_and_unknown_members() -> None:
    block = Block("B", (Field("float", "a", ""), Field("vec2", "b", "")))
    with pytest.raises(ValueError, match=r"block B: missing \['b'\], unknown \['c'\]"):
        block.pack({"a": 1.0, "c": 2.0})
    lamps = [dict(VALUES["lamps"][0]) for _ in range(3)]
    del lamps[2]["gain"]
    with pytest.raises(ValueError, match=r"block Lamp: missing \['gain'\]"):
        ALL.pack(VALUES | {"lamps": lamps})


def test_types_with_surprises_are_refused() -> None:
    with pytest.raises(ValueError, match="weights: std140 pads arrays of float"):
        _ = Block("B", (Field("float", "weights", "", 3),)).dtype
    with pytest.raises(ValueError, match="lamp: a struct stands in a block as an array only"):
        _ = Block("B", (Field(LAMP, "lamp", ""),)).dtype
