"""The window's own framebuffer: drawn onto by us, then by others, and read back."""

from __future__ import annotations

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrlf.gpu.device import Device
from vrlf.gpu.draw import linked
from vrlf.gpu.memory import Texture
from vrlf.gpu.sources import assemble
from vrlf.resources import shaders_dir


class Screen:
    """Owns the program that brings a picture onto the window of the device's context.

    It draws: a driver's copying may take a megabyte after some thousand frames.
    """

    def __init__(self, device: Device) -> None:
        self._device = device
        vertex, fragment = (assemble(f"screen.{end}", shaders_dir()) for end in ("vert", "frag"))
        self._program = linked(device, vertex, fragment, "screen.vert + screen.frag")
        self._feed = device.context.vertex_array(self._program, [])
        self._ticket = device.enlist("pass screen.vert + screen.frag", 0)

    def show(self, canvas: Texture) -> None:
        """Draw a picture of the window's size (kind f1, row 0 the lowest), pixel for pixel.

        What is drawn afterwards, by whomever, goes onto the window too.
        """
        context = self._device.context
        screen = context.detect_framebuffer(0)
        screen.use()
        screen.viewport = (0, 0, *canvas.size_px)
        context.enable_only(moderngl.NOTHING)
        canvas.bind_sampler(0)
        self._feed.render(moderngl.TRIANGLES, vertices=3)
        self._device.check("showing the window")

    def release(self) -> None:
        """Give the program back; the second call does nothing."""
        if self._ticket:
            self._feed.release()
            self._program.release()
            self._device.strike(self._ticket)
            self._ticket = 0


def read_screen(device: Device, size_px: tuple[int, int]) -> NDArray[np.uint8]:
    """What the window will show, shape (H, W, 3), row 0 at the top.

    By way of a framebuffer of our own: reading the window's leaves an error behind.
    """
    context = device.context
    copy = context.simple_framebuffer(size_px, 4)
    screen = context.detect_framebuffer(0)
    try:
        context.copy_framebuffer(copy, screen)
        raw = copy.read(components=4, alignment=1)
        screen.use()
    finally:
        copy.release()
    device.check("reading the window")
    codes = np.frombuffer(raw, np.uint8).reshape(size_px[1], size_px[0], 4)
    return np.ascontiguousarray(codes[::-1, :, :3])
