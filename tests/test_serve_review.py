"""``vrlf serve`` where it broke once: stuck sends, other panels, silent strangers."""

from __future__ import annotations

import asyncio
import contextlib
import json
import socket
import ssl
import time
from contextlib import AsyncExitStack, ExitStack
from multiprocessing.shared_memory import SharedMemory
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
from phone import Stub, broadcasting, wait_for
from test_serve_command import HELLO as SMALL_HELLO
from test_serve_command import RIG, SHAPE, serving, settled
from test_serve_faults import HELLO, dial, frames, is_closed, run

from vrlf.app.serve.address import hosts
from vrlf.app.serve.certificate import names_of, own_certificate
from vrlf.app.serve.door import Door
from vrlf.app.serve.drawing import lens_axes
from vrlf.app.serve.gate import MOST_OF_AN_ADDRESS
from vrlf.app.serve.phones import MOST_PHONES
from vrlf.app.serve.server import Plan, Server
from vrlf.app.serve.slots import Slots, Stamp
from vrlf.app.serve.wire import RAW, Hello, Link
from vrlf.model import load_rig


def test_a_phone_that_takes_nothing_keeps_no_word_from_the_others() -> None:
    """Its send never ends; the watch goes on, tells the other phone and lets the stuck one go."""

    async def watch() -> list[str]:
        got: list[str] = []

        async def never(_: str) -> None:
            await asyncio.sleep(100.0)

        async def heard(text: str) -> None:
            got.append(json.loads(text)["t"])

        def phone(send: Any, **on_the_way: Any) -> Any:
            transport = SimpleNamespace(
                get_write_buffer_size=lambda: 600_000, abort=lambda: got.append("let go")
            )
            link = SimpleNamespace(send=send, transport=transport)
            return SimpleNamespace(socket=link, on_the_way=on_the_way)

        door = Door("", frozenset(), "http")
        stuck: Any = SimpleNamespace(beat_s=time.monotonic() - 5.0)
        no: Any = None
        server = Server(Plan(door, "", 1, (1, 1)), stuck, no, no)
        server._phones = [phone(never, frame=(RAW, time.monotonic() - 60.0)), phone(heard)]
        watching = asyncio.create_task(server._watch())
        await asyncio.sleep(1.2)
        assert not watching.done()
        watching.cancel()
        return got

    got = run(watch())
    assert "held" in got
    assert got.count("let go") >= 3  # at each of its rounds, for this phone never leaves the list


def test_a_rig_with_another_panel_is_not_read_while_phones_look(tmp_path: Path) -> None:
    rig = tmp_path / "mine.toml"
    rig.write_text(RIG)

    async def talk(address: str) -> None:
        async with dial(address) as phone:
            first, _ = await settled(phone, json.loads(SMALL_HELLO))
            for other in (RIG.replace("117", "234"), RIG.replace("202", "100")):
                rig.write_text(other)
                await phone.send(json.dumps({"t": "key", "chord": "ctrl+r"}))
                said = json.loads(await asyncio.wait_for(phone.recv(), 20.0))
                assert "the rig's panel has other pixels now" in said["left"]
            rig.write_text(RIG.replace("-4.5", "-3.0"))
            second, _ = await settled(phone, {"t": "key", "chord": "ctrl+r"})
            assert first.shape == second.shape == SHAPE
            assert not np.array_equal(first, second)

    with serving("chart:grid", "-r", str(rig), "--no-qr", cwd=tmp_path) as (address, running):
        asyncio.run(talk(address))
    assert running.returncode == 0


