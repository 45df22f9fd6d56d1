"""The drawing mechanism: which pixels a mesh covers, which surface wins, what is refused."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from vrlf.errors import InputError, ShaderError
from vrlf.gpu import Block, Canvas, Device, DrawPass, Field, Mesh, draw

PAINT = Block("Paint", (Field("vec4", "shift", "added to every place"),))
VERTEX = np.dtype([("in_place", "f4", 3), ("in_unused", "f4", 2), ("in_shade", "f4")])
INSTANCE = np.dtype([("in_at", "f4", 2)])

_VERT = """#include "block/Paint"
in vec3 in_place;
in float in_shade;
out float shade;
void main() {
    shade = in_shade;
    gl_Position = vec4(in_place, 1.0) + vec4(shift.xyz, 0.0);
}
"""
_MANY_VERT = _VERT.replace("in float in_shade;", "in float in_shade;\nin vec2 in_at;").replace(
    "vec4(in_place, 1.0)", "vec4(in_place + vec3(in_at, 0.0), 1.0)"
)
_FRAG = """in float shade;
out vec4 light;
void main() { light = vec4(shade, 2.0 * shade, 0.0, 1.0); }
"""
_BEHIND_VERT = """#include "block/Paint"
out float shade;
void main() {
    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    shade = shift.x;
    gl_Position = vec4(2.0 * corner - 1.0, 1.0, 1.0);
}
"""
SHADERS = {"one.vert": _VERT, "many.vert": _MANY_VERT, "behind.vert": _BEHIND_VERT, "p.frag": _FRAG}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of small shaders that the passes are made of."""
    for name, text in SHADERS.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.setattr(draw, "shaders_dir", lambda: tmp_path)
    return tmp_path


class Bench:
    """Makes things and gives them back when the test ends."""

    def __init__(self, device: Device, stack: ExitStack) -> None:
        self.device, self._stack = device, stack

    def keep(self, thing: Any) -> Any:
        self._stack.callback(thing.release)
        return thing

    def canvas(self, width: int, height: int) -> Canvas:
        return self.keep(Canvas(self.device, (width, height), kind="f4"))

    def program(self, vertex: str, shift: tuple[float, ...] = (0, 0, 0, 0)) -> DrawPass:
        made = self.keep(DrawPass(self.device, vertex, "p.frag", PAINT))
        made.set({"shift": shift})
        return made

    def mesh(self, *rectangles: Any, instances: Any = None) -> Mesh:
        vertices = np.concatenate([corners(*each) for each in rectangles])
        start = 4 * np.arange(len(rectangles))[:, None, None]
        triangles = (np.array([[0, 1, 2], [0, 2, 3]]) + start).reshape(-1, 3)
        return self.keep(Mesh(self.device, vertices, triangles, instances=instances))


@pytest.fixture
def bench(device: Device, folder: Path) -> Iterator[Bench]:
    """All that a test makes goes back when it ends."""
    assert folder.is_dir()
    with ExitStack() as stack:
        yield Bench(device, stack)


def corners(
    left: float, bottom: float, right: float, top: float, depth: float, shade: float
) -> NDArray[np.void]:
    """A rectangle in clip space."""
    vertices = np.zeros(4, VERTEX)
    places = [(left, bottom), (right, bottom), (right, top), (left, top)]
    vertices["in_place"] = [(*place, depth) for place in places]
    vertices["in_shade"] = shade
    vertices["in_unused"] = 99.0
    return vertices


def test_row_zero_is_the_lowest(bench: Bench) -> None:
    """A rectangle over columns 2..4 and rows 1..2 of a 8 x 4 canvas, counted upward."""
    canvas = bench.canvas(8, 4)
    canvas.begin(clear=(0.0, 0.0, 0.5, 1.0))
    bench.program("one.vert").draw(bench.mesh((-0.5, -0.5, 0.25, 0.5, 0.0, 0.25)))
    expected = np.zeros((4, 8, 4), np.float32)
    expected[...] = (0.0, 0.0, 0.5, 1.0)
    expected[1:3, 2:5] = (0.25, 0.5, 0.0, 1.0)
    assert np.array_equal(canvas.colour.read(), expected)


def test_the_block_moves_what_is_drawn(bench: Bench) -> None:
    canvas = bench.canvas(8, 4)
    canvas.begin()
    program = bench.program("one.vert", shift=(0.5, -0.5, 0.0, 0.0))
    program.draw(bench.mesh((-1.0, 0.0, -0.5, 0.5, 0.0, 0.25)))
    lit = np.argwhere(canvas.colour.read()[..., 0] > 0)
    assert lit.tolist() == [[1, 2], [1, 3]]


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_nearest_wins_in_any_order(bench: Bench, order: tuple[int, int]) -> None:
    near, far = (-1, -1, 0, 1, -0.5, 0.25), (-1, -1, 1, 1, 0.5, 0.75)
    canvas = bench.canvas(4, 2)
    canvas.begin()
    bench.program("one.vert").draw(bench.mesh(*((near, far)[i] for i in order)))
    assert canvas.colour.read()[..., 0].tolist() == [[0.25, 0.25, 0.75, 0.75]] * 2


def test_the_screen_fills_only_what_is_free(bench: Bench) -> None:
    canvas = bench.canvas(4, 2)
    canvas.begin()
    bench.program("one.vert").draw(bench.mesh((-1, -1, -0.5, 1, 0.9, 0.25)))
    bench.program("behind.vert", shift=(0.5, 0, 0, 0)).draw_screen()
    assert canvas.colour.read()[..., 0].tolist() == [[0.25, 0.5, 0.5, 0.5]] * 2


