"""Turns of the window's loop with a clock of one's own; run in a process that has a display.

python preview_by_hand.py SCENARIO
"""

from __future__ import annotations

import gc
import json
import os
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pass_rigs
from live_by_hand import Known, light_at
from numpy.typing import NDArray

from vrlf.app.options import RigChoice
from vrlf.app.preview import panels  # noqa: F401 - before glfw, whose library it names
from vrlf.app.preview.files import Files
from vrlf.app.preview.loop import Opening, Preview
from vrlf.app.preview.session import Session
from vrlf.errors import DeviceError
from vrlf.gpu import Device
from vrlf.gpu.screen import read_screen
from vrlf.gpu.window import Window
from vrlf.model import Rig
from vrlf.renderer import GpuRenderer

RIG = pass_rigs.SMALL["coma-lenslets"]
SIZE = (RIG.panel.width_px, RIG.panel.height_px)
FRAME_S = 1.0 / 60.0


class Wild(Known):
    """Shows values that are no light."""

    def draw(self, target: Any, rig: Rig, **_how: Any) -> None:
        self.drawn += 1
        light = light_at(rig)
        light[::2, ::3] = (np.nan, np.inf, -np.inf)
        target.write(light)


def main() -> None:
    """Run a scenario; what it found goes to standard output."""
    scenarios = (fault, wild, lost, small, long, early)
    scenario = next(each for each in scenarios if each.__name__ == sys.argv[1])
    with Window(SIZE, "by hand") as window, window.device() as device:
        live = Wild(is_still=False) if sys.argv[1] == "wild" else Known(is_still=False)
        session = Session(rig=RIG, loaded=RIG, has_panels=False)
        files = Files(RigChoice("bare", (), None, None, None), Path(tempfile.gettempdir()))
        preview = Preview(window, device, session, live, files, Opening(rays=16))
        try:
            print(json.dumps(scenario(preview, window, device, live)))
        finally:
            preview.release()
            left = device.live_objects
    assert left == (), left


def turns(preview: Preview, device: Device, window: Window, count: int) -> list[NDArray[Any]]:
    """The window's codes after each of some turns, a sixtieth of a second apart."""
    found = []
    for _ in range(count):
        preview.session = replace(preview.session, message="")
        preview.turn(turns.now_s, FRAME_S)  # type: ignore[attr-defined]
        turns.now_s += FRAME_S  # type: ignore[attr-defined]
        found.append(read_screen(device, window.size_px).astype(int))
    return found


turns.now_s = 100.0  # type: ignore[attr-defined]


def fault(preview: Preview, window: Window, device: Device, live: Known) -> dict[str, Any]:
    """The source fails for a while, then works again."""
    good = turns(preview, device, window, 40)[-1]
    live.fails = RuntimeError("something broke")
    fading = turns(preview, device, window, 60)
    live.fails = None
    back = turns(preview, device, window, 60)
    steps = [np.abs(b - a).max() for a, b in zip([good, *fading], [*fading, *back], strict=False)]
    return {
        "first": int(np.abs(fading[0] - good).max()),
        "largest_step": int(max(steps)),
        "grey_at": [int(k) for k, codes in enumerate(fading) if (codes == 118).all()],
        "is_back": bool((back[-1] != 118).any()),
        "fault": preview._guard.fault,
    }


def early(preview: Preview, window: Window, device: Device, live: Known) -> dict[str, Any]:
    """Nothing was ever drawn; a screenshot and new shaders are asked for all the same."""
    live.fails = RuntimeError("something broke")
    for chord in ("f12", "f5"):
        preview._chords.append((chord, False))
        preview.turn(200.0, FRAME_S)
    live.fails = None
    return {"is_alive": bool(turns(preview, device, window, 60)[-1].any())}


def wild(preview: Preview, window: Window, device: Device, _live: Known) -> dict[str, Any]:
    """No number, infinite light: dark and full drive, never another code."""
    preview.session = replace(preview.session, view="target")
    codes = turns(preview, device, window, 5)[-1]
    spots = codes[::2, ::3]
    return {"spots": sorted({tuple(int(c) for c in each) for each in spots.reshape(-1, 3)})}


def lost(preview: Preview, window: Window, device: Device, live: Known) -> dict[str, Any]:
    """The GPU answers nothing any more."""
    turns(preview, device, window, 3)
    live.fails = DeviceError("GPU: found GL_UNKNOWN_ERROR, wanted no error")

    def refuse(*_: Any) -> None:
        raise DeviceError("GPU: found GL_UNKNOWN_ERROR, wanted no error")

    device.check = refuse  # type: ignore[method-assign]
    try:
        for k in range(9):
            preview.turn(200.0 + k, FRAME_S)
    except DeviceError as error:
        return {"error": str(error)}
    finally:
        del device.check
    return {"error": ""}


def small(preview: Preview, window: Window, device: Device, live: Known) -> dict[str, Any]:
    """Minimised: the framebuffer has no size, and nothing is drawn."""
    turns(preview, device, window, 3)
    before = live.drawn
    real = type(window).size_px
    type(window).size_px = property(lambda _: (0, 0))  # type: ignore[method-assign, assignment]
    preview.turn(200.0, FRAME_S)
    preview.turn(201.0, FRAME_S)
    type(window).size_px = real  # type: ignore[method-assign]
    drawn = live.drawn - before
    turns(preview, device, window, 2)
    return {"drawn_meanwhile": drawn, "drawn_after": live.drawn - before}


def long(preview: Preview, window: Window, device: Device, live: Known) -> dict[str, Any]:
    """Many frames, every tenth with another prescription; the picture moves all the time.

    Each frame belongs to the prescription that was wanted when it began, wholly: its eyes are those
    of the session, and the panel image is held against a renderer's own.
    """
    frames, views = int(sys.argv[2]), ("panel", "perceived", "compare", "wall")
    preview._clock.period_ms = 0.01  # no display to wait for
    footprints, mixed, late = {}, 0, 0
    with GpuRenderer(device) as renderer:
        for index in range(frames):
            if index % 10 == 0:
                sphere_d = -6.0 + 0.25 * (index // 10 % 17)
                eye = RIG.left.model_copy(update={"sphere_d": sphere_d})
                preview.session = replace(preview.session, rig=RIG.model_copy(update={"left": eye}))
            view: Any = views[index // 100 % len(views)]
            preview.session = replace(preview.session, view=view, message="")
            window.wait(0.0)
            preview.turn(300.0 + index * FRAME_S, FRAME_S)
            late += preview._frames.rig.left != preview.session.rig.left
            if view == "panel" and index % 10 == 0:
                light = light_at(RIG, preview._time_s, preview.session.head)
                wanted = renderer.encode(renderer.prefilter(light, preview._frames.rig))
                shown = preview._frames.canvas.read()[::-1, :, :3]
                mixed += bool((shown != wanted).any())
            if index + 1 in (1000, frames):
                gc.collect()
                footprints[index + 1] = [
                    len(device.live_objects),
                    device.live_bytes,
                    int(Path("/proc/self/statm").read_text().split()[1])
                    * os.sysconf("SC_PAGE_SIZE"),
                ]
    return {
        "changes": frames // 10,
        "late": late,
        "mixed": mixed,
        "drawn": live.drawn,
        "footprints": footprints,
    }


if __name__ == "__main__":
    main()
