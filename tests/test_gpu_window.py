"""A device from a real window, on a virtual screen; and what is said without a screen."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

# Prints a digest of a small perceived picture; DEVICE is how its device comes up.
_DRAW = """
import contextlib, hashlib
import numpy as np
from vrlf.gpu import Device
from vrlf.gpu.window import Window
from vrlf.model import load_rig
from vrlf.renderer import GpuRenderer

rig = load_rig("matched-microlens", overrides=[
    "panel.width_px=97", "panel.height_px=64", "headset.lens_separation_mm=3.7"])
panel = np.random.default_rng(3).random((64, 97, 3)).astype(np.float32)
with contextlib.ExitStack() as stack:
    device = DEVICE
    with GpuRenderer(device) as renderer:
        seen = renderer.perceive(panel, rig, rays=32)
    assert device.live_objects == (), device.live_objects
    assert seen.mean() > 0.1
    device.release()
print(hashlib.sha256(seen.tobytes()).hexdigest())
"""
_WINDOWED = 'stack.enter_context(Window((64, 48), "test", visible=VISIBLE)).device()'


def _run(program: str, **environment: str) -> subprocess.CompletedProcess[str]:
    kept = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    return subprocess.run(
        [sys.executable, "-c", program],
        env={**kept, **environment},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.mark.parametrize("visible", [True, False])
def test_a_window_lends_its_context(display: str, visible: bool) -> None:
    """One driver on one CPU gives the same bytes whichever way its context came up.

    Two processes: EGL and GLX do not share a thread.
    """
    alone = _run(_DRAW.replace("DEVICE", "Device.headless()"))
    program = _DRAW.replace("DEVICE", _WINDOWED).replace("VISIBLE", str(visible))
    windowed = _run(program, DISPLAY=display)
    assert alone.returncode == 0, alone.stderr
    assert windowed.returncode == 0, windowed.stderr
    assert windowed.stdout == alone.stdout


def test_without_a_display_the_error_says_so() -> None:
    program = "from vrlf.gpu.window import Window\nWindow((64, 48), 'test')\n"
    result = _run(program)
    last = result.stderr.strip().splitlines()[-1]
    assert result.returncode == 1
    assert "DeviceError: window: found no display" in last
    assert "wanted one" in last


def test_a_window_too_old_says_so(display: str) -> None:
    program = "from vrlf.gpu.window import Window\nWindow((64, 48), 'test')\n"
    result = _run(program, DISPLAY=display, MESA_GL_VERSION_OVERRIDE="3.3")
    assert "DeviceError: window: found no display that gives an OpenGL 4.3 window" in result.stderr
