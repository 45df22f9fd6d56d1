"""The phone's door, its messages, the slots between the processes, the certificate."""

from __future__ import annotations

import contextlib
import json
import math
import ssl
import stat
import struct
import threading
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vrlf.app.serve.address import addresses, listen
from vrlf.app.serve.certificate import fingerprint, own_certificate, tls_context
from vrlf.app.serve.door import Allowance, Door, Patience, Refusal, new_token
from vrlf.app.serve.page import page, page_headers
from vrlf.app.serve.slots import Slots, Stamp
from vrlf.app.serve.wire import (
    DEFLATE,
    HEAD,
    RAW,
    Hello,
    Link,
    Measured,
    MessageError,
    Pressed,
    Shown,
    Turn,
    encoded,
    frame_head,
    joined,
    message_of,
    strips,
)
from vrlf.errors import InputError

TOKEN = "a" * 43
DOOR = Door(TOKEN, frozenset({"127.0.0.1:7433", "localhost:7433"}), "https")


def headers(host: str | None = "127.0.0.1:7433", origin: str | None = None) -> dict[str, list[str]]:
    found = {} if host is None else {"host": [host]}
    return found | ({} if origin is None else {"origin": [origin]})


def test_a_token_is_long_and_never_the_same() -> None:
    assert len({new_token() for _ in range(100)}) == 100
    assert len(new_token()) * 6 >= 128  # base64: six bits a character


def test_the_owner_gets_the_page_and_the_socket() -> None:
    assert DOOR.admits(f"/{TOKEN}/", headers()) == "page"
    assert DOOR.admits(f"/{TOKEN}/", headers("LOCALHOST:7433")) == "page"
    there = headers(origin="https://127.0.0.1:7433")
    assert DOOR.admits(f"/{TOKEN}/live", there) == "socket"


@pytest.mark.parametrize(
    ("path", "given_headers", "status"),
    [
        ("/", headers(), 404),
        ("", headers(), 404),
        (f"/{TOKEN[:-1]}/", headers(), 404),
        (f"/{TOKEN}a/", headers(), 404),
        (f"{TOKEN}/", headers(), 404),
        (f"//{TOKEN}/", headers(), 404),
        (f"/{TOKEN}", headers(), 404),
        (f"/{TOKEN}/../etc/passwd", headers(), 404),
        (f"/{TOKEN}/x", headers(), 404),
        ("/\u00e9/", headers(), 404),
        (f"/{TOKEN}/", headers(None), 421),
        (f"/{TOKEN}/", headers("evil.example:7433"), 421),
        (f"/{TOKEN}/", {"host": ["127.0.0.1:7433", "evil.example"]}, 421),
        (f"/{TOKEN}/live", headers(), 403),
        (f"/{TOKEN}/live", headers(origin="https://evil.example"), 403),
        (f"/{TOKEN}/live", headers(origin="http://127.0.0.1:7433"), 403),
        (f"/{TOKEN}/live", headers(origin="null"), 403),
        (f"/{TOKEN}/", headers(origin="https://localhost:7433"), 403),
    ],
)
def test_all_others_are_refused(path: str, given_headers: dict, status: int) -> None:
    found = DOOR.admits(path, given_headers)
    assert isinstance(found, Refusal)
    assert found.status == status


def test_patience_ends_and_comes_back() -> None:
    clock = [0.0]
    patience = Patience(lambda: clock[0])
    for _ in range(29):
        patience.refused("a")
    assert not patience.is_over("a")
    patience.refused("a")
    assert patience.is_over("a")
    assert not patience.is_over("b")
    clock[0] = 61.0
    assert not patience.is_over("a")
    for k in range(10_000):
        patience.refused(str(k))
    assert len(patience._refused) <= 4096


