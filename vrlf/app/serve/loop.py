"""The drawing process's loop: what phones say goes in, frames go out, at the display's pace."""

from __future__ import annotations

import math
import multiprocessing
import socket
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from vrlf.app.options import say
from vrlf.app.preview.session import Session
from vrlf.app.serve.head import Turning, filtered, head_pose, heading_deg, predicted, screen_turn
from vrlf.app.serve.server import Plan, run_server
from vrlf.app.serve.slots import Slots, Stamp
from vrlf.app.serve.wire import Measured, Pressed, Turn
from vrlf.errors import DeviceError
from vrlf.scene import HeadPose

_PERIOD_S = 1.0 / 60.0
_READY_S = 20.0
# How fast the guess at motion to photon follows what phones report.
_SMOOTHING = 0.1


class Shows(Protocol):
    """What is sent and what hears the phones: ``Drawing``, or ``Mirrored`` beside a window."""

    session: Session
    has_latency: bool

    @property
    def fault(self) -> str:
        """What is wrong now; empty where nothing is."""

    @property
    def size_px(self) -> tuple[int, int]:
        """Of the panel."""

    def frame(self, head: HeadPose, passed_s: float, /) -> NDArray[np.uint8] | None:
        """The next panel image's codes, or None where it would be the last one again."""

    def press(self, chord: str) -> str:
        """Do what a key does; what to say of it."""

    def prompts(self) -> tuple[str, str]:
        """What to say before each eye."""

    def axes(self) -> tuple[float, float]:
        """Where each lens's axis meets the panel, in shares of its width."""

    def write_panel(self, measured: Measured) -> str:
        """Write a rig with the panel that was measured; what to say of it."""


class Broadcast:
    """Owns the server's process and the shared memory; the drawing is its maker's."""

    def __init__(
        self,
        drawing: Shows,
        make_plan: Callable[[str, int], Plan],
        listening: list[socket.socket],
    ) -> None:
        self._drawing = drawing
        width, height = drawing.size_px
        self._slots = Slots(width * height)
        self._bell, theirs = socket.socketpair()
        self._bell.setblocking(False)
        theirs.setblocking(False)
        context = multiprocessing.get_context("spawn")
        self._pipe, far = context.Pipe()
        plan = make_plan(self._slots.name, width * height)
        self._server = context.Process(
            target=run_server, args=(plan, listening, theirs, far), daemon=True, name="vrlf-server"
        )
        self._turning: Turning | None = None
        self._heard: tuple[float, float] | None = None
        self._ahead_deg = 0.0
        self._photon_ms = 50.0
        self._number = 0
        self._said: Any = None
        self._told_fault = ""
        self.phones = 0
        self.link_ms: dict[str, float] = {}
        try:
            self._server.start()
            far.close()
            for each in (theirs, *listening):
                each.close()
            if not self._is_serving():
                raise DeviceError("serve: found its server's process not starting, wanted it to")
        except BaseException:
            self.release()
            raise
        self._slots.forget_name()

    def _is_serving(self) -> bool:
        try:
            return self._pipe.poll(_READY_S) and self._pipe.recv()[0] == "serving"
        except (EOFError, OSError):
            return False

    def run(self, until: Callable[[], bool]) -> None:
        """Draw and send until ``until`` says so.

        Raises
        ------
        DeviceError
            If the GPU or the server's process is lost.
        """
        before_s = time.monotonic()
        while not until():
            now_s = time.monotonic()
            self.turn(now_s, now_s - before_s)
            before_s = now_s
            time.sleep(max(0.0, _PERIOD_S - (time.monotonic() - now_s)))

    def turn(self, now_s: float, passed_s: float) -> None:
        """Hear the phones, draw a frame, send it if it is another one."""
        if not self._server.is_alive():
            raise _gone()
        self._hear()
        self._slots.beat()
        if not self.phones and self._number:
            return  # nobody looks
        codes = self._drawing.frame(self._head(), passed_s)
        self._tell_faults()
        if codes is None:
            return
        self._number += 1
        sensor_ms, heard_s = self._heard or (math.nan, now_s)
        size = (codes.shape[1], codes.shape[0])
        stamp = Stamp(self._number, size, sensor_ms, heard_s, now_s, time.monotonic())
        self._slots.put(codes, stamp)
        self._heard = None
        with suppress(OSError):  # full: it is rung already; broken: the next turn says so
            self._bell.send(b".")

    def _head(self) -> HeadPose:
        """Where the head will be when the frame is seen; it stands where keys walked it."""
        drawing = self._drawing
        if self._turning is not None:
            pose = head_pose(predicted(self._turning, 1e-3 * self._photon_ms), self._ahead_deg)
            pose = replace(pose, position_m=drawing.session.head.position_m)
            drawing.session = replace(drawing.session, head=pose)
        return drawing.session.head

    def _hear(self) -> None:
        while self._pipe.poll():
            try:
                item = self._pipe.recv()
            except (EOFError, OSError) as error:
                raise _gone() from error
            self._take(item)

    def _take(self, item: Any) -> None:
        match item:
            case (Turn() as turn, float(heard_s)):
                self._turned(turn, heard_s)
            case Pressed(chord):
                self._press(chord)
            case Measured():
                self._tell(self._drawing.write_panel(item), aloud=True)
            case ("photon", float(photon_ms), dict(link_ms)):
                self._photon_ms += _SMOOTHING * (min(photon_ms, 500.0) - self._photon_ms)
                self.link_ms = link_ms
            case ("hello", (width, height), bool(fits), int(phones)):
                self.phones = phones
                words = "which fits the rig" if fits else "which is not the rig's: nothing is shown"
                say(f"a phone: {width} x {height} pixels, {words}")
                self._tell("")
            case ("phones", int(phones)):
                self.phones = phones

    def _turned(self, turn: Turn, heard_s: float) -> None:
        measured = screen_turn(turn.alpha_deg, turn.beta_deg, turn.gamma_deg, turn.screen_deg)
        is_first = self._turning is None
        self._turning = filtered(self._turning, measured, 1e-3 * turn.at_ms)
        self._heard = (turn.at_ms, heard_s)
        if is_first:
            self._ahead_deg = heading_deg(self._turning.turn)

    def _press(self, chord: str) -> None:
        if chord == "h" and self._turning is not None:
            self._ahead_deg = heading_deg(self._turning.turn)
        self._tell(self._drawing.press(chord))

    def _tell(self, message: str, *, aloud: bool = False) -> None:
        """To every phone, before each eye; and to the terminal if somebody may want to read it."""
        left, right = self._drawing.prompts()
        lines = [f"{each}\n{message}" if message else each for each in (left, right)]
        given = {
            "left": lines[0],
            "right": lines[1],
            "axes": self._drawing.axes(),
            "latency": self._drawing.has_latency,
        }
        try:
            self._pipe.send(("say", given))
        except OSError as error:
            raise _gone() from error
        if aloud:
            say(message)

    def _tell_faults(self) -> None:
        fault = self._drawing.fault
        if fault != self._told_fault:
            self._told_fault = fault
            self._tell(fault or "it works again", aloud=True)

    def release(self) -> None:
        """End the server's process and give the memory back; the second call does nothing."""
        self._pipe.close()
        self._bell.close()
        if self._server.pid:
            self._server.join(3.0)
            if self._server.is_alive():
                self._server.kill()
                self._server.join()
        self._slots.release()


def _gone() -> DeviceError:
    return DeviceError("serve: found its server's process gone, wanted it to stay")