def test_a_frame_never_runs_over_into_the_next_slot() -> None:
    with Slots(100) as ours, pytest.raises(ValueError, match="at most 300"):
        ours.put(np.zeros((15, 10, 3), np.uint8), Stamp(1, (10, 15), 0.0, 0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("css", "ratio", "panel", "may"),
    [
        ((412, 915), 2.625, (2400, 1080), True),  # Pixel 7: 411.43 by 914.29, told upward
        ((412, 892), 3.5, (3120, 1440), True),  # Pixel 6 Pro: 411.43 by 891.43
        ((411, 914), 2.625, (2400, 1080), True),  # downward
        ((411.4286, 914.2857), 2.625, (2400, 1080), True),
        ((375, 667), 2.0, (1334, 750), True),
        ((375, 667), 2.0, (1336, 750), False),
        ((412, 915), 2.625, (2405, 1080), False),
        ((320, 180), 3.0, (640, 360), False),
    ],
)
def test_a_screen_is_known_however_its_browser_rounds(
    css: tuple[float, float], ratio: float, panel: tuple[int, int], *, may: bool
) -> None:
    assert Hello(css, ratio).may_have(*panel) is may
    assert Hello(css[::-1], ratio).may_have(*panel[::-1]) is may


def test_what_cannot_be_unpacked_is_not_sent() -> None:
    link = Link()
    link.can_inflate = False
    assert {link.choose() for _ in range(2 * Link.TRIED_EVERY)} == {RAW}


def test_silent_strangers_before_their_tls_handshake_count_and_leave(tmp_path: Path) -> None:
    """Each would hold memory for a minute, uncounted."""
    files = own_certificate(tmp_path, ["127.0.0.1"])
    with broadcasting(Stub(), files) as (address, _), ExitStack() as opened:
        parts, held = urlsplit(address), []
        for _ in range(MOST_OF_AN_ADDRESS + 60):
            wire = socket.create_connection((parts.hostname, parts.port), 10.0)
            opened.callback(wire.close)
            held.append(wire)
        wait_for(lambda: sum(is_closed(wire) for wire in held) >= 60, "the dropping", 4.5)
        # Those that had room leave after 5 s, long before the library's 60.
        wait_for(lambda: all(is_closed(wire) for wire in held), "the leaving", 20.0)


def test_nothing_lies_in_shared_memory_by_name_while_it_serves() -> None:
    """So whoever is killed, nothing stays behind."""
    with broadcasting(Stub()) as (_, broadcast):
        with pytest.raises(FileNotFoundError):
            SharedMemory(name=broadcast._slots.name)
        wait_for(lambda: broadcast._number == 1, "a frame")


def test_without_a_phone_nothing_is_drawn() -> None:
    async def look(address: str) -> int:
        async with dial(address) as phone:
            await phone.send(HELLO)
            return await frames(phone, 0.5)

    stub = Stub()
    with broadcasting(stub) as (address, _):
        wait_for(lambda: stub.number == 1, "the first frame")
        time.sleep(0.3)
        assert stub.number == 1
        assert run(look(address)) > 3


def test_lively_phones_are_not_let_go_for_another() -> None:
    async def crowd(address: str) -> int | None:
        async with AsyncExitStack() as opened:
            lively = [await opened.enter_async_context(dial(address)) for _ in range(MOST_PHONES)]
            for phone in lively:
                await phone.send(HELLO)
            showing = [asyncio.create_task(frames(phone, 3.0)) for phone in lively]
            await asyncio.sleep(1.0)
            code: int | None = None
            async with dial(address) as another:
                with contextlib.suppress(Exception):
                    await asyncio.wait_for(another.recv(), 2.0)
                code = another.close_code
            assert all(count > 3 for count in await asyncio.gather(*showing))
            return code

    with broadcasting(Stub()) as (address, _):
        assert run(crowd(address)) == 1013


def test_a_beat_is_answered_and_another_phones_clock_is_not_believed() -> None:
    turn = {"t": "turn", "alpha": 0, "beta": 0, "gamma": -90, "screen": 90, "at": 1000}

    async def talk(address: str, broadcast: Any) -> None:
        async with dial(address) as turner, dial(address) as other:
            for phone in (turner, other):
                await phone.send(HELLO.replace("320", "321"))  # no frames: one's turn is enough
                await phone.send('{"t": "beat"}')
                while json.loads(await phone.recv())["t"] != "beat":
                    pass
            before_ms = broadcast._photon_ms
            await turner.send(json.dumps(turn))
            await other.send('{"t": "shown", "number": 1, "photon": 90000}')
            await asyncio.sleep(0.5)
            assert broadcast._photon_ms == before_ms

    with broadcasting(Stub()) as (address, broadcast):
        run(talk(address, broadcast))


def test_a_usual_port_and_a_certificates_own_name_are_known(tmp_path: Path) -> None:
    """Browsers leave the usual port out of Host."""
    assert hosts(["192.0.2.7"], 443, "https") == {"192.0.2.7:443", "192.0.2.7"}
    assert hosts(["::1"], 80, "http") == {"[::1]:80", "[::1]"}
    assert hosts(["Phone.Example"], 7433, "https") == {"phone.example:7433"}
    cert, _ = own_certificate(tmp_path, ["192.0.2.7", "phone.example", "*.other.example"])
    assert names_of(cert) == ("phone.example",)
    assert names_of(tmp_path / "none.pem") == ()


def test_with_their_own_certificate_its_name_is_in_the_address(tmp_path: Path) -> None:
    cert, key = own_certificate(tmp_path / "own", ["phone.example"])
    rig = tmp_path / "mine.toml"
    rig.write_text(RIG)
    given = ("chart:grid", "-r", str(rig), "--no-qr", "--cert", str(cert), "--key", str(key))
    with serving(*given, cwd=tmp_path) as (address, _):
        assert urlsplit(address).hostname == "phone.example"
        parts = urlsplit(address)
        context = ssl.create_default_context(cafile=str(cert))
        with (
            socket.create_connection(("127.0.0.1", parts.port), 10.0) as plain,
            context.wrap_socket(plain, server_hostname="phone.example") as wire,
        ):
            wire.sendall(f"GET {parts.path} HTTP/1.1\r\nHost: {parts.netloc}\r\n\r\n".encode())
            assert wire.recv(15) == b"HTTP/1.1 200 OK"


def test_words_stand_before_the_lenses() -> None:
    rig = load_rig("matched-microlens")
    panel_mm = 1e-3 * rig.panel.width_px * rig.panel.pixel_pitch_um
    left, right = lens_axes(rig)
    assert (right - left) * panel_mm == pytest.approx(rig.headset.lens_separation_mm)
    assert left + right == pytest.approx(1.0)
    small = rig.model_copy(update={"panel": rig.panel.model_copy(update={"width_px": 200})})
    assert lens_axes(small) == (0.11, 0.89)
