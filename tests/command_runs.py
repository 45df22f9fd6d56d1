"""Running commands as a user does: in this process for speed, or in one of their own."""

from __future__ import annotations

import contextlib
import io
import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from files_by_hand import png
from numpy.typing import NDArray

from vrlf.app.main import run
from vrlf.images import write_picture

DATA = Path(__file__).resolve().parent / "data"
# 96 x 64 pixels, full sub-pixels; a turned microlens array, and none.
LENSLETS = ("-r", str(DATA / "lenslets-turned.toml"))
BARE = ("-r", str(DATA / "bare-sphere.toml"))
SIZE_PX = (96, 64)

PROGRAM = (sys.executable, "-c", "from vrlf.app.main import main; main()")


class Outcome(NamedTuple):
    """What a command left with: its exit status and its two streams."""

    status: int
    out: str
    err: str

    @property
    def lines(self) -> list[str]:
        """What it said, line by line."""
        return self.err.splitlines()

    def json(self) -> dict[str, Any]:
        """Standard output as one JSON object, strictly: no NaN, nothing before or after it."""
        value = json.loads(self.out, parse_constant=_no_constant)
        assert isinstance(value, dict)
        return value


def _no_constant(name: str) -> None:
    raise AssertionError(f"found {name} in the JSON")


def call(*arguments: str | Path) -> Outcome:
    """A command in this process."""
    streams = [io.TextIOWrapper(io.BytesIO(), encoding="utf-8", newline="") for _ in range(2)]
    with contextlib.redirect_stdout(streams[0]), contextlib.redirect_stderr(streams[1]):
        status = run([str(argument) for argument in arguments])
    texts = []
    for stream in streams:
        stream.flush()
        texts.append(stream.buffer.getvalue().decode())  # type: ignore[attr-defined]
    return Outcome(status, texts[0], texts[1])


def start(*arguments: str | Path, **options: Any) -> subprocess.Popen[str]:
    """A command in a process of its own, both streams in pipes unless told otherwise."""
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    command = [*PROGRAM, *(str(argument) for argument in arguments)]
    return subprocess.Popen(command, text=True, **(pipes | options))


def spawn(*arguments: str | Path, timeout_s: float = 60.0, **options: Any) -> Outcome:
    """A command in a process of its own, to its end."""
    with start(*arguments, **options) as process:
        try:
            out, err = process.communicate(timeout=timeout_s)
        except subprocess.TimeoutExpired:
            process.kill()
            raise
    return Outcome(process.returncode, out or "", err or "")


def require_done(outcome: Outcome) -> Outcome:
    """Exit status 0 and no complaint."""
    assert outcome.status == 0, outcome.err
    assert not [line for line in outcome.lines if line.startswith("vrlf:")], outcome.err
    return outcome


def require_refused(outcome: Outcome, status: int, *names: str) -> None:
    """One line of complaint, last on standard error, that holds the names; nothing as result."""
    assert outcome.status == status, outcome
    assert outcome.out == ""
    assert "Traceback" not in outcome.err
    complaints = [line for line in outcome.lines if line.startswith("vrlf: ")]
    assert complaints == outcome.lines[-1:], outcome.err
    assert "please report" not in complaints[0]
    for name in names:
        assert name in complaints[0], complaints[0]


def require_one_line(outcome: Outcome, status: int, *names: str) -> None:
    """As ``require_refused``, and no message before it: refused before any work."""
    require_refused(outcome, status, *names)
    assert len(outcome.lines) == 1, outcome.err


def left_in(folder: Path) -> list[str]:
    """Names in a folder, hidden ones too."""
    return sorted(path.name for path in folder.iterdir())


def light(seed: int = 3, size_px: Sequence[int] = SIZE_PX) -> NDArray[np.float32]:
    """Random light between 0 and 1, a quarter of it dark."""
    shape = (size_px[1], size_px[0], 3)
    values = np.random.default_rng(seed).random(shape, dtype=np.float32)
    return np.clip(values * 1.3 - 0.3, 0.0, 1.0, dtype=np.float32)


def exr_file(path: Path, linear: NDArray[np.float32]) -> Path:
    """Linear light, exactly."""
    write_picture(path, linear)
    return path


def png_file(path: Path, codes: NDArray[np.uint8]) -> Path:
    """A picture that no library of ours wrote."""
    path.write_bytes(png(codes))
    return path
