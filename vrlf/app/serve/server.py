"""The server: a process of its own, which no GPU work ever blocks and which never blocks any.

It takes the newest frame from shared memory (``slots``) when a phone is ready for one, so a slow
phone gets fewer frames and no old ones, and a stalled one costs nothing but its socket. What
phones say is checked (``wire``) and goes on to the drawing process in order; of turns only the
newest waits.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import resource
import signal
import socket
import time
from collections.abc import AsyncIterator, Coroutine
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from http import HTTPStatus
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Final

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from vrlf.app.serve.answers import answer, lists
from vrlf.app.serve.certificate import tls_context
from vrlf.app.serve.door import Allowance, Door, Patience, Refusal
from vrlf.app.serve.gate import Gate
from vrlf.app.serve.page import page
from vrlf.app.serve.phones import Phone, makes_room
from vrlf.app.serve.slots import Slots
from vrlf.app.serve.wire import (
    ENCODINGS,
    MOST_MESSAGE_BYTES,
    RAW,
    STRIPS,
    Beat,
    Hello,
    Link,
    MessageError,
    Shown,
    Turn,
    encoded,
    frame_head,
    joined,
    message_of,
    strips,
)

# Frames on their way to a phone: one over the link while another is being put on the canvas.
_ON_THE_WAY: Final = 2
_MESSAGES_A_SECOND, _MESSAGES_SAVED = 250.0, 500.0
# To open a connection, to say hello, to show a frame.
_OPENING_S, _STALLED_S = 5.0, 10.0
_MOST_WAITING: Final = 64
# A drawing process that has said nothing for so long is held for stuck.
_STUCK_S: Final = 1.0
_BEAT: Final = json.dumps({"t": "beat"})


@dataclass(frozen=True)
class Plan:
    """All that the server's process is told.

    Attributes
    ----------
    door : Door
    slots_name : str
    most_pixels : int
    panel_px : (width, height)
        Of the rig: no other screen is sent a frame.
    cert, key : Path or None
        For TLS.
    encodings : tuple of str
        Of ``wire.ENCODINGS``; of several the faster one is chosen for each phone.
    """

    door: Door
    slots_name: str
    most_pixels: int
    panel_px: tuple[int, int]
    cert: Path | None = None
    key: Path | None = None
    encodings: tuple[str, ...] = ENCODINGS


def run_server(
    plan: Plan, listening: list[socket.socket], bell: socket.socket, pipe: Connection
) -> None:
    """The process's whole life; ends when the other end of the pipe does."""
    # Ctrl-C and a terminal's end are the drawing process's to hear; it closes the pipe.
    for name in ("SIGINT", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    logging.getLogger("websockets").setLevel(logging.CRITICAL)
    with contextlib.suppress(OSError, ValueError):
        _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    with Slots(plan.most_pixels, name=plan.slots_name) as slots:
        asyncio.run(Server(plan, slots, bell, pipe).run(listening))


class Server:
    """Owns the phones' sockets; the slots and the pipe are its maker's."""

    def __init__(self, plan: Plan, slots: Slots, bell: socket.socket, pipe: Connection) -> None:
        self._plan, self._slots, self._bell, self._pipe = plan, slots, bell, pipe
        self._phones: list[Phone] = []
        self._patience = Patience()
        self._said: dict[str, Any] = {}
        self._waiting: asyncio.Queue[Any] = asyncio.Queue(_MOST_WAITING)
        self._turn: tuple[Turn, float] | None = None
        self._turner: Phone | None = None
        self._has_turn = asyncio.Event()
        self._newest: tuple[Any, bytes] | None = None
        self._packed: dict[str, asyncio.Task[tuple[bytes, float]]] = {}
        self._threads = ThreadPoolExecutor(STRIPS)
        self._running: set[asyncio.Task[None]] = set()
        self._over = asyncio.Event()

    async def run(self, listening: list[socket.socket]) -> None:
        """Serve until the drawing process is gone."""
        loop = asyncio.get_running_loop()
        plan = self._plan
        tls = tls_context(plan.cert, plan.key) if plan.cert and plan.key else None
        loop.add_reader(self._bell.fileno(), self._ring)
        loop.add_reader(self._pipe.fileno(), self._hear)
        async with contextlib.AsyncExitStack() as open_:
            for sock in listening:
                await open_.enter_async_context(
                    serve(
                        self._phone,
                        sock=Gate(sock),
                        ssl=tls,
                        ssl_handshake_timeout=_OPENING_S if tls else None,
                        process_request=self._request,
                        compression=None,
                        max_size=MOST_MESSAGE_BYTES,
                        max_queue=4,
                        open_timeout=_OPENING_S,
                        ping_interval=5.0,
                        ping_timeout=10.0,
                        close_timeout=1.0,
                        server_header=None,
                        logger=logging.getLogger("websockets"),
                    )
                )
            tasks = [asyncio.create_task(each) for each in (self._pass_on(), self._watch())]
            self._pipe.send(("serving", None))
            await self._over.wait()
            for task in tasks:
                task.cancel()
        self._threads.shutdown(wait=False, cancel_futures=True)

    # Requests

    def _request(self, connection: ServerConnection, request: Request) -> Response | None:
        """The page, leave to open the socket, or a refusal that says next to nothing."""
        headers = lists(request.headers)
        found = self._plan.door.admits(request.path, headers)
        if found == "socket":
            return None
        if isinstance(found, Refusal):
            address = str((connection.remote_address or ("?",))[0])
            if self._patience.is_over(address):
                connection.transport.abort()
            self._patience.refused(address)
            return answer(HTTPStatus(found.status), b"", "text/plain")
        return answer(HTTPStatus.OK, page(), "text/html; charset=utf-8")

    # Phones

    async def _phone(self, connection: ServerConnection) -> None:
        phone = Phone(connection, Link(self._plan.encodings))
        if not makes_room(self._phones):
            await connection.close(1013, "full")
            return
        self._phones.append(phone)
        sending = asyncio.create_task(self._send_frames(phone))
        try:
            await self._listen(phone)
        except ConnectionClosed:
            pass
        finally:
            sending.cancel()
            self._phones.remove(phone)
            if self._turner is phone:
                self._turner = None
            self._tell(("phones", len(self._phones)))

    async def _listen(self, phone: Phone) -> None:
        allowance = Allowance(_MESSAGES_A_SECOND, _MESSAGES_SAVED)
        try:
            async with asyncio.timeout(_OPENING_S):
                await self._greet(phone, message_of(await phone.socket.recv()))
            async for text in phone.socket:
                if not allowance.take():
                    raise MessageError("too many messages")
                await self._take(phone, message_of(text))
        except TimeoutError:
            await phone.socket.close(1008, "no hello")
        except MessageError as error:
            await phone.socket.close(1008, str(error)[:100])

    async def _greet(self, phone: Phone, message: Any) -> None:
        if not isinstance(message, Hello):
            raise MessageError("wanted hello first")
        width, height = self._plan.panel_px
        phone.fits = message.may_have(width, height)
        phone.link.can_inflate = message.can_inflate
        await phone.socket.send(
            json.dumps({"t": "rig", "width": width, "height": height,
                        "fits": phone.fits, "screen": list(message.device_px)})
        )  # fmt: skip
        if self._said:
            await phone.socket.send(json.dumps(self._said))
        self._tell(("hello", message.device_px, phone.fits, len(self._phones)))
        phone.ready.set()

    async def _take(self, phone: Phone, message: Any) -> None:
        if isinstance(message, Beat):
            if not phone.on_the_way:
                phone.shown_s = time.monotonic()
            # Behind a frame it would say nothing that the frame does not.
            if not phone.socket.transport.get_write_buffer_size():
                await phone.socket.send(_BEAT)
        elif isinstance(message, Hello):  # the screen turned, or its pixels changed
            await self._greet(phone, message)
        elif isinstance(message, Shown):
            sent = phone.on_the_way.pop(message.number, None)
            if sent is not None:
                phone.shown_s = time.monotonic()
                phone.link.took(sent[0], 1e3 * (time.monotonic() - sent[1]))
            # By another phone's clock the sensor's time says nothing.
            is_known = sent is not None and phone is self._turner
            # A key must not be lost for it.
            has_room = self._waiting.qsize() < _MOST_WAITING // 2
            if message.photon_ms is not None and is_known and has_room:
                self._tell(("photon", message.photon_ms, dict(phone.link.milliseconds)))
            phone.ready.set()
        elif isinstance(message, Turn):
            self._turn, self._turner = (message, time.monotonic()), phone
            self._has_turn.set()
        else:
            self._tell(message)

    async def _send_frames(self, phone: Phone) -> None:
        with contextlib.suppress(ConnectionClosed):
            async for number, encoding in self._frames_for(phone):
                began_s = time.monotonic()
                task = self._packed.get(encoding)
                if task is None or self._newest is None:
                    continue
                data, _ = await asyncio.shield(task)
                phone.on_the_way[number] = (encoding, began_s)
                await phone.socket.send(data)

    async def _frames_for(self, phone: Phone) -> AsyncIterator[tuple[int, str]]:
        """The newest frame, each time that the phone can take one it has not had."""
        while True:
            await phone.ready.wait()
            phone.ready.clear()
            found = self._newest
            if not phone.fits or found is None or len(phone.on_the_way) >= _ON_THE_WAY:
                continue
            if found[0].number <= phone.last_sent:
                continue
            phone.last_sent = found[0].number
            encoding = phone.link.choose()
            if encoding not in self._packed:
                work = self._pack(found, encoding)
                self._packed[encoding] = asyncio.create_task(work)
            yield found[0].number, encoding
            phone.ready.set()

    async def _pack(self, found: tuple[Any, bytes], encoding: str) -> tuple[bytes, float]:
        """A frame as it goes out; made once for all phones."""
        began_s = time.monotonic()
        loop = asyncio.get_running_loop()
        data = found[1]
        if encoding != RAW:
            work = [
                loop.run_in_executor(self._threads, encoded, strip)
                for strip in strips(data, encoding)
            ]
            data = joined(await asyncio.gather(*work))
        took_ms = 1e3 * (time.monotonic() - began_s)
        return frame_head(found[0], encoding, took_ms) + data, took_ms

    # The drawing process

    def _ring(self) -> None:
        """There is a newer frame."""
        with contextlib.suppress(BlockingIOError):
            while self._bell.recv(4096):
                pass
            self._end()
            return
        self._newest, self._packed = self._slots.newest(), {}
        for phone in self._phones:
            phone.ready.set()

    def _hear(self) -> None:
        try:
            while self._pipe.poll():
                kind, given = self._pipe.recv()
                if kind == "say":
                    self._said = {"t": "say", **given}
                    self._broadcast(self._said)
        except (EOFError, OSError):
            self._end()

    def _end(self) -> None:
        """The drawing process is gone; its closed ends would ring without pause."""
        loop = asyncio.get_running_loop()
        loop.remove_reader(self._bell.fileno())
        loop.remove_reader(self._pipe.fileno())
        self._over.set()

    def _start(self, work: Coroutine[Any, Any, None]) -> None:
        """Run it; the loop itself would forget what nobody holds."""
        task = asyncio.create_task(work)
        self._running.add(task)
        task.add_done_callback(self._running.discard)

    def _broadcast(self, message: dict[str, Any]) -> None:
        """To every phone, none of which waits for another."""
        text = json.dumps(message)
        for phone in self._phones:
            if phone.socket.transport.get_write_buffer_size() < 1 << 20:
                self._start(_sent(phone, text))

    def _tell(self, item: Any) -> None:
        """Hand something on; where the other end has not listened for long, the oldest goes."""
        if self._waiting.full():
            self._waiting.get_nowait()
        self._waiting.put_nowait(item)
        self._has_turn.set()

    async def _pass_on(self) -> None:
        loop = asyncio.get_running_loop()
        while True:
            await self._has_turn.wait()
            self._has_turn.clear()
            while not self._waiting.empty() or self._turn is not None:
                if self._waiting.empty():
                    item, self._turn = self._turn, None
                else:
                    item = self._waiting.get_nowait()
                try:
                    await loop.run_in_executor(None, self._pipe.send, item)
                except (BrokenPipeError, OSError):
                    self._over.set()
                    return

    async def _watch(self) -> None:
        """Tell phones when the drawing process is stuck; let stalled ones go."""
        was_stuck = False
        while True:
            await asyncio.sleep(0.2)
            now_s = time.monotonic()
            is_stuck = now_s - self._slots.beat_s > _STUCK_S
            if is_stuck != was_stuck:
                was_stuck = is_stuck
                self._broadcast({"t": "held" if is_stuck else "going"})
            for phone in list(self._phones):
                waits = [began_s for _, began_s in phone.on_the_way.values()]
                if waits and now_s - min(waits) > _STALLED_S:
                    phone.socket.transport.abort()


async def _sent(phone: Phone, text: str) -> None:
    with contextlib.suppress(ConnectionClosed, TimeoutError):
        async with asyncio.timeout(0.5):
            await phone.socket.send(text)
