"""``vrlf serve`` as a command: its frames are the prefilter's bytes, keys change them, faults."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import signal
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest
from command_runs import call, spawn, start
from phone import free_port
from test_serve_faults import dial, unpacked

from vrlf.images import read_codes

# Odd halves, an array turned against the stripes, two different eyes.
RIG = """
extends = "matched-microlens"
[panel]
width_px = 202
height_px = 117
[left]
sphere_d = -4.5
cylinder_d = -1.0
axis_deg = 30.0
[right]
sphere_d = -5.25
"""
SHAPE = (117, 202, 3)
HELLO = json.dumps({"t": "hello", "width": 101, "height": 58.5, "ratio": 2})


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    path = tmp_path / "mine.toml"
    path.write_text(RIG)
    return path


@contextmanager
def serving(*arguments: str, cwd: Path) -> Iterator[tuple[str, subprocess.Popen]]:
    """The command as it runs; its address."""
    environment = os.environ | {"VRLF_CONFIG_DIR": str(cwd / "config")}
    running = start("serve", *arguments, "--port", "0", cwd=cwd, env=environment)
    try:
        assert running.stdout is not None
        yield running.stdout.readline().strip(), running
    finally:
        running.send_signal(signal.SIGINT)
        try:
            running.communicate(timeout=20.0)
        finally:
            running.kill()


async def settled(phone, *messages: dict) -> tuple[np.ndarray, list[dict]]:
    """The frame after which none comes for a while, and what was said meanwhile."""
    for message in messages:
        await phone.send(json.dumps(message))
    frame, words = None, []
    while True:
        try:
            data = await asyncio.wait_for(phone.recv(), 60.0 if frame is None else 3.0)
        except TimeoutError:
            assert frame is not None
            return np.frombuffer(frame, np.uint8).reshape(SHAPE), words
        if isinstance(data, str):
            words.append(json.loads(data))
            continue
        number, frame = unpacked(data)
        await phone.send(json.dumps({"t": "shown", "number": number, "photon": None}))


def prefiltered(rig: Path, *arguments: str) -> np.ndarray:
    out = rig.parent / "panel.png"
    run = call("prefilter", "chart:logmar", "-r", rig, "-o", out, *arguments)
    assert run.status == 0, run.err
    return read_codes(out)


def test_frames_are_the_prefilters_bytes_and_keys_change_them(rig: Path) -> None:
    async def talk(address: str) -> None:
        async with dial(address) as phone:
            first, words = await settled(phone, json.loads(HELLO))
            assert words[0]["fits"]
            assert np.array_equal(first, prefiltered(rig))
            keys = [{"t": "key", "chord": each} for each in ("1", "down", "down")]
            second, words = await settled(phone, *keys)
            assert words[-1]["left"].startswith("> left  -5.00 / -1.00 x 30")
            assert words[-1]["right"].startswith("right  -5.25")
            assert np.array_equal(second, prefiltered(rig, "--left", "-5.00 / -1.00 x 30"))
            assert not np.array_equal(first, second)
            assert np.array_equal(first[:, 101:], second[:, 101:])  # the right eye's half
            await phone.send(json.dumps({"t": "key", "chord": "ctrl+s"}))
            saved = json.loads(await asyncio.wait_for(phone.recv(), 20.0))
            assert "saved" in saved["left"]

    with serving("chart:logmar", "-r", str(rig), "--no-qr", cwd=rig.parent) as (address, running):
        asyncio.run(talk(address))
    assert running.returncode == 0
    assert "sphere_d = -5.0" in rig.read_text()


def test_a_measured_panel_becomes_a_rig(rig: Path) -> None:
    async def talk(address: str) -> dict:
        async with dial(address) as phone:
            panel = {"t": "panel", "width": 2400, "height": 1080, "pitch_um": 63.77}
            _, words = await settled(phone, json.loads(HELLO), panel)
            return words[-1]

    with serving("chart:grid", "-r", str(rig), cwd=rig.parent) as (address, _):
        words = asyncio.run(talk(address))
    assert "wrote phone-2400x1080.toml" in words["left"]
    made = call("inspect", "-r", rig.parent / "phone-2400x1080.toml", "--json").json()
    assert made["left"]["cylinder_d"] == pytest.approx(-1.0, abs=0.3)
    text = (rig.parent / "phone-2400x1080.toml").read_text()
    assert "width_px = 2400" in text
    assert "pixel_pitch_um = 63.77" in text


def test_over_the_network_it_speaks_tls_with_its_own_certificate(rig: Path) -> None:
    arguments = ("chart:grid", "-r", str(rig), "--host", "0.0.0.0", "--json")
    with serving(*arguments, cwd=rig.parent) as (first, running):
        assert first == "{"
        assert running.stdout is not None
        address = json.loads("{" + "".join(running.stdout.readline() for _ in range(4)))["url"]
        assert address.startswith("https://")
        port = urlsplit(address).port
        curl = subprocess.run(
            ["curl", "-s", "--cacert", str(rig.parent / "config/serve/certificate.pem"),
             f"https://127.0.0.1:{port}{urlsplit(address).path}"],
            capture_output=True, text=True, timeout=20.0,
        ) if shutil.which("curl") else None  # fmt: skip
        if curl is not None:
            assert curl.returncode == 0, curl.stderr
            assert "<canvas" in curl.stdout


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["nothing.png"], "nothing.png: found no such file"),
        (["--host", "example"], "--host: found 'example', wanted an IP address"),
        (["--host", "192.0.2.9"], "192.0.2.9:"),
        (["--port", "70000"], "found '70000', wanted a whole number from 0 to 65535"),
        (["--cert", "a.pem"], "--cert, --key: found one of the two"),
        (["--cert", "a.pem", "--key", "b.pem"], "a.pem: found no such file, wanted a PEM file"),
        (["--folder", "nowhere"], "found no folder"),
        (["-r", "unknown-rig"], "unknown-rig"),
    ],
)
def test_wrong_input_is_one_line(
    arguments: list[str], complaint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    if "--port" not in arguments:
        arguments = [*arguments, "--port", "0"]
    run = call("serve", *arguments)
    assert run.status == 2, run.err
    assert complaint in run.err
    assert len(run.lines) == 1
    assert not list(tmp_path.iterdir())


def test_a_port_in_use_is_one_line(tmp_path: Path) -> None:
    port = free_port()
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", port))
        taken.listen()
        run = spawn("serve", "--port", str(port), cwd=tmp_path)
    assert run.status == 2
    assert f"127.0.0.1:{port}: found 'Address already in use'" in run.err
    assert len(run.lines) == 1
