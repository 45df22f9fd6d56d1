"""The phones that were let in, and which one goes when there is no room for another."""

from __future__ import annotations

import asyncio
import time
from dataclasses import dataclass, field
from typing import Final

from websockets.asyncio.server import ServerConnection

from vrlf.app.serve.wire import Link

# Sockets that are let in at once; one more takes the place of the one that showed nothing longest.
MOST_PHONES: Final = 4
# A phone that showed a frame within so long is not let go for another.
_LIVELY_S: Final = 2.0


@dataclass(eq=False)
class Phone:
    """One socket that was let in."""

    socket: ServerConnection
    link: Link
    # Number of each frame that is on its way: its encoding, and when its encoding began.
    on_the_way: dict[int, tuple[str, float]] = field(default_factory=dict)
    last_sent: int = 0
    came_s: float = field(default_factory=time.monotonic)
    shown_s: float | None = None
    fits: bool = False
    ready: asyncio.Event = field(default_factory=asyncio.Event)


def make_room(phones: list[Phone]) -> None:
    """Let the one go that has shown nothing for longest; it leaves the list itself."""
    if len(phones) < MOST_PHONES:
        return
    now_s = time.monotonic()

    def liveliness(phone: Phone) -> tuple[bool, float]:
        shown_s = phone.shown_s
        return shown_s is not None and now_s - shown_s < _LIVELY_S, shown_s or phone.came_s

    min(phones, key=liveliness).socket.transport.abort()
