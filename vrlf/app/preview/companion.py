"""A phone beside the window: it shows the panel image of the window's own frames."""

from __future__ import annotations

from typing import Protocol

from vrlf.app.preview.panels import Phone


class Sender(Protocol):
    """What sends frames to phones and hears them: ``vrlf.app.serve.loop.Broadcast``."""

    phones: int

    def turn(self, now_s: float, passed_s: float) -> None:
        """Hear the phones, send a frame if it is another one."""


class Companion:
    """Stands between a window and the phones; the sender is its maker's."""

    def __init__(self, sender: Sender, modules: tuple[tuple[bool, ...], ...]) -> None:
        self._sender, self._modules = sender, modules

    def turn(self, now_s: float, passed_s: float) -> bool:
        """Send what the window's frame left; whether somebody looks on and frames shall go on."""
        self._sender.turn(now_s, passed_s)
        return self._sender.phones > 0

    @property
    def status(self) -> Phone:
        """For the window's panel."""
        count = self._sender.phones
        words = {0: "scan it: no phone so far", 1: "one phone"}.get(count, f"{count} phones")
        return Phone(self._modules, words)
