"""A screen without a monitor: what is on it, and keys that go to the window under its pointer."""

from __future__ import annotations

import struct
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

SERVER = ("-screen", "0", "640x480x24", "-nolisten", "tcp")


@dataclass(frozen=True)
class Screen:
    """Xvfb's name, its framebuffer's file and its process."""

    display: str
    framebuffer: Path
    server: subprocess.Popen[bytes]

    def pixels(self) -> NDArray[np.uint8]:
        """What is on it, shape (height, width, 3): an XWD file, version 7."""
        raw = self.framebuffer.read_bytes()
        header: tuple[Any, ...] = struct.unpack(">25I", raw[:100])
        size, width, height, row_bytes, colours = (header[k] for k in (0, 4, 5, 12, 19))
        start = size + 12 * colours
        codes = np.frombuffer(raw[start : start + row_bytes * height], np.uint8)
        bgrx = codes.reshape(height, row_bytes // 4, 4)[:, :width]
        return np.ascontiguousarray(bgrx[..., 2::-1])

    def keys(self, *chords: str) -> None:
        """Press them one after the other, as xdotool names them."""
        self._do("key", "--delay", "60", *chords)

    def type(self, text: str) -> None:
        """Write a text."""
        self._do("type", "--delay", "60", "--", text)

    def mouse(self, *what: str) -> None:
        """Let xdotool do something else."""
        self._do(*what)

    def _do(self, *arguments: str) -> None:
        subprocess.run(
            ["xdotool", *arguments],
            env={"DISPLAY": self.display, "PATH": "/usr/bin:/bin:/usr/local/bin"},
            check=True,
            timeout=60,
        )
