"""A compute program with its uniform block."""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil
from typing import Any

import numpy as np

from vrlf.errors import ShaderError
from vrlf.gpu.blocks import Block
from vrlf.gpu.device import Device
from vrlf.gpu.sources import Source, assemble
from vrlf.resources import shaders_dir

GROUP_PX = 8  # every pass over a raster works in 8 x 8 groups


class ComputePass:
    """Owns a compute program and the buffer of its uniform block.

    Parameters
    ----------
    device : Device
    shader : str
        File below ``shaders/``.
    block : Block
        The shader includes it as ``block/NAME``.
    defines : mapping, optional
        Compile-time choices.
    """

    def __init__(
        self,
        device: Device,
        shader: str,
        block: Block,
        *,
        defines: Mapping[str, int | float | str] | None = None,
    ) -> None:
        self._device, self._block, self._shader = device, block, shader
        source = assemble(
            shader,
            shaders_dir(),
            defines={"GROUP_PX": GROUP_PX, **(defines or {})},
            virtual={f"block/{block.name}": block.glsl},
        )
        self._program = _compile(device, source, shader)
        self._uniforms = device.context.buffer(reserve=block.dtype.itemsize)
        self._ticket = device.enlist(f"pass {shader}", block.dtype.itemsize)
        try:
            check_block_size(self._program, block, shader)
        except ShaderError:
            self.release()
            raise

    def set(self, values: Mapping[str, Any]) -> None:
        """Fill the uniform block."""
        self._uniforms.write(self._block.pack(values).tobytes())

    def run(self, width_px: int, height_px: int = 1, layers: int = 1) -> None:
        """Dispatch enough groups to cover a raster; storage is visible to what follows."""
        context = self._device.context
        self._uniforms.bind_to_uniform_block(self._block.binding)
        self._program.run(ceil(width_px / GROUP_PX), ceil(height_px / GROUP_PX), layers)
        context.memory_barrier()

    def run_linear(self, count: int, group: int) -> None:
        """Dispatch enough groups of ``group`` invocations to cover a list."""
        context = self._device.context
        self._uniforms.bind_to_uniform_block(self._block.binding)
        self._program.run(ceil(count / group), 1, 1)
        context.memory_barrier()

    def release(self) -> None:
        """Give program and buffer back; the second call does nothing."""
        if self._ticket:
            self._program.release()
            self._uniforms.release()
            self._device.strike(self._ticket)
            self._ticket = 0


class ComputeVariants:
    """Owns one shader's programs, one for each set of defines that was asked for so far."""

    def __init__(self, device: Device, shader: str, block: Block) -> None:
        self._device, self._shader, self._block = device, shader, block
        self._programs: dict[tuple[tuple[str, Any], ...], ComputePass] = {}

    def get(self, defines: Mapping[str, int | float | str]) -> ComputePass:
        """The program for these defines, compiled when first needed."""
        key = tuple(sorted(defines.items()))
        if key not in self._programs:
            self._programs[key] = ComputePass(
                self._device, self._shader, self._block, defines=defines
            )
        return self._programs[key]

    def release(self) -> None:
        """Give the programs back."""
        for program in self._programs.values():
            program.release()
        self._programs.clear()


def check_block_size(program: Any, block: Block, shader: str) -> None:
    """Compare a block's declared size with the compiled program's."""
    try:
        found = program[block.name].size
    except KeyError:
        raise ShaderError(f"{shader}: uses nothing of its block {block.name}") from None
    wanted = np.zeros((), block.dtype).nbytes
    if found != wanted:
        raise ShaderError(
            f"{shader}: block {block.name} has {found} bytes on the GPU, {wanted} in Python"
        )


def _compile(device: Device, source: Source, shader: str) -> Any:
    try:
        program = device.context.compute_shader(source.text)
    except Exception as error:  # moderngl.Error, with the compiler's log in its text
        raise ShaderError(f"{shader}: {source.explain(str(error))}") from error
    device.check(f"compiling {shader}")
    return program
