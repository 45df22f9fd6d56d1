"""The window's own framebuffer: copied onto, drawn onto by others, read back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu.device import Device
from vrlf.gpu.memory import Texture


def show_on_screen(device: Device, canvas: Texture) -> None:
    """Copy a picture of the window's size (kind f1, row 0 the lowest), pixel for pixel.

    What is drawn afterwards, by whomever, goes onto the window too.
    """
    screen = device.context.detect_framebuffer(0)
    device.context.copy_framebuffer(screen, canvas.as_source())
    screen.use()
    device.check("showing the window")


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
