"""Take the README's pictures of the window: `python scripts/window_pictures.py`.

Opens `vrlf preview` on a virtual screen of its own (Xvfb and xdotool, which `make test` installs),
presses keys and reads what the screen shows. Writes docs/window-*.jpg.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from skimage import data

from vrlf.images import write_encoded

sys.path.append(str(Path(__file__).resolve().parent.parent / "tests"))
from virtual_screen import Screen

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
                _take(folder, Screen(":98", folder / "Xvfb_screen0", server))
            finally:
                server.terminate()


def _take(folder: Path, screen: Screen) -> None:
    environment = {
        **os.environ,
        "DISPLAY": screen.display,
        "VRLF_CONFIG_DIR": str(folder / "configuration"),
    }
    given = ["-r", "matched-microlens", "--left", "-5.00 / -1.25 x 170", "--right", "-4.50"]
    command = [sys.executable, "-m", "vrlf", "preview", str(folder / "astronaut.png"), *given]
    with subprocess.Popen([*command, "--folder", str(folder)], env=environment) as window:
        time.sleep(12.0)
        for name, keys, seconds in PICTURES:
            screen.mouse("key", "--delay", "400", *keys)
            screen.mouse("mousemove", "1270", "710")
            time.sleep(seconds)
            target = DOCS / f"window-{name}.jpg"
            write_encoded(target, screen.pixels())
            print(target)
        window.terminate()


if __name__ == "__main__":
    main()
