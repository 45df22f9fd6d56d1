"""By hand: how fast frames reach a phone's page, and what strangers and stalled phones cost.

python tests/serve_by_hand.py speed              a table by panel and encoding, in Chromium
python tests/serve_by_hand.py strangers 10000    requests without the token
python tests/serve_by_hand.py stalled 10         seconds with and without 100 stalled phones
python tests/serve_by_hand.py soak 600           seconds; memory of both processes
"""

from __future__ import annotations

import asyncio
import json
import resource
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from phone import Stub, broadcasting, browser, wait_for
from test_serve_faults import dial, frames, picture_bytes, run, stalled_phones, unpacked

from vrlf.app.serve import wire

SIZES = ((667, 375), (1334, 750), (2400, 1080))
HELLO = {"t": "hello", "ratio": 1}


class Film(Stub):
    """Frames that are there already: a panel image's own bytes, moved on by a row each."""

    def __init__(self, size_px: tuple[int, int], codes: np.ndarray) -> None:
        super().__init__(size_px)
        self._noise = np.concatenate([codes, codes])


def panel_image(size_px: tuple[int, int]) -> np.ndarray:
    """The shipped scene's panel image for the default rig, cut or repeated to a size."""
    import vrlf
    from vrlf.gpu import Device
    from vrlf.renderer import GpuRenderer
    from vrlf.scene import render_stereo

    rig = vrlf.load_rig("matched-microlens")
    with Device.headless() as device, GpuRenderer(device) as renderer:
        panel = renderer.prefilter(np.hstack(render_stereo(device, rig)), rig)
        codes = renderer.encode(panel)
    rows, columns = (np.arange(n) % m for n, m in zip(size_px[::-1], codes.shape, strict=False))
    return np.ascontiguousarray(codes[rows[:, None], columns])


def speed(seconds: float = 5.0) -> None:
    """Frames a second on the page's canvas, and where the time goes."""
    print("| panel | encoding | MB a frame | frames/s | packing | unpacking | put, whole way |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    codes = {size: panel_image(size) for size in SIZES}
    for size in SIZES:
        for encodings in ((wire.RAW,), (wire.DEFLATE,), wire.ENCODINGS):
            found = page_speed(size, codes[size], encodings, seconds)
            name = encodings[0] if len(encodings) == 1 else "chosen"
            print(f"| {size[0]} x {size[1]} | {name} | {found} |", flush=True)


_COUNT = """
const done = arguments[0];
const before = [state.shown, performance.now(), state.bytes];
setTimeout(() => {
  const seconds = (performance.now() - before[1]) / 1000;
  const mean = (key) => state.times.reduce((sum, each) => sum + each[key], 0) / state.times.length;
  done([(state.shown - before[0]) / seconds, (state.bytes - before[2]) / (state.shown - before[0]),
        mean("encoded"), mean("decoded"), mean("drawn")]);
}, 1000 * arguments[1]);
"""
_WATCH = """
addEventListener("load", () => {
  state.bytes = 0; state.times = [];
  const take_ = take;
  take = async (buffer) => {
    const came = performance.now(); state.bytes += buffer.byteLength;
    const view = new DataView(buffer);
    await take_(buffer);
    state.times.push({encoded: view.getFloat32(28, true), drawn: view.getFloat32(24, true),
                      decoded: performance.now() - came});
    if (state.times.length > 60) state.times.shift();
  };
});
"""


def page_speed(
    size: tuple[int, int], codes: np.ndarray, encodings: tuple[str, ...], seconds: float
) -> str:
    """A row of the table, from its third column on."""
    film = Film(size, codes)
    with browser(size, 1.0, _WATCH) as driver, broadcasting(film, encodings) as (address, _):
        driver.set_script_timeout(60)
        driver.get(address)
        wait_for(lambda: driver.find_element("id", "begin").is_enabled(), "fitting")
        driver.find_element("id", "begin").click()
        wait_for(lambda: driver.execute_script("return state.shown") > 20, "frames")
        done = driver.execute_async_script(_COUNT.replace("arguments[1]", str(seconds)))
    rate, size_bytes, encoded, decoded, _ = done
    way = 1e3 / rate
    return (
        f"{size_bytes / 1e6:.2f} | {rate:.1f} | {encoded:.1f} ms | {decoded:.1f} ms | {way:.1f} ms"
    )


def strangers(count: int) -> None:
    """What so many requests without the token get."""
    with broadcasting(Stub()) as (address, _):
        began = time.monotonic()
        got = picture_bytes(address, "/x/live", count)
        print(f"{count} requests: {got} bytes of picture, {time.monotonic() - began:.1f} s")


def stalled(seconds: float) -> None:
    """Frames of a good phone, without and with a hundred stalled ones, by turns."""

    async def good(address: str) -> int:
        async with dial(address) as phone:
            await phone.send(json.dumps(HELLO | {"width": 640, "height": 360}))
            return await frames(phone, seconds)

    async def both(address: str) -> int:
        count, _ = await asyncio.gather(good(address), stalled_phones(address, seconds))
        return int(count)

    with broadcasting(Stub()) as (address, _):
        pairs = [(run(good(address)), run(both(address))) for _ in range(4)]
    without, with_ = np.sum(pairs, axis=0)
    print(f"frames in {seconds:g} s, without and with: {pairs}; {100 * (1 - with_ / without):.1f} %"
          " fewer")  # fmt: skip


def soak(seconds: float) -> None:
    """Memory of the drawing and the server's process over time."""

    async def watch(address: str, pid: int) -> None:
        async with dial(address) as phone:
            await phone.send(json.dumps(HELLO | {"width": 640, "height": 360}))
            began, told, count = time.monotonic(), 0.0, 0
            while time.monotonic() - began < seconds:
                data: Any = await phone.recv()
                if isinstance(data, str):
                    continue
                number, _ = unpacked(data)
                count += 1
                await phone.send(json.dumps({"t": "shown", "number": number, "photon": 20.0}))
                turn = {"alpha": count % 360, "beta": 1, "gamma": -89, "screen": 90}
                at = 1e3 * (time.monotonic() - began)
                await phone.send(json.dumps({"t": "turn", "at": at} | turn))
                if time.monotonic() - began >= told:
                    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
                    print(
                        f"{told:6.0f} s: {count} frames, server {resident_kb(pid)} kB, open files "
                        f"{open_files(pid)}, this process at most {own} kB",
                        flush=True,
                    )
                    told += seconds / 10

    with broadcasting(Stub()) as (address, broadcast):
        asyncio.run(watch(address, int(broadcast._server.pid or 0)))


def resident_kb(pid: int) -> int:
    """Resident memory of a process."""
    status = Path(f"/proc/{pid}/status").read_text()
    return int(status.split("VmRSS:")[1].split()[0])


def open_files(pid: int) -> int:
    """Its open files."""
    return len(list(Path(f"/proc/{pid}/fd").iterdir()))


if __name__ == "__main__":
    name, *numbers = sys.argv[1:] or ["speed"]
    {"speed": speed, "strangers": strangers, "stalled": stalled, "soak": soak}[name](
        *(int(number) for number in numbers)
    )
