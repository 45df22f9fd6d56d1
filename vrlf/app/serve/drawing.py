"""What the phone shows: the preview's session and frames without a window, read back as codes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from vrlf.app.preview.fading import Fade, faded, words_of
from vrlf.app.preview.files import Files, as_loaded
from vrlf.app.preview.frames import Frames, Moment
from vrlf.app.preview.keys import Press, press_of
from vrlf.app.preview.layout import placed
from vrlf.app.preview.session import Session, act, strolled
from vrlf.app.preview.steps import written
from vrlf.app.serve.wire import Measured
from vrlf.errors import DeviceError, InputError, VrlfError
from vrlf.files import check_target, shown
from vrlf.gpu import Device, Texture
from vrlf.model import Rig, rig_from_tables
from vrlf.model.saving import new_rig_file
from vrlf.optics.viewport import SIDES, pitch_mm, viewport
from vrlf.renderer.live import Live
from vrlf.scene import HeadPose

# The panel image alone is computed; the window's perceived views would need more.
_RAYS = 8
_LOST_AFTER = 3
_STROLL_S = 0.1
_WORDS_HALF = 0.11  # as phone.css has it, in shares of the panel
_WALKING = frozenset({"walk_ahead", "walk_left", "walk_back", "walk_right"})
# On a phone there is nothing to do for these.
_NOT_HERE: Final[Mapping[str, str]] = {
    "type": "typing a prescription: in vrlf preview",
    **dict.fromkeys(("fullscreen", "monitor", "screenshot", "screenshot_all", "shaders", "leave",
                     "help", "panels", "timing", "loupe", "zoom", "zoom_in", "zoom_out", "eyes",
                     "view_panel", "view_perceived", "view_uncorrected", "view_target",
                     "view_difference", "view_compare", "view_wall"),
                    "that key is for the window of vrlf preview"),
}  # fmt: skip


def lens_axes(rig: Rig) -> tuple[float, float]:
    """Where the lenses' axes meet the panel, in shares of its width; words there stay whole."""
    width_mm = rig.panel.width_px * pitch_mm(rig)
    left, right = (0.5 + viewport(rig, side).axis_mm[0] / width_mm for side in SIDES)
    return max(left, _WORDS_HALF), min(right, 1.0 - _WORDS_HALF)


