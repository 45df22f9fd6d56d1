"""Films whose every frame is known, made with PyAV directly."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray


def frame_codes(index: int, size_px: tuple[int, int] = (48, 20)) -> NDArray[np.uint8]:
    """Frame ``index``: no two are alike, nor are its halves."""
    width, height = size_px
    codes = np.random.default_rng(100 + index).integers(0, 256, (height, width, 3), np.uint8)
    codes[:4, :4] = (10 * index) % 250
    return codes


def make_film(
    path: Path,
    frames: int,
    *,
    codec: str = "ffv1",
    pixels: str = "bgr0",
    times: list[int] | None = None,
    size_px: tuple[int, int] = (48, 20),
    picture: Any = frame_codes,
    **options: str,
) -> Path:
    """A film of 25 ticks a second; ``times`` are its frames' ticks, one after the other else."""
    with av.open(str(path), "w") as container:
        stream: Any = container.add_stream(codec, rate=25)
        stream.width, stream.height = size_px
        stream.pix_fmt, stream.options = pixels, options
        stream.time_base = Fraction(1, 25)
        stream.codec_context.time_base = Fraction(1, 25)
        for index in range(frames):
            codes = np.ascontiguousarray(picture(index, size_px))
            frame = av.VideoFrame.from_ndarray(codes, format="rgb24").reformat(format=pixels)
            frame.pts = times[index] if times else index
            frame.time_base = Fraction(1, 25)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path
