"""Makes the README's pictures from the demo: ``.venv/bin/python scripts/readme_pictures.py``."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from vrlf.images import read_picture, resize_area, write_picture

WIDTH_PX = 1200
FOLDER = Path(__file__).resolve().parent.parent / "docs"


def main() -> None:
    """Run the demo and shrink its overview."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, "-m", "vrlf", "demo", "-o", folder], check=True)
        sheet = read_picture(Path(folder) / "overview.png")
    height_px = round(sheet.shape[0] * WIDTH_PX / sheet.shape[1])
    FOLDER.mkdir(exist_ok=True)
    write_picture(FOLDER / "overview.jpg", resize_area(sheet, WIDTH_PX, height_px))


if __name__ == "__main__":
    main()
