"""Shader sources: includes, defines, and errors that name the file and line they are in."""

from __future__ import annotations

from pathlib import Path

import pytest

from vrlf.errors import ShaderError
from vrlf.gpu import Block, ComputePass, Device, Field, compute
from vrlf.gpu.sources import Source, assemble

BLOCK = Block("Numbers", (Field("float", "factor", ""),))
MAIN = """// line 1
#include "block/Numbers"
#include "include/outer.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba32f) writeonly uniform image2D shown;
#include "include/inner.glsl"
void main() {
    imageStore(shown, ivec2(gl_GlobalInvocationID.xy), vec4(outer(factor)));
}
"""
OUTER = """// outer, line 1
#include "include/inner.glsl"

float outer(float x) { return inner(x) + 1.0; }
"""
INNER = """// inner, line 1

float inner(float x) {
    return 2.0 * x;
}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A shader with an include in an include, each without a fault."""
    monkeypatch.setattr(compute, "shaders_dir", lambda: tmp_path)
    (tmp_path / "include").mkdir()
    write(tmp_path)
    return tmp_path


def write(folder: Path, main: str = MAIN, outer: str = OUTER, inner: str = INNER) -> None:
    (folder / "main.comp").write_text(main, encoding="utf-8")
    (folder / "include" / "outer.glsl").write_text(outer, encoding="utf-8")
    (folder / "include" / "inner.glsl").write_text(inner, encoding="utf-8")


def test_nested_includes_come_once_and_in_order(folder: Path) -> None:
    source = assemble(
        "main.comp", folder, defines={"SIZE": 3}, virtual={"block/Numbers": BLOCK.glsl}
    )
    assert source.files == (
        "main.comp",
        "block/Numbers",
        "include/outer.glsl",
        "include/inner.glsl",
    )
    lines = source.text.splitlines()
    assert lines[:3] == ["#version 430", "#define SIZE 3", "#line 1 0"]
    assert source.text.count("float inner(") == 1
    assert source.text.index("float inner(") < source.text.index("float outer(")
    assert "#include" not in source.text


def test_nested_includes_compile(device: Device, folder: Path) -> None:
    assert folder.is_dir()
    ComputePass(device, "main.comp", BLOCK).release()


@pytest.mark.parametrize(
    ("place", "old", "new", "where"),
    [
        ("inner", "2.0 * x", "2.0 * wrong", "include/inner.glsl:4"),
        ("outer", "+ 1.0", "+ wrong", "include/outer.glsl:4"),
        ("main", "vec4(outer", "vec4(wrong", "main.comp:8"),
        ("main", "// line 1", "wrong", "main.comp:1"),
    ],
)
def test_a_compilers_error_names_file_and_line(
    device: Device, folder: Path, place: str, old: str, new: str, where: str
) -> None:
    texts = {"main": MAIN, "outer": OUTER, "inner": INNER}
    texts[place] = texts[place].replace(old, new)
    write(folder, **texts)
    with pytest.raises(ShaderError) as caught:
        ComputePass(device, "main.comp", BLOCK)
    message = str(caught.value)
    assert message.startswith("main.comp: ")
    # A misplaced word may be noted where the parser stops, at the next line's end.
    assert where in message or (old == "// line 1" and "block/Numbers:1" in message)
    assert "\n" not in message


def test_an_include_of_itself_is_refused(folder: Path) -> None:
    write(folder, inner='#include "include/outer.glsl"\n')
    chain = "main.comp > include/outer.glsl > include/inner.glsl > include/outer.glsl"
    with pytest.raises(ShaderError, match=rf"include/outer.glsl: includes itself \({chain}\)"):
        assemble("main.comp", folder, virtual={"block/Numbers": BLOCK.glsl})


def test_a_missing_include_names_who_wants_it(folder: Path) -> None:
    write(folder, outer='#include "include/lost.glsl"\n')
    wanted = r"include/lost\.glsl, included by include/outer\.glsl: cannot be read \(No such file"
    with pytest.raises(ShaderError, match=wanted):
        assemble("main.comp", folder, virtual={"block/Numbers": BLOCK.glsl})


def test_a_missing_shader_is_named(folder: Path) -> None:
    with pytest.raises(ShaderError, match=r"shader lost\.comp: cannot be read"):
        assemble("lost.comp", folder)


@pytest.mark.parametrize(
    ("said", "wanted"),
    [
        ("1:17(5): error: `x' undeclared", "b.glsl:17: error: `x' undeclared"),
        ("0(3) : error C1503: undefined", "a.comp:3: error C1503: undefined"),
        ("ERROR: 1:8: 'x' : undeclared", "ERROR: b.glsl:8: 'x' : undeclared"),
        ("7:17(5): error", "7:17: error"),
    ],
)
def test_drivers_messages_get_file_names(said: str, wanted: str) -> None:
    assert Source("", ("a.comp", "b.glsl")).explain(said) == wanted


def test_each_shipped_shader_assembles(repo_root: Path) -> None:
    shaders = repo_root / "shaders"
    found = [path.relative_to(shaders).as_posix() for path in sorted(shaders.rglob("*.comp"))]
    assert {"perceive.comp", "forward.comp"} <= set(found)
    for name in found:
        text = (shaders / name).read_text(encoding="utf-8")
        blocks = [line.split('"')[1] for line in text.splitlines() if '#include "block/' in line]
        assert assemble(name, shaders, virtual=dict.fromkeys(blocks, "")).files[0] == name