def test_an_allowance_runs_out_and_fills_up() -> None:
    clock = [0.0]
    allowance = Allowance(10.0, 5.0, lambda: clock[0])
    assert [allowance.take() for _ in range(6)] == [True] * 5 + [False]
    clock[0] = 0.25
    assert [allowance.take() for _ in range(3)] == [True, True, False]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ({"t": "hello", "width": 667, "height": 375.2, "ratio": 2}, Hello((667.0, 375.2), 2.0)),
        ({"t": "shown", "number": 7, "photon": None}, Shown(7, None)),
        ({"t": "shown", "number": 7, "photon": 31.5}, Shown(7, 31.5)),
        (
            {"t": "turn", "alpha": 1, "beta": -2, "gamma": 3.5, "screen": 90, "at": 12.25},
            Turn(1.0, -2.0, 3.5, 90.0, 12.25),
        ),
        ({"t": "key", "chord": "ctrl+z"}, Pressed("ctrl+z")),
        ({"t": "panel", "width": 2400, "height": 1080, "pitch_um": 64}, Measured((2400, 1080), 64)),
    ],
)
def test_messages_are_read(text: dict, message: object) -> None:
    assert message_of(json.dumps(text)) == message


@pytest.mark.parametrize(
    "text",
    [
        b"{}", "", "[]", "{}", "null", '{"t": 3}', '{"t": "shown"}',
        '{"t": "shown", "number": 1.5}',
        '{"t": "shown", "number": true, "photon": null}', '{"t": "shown", "number": -1}',
        '{"t": "hello", "width": NaN, "height": 1, "ratio": 1}',
        '{"t": "hello", "width": 1e999, "height": 1, "ratio": 1}',
        '{"t": "hello", "width": "667", "height": 1, "ratio": 1}',
        '{"t": "turn", "alpha": 1, "beta": 2, "gamma": 3, "screen": 4}',
        '{"t": "key", "chord": ""}', '{"t": "key", "chord": ["h"]}',
        '{"t": "key", "chord": "' + "h" * 25 + '"}',
        '{"t": "panel", "width": 1e9, "height": 2, "pitch_um": 60}',
        "[" * 4000,
    ],
)  # fmt: skip
def test_what_no_phone_says_is_refused(text: str | bytes) -> None:
    with pytest.raises(MessageError):
        message_of(text)


@given(st.text(max_size=200))
def test_any_text_is_a_message_or_refused(text: str) -> None:
    with contextlib.suppress(MessageError):
        message_of(text)


def test_the_screens_pixels_are_the_ratio_times_the_pages() -> None:
    # A phone of 1080 x 2400 at ratio 2.625: the page sees 411.43 x 914.29.
    assert Hello((411.4286, 914.2857), 2.625).device_px == (2400, 1080)


def test_a_frames_head() -> None:
    stamp = Stamp(2**32 + 5, (641, 359), 1234.5, 10.0, 10.004, 10.014)
    head = HEAD.unpack(frame_head(stamp, DEFLATE, 3.5))
    assert head[:7] == (b"VF", 1, 1, 5, 641, 359, 1234.5)
    np.testing.assert_allclose(head[7:], (4.0, 10.0, 3.5), rtol=1e-4)  # floats of 32 bits
    assert len(frame_head(stamp, RAW, 0.0)) == 32  # as phone.js has it


def test_encodings_give_the_bytes_back() -> None:
    data = np.random.default_rng(1).integers(0, 256, 3001, np.uint8).tobytes()
    assert strips(data, RAW) == [data]
    parts = [encoded(strip) for strip in strips(data, DEFLATE)]  # 3001 bytes: not of one length
    whole = joined(parts)
    assert struct.unpack_from("<4I", whole) == tuple(len(part) for part in parts)
    assert whole[16:] == b"".join(parts)
    assert b"".join(zlib.decompress(part) for part in parts) == data


def test_the_faster_encoding_is_chosen_and_the_other_tried_again() -> None:
    link, times = Link(), {RAW: 12.0, DEFLATE: 40.0}
    used = []
    for k in range(400):
        if k == 200:  # now the link is slow
            times = {RAW: 90.0, DEFLATE: 45.0}
        used.append(link.choose())
        link.took(used[-1], times[used[-1]])
    assert used[2:80].count(RAW) == 78
    assert used[-50:].count(DEFLATE) >= 49


