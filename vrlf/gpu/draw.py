"""What a scene is drawn with: a program, a mesh, and a canvas with depth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrlf.errors import ShaderError
from vrlf.gpu.blocks import Block
from vrlf.gpu.compute import check_block_size
from vrlf.gpu.device import Device
from vrlf.gpu.memory import Texture
from vrlf.gpu.sources import assemble
from vrlf.resources import shaders_dir

# numpy base type of a vertex attribute -> moderngl's letter.
_LETTER = {"f": "f", "i": "i"}


class Canvas:
    """A float picture with depth that is drawn into. Row 0 is the first row of clip space."""

    def __init__(self, device: Device, size_px: tuple[int, int], *, label: str = "canvas") -> None:
        self._device = device
        self.colour = Texture(device, size_px, label=label)
        self._depth = device.context.depth_renderbuffer(size_px)
        self._frame = self.colour.as_framebuffer(self._depth)
        self._ticket = device.enlist(f"canvas {label}", size_px[0] * size_px[1] * 4)
        try:
            device.check(f"allocating {label}")
        except Exception:
            self.release()
            raise

    def clear(self, colour: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)) -> None:
        """Fill with one colour, at the greatest depth, and draw here from now on."""
        self._frame.use()
        self._frame.clear(*colour, depth=1.0)

    def release(self) -> None:
        """Give the memory back; the second call does nothing."""
        if self._ticket:
            self._frame.release()
            self._depth.release()
            self.colour.release()
            self._device.strike(self._ticket)
            self._ticket = 0


class DrawPass:
    """Owns a vertex and a fragment shader, their uniform block, and the meshes' bindings."""

    def __init__(
        self,
        device: Device,
        vertex: str,
        fragment: str,
        block: Block,
        *,
        defines: Mapping[str, int | float | str] | None = None,
    ) -> None:
        self._device, self._block = device, block
        virtual = {f"block/{block.name}": block.glsl}
        sources = [
            assemble(name, shaders_dir(), defines=defines, virtual=virtual)
            for name in (vertex, fragment)
        ]
        try:
            self._program = device.context.program(
                vertex_shader=sources[0].text, fragment_shader=sources[1].text
            )
        except Exception as error:  # moderngl.Error, with the compiler's log in its text
            at_fault = 1 if "fragment_shader" in str(error) else 0
            name = (vertex, fragment)[at_fault]
            raise ShaderError(f"{name}: {sources[at_fault].explain(str(error))}") from error
        self._uniforms = device.context.buffer(reserve=block.dtype.itemsize)
        self._ticket = device.enlist(f"draw {fragment}", block.dtype.itemsize)
        try:
            check_block_size(self._program, block, fragment)
        except ShaderError:
            self.release()
            raise

    def mesh(self, vertices: NDArray[np.void], *, label: str) -> Mesh:
        """Triangles for this program from a structured array, one entry a vertex."""
        return Mesh(self._device, self._program, vertices, label=label)

    def draw(self, mesh: Mesh, values: Mapping[str, Any]) -> None:
        """Draw into the canvas that was cleared last."""
        self._uniforms.write(self._block.pack(values).tobytes())
        self._uniforms.bind_to_uniform_block(self._block.binding)
        self._device.context.enable_only(moderngl.DEPTH_TEST)
        mesh.render()
        self._device.check("drawing")

    def release(self) -> None:
        """Give program and buffer back; the second call does nothing."""
        if self._ticket:
            self._program.release()
            self._uniforms.release()
            self._device.strike(self._ticket)
            self._ticket = 0


class Mesh:
    """Triangles on the GPU, bound to one program's attributes by name."""

    def __init__(
        self, device: Device, program: Any, vertices: NDArray[np.void], *, label: str
    ) -> None:
        self._device = device
        names = list(vertices.dtype.names or ())
        form = " ".join(_attribute(vertices.dtype, name) for name in names)
        self._buffer = device.context.buffer(np.ascontiguousarray(vertices).tobytes())
        self._array = device.context.vertex_array(program, [(self._buffer, form, *names)])
        self._ticket = device.enlist(f"mesh {label}", vertices.nbytes)
        device.check(f"allocating {label}")

    def render(self) -> None:
        """Issue the draw call."""
        self._array.render(moderngl.TRIANGLES)

    def release(self) -> None:
        """Give the memory back; the second call does nothing."""
        if self._ticket:
            self._array.release()
            self._buffer.release()
            self._device.strike(self._ticket)
            self._ticket = 0


def _attribute(dtype: np.dtype[Any], name: str) -> str:
    base, shape = dtype[name].subdtype or (dtype[name], ())
    if base.itemsize != 4 or base.kind not in _LETTER:
        raise ValueError(f"vertex attribute {name}: found {base}, wanted 32-bit floats or integers")
    return f"{shape[0] if shape else 1}{_LETTER[base.kind]}"
