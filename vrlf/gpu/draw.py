"""The drawing mechanism: a draw program, the meshes it draws and the canvas it draws on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrlf.errors import DeviceError, ShaderError
from vrlf.gpu.blocks import Block
from vrlf.gpu.compute import check_block_size
from vrlf.gpu.device import Device
from vrlf.gpu.memory import Texture
from vrlf.gpu.sources import Source, assemble
from vrlf.resources import shaders_dir

_SCREEN_VERTICES = 3  # one triangle that covers the whole canvas
_DEPTH_BYTES = 4


class Canvas:
    """A colour texture and a depth buffer to draw on.

    OpenGL draws upward: row 0 of ``colour`` is the *lowest* one. What reads the canvas
    turns it.

    Parameters
    ----------
    device : Device
    size_px : (width, height)
    kind : str
        Component type of the colour, as for ``Texture``.
    """

    def __init__(
        self,
        device: Device,
        size_px: tuple[int, int],
        *,
        kind: str = "f2",
        label: str = "canvas",
    ) -> None:
        self._device = device
        self.colour = Texture(device, size_px, kind=kind, label=f"{label} colour")
        self._depth: Any = None
        self._frame: Any = None
        nbytes = _DEPTH_BYTES * size_px[0] * size_px[1]
        self._ticket = device.enlist(f"depth {label} {size_px[0]}x{size_px[1]}", nbytes)
        try:
            self._depth = device.context.depth_renderbuffer(size_px)
            self._frame = self.colour.as_framebuffer(self._depth)
            device.check(f"allocating {label}")
        except (moderngl.Error, DeviceError) as error:
            self.release()
            raise DeviceError(f"{label}: the GPU gave no {size_px} canvas ({error})") from error

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height."""
        return self.colour.size_px

    def begin(self, clear: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)) -> None:
        """Draw on this canvas from now on, from an empty one: colour ``clear``, depth far."""
        self._frame.use()
        self._frame.clear(*clear, depth=1.0)

    def release(self) -> None:
        """Give the memory back; the second call does nothing."""
        if self._ticket:
            self._device.rest()
            for part in (self._frame, self._depth, self.colour):
                if part is not None:
                    part.release()
            self._device.strike(self._ticket)
            self._ticket = 0


class Mesh:
    """Triangles: a vertex buffer, three indices a triangle, and any number of instances.

    The fields of the arrays are the attributes of the vertex shader, by name; each is
    float32, one to four of them. An instance field advances once an instance.

    Parameters
    ----------
    device : Device
    vertices : structured array, shape (V,)
    triangles : int array, shape (T, 3)
        Anticlockwise, seen from the front.
    instances : structured array, shape (N,), optional
        At least one; without it the vertices are drawn once.
    """

    def __init__(
        self,
        device: Device,
        vertices: NDArray[np.void],
        triangles: NDArray[np.integer[Any]],
        *,
        instances: NDArray[np.void] | None = None,
        label: str = "mesh",
    ) -> None:
        _require_triangles(triangles, len(vertices), label)
        arrays: list[NDArray[Any]] = [vertices] if instances is None else [vertices, instances]
        if any(len(array) == 0 for array in (*arrays, triangles)):
            raise ValueError(f"{label}: found an empty array, wanted something to draw")
        self._device = device
        self._feeds: list[tuple[Any, np.dtype[Any], str]] = []
        self._indices: Any = None
        self.instance_count = 1 if instances is None else len(instances)
        nbytes = sum(int(array.nbytes) for array in arrays) + 4 * int(triangles.size)
        self._ticket = device.enlist(f"mesh {label}", nbytes)
        try:
            for array, per in zip(arrays, ("", "/i"), strict=False):
                self._feeds.append((_uploaded(device, array), array.dtype, per))
            self._indices = _uploaded(device, triangles.astype(np.uint32))
            device.check(f"allocating {label}")
        except (moderngl.Error, DeviceError) as error:
            self.release()
            raise DeviceError(f"{label}: the GPU gave no buffer for it ({error})") from error

    def bound_to(self, program: Any, shader: str) -> Any:
        """A vertex array that feeds a program's attributes; the caller releases it."""
        wanted = {name for name in program if isinstance(program[name], moderngl.Attribute)}
        given = {name for _, dtype, _ in self._feeds for name in dtype.names or ()}
        if wanted - given:
            raise ShaderError(f"{shader}: the mesh lacks the attributes {sorted(wanted - given)}")
        content = [(buffer, *_fed(dtype, wanted, per)) for buffer, dtype, per in self._feeds]
        used = [feed for feed in content if len(feed) > 2]  # moderngl refuses one without names
        return self._device.context.vertex_array(program, used, index_buffer=self._indices)

    def release(self) -> None:
        """Give the buffers back; the second call does nothing."""
        if self._ticket:
            for buffer in (*(buffer for buffer, _, _ in self._feeds), self._indices):
                if buffer is not None:
                    buffer.release()
            self._device.strike(self._ticket)
            self._ticket = 0


