"""A window with a context of its own, for what is shown live; glfw."""

from __future__ import annotations

import warnings
from types import TracebackType
from typing import Any, Self

import glfw

from vrlf.errors import DeviceError
from vrlf.gpu.device import REQUIRED_GL, Device


class Window:
    """Owns a glfw window whose context is current on this thread.

    Parameters
    ----------
    size_px : (width, height)
    title : str
    visible : bool
        False makes one that only lends its context.

    Raises
    ------
    DeviceError
        Without a display, or where no OpenGL 4.3 context can be had for a window.
    """

    def __init__(self, size_px: tuple[int, int], title: str, *, visible: bool = True) -> None:
        self._handle: Any = None
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

    def device(self) -> Device:
        """The window's context as a device; the window keeps it alive."""
        return Device.from_current_context()

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


def _create(size_px: tuple[int, int], title: str, *, visible: bool) -> Any:
    glfw.window_hint(glfw.CONTEXT_VERSION_MAJOR, REQUIRED_GL // 100)
    glfw.window_hint(glfw.CONTEXT_VERSION_MINOR, REQUIRED_GL % 100 // 10)
    glfw.window_hint(glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE)
    glfw.window_hint(glfw.OPENGL_FORWARD_COMPAT, True)
    glfw.window_hint(glfw.VISIBLE, visible)
    return glfw.create_window(*size_px, title, None, None)
