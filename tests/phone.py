"""What the tests of ``vrlf serve`` share: a drawing without a GPU, a browser of a phone's size."""

from __future__ import annotations

import shutil
import socket
import threading
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from vrlf.app.preview.session import Session
from vrlf.app.serve.address import in_address, listen
from vrlf.app.serve.door import Door, new_token
from vrlf.app.serve.loop import Broadcast
from vrlf.app.serve.server import Plan
from vrlf.app.serve.wire import ENCODINGS, Measured
from vrlf.model import load_rig
from vrlf.scene import HeadPose


@dataclass
class Stub:
    """Stands for ``Drawing``: frames of noise, each with its number in its first pixel."""

    size_px: tuple[int, int] = (640, 360)
    changes: bool = True
    session: Session = field(default_factory=lambda: Session(load_rig("bare"), load_rig("bare")))
    fault: str = ""
    has_latency: bool = False
    sums: dict[int, int] = field(default_factory=dict)
    heads: list[HeadPose] = field(default_factory=list)
    pressed: list[str] = field(default_factory=list)
    measured: list[Measured] = field(default_factory=list)
    number: int = 0
    sleeps_s: float = 0.0

    def __post_init__(self) -> None:
        width, height = self.size_px
        random = np.random.default_rng(3)
        self._noise = random.integers(0, 256, (2 * height, width, 3), np.uint8)

    def frame(self, head: HeadPose, _: float) -> NDArray[np.uint8] | None:
        self.heads.append(head)
        if self.sleeps_s:
            time.sleep(self.sleeps_s)
        if not self.changes and self.number:
            return None
        self.number += 1
        start = self.number * 7 % self.size_px[1]
        codes = self._noise[start : start + self.size_px[1]].copy()
        codes[0, 0] = (self.number >> 16 & 255, self.number >> 8 & 255, self.number & 255)
        self.sums[self.number] = zlib.crc32(codes.tobytes())
        return codes

    def press(self, chord: str) -> str:
        self.pressed.append(chord)
        return f"pressed {chord}"

    def prompts(self) -> tuple[str, str]:
        return "> left  -5.00", "right  -4.50"

    def axes(self) -> tuple[float, float]:
        return 0.25, 0.75

    def write_panel(self, measured: Measured) -> str:
        self.measured.append(measured)
        return "wrote it"


@contextmanager
def broadcasting(
    stub: Any,
    encodings: tuple[str, ...] = ENCODINGS,
    tls: tuple[Path, Path] | None = None,
) -> Iterator[tuple[str, Broadcast]]:
    """A server with its drawing loop in a thread; the page's address."""
    sock = listen("127.0.0.1", 0)
    port = sock.getsockname()[1]
    scheme = "https" if tls else "http"
    door = Door(new_token(), frozenset({in_address("127.0.0.1", port)}), scheme)

    def plan(name: str, most_pixels: int) -> Plan:
        cert, key = tls or (None, None)
        return Plan(door, name, most_pixels, stub.size_px, cert, key, encodings)

    broadcast = Broadcast(stub, plan, [sock])
    is_over = threading.Event()
    errors: list[BaseException] = []

    def run() -> None:
        try:
            broadcast.run(is_over.is_set)
        except BaseException as error:
            errors.append(error)

    loop = threading.Thread(target=run)
    loop.start()
    try:
        yield f"{scheme}://127.0.0.1:{port}{door.path}", broadcast
    finally:
        is_over.set()
        loop.join(10.0)
        broadcast.release()
    assert not errors, errors


def wait_for(is_so: Callable[[], Any], what: str, seconds: float = 20.0) -> Any:
    """Until it is so; fails after a while."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        found = is_so()
        if found:
            return found
        time.sleep(0.05)
    raise AssertionError(f"{what}: not within {seconds:g} s")


def require_browser() -> None:
    """Skip where there is none, and say so."""
    if shutil.which("chromium") is None or shutil.which("chromedriver") is None:
        pytest.skip("found no chromium and chromedriver; 'make setup-test' installs them")


@contextmanager
def browser(size: tuple[int, int], ratio: float, script: str = "") -> Iterator[Any]:
    """A headless Chromium that takes itself for a phone on its side.

    Parameters
    ----------
    size : (width, height)
        Of its screen in the page's pixels.
    ratio : float
        Device pixels for each.
    script : str
        Run in every page before its own.
    """
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    for argument in (
        *("--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"),
        *("--disable-dev-shm-usage", "--force-color-profile=srgb"),
        f"--window-size={size[0]},{size[1]}",
        # Emulated ratios leave a picture's true size in device pixels as it was.
        f"--force-device-scale-factor={ratio}",
    ):
        options.add_argument(argument)
    options.binary_location = shutil.which("chromium") or ""
    service = webdriver.ChromeService(executable_path=shutil.which("chromedriver"))
    driver = webdriver.Chrome(options=options, service=service)
    try:
        resize(driver, size)
        if script:
            driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": script})
        yield driver
    finally:
        driver.quit()


def resize(driver: Any, size: tuple[int, int], ratio: float = 0.0) -> None:
    """Another screen; a ratio of 0 is the browser's own."""
    is_wide = size[0] >= size[1]
    kind = "landscapePrimary" if is_wide else "portraitPrimary"
    driver.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {
            "width": size[0],
            "height": size[1],
            "screenWidth": size[0],
            "screenHeight": size[1],
            "deviceScaleFactor": ratio,
            "mobile": True,
            "screenOrientation": {"type": kind, "angle": 90 if is_wide else 0},
        },
    )


def free_port() -> int:
    """One that nobody listens on now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