class Drawing:
    """Owns the frames; device, live and files are its maker's."""

    def __init__(self, device: Device, rig: Rig, live: Live, files: Files, folder: Path) -> None:
        self._device, self._live, self._files, self._folder = device, live, files, folder
        self.session = Session(rig=rig, loaded=rig, view="panel", zoom=1.0, has_panels=False)
        self.time_s = 0.0
        self.has_latency = False
        self._held: NDArray[np.uint8] | None = None
        self._fade, self._faults, self.fault = Fade(), 0, ""
        self._drawn: Any = None
        self._has_more = True
        self._frames = Frames(device, rig, live, rays=_RAYS)
        if self._frames.is_software:
            live.ease(1)

    @property
    def size_px(self) -> tuple[int, int]:
        """Of the panel."""
        panel = self.session.rig.panel
        return panel.width_px, panel.height_px

    # What the phone says

    def press(self, chord: str) -> str:
        """Do what a key of the preview's table does; what to say of it."""
        if chord == "t":
            self.has_latency = not self.has_latency
            return "latency" if self.has_latency else ""
        press = press_of(chord, aligning=self.session.is_aligning is not None)
        if press is None:
            return ""
        self.session = replace(self.session, message="")
        try:
            self._do(press)
        except Exception as error:  # whatever it is, the picture stays and the show goes on
            return words_of(error)
        return self.session.message

    def _do(self, press: Press) -> None:
        action = press.key.action
        own: dict[str, Callable[[], None]] = {
            "save": self._save,
            "reload": self._reload,
            "seek": lambda: self._seek(self.time_s + press.key.amount),
            "rewind": lambda: self._seek(0.0),
        }
        if action in _NOT_HERE:
            self.session = replace(self.session, message=_NOT_HERE[action])
        elif action in _WALKING:
            self.session = strolled(self.session, [action], _STROLL_S)
        elif action in own:
            own[action]()
        else:
            self.session = act(self.session, press)

    def _save(self) -> None:
        path = self._files.save(self.session.rig)
        self.session = replace(self.session, loaded=self.session.rig, message=f"saved {path}")

    def _reload(self) -> None:
        rig = self._files.load()
        if (rig.panel.width_px, rig.panel.height_px) != self.size_px:
            # Phones were let in, and the memory was made, for the panel that there is.
            raise InputError("the rig's panel has other pixels now: start vrlf serve again")
        self.session = as_loaded(self.session, rig)

    def _seek(self, time_s: float) -> None:
        self.time_s = max(time_s, 0.0)

    def write_panel(self, measured: Measured) -> str:
        """Write a rig with the panel that was measured; what to say of it."""
        return write_panel(measured, self.session.rig, self._folder, self._files.name)

    def prompts(self) -> tuple[str, str]:
        """For each eye its prescription, marked where keys change it."""
        return eye_words(self.session)

    def axes(self) -> tuple[float, float]:
        """Where each lens's axis meets the panel, in shares of its width: words stand there."""
        return lens_axes(self.session.rig)

    # Frames

    def frame(self, head: HeadPose, passed_s: float) -> NDArray[np.uint8] | None:
        """The next panel image's codes, or None where it would be the last one again.

        Raises
        ------
        DeviceError
            If the GPU is lost.
        """
        session = self.session
        if session.is_playing and self._live.has_time:
            self.time_s += min(passed_s, 0.25)
            if self._live.duration_s is not None:
                self.time_s %= self._live.duration_s
        moment = Moment(self.time_s, head, session.is_aligning)
        wanted = (session.rig, moment)
        if wanted == self._drawn and not self._has_more and not self._fade.level:
            return None
        try:
            codes = self._draw(session, moment)
        except Exception as error:
            return self._caught(error, passed_s)
        self._drawn, self._faults, self.fault = wanted, 0, ""
        failure = self._frames.take_failure()
        if failure is not None:
            self.fault = str(failure)
        level = self._fade.step(passed_s, is_faulty=False)
        self._held = codes
        return faded(codes, level) if level else codes

    def _draw(self, session: Session, moment: Moment) -> NDArray[np.uint8]:
        self._frames.want(session.rig)
        size = self.size_px
        self._has_more = self._frames.draw(placed(session, size), size, moment)
        canvas = self._frames.canvas
        return np.ascontiguousarray(canvas.read()[::-1, :, :3], np.uint8)

    def _caught(self, error: Exception, passed_s: float) -> NDArray[np.uint8] | None:
        """On a fault the last good picture stays and gives way to grey."""
        self._faults += 1
        self.fault = words_of(error)
        self._drawn = None
        if self._faults >= _LOST_AFTER and self._is_lost():
            raise DeviceError(
                f"GPU: found its context lost ({self.fault}), wanted it to stay"
            ) from error
        before, level = self._fade.level, self._fade.step(passed_s, is_faulty=True)
        if before == level:  # grey already
            return None
        return None if self._held is None else faded(self._held, level)

    def _is_lost(self) -> bool:
        try:
            Texture(self._device, (4, 4), kind="f1", label="probe").release()
        except DeviceError:
            return True
        return False

    def release(self) -> None:
        """Give the frames back."""
        with ExitStack() as owned:
            owned.callback(self._frames.release)


def eye_words(session: Session) -> tuple[str, str]:
    """For each eye its prescription, marked where keys change it."""

    def words(side: str) -> str:
        mark = "> " if side in session.sides else ""
        return f"{mark}{side}  {written(getattr(session.rig, side))}"

    return words("left"), words("right")


def write_panel(measured: Measured, rig: Rig, folder: Path, extends: str) -> str:
    """Write a rig with the panel that was measured; what to say of it.

    Parameters
    ----------
    measured : Measured
    rig : Rig
        Of which all but the panel's size stays.
    folder : Path
        Where it goes; no file that is there is replaced.
    extends : str
        The rig that the new file extends.
    """
    width, height = measured.size_px
    tables = rig.model_dump(mode="json", by_alias=True)
    pitch_um = round(measured.pixel_pitch_um, 2)
    tables["panel"] |= {"width_px": width, "height_px": height, "pixel_pitch_um": pitch_um}
    path = folder / f"phone-{width}x{height}.toml"
    try:
        if path.exists():
            return f"{shown(path)} is there already; move it away first"
        check_target(path)
        # A file is named so that the new one finds it from wherever it lies.
        base = str(Path(extends).resolve()) if Path(extends).is_file() else extends
        new_rig_file(path, rig_from_tables(tables, source="the phone's panel"), base)
    except VrlfError as error:
        return str(error)
    return f"wrote {shown(path)}: vrlf serve -r {shown(path)}"