class DrawPass:
    """Owns a draw program and the buffer of its uniform block.

    Parameters
    ----------
    device : Device
    vertex, fragment : str
        Files below ``shaders/``.
    block : Block
        Both shaders may include it as ``block/NAME``; one of them uses it.
    defines : mapping, optional
        Compile-time choices.
    """

    def __init__(
        self,
        device: Device,
        vertex: str,
        fragment: str,
        block: Block,
        *,
        defines: Mapping[str, int | float | str] | None = None,
    ) -> None:
        self._device, self._block, self._shader = device, block, f"{vertex} + {fragment}"
        virtual = {f"block/{block.name}": block.glsl}
        sources = [
            assemble(name, shaders_dir(), defines=defines, virtual=virtual)
            for name in (vertex, fragment)
        ]
        self._program = linked(device, sources[0], sources[1], self._shader)
        self._uniforms = device.context.buffer(reserve=block.dtype.itemsize)
        self._ticket = device.enlist(f"pass {self._shader}", block.dtype.itemsize)
        try:
            check_block_size(self._program, block, self._shader)
        except ShaderError:
            self.release()
            raise

    def set(self, values: Mapping[str, Any]) -> None:
        """Fill the uniform block."""
        self._uniforms.write(self._block.pack(values).tobytes())

    def draw(self, mesh: Mesh) -> None:
        """Draw all instances of a mesh on the canvas that was begun; the nearest wins."""
        # A vertex array is a few words: made for the draw, it outlives neither mesh nor pass.
        feed = mesh.bound_to(self._program, self._shader)
        self._render(feed, instances=mesh.instance_count)

    def draw_screen(self) -> None:
        """Draw one triangle, of which the shader knows gl_VertexID 0, 1, 2 and nothing else.

        Put at the depth of the far plane (z = w) it fills what nothing was drawn on.
        """
        feed = self._device.context.vertex_array(self._program, [])
        self._render(feed, vertices=_SCREEN_VERTICES)

    def _render(self, feed: Any, **how: int) -> None:
        context = self._device.context
        context.enable_only(moderngl.DEPTH_TEST)
        context.depth_func = "<="  # so that the far plane itself still counts
        self._uniforms.bind_to_uniform_block(self._block.binding)
        try:
            feed.render(moderngl.TRIANGLES, **how)
        finally:
            feed.release()
            context.enable_only(moderngl.NOTHING)
        self._device.check(f"drawing with {self._shader}")

    def release(self) -> None:
        """Give program and buffer back; the second call does nothing."""
        if self._ticket:
            self._program.release()
            self._uniforms.release()
            self._device.strike(self._ticket)
            self._ticket = 0


def _uploaded(device: Device, array: NDArray[Any]) -> Any:
    return device.context.buffer(np.ascontiguousarray(array).tobytes())


def _require_triangles(triangles: NDArray[np.integer[Any]], vertices: int, label: str) -> None:
    """An index beyond the vertices would read foreign memory, without an error."""
    if triangles.ndim != 2 or triangles.shape[1] != 3:
        raise ValueError(f"{label}: found triangles of shape {triangles.shape}, wanted (T, 3)")
    if triangles.size and not 0 <= int(triangles.min()) <= int(triangles.max()) < vertices:
        raise ValueError(f"{label}: found an index outside 0 to {vertices - 1}")


def _fed(dtype: np.dtype[Any], wanted: set[str], per: str) -> tuple[str, ...]:
    """moderngl's format of a buffer and its attributes; what the program left out is skipped."""
    parts: list[str] = []
    for name in dtype.names or ():
        kind = dtype[name]
        count = int(np.prod(kind.shape, dtype=int))
        if kind.base != np.float32 or not 1 <= count <= 4:
            raise ValueError(f"attribute {name}: found {kind}, wanted one to four float32")
        parts.append(f"{count}f4" if name in wanted else f"{4 * count}x1")
    names = [name for name in dtype.names or () if name in wanted]
    return (" ".join(parts) + per, *names)


def linked(device: Device, vertex: Source, fragment: Source, shader: str) -> Any:
    """A program for drawing, or the compiler's message."""
    try:
        program = device.context.program(vertex_shader=vertex.text, fragment_shader=fragment.text)
    except Exception as error:  # moderngl.Error, with the compiler's log in its text
        log = str(error)
        source = fragment if "fragment_shader" in log else vertex
        raise ShaderError(f"{shader}: {source.explain(log)}") from error
    device.check(f"linking {shader}")
    return program
