"""Take the README's pictures of the window: `python scripts/window_pictures.py`.

Opens `vrlf preview` on a virtual screen of its own (Xvfb and xdotool, which `make test` installs),
presses keys and reads what the screen shows. Writes docs/window-*.jpg.
"""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from skimage import data

from vrlf.images import write_encoded

DOCS = Path(__file__).resolve().parent.parent / "docs"
SIZE = (1280, 720)
# Picture: what is pressed before it is taken, and how long all of it may take to be there.
PICTURES = (
    ("compare", ("5", "1", "bracketleft", "bracketleft", "9", "t"), 14.0),
    ("wall", ("t", "Tab", "0"), 14.0),
    ("alignment", ("Tab", "5", "g", "Right", "Tab"), 14.0),
)


def main() -> None:
    """Take them all."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_encoded(folder / "astronaut.png", data.astronaut())
        with subprocess.Popen(
            ["Xvfb", ":98", "-screen", "0", f"{SIZE[0]}x{SIZE[1]}x24", "-fbdir", name],
            stderr=subprocess.DEVNULL,
        ) as server:
            try:
                time.sleep(2.0)
                _take(folder)
            finally:
                server.terminate()


def _take(folder: Path) -> None:
    environment = {**os.environ, "DISPLAY": ":98", "VRLF_CONFIG_DIR": str(folder / "configuration")}
    given = ["-r", "matched-microlens", "--left", "-5.00 / -1.25 x 170", "--right", "-4.50"]
    command = [sys.executable, "-m", "vrlf", "preview", str(folder / "astronaut.png"), *given]
    with subprocess.Popen([*command, "--folder", str(folder)], env=environment) as window:
        time.sleep(12.0)
        for name, keys, seconds in PICTURES:
            subprocess.run(["xdotool", "key", "--delay", "400", *keys], env=environment, check=True)
            subprocess.run(["xdotool", "mousemove", "1270", "710"], env=environment, check=True)
            time.sleep(seconds)
            target = DOCS / f"window-{name}.jpg"
            write_encoded(target, _screen(folder / "Xvfb_screen0"))
            print(target)
        window.terminate()


def _screen(path: Path) -> NDArray[np.uint8]:
    """The virtual screen's pixels: an XWD file, version 7."""
    raw = path.read_bytes()
    header = struct.unpack(">25I", raw[:100])
    size, width, height, row_bytes, colours = (header[k] for k in (0, 4, 5, 12, 19))
    start = size + 12 * colours
    codes = np.frombuffer(raw[start : start + row_bytes * height], np.uint8)
    bgrx = codes.reshape(height, row_bytes // 4, 4)[:, :width]
    return np.ascontiguousarray(bgrx[..., 2::-1])


if __name__ == "__main__":
    main()
