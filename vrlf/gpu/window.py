"""A window with a context of its own, for what is shown live; glfw."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

import glfw

from vrlf.errors import DeviceError
from vrlf.gpu.device import REQUIRED_GL, Device

Box = tuple[int, int, int, int]


@dataclass(frozen=True)
class Monitor:
    """A screen: its name, its place and size on the desktop, its pictures a second."""

    name: str
    box_px: Box
    rate_hz: float


class Window:
    """Owns a glfw window whose context is current on this thread.

    Parameters
    ----------
    size_px : (width, height)
    title : str
    visible : bool
        False makes one that only lends its context.
    place_px : (x, y), optional
        On the desktop; the system chooses without it.

    Raises
    ------
    DeviceError
        Without a display, or where no OpenGL 4.3 context can be had for a window.
    """

    def __init__(
        self,
        size_px: tuple[int, int],
        title: str,
        *,
        visible: bool = True,
        place_px: tuple[int, int] | None = None,
    ) -> None:
        self._handle: Any = None
        self._windowed: Box | None = None
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")  # glfw tells its reasons as warnings
            if glfw.init():
                self._handle = _create(size_px, title, visible=visible)
        if not self._handle:
            glfw.terminate()
            reason = "; ".join(str(w.message) for w in said) or "glfw gives no reason"
            raise DeviceError(
                f"window: found no display that gives an OpenGL 4.3 window ({reason}), wanted one; "
                "set DISPLAY, or work without a window (vrlf prefilter, vrlf perceive)"
            )
        glfw.make_context_current(self._handle)
        if place_px is not None and _is_on_a_screen(place_px):
            glfw.set_window_pos(self._handle, *place_px)

    def device(self) -> Device:
        """The window's context as a device; the window keeps it alive."""
        return Device.from_current_context()

    @property
    def handle(self) -> Any:
        """glfw's own, for callbacks and for the library that draws the panels."""
        return self._handle

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height of what is drawn, in pixels; 0 while it is minimised."""
        width, height = glfw.get_framebuffer_size(self._handle)
        return int(width), int(height)

    @property
    def pixels_per_unit(self) -> tuple[float, float]:
        """Pixels per unit of the cursor's place: more than 1 on dense screens."""
        size, units = self.size_px, glfw.get_window_size(self._handle)
        return size[0] / max(units[0], 1), size[1] / max(units[1], 1)

    @property
    def wants_to_close(self) -> bool:
        """Whether the user closed it."""
        return bool(glfw.window_should_close(self._handle))

    @property
    def is_fullscreen(self) -> bool:
        """Whether it fills a monitor."""
        return self._windowed is not None

    @property
    def windowed_box_px(self) -> Box:
        """Its place and size as a window, on the desktop."""
        if self._windowed is not None:
            return self._windowed
        place, size = glfw.get_window_pos(self._handle), glfw.get_window_size(self._handle)
        return int(place[0]), int(place[1]), int(size[0]), int(size[1])

    def fill(self, monitor: int) -> None:
        """Fill the monitor of that index; one that is gone stands for the first."""
        found = glfw.get_monitors()
        if not found:
            return
        box = self.windowed_box_px
        chosen = found[monitor] if monitor < len(found) else found[0]
        mode = glfw.get_video_mode(chosen)
        width, height = mode.size
        glfw.set_window_monitor(self._handle, chosen, 0, 0, width, height, mode.refresh_rate)
        self._windowed = box

    def unfill(self) -> None:
        """Be a window again, where it was."""
        if self._windowed is not None:
            x, y, width, height = self._windowed
            no_monitor: Any = None
            glfw.set_window_monitor(self._handle, no_monitor, x, y, width, height, glfw.DONT_CARE)
            self._windowed = None

    def lost_monitor(self) -> bool:
        """Whether it filled a monitor that is gone; it is a window again then."""
        if self._windowed is None or glfw.get_window_monitor(self._handle):
            return False
        self.unfill()
        return True

    def set_title(self, title: str) -> None:
        """What its frame says."""
        glfw.set_window_title(self._handle, title)

    def wait(self, seconds: float) -> None:
        """Take what the user did; wait for it if that is more than 0."""
        if seconds > 0.0:
            glfw.wait_events_timeout(seconds)
        else:
            glfw.poll_events()

    def on_key(self, call: Callable[[int, int, int], None]) -> None:
        """Have ``call(key, scancode, mods)`` called for each key that goes down or repeats."""

        def pressed(_window: Any, key: int, code: int, action: int, mods: int) -> None:
            if action != glfw.RELEASE:
                call(key, code, mods)

        glfw.set_key_callback(self._handle, pressed)

    def is_down(self, key: int) -> bool:
        """Whether one of glfw's keys is held."""
        return bool(glfw.get_key(self._handle, key) == glfw.PRESS)

    def present(self) -> None:
        """Bring what was drawn onto the screen, at the screen's own pace."""
        glfw.swap_buffers(self._handle)

    def keep_pace(self, frames: int) -> None:
        """Screen pictures for each frame: 1 waits for the screen, 0 does not wait."""
        glfw.swap_interval(frames)

    def close(self) -> None:
        """Destroy the window and its context; the second call does nothing."""
        if self._handle:
            glfw.destroy_window(self._handle)
            glfw.terminate()
            self._handle = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def monitors() -> tuple[Monitor, ...]:
    """All screens, the first one first; glfw must be at work (a ``Window`` lives)."""
    found = []
    for each in glfw.get_monitors():
        mode, (x, y) = glfw.get_video_mode(each), glfw.get_monitor_pos(each)
        name = glfw.get_monitor_name(each)
        name = name.decode("utf-8", "replace") if isinstance(name, bytes) else str(name)
        box = (int(x), int(y), int(mode.size[0]), int(mode.size[1]))
        found.append(Monitor(name, box, float(mode.refresh_rate)))
    return tuple(found)


def _is_on_a_screen(place_px: tuple[int, int]) -> bool:
    """Whether a window there can be seen: monitors come and go."""
    for monitor in monitors():
        x, y, width, height = monitor.box_px
        if x <= place_px[0] < x + width and y <= place_px[1] < y + height:
            return True
    return False


def _create(size_px: tuple[int, int], title: str, *, visible: bool) -> Any:
    glfw.window_hint(glfw.CONTEXT_VERSION_MAJOR, REQUIRED_GL // 100)
    glfw.window_hint(glfw.CONTEXT_VERSION_MINOR, REQUIRED_GL % 100 // 10)
    glfw.window_hint(glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE)
    glfw.window_hint(glfw.OPENGL_FORWARD_COMPAT, True)
    glfw.window_hint(glfw.VISIBLE, visible)
    return glfw.create_window(*size_px, title, None, None)
