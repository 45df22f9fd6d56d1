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


def makes_room(phones: list[Phone]) -> bool:
    """Let the one go that has shown nothing for longest, unless all are lively."""
    if len(phones) < MOST_PHONES:
        return True
    least_s = time.monotonic() - _LIVELY_S
    silent = [each for each in phones if each.shown_s is None or each.shown_s < least_s]
    if silent:  # it leaves the list itself
        min(silent, key=lambda each: each.shown_s or each.came_s).socket.transport.abort()
    return bool(silent)
