"""The GPU context: made headless or taken from a window, owned by one thread."""

from __future__ import annotations

import sys
import threading
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

import moderngl

from vrlf.errors import DeviceError, InputError

REQUIRED_GL = 430
_OLDEST_GL = 210  # what is tried to learn how old a driver is that lacks REQUIRED_GL
_DEBIAN_PACKAGES = "libegl1 libgl1 libgl1-mesa-dri libglx-mesa0 libegl-mesa0 libgles2"


@dataclass(frozen=True)
class DeviceInfo:
    """What GPU, driver and limits there are."""

    renderer: str
    vendor: str
    version: str
    gl_version: int
    max_texture_px: int
    max_storage_bytes: int

    @property
    def is_software(self) -> bool:
        """Whether the CPU does the drawing."""
        return any(name in self.renderer.lower() for name in ("llvmpipe", "softpipe", "swrast"))


class Device:
    """A GPU context with the list of what lives on it.

    Every texture, buffer and program registers here and leaves when it is released. A
    context belongs to the thread that made it: OpenGL answers a foreign thread with zeros
    and no error, so the device refuses it.
    """

    def __init__(self, context: moderngl.Context, *, owns_context: bool) -> None:
        self._context = context
        self._owns_context = owns_context
        self._thread = threading.get_ident()
        self._live: dict[int, tuple[str, int]] = {}
        self._next = 0
        self._released = False
        self._resting: moderngl.Framebuffer | None = None
        self.info = _info(context)
        if self.info.gl_version < REQUIRED_GL:
            self.release()
            raise DeviceError(_too_old(self.info.gl_version))

    @classmethod
    def headless(cls) -> Self:
        """A context without a window: EGL on Linux, the platform's own way elsewhere.

        Raises
        ------
        DeviceError
            Without EGL, without a driver, or where OpenGL is older than 4.3.
        """
        options: dict[str, Any] = {"standalone": True}
        if sys.platform.startswith("linux"):
            options["backend"] = "egl"
        return cls(_create(options), owns_context=True)

    @classmethod
    def from_current_context(cls) -> Self:
        """The context that a window made current on this thread; the window keeps it."""
        return cls(_create({}), owns_context=False)

    @property
    def context(self) -> moderngl.Context:
        """The moderngl context, for this room alone; refuses a foreign thread."""
        if self._released:
            raise DeviceError("GPU device: found it released already, wanted a live one")
        if threading.get_ident() != self._thread:
            raise DeviceError(
                "GPU device: found a call from another thread, wanted the thread that made it "
                "(an OpenGL context works on one thread only; make a device for each)"
            )
        return self._context

    def make_current(self) -> None:
        """Take the context up again after another one was made on this thread."""
        if self._owns_context:
            self.context.mglo.__enter__()

    def check(self, doing: str) -> None:
        """Raise if the GPU has reported an error; it raises nothing by itself."""
        error = self.context.error
        if error != "GL_NO_ERROR":
            raise DeviceError(
                f"GPU ({self.info.renderer}): found {error} while {doing}, wanted no error; "
                "out of memory? try a smaller panel or picture"
            )

    def finish(self) -> None:
        """Wait until the GPU has done all that it was given."""
        self.context.finish()

    def require_texture_size(self, width_px: int, height_px: int, what: str) -> None:
        """Refuse a size that the GPU cannot hold in one texture."""
        limit = self.info.max_texture_px
        if width_px > limit or height_px > limit:
            raise InputError(
                f"{what}: found {width_px}x{height_px} pixels, wanted at most {limit} a side "
                f"(the limit of {self.info.renderer})"
            )

    def rest(self) -> None:
        """Draw into nothing from now on.

        moderngl binds again whatever was drawn into last; once that is released the next
        framebuffer fails. A headless context has no screen to fall back on.
        """
        if self._resting is None:
            self._resting = self.context.simple_framebuffer((1, 1))
        self._resting.use()

    def enlist(self, label: str, nbytes: int) -> int:
        """Note a new GPU object; returns the ticket with which it is struck off."""
        self._next += 1
        self._live[self._next] = (label, nbytes)
        return self._next

    def strike(self, ticket: int) -> None:
        """Strike a released object off the list."""
        self._live.pop(ticket, None)

    @property
    def live_objects(self) -> tuple[str, ...]:
        """Labels of the GPU objects that have not been released."""
        return tuple(label for label, _ in self._live.values())

    @property
    def live_bytes(self) -> int:
        """Their size together."""
        return sum(nbytes for _, nbytes in self._live.values())

    def release(self) -> None:
        """Give the context back; the owner of each object has released it before."""
        if not self._released and self._resting is not None:
            self._resting.release()
            self._resting = None
        if not self._released and self._owns_context:
            self._context.release()
        self._released = True

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.release()


def _info(context: moderngl.Context) -> DeviceInfo:
    info = context.info
    return DeviceInfo(
        renderer=str(info["GL_RENDERER"]),
        vendor=str(info["GL_VENDOR"]),
        version=str(info["GL_VERSION"]),
        gl_version=int(context.version_code),
        max_texture_px=int(info["GL_MAX_TEXTURE_SIZE"]),
        max_storage_bytes=int(info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"]),
    )


def _create(options: dict[str, Any]) -> moderngl.Context:
    """A context of the required version, or an error that says what there is instead."""
    try:
        return moderngl.create_context(require=REQUIRED_GL, **options)
    except Exception as error:  # glcontext raises bare Exception, with the reason in the text
        reason = str(error)
    try:
        older = moderngl.create_context(require=_OLDEST_GL, **options)
    except Exception:
        raise DeviceError(_no_context(reason)) from None
    version = older.version_code
    older.release()
    raise DeviceError(_too_old(version))


def _no_context(reason: str) -> str:
    hint = f"on Debian or Ubuntu: apt-get install {_DEBIAN_PACKAGES}"
    if sys.platform == "darwin":
        hint = "macOS stops at OpenGL 4.1, which has no compute shaders"
    return (
        f"GPU: found no usable OpenGL context ({reason}), wanted OpenGL 4.3 with compute "
        f"shaders; {hint}; 'vrlf doctor' tells more"
    )


def _too_old(version: int) -> str:
    found = f"OpenGL {version // 100}.{version % 100 // 10}"
    return (
        f"GPU: found {found}, wanted OpenGL 4.3 or newer with compute shaders; update the "
        "graphics driver, or let the CPU do it with Mesa's llvmpipe (LIBGL_ALWAYS_SOFTWARE=1)"
    )
