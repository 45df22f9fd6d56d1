"""``vrlf serve``: the panel image on a phone, live."""

from __future__ import annotations

import importlib.util
import io
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import click

from vrlf.app.options import (
    json_option,
    put_json,
    rig_choice,
    rig_options,
    say,
    say_of_wavefronts,
    whole_number,
)
from vrlf.app.preview.files import Files
from vrlf.app.preview.state import state_folder
from vrlf.app.sources import SCENE, SourceOptions, open_live, source_options
from vrlf.errors import DeviceError, InputError
from vrlf.files import check_target
from vrlf.gpu import Device

_PORT = 7433


@click.command(short_help="Show it on a phone in the headset, live.")
@click.argument("source", required=False)
@rig_options
@source_options
@click.option(
    "--host",
    default="127.0.0.1",
    show_default=True,
    metavar="ADDRESS",
    help="The address to listen on; 0.0.0.0 lets a phone on the same network in, by its token.",
)
@click.option(
    "--port",
    type=whole_number(0, 65535),
    default=_PORT,
    show_default=True,
    metavar="N",
    help="0 takes a free one.",
)
@click.option("--cert", metavar="FILE", help="Your own TLS certificate, PEM; with --key.")
@click.option("--key", metavar="FILE", help="Its key.")
@click.option(
    "--folder",
    default=".",
    show_default=True,
    metavar="DIR",
    help="Where rigs that the phone measures or saves go.",
)
@click.option("--no-qr", is_flag=True, help="Print the address alone, no QR code.")
@json_option
def serve(
    source: str | None,
    host: str,
    port: int,
    cert: str | None,
    key: str | None,
    folder: str,
    no_qr: bool,
    as_json: bool,
    **options: Any,
) -> None:
    """Serve SOURCE's panel image to a phone's browser, pixel for pixel, and follow its turning.

    Prints an address and its QR code; whoever has it gets in, nobody else. Over the network
    phones want TLS: a certificate is made on first use, which the phone's browser warns of once.
    With a cable, 'adb reverse tcp:7433 tcp:7433' brings the default address onto the phone
    without any network. Ctrl-C ends it.

    \b
    Examples:
      vrlf serve scene -r mine.toml
      vrlf serve orrery -r mine.toml --host 0.0.0.0
    """
    _require("websockets")
    from vrlf.app.serve.drawing import Drawing
    from vrlf.app.serve.loop import Broadcast

    choice = rig_choice(options)
    rig = choice.load()
    say_of_wavefronts(rig)
    check_target(Path(folder) / "phone.toml")
    if (cert is None) != (key is None):
        raise InputError("--cert, --key: found one of the two, wanted both or none")
    with ExitStack() as owned:
        where = _Where(host, port, cert, key)
        owned.callback(where.close)
        device = owned.enter_context(Device.headless())
        live = open_live(source or SCENE, rig, device, SourceOptions(**options))
        owned.callback(live.release)
        drawing = Drawing(device, rig, live, Files(choice, Path(folder)), Path(folder))
        owned.callback(drawing.release)
        broadcast = Broadcast(drawing, where.plan_of(drawing.size_px), [where.socket])
        owned.callback(broadcast.release)
        where.say(has_qr=not no_qr)
        if as_json:
            put_json({"url": where.url, "width": rig.panel.width_px, "height": rig.panel.height_px})
        else:
            click.echo(where.url)
        with _told_to_stop() as until:
            broadcast.run(until)
    say("stopped")


class _Where:
    """Owns the listening socket; knows the address that a phone is given."""

    def __init__(self, host: str, port: int, cert: str | None, key: str | None) -> None:
        from vrlf.app.serve.address import LOOPBACK, addresses, hosts, in_address, listen
        from vrlf.app.serve.certificate import names_of, own_certificate, tls_context
        from vrlf.app.serve.door import Door, new_token

        self.socket = listen(host, port)
        try:
            self.port = self.socket.getsockname()[1]
            found = addresses(host)
            self._files: tuple[Path, Path] | None = None
            if cert is not None and key is not None:
                self._files = (Path(cert), Path(key))
            elif not found.is_loopback:
                self._files = own_certificate(state_folder() / "serve", found.all)
            if self._files is not None:
                tls_context(*self._files)  # a wrong one is said now
            self._is_own = cert is None
            scheme = "https" if self._files else "http"
            # Their own certificate is for a name, and that is what the phone must ask for.
            named = names_of(self._files[0]) if self._files and cert is not None else ()
            known = hosts((*found.all, *named), self.port, scheme)
            self.door = Door(new_token(), known, scheme)
            best = named[0] if named else found.best
            self.url = f"{scheme}://{in_address(best, self.port)}{self.door.path}"
            self.is_stranded = not found.is_loopback and best == LOOPBACK
        except BaseException:
            self.socket.close()
            raise

    def plan_of(self, panel_px: tuple[int, int]) -> Any:
        """For the server's process."""
        from vrlf.app.serve.server import Plan

        def plan(slots_name: str, most_pixels: int) -> Plan:
            cert, key = self._files or (None, None)
            return Plan(self.door, slots_name, most_pixels, panel_px, cert, key)

        return plan

    def say(self, *, has_qr: bool) -> None:
        """The QR code, and what the phone will ask about."""
        if self._files and self._is_own:
            from vrlf.app.serve.certificate import fingerprint

            say(f"the phone warns once of this certificate, SHA-256 {fingerprint(self._files[0])}")
        if self.is_stranded:
            say("found no way into a network: no phone reaches this address")
        if not has_qr:
            return
        if importlib.util.find_spec("segno") is None:
            say("no QR code: found no segno; pip install 'vrlf[serve]'")
            return
        import segno

        text = io.StringIO()
        segno.make(self.url, micro=False).terminal(out=text, compact=True)
        say(text.getvalue())

    def close(self) -> None:
        """Give the socket back."""
        self.socket.close()


@contextmanager
def _told_to_stop() -> Iterator[Callable[[], bool]]:
    """Whether Ctrl-C or a signal to end came; both do what they did before when this is over."""
    told = threading.Event()
    numbers = [signal.SIGINT, signal.SIGTERM]
    hang_up = getattr(signal, "SIGHUP", None)
    if hang_up and signal.getsignal(hang_up) != signal.SIG_IGN:  # nohup stays nohup
        numbers.append(hang_up)
    before = [signal.signal(number, lambda *_: told.set()) for number in numbers]
    try:
        yield told.is_set
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)


def _require(name: str) -> None:
    if importlib.util.find_spec(name) is None:
        raise DeviceError(f"serve: found no {name}, wanted it; pip install 'vrlf[serve]'")
