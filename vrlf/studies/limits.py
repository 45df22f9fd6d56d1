"""How fast the device at hand moves memory and fetches texels, measured by two small shaders.

Every pass reads and writes pixels, so none is faster than a copy of as many bytes; one that
traces rays is no faster than as many fetches from the nearest cache. What a pass takes, against
that, says how far from the limit it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from vrlf.gpu import Block, ComputePass, Device, Field, GpuTimer, Texture

PROBE = Block(
    "BenchProbe",
    (
        Field("ivec2", "size_px", "width and height of the result"),
        Field("int", "fetches", "texels fetched for each pixel; 1 for the copy"),
    ),
)
# Source and copy together, 64 MiB and 512 MiB: more than any cache of theirs holds.
_COPY_SIDE_SOFTWARE_PX: Final = 1448
_COPY_SIDE_GPU_PX: Final = 4096
# 16 KiB, within the nearest cache of a core and of a texture unit.
SOURCE_PX: Final = 32
_FETCH_SIDE_SOFTWARE_PX: Final = 256
_FETCH_SIDE_GPU_PX: Final = 2048
_FETCHES: Final = 256
_RUNS: Final = 7
PIXEL_BYTES: Final = 16


@dataclass(frozen=True)
class Limits:
    """What the device can do at best.

    Attributes
    ----------
    copy_gb_per_s : float
        Bytes read plus bytes written by a copy of rgba32f pixels, 1e9 a second.
    fetch_g_per_s : float
        Texels of rgba32f fetched from the nearest cache, 1e9 a second.
    """

    copy_gb_per_s: float
    fetch_g_per_s: float

    def least_ms(self, nbytes: float, fetches: float = 0.0) -> float:
        """No pass that moves so many bytes and fetches so many texels is faster."""
        return max(nbytes / self.copy_gb_per_s, fetches / self.fetch_g_per_s) / 1e6


def measured_limits(device: Device, *, runs: int = _RUNS) -> Limits:
    """Measure both, the best of some runs; the device is left as it was found.

    Raises
    ------
    DeviceError
        If the GPU has no room for two textures of 268 MB.
    """
    software = device.info.is_software
    copy_px = _COPY_SIDE_SOFTWARE_PX if software else _COPY_SIDE_GPU_PX
    fetch_px = _FETCH_SIDE_SOFTWARE_PX if software else _FETCH_SIDE_GPU_PX
    copy_ms = best_ms(device, "bench_copy.comp", copy_px, copy_px, 1, runs)
    fetch_ms = best_ms(device, "bench_fetch.comp", SOURCE_PX, fetch_px, _FETCHES, runs)
    return Limits(
        copy_gb_per_s=2 * PIXEL_BYTES * copy_px**2 / copy_ms / 1e6,
        fetch_g_per_s=_FETCHES * fetch_px**2 / fetch_ms / 1e6,
    )


def best_ms(
    device: Device, shader: str, source_px: int, result_px: int, fetches: int, runs: int
) -> float:
    """The fastest of some runs of a probe over squares of these sides."""
    defines = {"SOURCE_PX": source_px} if shader == "bench_fetch.comp" else {}
    probe = ComputePass(device, shader, PROBE, defines=defines)
    textures: list[Texture] = []
    try:
        for side_px, label in ((source_px, "probe's source"), (result_px, "probe's result")):
            textures.append(Texture(device, (side_px, side_px), label=label))
        # Written pages: a texture that nobody wrote may have no memory of its own yet.
        textures[0].write(np.ones((source_px, source_px, 4), np.float32))
        timer, times_ms = GpuTimer(device), []
        for _ in range(runs + 1):  # the first warms up, and is not the fastest
            with timer.measure():
                run_probe(probe, textures[0], textures[1], fetches)
            device.check("measuring the device's limits")
            times_ms.append(timer.milliseconds)
        return min(times_ms)
    finally:
        probe.release()
        for texture in textures:
            texture.release()


def run_probe(probe: ComputePass, source: Texture, result: Texture, fetches: int) -> None:
    """Dispatch a probe once."""
    source.bind_sampler(0)
    result.bind_image(0, read=False, write=True)
    probe.set({"size_px": result.size_px, "fetches": fetches})
    probe.run(*result.size_px)
