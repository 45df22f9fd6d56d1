"""Who gets in: every request and every socket is held against the owner's token, Host and Origin.

A page on the network could ask a browser to open our address (Origin differs), and a name on the
network could be made to point to us (Host differs, DNS rebinding): both are refused, whatever
token they bring.
"""

from __future__ import annotations

import hmac
import secrets
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

# Of random bits; 128 are asked for.
_TOKEN_BYTES = 32
# Refusals of an address in a while before it is answered no more.
_MOST_REFUSALS, _WHILE_S = 30, 60.0
_MOST_ADDRESSES = 4096

Place = Literal["page", "socket"]
# Beneath the token: the page and its socket, nothing else.
SOCKET = "live"


def new_token() -> str:
    """Random, for an address: 256 bits in 43 characters."""
    return secrets.token_urlsafe(_TOKEN_BYTES)


@dataclass(frozen=True)
class Refusal:
    """Why not: the status of the answer and a word for the log, never the token."""

    status: int
    reason: str


@dataclass(frozen=True)
class Door:
    """What a request must bring.

    Attributes
    ----------
    token : str
    hosts : frozenset of str
        ``host:port`` as a browser writes it.
    scheme : str
        ``http`` or ``https``.
    """

    token: str
    hosts: frozenset[str]
    scheme: str

    @property
    def path(self) -> str:
        """Of the page."""
        return f"/{self.token}/"

    def admits(self, path: str, headers: Mapping[str, list[str]]) -> Place | Refusal:
        """What a request may have, or why nothing.

        Parameters
        ----------
        path : str
            As it was sent.
        headers : mapping of lower-case name to all its values
        """
        # The token first: a stranger learns nothing else of us.
        parts = path.split("/")
        sent = parts[1] if len(parts) > 1 and not parts[0] else ""
        if not hmac.compare_digest(sent.encode(), self.token.encode()):
            return Refusal(404, "token")
        hosts = headers.get("host", [])
        if len(hosts) != 1 or hosts[0].lower() not in self.hosts:
            return Refusal(421, "host")
        origins = headers.get("origin", [])
        allowed = f"{self.scheme}://{hosts[0].lower()}"
        if any(origin.lower() != allowed for origin in origins) or len(origins) > 1:
            return Refusal(403, "origin")
        rest = "/".join(parts[2:])
        if rest == SOCKET:
            # A browser always says where a socket comes from.
            return "socket" if origins else Refusal(403, "origin")
        return "page" if rest == "" and len(parts) == 3 else Refusal(404, "path")


class Patience:
    """Counts what each address was refused; remembers so many addresses at most."""

    def __init__(self, now_s: Callable[[], float] = time.monotonic) -> None:
        self._now_s = now_s
        self._refused: OrderedDict[str, tuple[float, int]] = OrderedDict()

    def is_over(self, address: str) -> bool:
        """Whether an address is answered no more for now."""
        began_s, count = self._refused.get(address, (0.0, 0))
        return count >= _MOST_REFUSALS and self._now_s() - began_s < _WHILE_S

    def refused(self, address: str) -> None:
        """One more."""
        began_s, count = self._refused.pop(address, (self._now_s(), 0))
        if self._now_s() - began_s >= _WHILE_S:
            began_s, count = self._now_s(), 0
        self._refused[address] = (began_s, count + 1)
        while len(self._refused) > _MOST_ADDRESSES:
            self._refused.popitem(last=False)


class Allowance:
    """So many a second, some saved up: messages of one socket."""

    def __init__(
        self, a_second: float, most: float, now_s: Callable[[], float] = time.monotonic
    ) -> None:
        self._a_second, self._most, self._now_s = a_second, most, now_s
        self._left, self._at_s = most, now_s()

    def take(self) -> bool:
        """Whether one more is within the allowance."""
        now_s = self._now_s()
        self._left = min(self._most, self._left + (now_s - self._at_s) * self._a_second)
        self._at_s = now_s
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True
