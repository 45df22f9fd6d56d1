"""``vrlf serve``: the panel image on a phone, live."""

from __future__ import annotations

import importlib.util
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
from vrlf.app.serve.wire import ENCODINGS
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
@click.option(
    "--link",
    type=click.Choice(["auto", *ENCODINGS]),
    default="auto",
    show_default=True,
    help="How frames go over the link, all without loss; auto measures which is faster.",
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
    link: str,
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
    require_server("serve")
    from vrlf.app.serve.drawing import Drawing
    from vrlf.app.serve.loop import Broadcast
    from vrlf.app.serve.where import Where

    choice = rig_choice(options)
    rig = choice.load()
    say_of_wavefronts(rig)
    check_target(Path(folder) / "phone.toml")
    if (cert is None) != (key is None):
        raise InputError("--cert, --key: found one of the two, wanted both or none")
    with ExitStack() as owned:
        where = Where(host, port, cert, key)
        owned.callback(where.close)
        device = owned.enter_context(Device.headless())
        live = open_live(source or SCENE, rig, device, SourceOptions(**options))
        owned.callback(live.release)
        drawing = Drawing(device, rig, live, Files(choice, Path(folder)), Path(folder))
        owned.callback(drawing.release)
        broadcast = Broadcast(drawing, where.plan_of(rig, link), [where.socket])
        owned.callback(broadcast.release)
        for line in where.words(has_qr=not no_qr):
            say(line)
        if as_json:
            put_json({"url": where.url, "width": rig.panel.width_px, "height": rig.panel.height_px})
        else:
            click.echo(where.url)
        with _told_to_stop() as until:
            broadcast.run(until)
    say("stopped")


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


def require_server(command: str) -> None:
    """Say how to get what a server needs, where it is missing."""
    for name in ("websockets", "segno"):
        if importlib.util.find_spec(name) is None:
            raise DeviceError(f"{command}: found no {name}, wanted it; pip install 'vrlf[serve]'")