def test_every_instance_is_drawn_at_its_place(bench: Bench) -> None:
    places = np.zeros(3, INSTANCE)
    places["in_at"] = [(0.0, 0.0), (1.0, 0.0), (0.5, 1.0)]
    canvas = bench.canvas(4, 2)
    canvas.begin()
    mesh = bench.mesh((-1, -1, -0.5, 0, 0.0, 0.25), instances=places)
    bench.program("many.vert").draw(mesh)
    assert (canvas.colour.read()[..., 0] > 0).tolist() == [
        [True, False, True, False],
        [False, True, False, False],
    ]


def test_beginning_again_empties_colour_and_depth(bench: Bench) -> None:
    canvas, program = bench.canvas(4, 2), bench.program("one.vert")
    canvas.begin()
    program.draw(bench.mesh((-1, -1, 1, 1, -0.9, 0.25)))
    canvas.begin()
    program.draw(bench.mesh((-1, -1, 0, 1, 0.9, 0.75)))
    assert canvas.colour.read()[0, :, 0].tolist() == [0.75, 0.75, 0.0, 0.0]


def test_a_mesh_serves_many_passes_and_outlives_them(bench: Bench, device: Device) -> None:
    mesh, canvas = bench.mesh((-1, -1, 1, 1, 0.0, 0.5)), bench.canvas(2, 2)
    for _ in range(3):
        program = DrawPass(device, "one.vert", "p.frag", PAINT)
        program.set({"shift": (0, 0, 0, 0)})
        canvas.begin()
        program.draw(mesh)
        program.release()
    assert np.all(canvas.colour.read()[..., 0] == 0.5)


def test_each_is_listed_and_released_once(device: Device, folder: Path) -> None:
    before, bytes_before = device.live_objects, device.live_bytes
    canvas = Canvas(device, (6, 5), label="lawn")
    mesh = Mesh(device, corners(0, 0, 1, 1, 0, 1), np.array([[0, 1, 2]]), label="tile")
    program = DrawPass(device, "one.vert", "p.frag", PAINT)
    listed = " ".join(device.live_objects)
    assert all(name in listed for name in ("lawn colour", "depth lawn", "mesh tile", "one.vert"))
    # 30 pixels of four halves and 4 bytes of depth; 4 vertices of 24 bytes and three indices.
    assert device.live_bytes - bytes_before == 30 * 12 + 4 * 24 + 12 + PAINT.dtype.itemsize
    for thing in (canvas, mesh, program):
        thing.release()
        thing.release()
    assert (device.live_objects, device.live_bytes) == (before, bytes_before)
    assert folder.is_dir()


def test_a_missing_attribute_is_named(bench: Bench) -> None:
    canvas = bench.canvas(2, 2)
    canvas.begin()
    with pytest.raises(ShaderError, match=r"many\.vert \+ p\.frag: the mesh lacks.*in_at"):
        bench.program("many.vert").draw(bench.mesh((-1, -1, 1, 1, 0, 1)))


@pytest.mark.parametrize(
    ("name", "line"), [("one.vert", "gl_Position = nothing;"), ("p.frag", "light = nothing;")]
)
def test_a_compiler_error_names_file_and_line(
    device: Device, folder: Path, name: str, line: str
) -> None:
    text = SHADERS[name].replace("void main() {", f"void main() {{\n{line}\n")
    number = text.splitlines().index(line) + 1
    (folder / name).write_text(text, encoding="utf-8")
    with pytest.raises(ShaderError, match=rf"{name}:{number}.*nothing"):
        DrawPass(device, "one.vert", "p.frag", PAINT)


def test_a_block_that_no_shader_includes_is_refused(device: Device, folder: Path) -> None:
    text = _VERT.replace(" + vec4(shift.xyz, 0.0)", "").replace('#include "block/Paint"', "")
    (folder / "one.vert").write_text(text, encoding="utf-8")
    with pytest.raises(ShaderError, match="uses nothing of its block Paint"):
        DrawPass(device, "one.vert", "p.frag", PAINT)


@pytest.mark.parametrize(
    ("triangles", "problem"),
    [
        (np.array([0, 1, 2]), r"shape \(3,\), wanted \(T, 3\)"),
        (np.array([[0, 1, 4]]), "outside 0 to 3"),
        (np.array([[-1, 1, 2]]), "outside 0 to 3"),
        (np.zeros((0, 3), int), "an empty array"),
    ],
)
def test_bad_triangles_are_refused(
    device: Device, triangles: NDArray[np.int64], problem: str
) -> None:
    with pytest.raises(ValueError, match=problem):
        Mesh(device, corners(0, 0, 1, 1, 0, 1), triangles, label="tile")


def test_an_attribute_of_another_type_is_refused(bench: Bench, device: Device) -> None:
    vertices = np.zeros(3, [("in_place", "f8", 3), ("in_shade", "f4")])
    mesh = bench.keep(Mesh(device, vertices, np.array([[0, 1, 2]])))
    with pytest.raises(ValueError, match=r"in_place: found .*wanted one to four float32"):
        bench.program("one.vert").draw(mesh)


def test_a_canvas_beyond_the_limit_is_refused(device: Device) -> None:
    with pytest.raises(InputError, match="wanted at most"):
        Canvas(device, (device.info.max_texture_px + 1, 2))
