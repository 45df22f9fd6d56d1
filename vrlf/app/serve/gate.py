"""How many connections there are at once, counted before a byte of them is read.

What waits for its TLS handshake counts too: each holds a quarter of a megabyte.
"""

from __future__ import annotations

import socket
from collections import Counter
from typing import Any, Final

# Of all; of one address, so that one stranger cannot take every place.
MOST_CONNECTIONS: Final = 256
MOST_OF_AN_ADDRESS: Final = 128


class Gate(socket.socket):
    """A listening socket that drops what comes while there is no room; takes the other one over."""

    def __init__(self, listening: socket.socket) -> None:
        super().__init__(fileno=listening.detach())
        self.setblocking(False)
        self.held: Counter[str] = Counter()

    def accept(self) -> tuple[socket.socket, Any]:
        """The next connection, counted until it is closed.

        Raises
        ------
        ConnectionAbortedError
            If there is no room for it; an event loop then goes on.
        """
        plain, address = super().accept()
        name = str(address[0]) if address else ""
        if self.held.total() >= MOST_CONNECTIONS or self.held[name] >= MOST_OF_AN_ADDRESS:
            plain.close()
            raise ConnectionAbortedError("no room")
        return _Counted(plain, self.held, name), address


class _Counted(socket.socket):
    """One that was let in: leaves the count when it is closed, once."""

    def __init__(self, plain: socket.socket, held: Counter[str], name: str) -> None:
        super().__init__(fileno=plain.detach())
        self._held, self._name, self._is_in = held, name, True
        held[name] += 1

    def close(self) -> None:
        """Close it and leave the count."""
        if self._is_in:
            self._is_in = False
            self._held[self._name] -= 1
            if not self._held[self._name]:
                del self._held[self._name]
        super().close()
