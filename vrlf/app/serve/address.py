"""Where to listen, and the addresses that a browser may know this machine by."""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Iterable
from dataclasses import dataclass

from vrlf.errors import InputError

LOOPBACK = "127.0.0.1"
_BACKLOG = 128
_USUAL_PORTS = {"http": 80, "https": 443}


@dataclass(frozen=True)
class Addresses:
    """This machine, as a phone sees it.

    Attributes
    ----------
    best : str
        The address for the QR code.
    all : tuple of str
        Every host name and address that a browser may use.
    is_loopback : bool
        Whether only this machine can reach it.
    """

    best: str
    all: tuple[str, ...]
    is_loopback: bool


def listen(host: str, port: int) -> socket.socket:
    """A listening socket.

    Raises
    ------
    InputError
        If the address is none of this machine's, or the port is in use or not allowed.
    """
    try:
        address = ipaddress.ip_address(host)
    except ValueError as error:
        raise InputError(
            f"--host: found {host[:60]!r}, wanted an IP address of this machine, or 0.0.0.0 for all"
        ) from error
    family = socket.AF_INET6 if address.version == 6 else socket.AF_INET
    sock = socket.socket(family, socket.SOCK_STREAM)
    try:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        sock.bind((host, port))
        sock.listen(_BACKLOG)
        sock.setblocking(False)
    except OSError as error:
        sock.close()
        raise InputError(
            f"{host}:{port}: found '{error.strerror}', wanted a free port on an address of this "
            "machine (--host, --port)"
        ) from error
    return sock


def addresses(host: str) -> Addresses:
    """What a browser may call the place that ``host`` listens on."""
    address = ipaddress.ip_address(host)
    if address.is_loopback:
        return Addresses(host, (host, "localhost"), True)
    if not address.is_unspecified:
        return Addresses(host, (host,), False)
    best = _outward() or LOOPBACK
    found = {best, LOOPBACK, "localhost", *_of_this_machine()}
    return Addresses(best, tuple(sorted(found)), False)


def _outward() -> str | None:
    """The address that a packet into the network would leave from; none is sent."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # RFC 5737: an address of nobody
            return str(probe.getsockname()[0])
        except OSError:
            return None


def _of_this_machine() -> set[str]:
    try:
        found = socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)
    except OSError:
        return set()
    return {str(each[4][0]) for each in found}


def hosts(names: Iterable[str], port: int, scheme: str) -> frozenset[str]:
    """What a browser may send as Host: without the port where it is the scheme's own."""
    is_usual = port == _USUAL_PORTS[scheme]
    found = [in_address(name.lower(), port) for name in names]
    bare = [each.rpartition(":")[0] for each in found] if is_usual else []
    return frozenset((*found, *bare))


def in_address(host: str, port: int) -> str:
    """Host and port as a browser writes them."""
    bracketed = f"[{host}]" if ":" in host else host
    return f"{bracketed}:{port}"
