"""The window: keys, mouse and clock go in, frames come out, faults are held off the eyes."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Any

import glfw
import numpy as np
from numpy.typing import NDArray

from vrlf.app.options import say
from vrlf.app.preview.chords import WALKING, chord_of
from vrlf.app.preview.fading import Guard, words_of
from vrlf.app.preview.files import Files, as_loaded
from vrlf.app.preview.frames import LOOKS, Frames, Moment
from vrlf.app.preview.keys import Press, press_of
from vrlf.app.preview.layout import Placed, loupe, needed, placed, tile_under
from vrlf.app.preview.mouse import Mouse
from vrlf.app.preview.pacing import FrameClock, Pacer, told
from vrlf.app.preview.panels import Panels, Status
from vrlf.app.preview.session import Session, act, strolled
from vrlf.errors import DeviceError, VrlfError
from vrlf.gpu import Device
from vrlf.gpu.screen import Screen, read_screen
from vrlf.gpu.window import Window, monitors
from vrlf.renderer.live import Live
from vrlf.scene import SAMPLES

_IDLE_S = 0.1
# Frames drawn after the last thing happened: ImGui settles in two.
_WAKE_FRAMES = 3
_WATCH_S = 1.0
_DEFAULT_RATE_HZ = 60.0


@dataclass(frozen=True)
class Opening:
    """How the window begins.

    Attributes
    ----------
    rays : int
        For each retinal pixel.
    monitor : int
        That F11 fills.
    fullscreen : bool
    """

    rays: int
    monitor: int = 0
    fullscreen: bool = False


class Preview:
    """Owns the frames and the panels of a window; window, device and live are its maker's."""

    def __init__(
        self,
        window: Window,
        device: Device,
        session: Session,
        live: Live,
        files: Files,
        opening: Opening,
    ) -> None:
        self._window, self._device, self._live, self._files = window, device, live, files
        self._opening = opening
        self.session = session
        self.monitor = opening.monitor
        self._chords: deque[tuple[str, bool]] = deque()
        self._time_s = 0.0
        self._live_fault: str | None = None
        self._awake = _WAKE_FRAMES
        self._last_watch_s = 0.0
        # What waits for the frame to be drawn.
        self._pending: list[Callable[[], None]] = []
        # The window's own key callback comes first; ImGui's chains to it.
        window.on_key(self._key)
        self._owned = ExitStack()
        try:
            self._panels = Panels(window)
            self._owned.callback(self._panels.release)
            self._screen = Screen(device)
            self._owned.callback(self._screen.release)
            self._guard = Guard(device, self._screen)
            self._frames = Frames(device, session.rig, live, rays=opening.rays)
        except BaseException:
            self._owned.close()
            raise
        if self._frames.is_software:
            live.ease(1)
        rate_hz = self._rate_hz()
        self._clock, self._pacer = FrameClock(1e3 / rate_hz), Pacer(1e3 / rate_hz)
        self._mouse = Mouse()
        window.keep_pace(1)
        if opening.fullscreen:
            window.fill(self.monitor)

    def _rate_hz(self) -> float:
        found = monitors()
        rate_hz = found[min(self.monitor, len(found) - 1)].rate_hz if found else 0.0
        return rate_hz or _DEFAULT_RATE_HZ

    def run(self) -> Session:
        """Until the window is left; the session as it was then.

        Raises
        ------
        DeviceError
            If the GPU was lost.
        """
        before_s = time.perf_counter()
        while not self._window.wants_to_close:
            self._window.wait(0.0 if self._awake else _IDLE_S)
            now_s = time.perf_counter()
            self.turn(now_s, now_s - before_s)
            before_s = now_s
        return self.session

    def turn(self, now_s: float, passed_s: float) -> None:
        """One turn of the loop: what happened, a frame, the panels over it."""
        self._watch(now_s)
        self._obey(passed_s)
        size = self._window.size_px
        if min(size) < 1:  # minimised: nothing to draw on
            self._clock.pause()
            self._window.wait(_IDLE_S)
            return
        tiles = placed(self.session, size)
        self._panels.begin()
        self.session = self._mouse.moved(self.session, tiles, self._window, self._panels)
        self.session = self._panels.build(self.session, self._status(tiles), tiles)
        shown = placed(self.session, size)
        began_s = time.perf_counter()
        has_more = self._frame(shown, size, passed_s)
        self._panels.end()
        while self._pending:
            self._pending.pop(0)()
        self._window.present()
        self._pace(began_s, has_more)

    def _pace(self, began_s: float, has_more: bool) -> None:
        """Keep the display's rate where nothing else does, and let the effort follow the time."""
        self._awake = _WAKE_FRAMES if has_more else max(self._awake - 1, 0)
        if not has_more and not self._awake:
            self._clock.pause()
            return
        work_ms = sum(self._frames.timers.milliseconds.values())
        if not self._frames.is_software and self._pacer.spent(work_ms):
            self._frames.ease(self._pacer.effort)
            self._live.ease(self._pacer.effort.of(SAMPLES))
        rest_s = 1e-3 * self._clock.period_ms - (time.perf_counter() - began_s)
        if self._frames.is_software and rest_s > 0.0:
            time.sleep(rest_s)  # no display keeps its pace
        self._clock.tick(time.perf_counter())

    # What happened

    def _key(self, key: int, code: int, mods: int) -> None:
        chord = chord_of(key, code, mods)
        if chord is not None:
            self._chords.append((chord, self._panels.has_keyboard))
        self._awake = _WAKE_FRAMES

    def _obey(self, passed_s: float) -> None:
        """Take the keys one by one, then those that are held."""
        while self._chords:
            chord, was_typing = self._chords.popleft()
            if self.session.is_typing or was_typing:
                if chord == "escape":
                    self.session = replace(self.session, is_typing=False)
                continue
            press = press_of(chord, aligning=self.session.is_aligning is not None)
            if press is not None:
                self._do(press)
        if self.session.is_typing:
            return
        held = [a for a, name in WALKING.items() if self._window.is_down(_key_of(name))]
        if held and not self._is_control_held():
            self.session = strolled(self.session, held, passed_s)
            self._awake = _WAKE_FRAMES
        if self.session.is_playing and self._live.has_time:
            self._time_s += min(passed_s, 0.25)
            if self._live.duration_s is not None:
                self._time_s %= self._live.duration_s

    def _is_control_held(self) -> bool:
        return any(
            self._window.is_down(key) for key in (glfw.KEY_LEFT_CONTROL, glfw.KEY_RIGHT_CONTROL)
        )

    def _do(self, press: Press) -> None:
        action = press.key.action
        found = self._own_actions().get(action)
        if found is None:
            self.session = act(self.session, press)
            return
        try:
            found(press)
        except Exception as error:  # whatever it is, the picture stays and the window goes on
            self._say(words_of(error))

    def _own_actions(self) -> dict[str, Callable[[Press], None]]:
        return {
            "leave": self._leave,
            "fullscreen": self._toggle_fullscreen,
            "monitor": self._next_monitor,
            "screenshot": lambda _: self._shoot(all_of_it=False),
            "screenshot_all": lambda _: self._shoot(all_of_it=True),
            "save": self._save,
            "reload": self._reload,
            "shaders": self._reload_shaders,
            "seek": lambda press: self._seek(self._time_s + press.key.amount),
            "rewind": lambda _: self._seek(0.0),
        }

    def _leave(self, _: Press) -> None:
        """Escape closes what is open first."""
        if self.session.has_help:
            self.session = replace(self.session, has_help=False)
        else:
            glfw.set_window_should_close(self._window.handle, True)

    def _toggle_fullscreen(self, _: Press) -> None:
        if self._window.is_fullscreen:
            self._window.unfill()
        else:
            self._window.fill(self.monitor)

    def _next_monitor(self, _: Press) -> None:
        found = monitors()
        self.monitor = (self.monitor + 1) % max(len(found), 1)
        if self._window.is_fullscreen:
            self._window.unfill()
            self._window.fill(self.monitor)
        name = found[self.monitor].name if found else "none"
        self._say(f"monitor {self.monitor + 1} of {len(found)}: {name}", aloud=False)

    def _shoot(self, *, all_of_it: bool) -> None:
        """When the frame is drawn, and for all of it the panels too."""

        def shoot() -> None:
            try:
                path = self._files.shoot(self._codes(all_of_it=all_of_it), self.session)
            except VrlfError as error:
                self._say(str(error))
            else:
                self._say(f"wrote {path}")

        self._pending.append(shoot)

    def _codes(self, *, all_of_it: bool) -> NDArray[np.uint8]:
        """What is shown, with the panels or without; shape (H, W, 3), row 0 at the top."""
        canvas = self._frames.last_canvas
        if all_of_it:
            return read_screen(self._device, self._window.size_px)
        if canvas is None:
            raise DeviceError("screenshot: found no frame drawn so far, wanted one")
        return np.asarray(canvas.read()[::-1, :, :3], np.uint8)

    def _save(self, _: Press) -> None:
        path = self._files.save(self.session.rig)
        self.session = replace(self.session, loaded=self.session.rig)
        self._say(f"saved {path}")

    def _reload(self, _: Press) -> None:
        rig = self._files.load()
        self.session = as_loaded(self.session, rig)
        self._say(f"read {self._files.name} again")

    def _reload_shaders(self, _: Press) -> None:
        """New programs from the files; with a fault in one the old ones go on."""
        frames = Frames(self._device, self.session.rig, self._live, rays=self._opening.rays)
        try:
            # Programs are compiled when first needed: the wall needs those of every view.
            size = self._window.size_px
            wall = placed(replace(self.session, view="wall"), size)
            frames.draw(wall, size, self._moment())
        except Exception:
            frames.release()
            raise
        self._frames.release()
        self._frames = frames
        frames.ease(self._pacer.effort)
        self._say("shaders reloaded", aloud=False)

    def _seek(self, time_s: float) -> None:
        self._time_s = max(time_s, 0.0)
        self._say(f"at {self._time_s:.1f} s", aloud=False)

    def _say(self, message: str, *, aloud: bool = True) -> None:
        """In the window, and on standard error where somebody may want to read it later."""
        self.session = replace(self.session, message=message)
        self._awake = _WAKE_FRAMES
        if aloud:
            say(message)

    def _watch(self, now_s: float) -> None:
        """What changes outside: the rig's file, the monitors."""
        if now_s - self._last_watch_s < _WATCH_S:
            return
        self._last_watch_s = now_s
        if self._window.lost_monitor():
            self._say("the monitor was unplugged; this is a window again")
        if self._live.fault != self._live_fault:
            self._live_fault = self._live.fault
            if self._live_fault:
                self._say(self._live_fault)
        if self._files.has_changed():
            self._say(f"{self._files.name} was changed by another program; Ctrl+R reads it again")

    # A frame

    def _frame(self, tiles: tuple[Placed, ...], size: tuple[int, int], passed_s: float) -> bool:
        """Draw into the window; whether the next frame would differ by itself."""
        guard = self._guard
        moment = self._moment()
        try:
            self._frames.want(self.session.rig)
            # Back from grey, if it was there: not at once either.
            level = guard.fade.level if guard.fault else guard.fade.step(passed_s, is_faulty=False)
            has_more = self._frames.draw(self._with_loupe(tiles, size), size, moment, fade=level)
            self._screen.show(self._frames.canvas)
        except Exception as error:
            told = guard.caught(error, self._frames.last_canvas)
            if told is not None:
                self._say(told)
            return guard.show(size, passed_s)
        self._accept_failure()
        if guard.passed():
            self._say("it works again")
        is_moving = self.session.is_playing and self._live.has_time
        return has_more or is_moving or level > 0.0

    def _moment(self) -> Moment:
        return Moment(self._time_s, self.session.head, self.session.is_aligning)

    def _accept_failure(self) -> None:
        failure = self._frames.take_failure()
        if failure is not None:
            self._say(str(failure))

    def _with_loupe(self, tiles: tuple[Placed, ...], size: tuple[int, int]) -> tuple[Placed, ...]:
        if not self.session.has_loupe:
            return tiles
        place = self._mouse.place_px(self._window)
        under = tile_under(tiles, place)
        piece = loupe(under, place, size) if under is not None else None
        return tiles if piece is None else (*tiles, piece)

    def _status(self, tiles: tuple[Placed, ...]) -> Status:
        notes = []
        if self._frames.is_standing_in:
            notes.append("forward, until optimal is made")
        elif self._frames.is_sampled_coarsely:
            notes.append("panel: one sample a sub-pixel so far")
        for name in sorted(needed(tiles) & set(LOOKS)):
            stride = self._frames.stride_of(name)
            if stride > 1:
                notes.append(f"{name}: one pixel in {stride}x{stride} so far")
        if self._pacer.has_given_way:
            share = self._pacer.effort.share
            notes.append(f"short of time: {share:g} of the rays and steps")
        notes.append(self._frames.likening.words)
        steps_ms = self._frames.timers.milliseconds
        return Status(
            rig=self._files.name,
            notes=notes,
            intervals_ms=np.asarray(self._clock.intervals_ms),
            period_ms=self._clock.period_ms,
            timing=told(self._clock, steps_ms),
        )

    def release(self) -> None:
        """Give frames and panels back."""
        self._frames.release()
        self._owned.close()


def _key_of(name: str) -> Any:
    return glfw.KEY_A + ord(name) - ord("a")