def test_the_newest_frame_goes_through_shared_memory() -> None:
    random = np.random.default_rng(2)
    with Slots(7 * 5) as ours, Slots(7 * 5, name=ours.name) as theirs:
        assert theirs.newest() is None
        for number in range(1, 6):
            codes = random.integers(0, 256, (5, 7, 3), np.uint8)
            stamp = Stamp(number, (7, 5), math.nan if number % 2 else 3.0, 1.0, 2.0, 3.0)
            ours.put(codes, stamp)
            found = theirs.newest()
            assert found is not None
            assert found[1] == codes.tobytes()
            assert (found[0].number, found[0].size_px) == (number, (7, 5))
        assert theirs.frames == 5


def test_no_frame_is_ever_torn() -> None:
    """A frame is one value throughout: any mixture would show."""
    with Slots(64 * 64) as ours, Slots(64 * 64, name=ours.name) as theirs:
        is_over = threading.Event()

        def draw() -> None:
            for number in range(1, 3000):
                codes = np.full((64, 64, 3), number % 251, np.uint8)
                ours.put(codes, Stamp(number, (64, 64), math.nan, 0.0, 0.0, 0.0))
            is_over.set()

        drawer = threading.Thread(target=draw)
        drawer.start()
        seen = 0
        while not is_over.is_set():
            found = theirs.newest()
            if found is not None:
                assert len(set(found[1])) == 1
                assert found[1][0] == found[0].number % 251
                seen += 1
        drawer.join()
        assert seen > 10


def test_the_page_needs_nothing_else() -> None:
    text = page().decode()
    for word in ("src=", "@import", "url(", "http://", "https://", "eval(", "innerHTML"):
        assert word not in text.replace('"https:" ? "wss:"', ""), word
    policy = dict(page_headers())["Content-Security-Policy"]
    assert policy.startswith("default-src 'none'")
    assert "unsafe" not in policy


def test_a_certificate_is_made_once_and_is_the_users_alone(tmp_path: Path) -> None:
    cert, key = own_certificate(tmp_path / "tls", ["127.0.0.1", "localhost"])
    assert stat.S_IMODE(key.stat().st_mode) == 0o600
    tls_context(cert, key)
    first = fingerprint(cert)
    own_certificate(tmp_path / "tls", ["127.0.0.1"])
    assert fingerprint(cert) == first
    own_certificate(tmp_path / "tls", ["127.0.0.1", "192.0.2.7"])  # another address: anew
    assert fingerprint(cert) != first
    context = ssl.create_default_context(cafile=str(cert))
    assert context.cert_store_stats()["x509"] == 1
    assert {each.name for each in (tmp_path / "tls").iterdir()} == {"certificate.pem", "key.pem"}


def test_a_wrong_certificate_is_one_line(tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.pem"
    with pytest.raises(InputError, match=r"found no such file, wanted a PEM file"):
        tls_context(wrong, wrong)
    wrong.write_text("no certificate")
    with pytest.raises(InputError, match=r"wanted a certificate and its key"):
        tls_context(wrong, wrong)


def test_addresses() -> None:
    assert addresses("127.0.0.1").all == ("127.0.0.1", "localhost")
    assert addresses("192.0.2.7") == type(addresses("::1"))("192.0.2.7", ("192.0.2.7",), False)
    every = addresses("0.0.0.0")
    assert {"127.0.0.1", "localhost", every.best} <= set(every.all)
    assert not every.is_loopback


def test_a_port_in_use_and_an_address_of_others_are_one_line() -> None:
    with listen("127.0.0.1", 0) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(
            InputError, match=rf"127\.0\.0\.1:{port}: found 'Address already in use"
        ):
            listen("127.0.0.1", port)
    with pytest.raises(InputError, match=r"192\.0\.2\.7:0: found '.*', wanted a free port"):
        listen("192.0.2.7", 0)
    with pytest.raises(InputError, match=r"--host: found 'example', wanted an IP address"):
        listen("example", 0)


def test_struct_sizes_fit_their_slots() -> None:
    assert struct.calcsize("<qqiidddd") <= 64
