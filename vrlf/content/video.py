"""Films: frames by their time, and lossless films written whole. The only room that knows PyAV."""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self

import av
import numpy as np
from numpy.typing import NDArray

from vrlf.content.pictures import PIXEL_ASPECT, Layout, guess_layout, halves
from vrlf.errors import ImageReadError, OutputError
from vrlf.files import check_target, shown

FILM_ENDINGS: Final = (".mkv", ".mp4", ".webm", ".mov", ".avi", ".m4v", ".ogv", ".mpg")
Codes = NDArray[np.uint8]

# Farther ahead than this a seek is cheaper than to decode all between.
_SEEK_S = 2.0
# A film whose pictures end by this much before it says it ends was cut off; sound may last longer.
_EARLY_S = 0.4
# Half of Matroska's tick; where a tick is a whole frame, its times are not rounded.
_ROUNDED_S = 0.0005
# From this height on an untagged film is high definition, which is BT.709 (ITU-R BT.709-6).
_HD_HEIGHT = 720
_UNTAGGED = 2  # ITU-T H.273, matrix coefficients "unspecified"


class Film:
    """Owns an open file. ``at`` gives each eye's picture for a time.

    Parameters
    ----------
    path : path
    layout : str
        ``auto`` or a layout of ``vrlf.content.pictures``.
    cross_eyed : bool
        The right eye's picture comes first.

    Attributes
    ----------
    size_px : (width, height)
        Of a whole frame.
    rate_hz, duration_s : float
        Frames a second, on the mean; the whole.
    pixel_aspect : float
        Seen width of a pixel over its seen height.
    fault : str or None
        Why the film ended before it should have, once that was met.

    Raises
    ------
    ImageReadError
        If it is no film, or not one frame of it can be decoded.
    """

    def __init__(
        self, path: str | os.PathLike[str], *, layout: str = "auto", cross_eyed: bool = False
    ) -> None:
        self._name = shown(path)
        self.fault: str | None = None
        self._frame_px: tuple[int, int] | None = None
        try:
            is_file = Path(path).is_file()
        except (OSError, ValueError):  # too long for a name, or with a NUL
            is_file = False
        if not is_file:  # FFmpeg would take some names for addresses, and wait for pipes
            raise ImageReadError(f"{self._name}: found no such file, wanted a film")
        try:
            self._container: Any = av.open(f"file:{Path(path).resolve()}")
        except (av.error.FFmpegError, OSError, ValueError) as error:
            raise ImageReadError(f"{self._name}: found {_words(error)}, wanted a film") from None
        try:
            self._open(Path(path), layout, cross_eyed)
        except BaseException:
            self._container.close()
            raise

    def _open(self, path: Path, layout: str, cross_eyed: bool) -> None:
        if not self._container.streams.video:
            raise ImageReadError(f"{self._name}: found no pictures in it, wanted a film")
        self._stream = self._container.streams.video[0]
        self._stream.thread_type = "AUTO"
        self._frames = self._decoded()
        first = next(self._frames, None)
        if first is None:
            raise ImageReadError(f"{self._name}: found no whole frame in it, wanted a film")
        self._start_s = float(first.time or 0.0)
        self._now, self._ahead = first, next(self._frames, None)
        # Containers round times to ticks (Matroska to 1 ms): a frame that is due is not late.
        self._slack_s = min(0.5 * float(self._stream.time_base or 0.0), _ROUNDED_S) + 1e-6
        picture = _codes(first)
        self.size_px = (picture.shape[1], picture.shape[0])
        self.rate_hz = float(self._stream.average_rate or 25.0)
        self.duration_s = self._told_duration()
        self._layout: Layout
        if layout == "auto":
            self._layout, swapped = guess_layout(path, picture.shape, None)
            cross_eyed = cross_eyed or swapped
        else:
            self._layout = layout  # type: ignore[assignment]
        self._cross_eyed = cross_eyed
        ratio = self._stream.sample_aspect_ratio
        self.pixel_aspect = PIXEL_ASPECT[self._layout] * (float(ratio) if ratio else 1.0)
        halves(picture, self._layout, self._name)

    @property
    def layout(self) -> Layout:
        """As it was taken, never ``auto``."""
        return self._layout

    def _told_duration(self) -> float:
        """As the file says; of one frame at least."""
        told = 0.0
        if self._stream.duration and self._stream.time_base:
            told = float(self._stream.duration * self._stream.time_base)
        elif self._container.duration:
            told = self._container.duration / av.time_base
        return max(told, 1.0 / self.rate_hz)

    def at(self, time_s: float) -> tuple[Codes, Codes]:
        """What is shown at a time from the beginning: the last frame that is not later.

        Returns
        -------
        left, right : ndarray of uint8, shape (H, W, 3)
            sRGB codes. Where the film is damaged, the last good frame.
        """
        wanted_s = self._start_s + max(time_s, 0.0)
        if self._time_of(self._now) > wanted_s + self._slack_s or self._is_far(wanted_s):
            self._seek(wanted_s)
        while self._ahead is not None and self._time_of(self._ahead) <= wanted_s + self._slack_s:
            self._now, self._ahead = self._ahead, next(self._frames, None)
        first, second = halves(_codes(self._now), self._layout, self._name)
        return (second, first) if self._cross_eyed else (first, second)

    def is_same(self, time_s: float) -> bool:
        """Whether ``at`` would give what it gave last."""
        wanted_s = self._start_s + max(time_s, 0.0)
        begins_s = self._time_of(self._now)
        ends_s = self._time_of(self._ahead) if self._ahead is not None else float("inf")
        return begins_s <= wanted_s + self._slack_s < ends_s and not self._is_far(wanted_s)

    def _is_far(self, wanted_s: float) -> bool:
        return self._ahead is not None and wanted_s > self._time_of(self._ahead) + _SEEK_S

    def _seek(self, wanted_s: float) -> None:
        """To the last key frame before a time; a film that cannot begins anew."""
        before = self._now
        for offset in (int(wanted_s / self._stream.time_base), 0):
            with contextlib.suppress(av.error.FFmpegError):
                self._container.seek(offset, stream=self._stream, backward=True)
            self._frames = self._decoded()
            first = next(self._frames, None)
            if first is not None:
                self._now, self._ahead = first, next(self._frames, None)
                return
        # Behind the last whole frame, where a damaged film ends: all from the beginning.
        self._now = before

    def _time_of(self, frame: Any) -> float:
        return float(frame.time) if frame.time is not None else self._start_s

    def _decoded(self) -> Iterator[Any]:
        """Frames from here on; a fault ends them and is kept."""
        last_s = 0.0
        try:
            for frame in self._container.decode(self._stream):
                self._frame_px = self._frame_px or (frame.width, frame.height)
                if (frame.width, frame.height) != self._frame_px:
                    self._end(last_s, f"another size, {frame.width}x{frame.height},")
                    return
                if frame.time is not None:
                    last_s = float(frame.time)
                    yield frame
        except av.error.FFmpegError as error:
            self._end(last_s, _words(error))
            return
        if hasattr(self, "_start_s") and hasattr(self, "duration_s"):
            ended_s = last_s - self._start_s
            if ended_s < self.duration_s - max(_EARLY_S, 3.0 / self.rate_hz):
                self._end(last_s, "its end too early")

    def _end(self, last_s: float, reason: str) -> None:
        self.fault = (
            f"{self._name}: found {reason} at {last_s:.2f} s, wanted a whole film; "
            "the last good frame stays"
        )

    def release(self) -> None:
        """Close the file."""
        self._container.close()


def _codes(frame: Any) -> Codes:
    """A frame as sRGB codes, upright.

    The film's own matrix and range count. Its tone curve is taken for sRGB's, which is what
    screens do with BT.709 films.
    """
    how: dict[str, Any] = {}
    if frame.format.name.startswith("yuv") and int(frame.colorspace) == _UNTAGGED:
        how["src_colorspace"] = "ITU709" if frame.height >= _HD_HEIGHT else "ITU601"
    rgb = frame.reformat(format="rgb24", **how).to_ndarray()
    turns = round((getattr(frame, "rotation", 0) or 0) / 90.0) % 4
    return np.ascontiguousarray(np.rot90(rgb, turns))


class FilmWriter:
    """Writes a lossless film, FFV1 in Matroska; the file is whole or not there.

    Parameters
    ----------
    path : path
        Ends in ``.mkv``.
    size_px : (width, height)
    rate_hz : float
    """

    def __init__(
        self, path: str | os.PathLike[str], size_px: tuple[int, int], rate_hz: float
    ) -> None:
        self._name, self._target = shown(path), check_target(path)
        self._partial = self._target.with_name(f".vrlf-{secrets.token_hex(8)}.mkv")
        try:
            self._container: Any = av.open(os.fspath(self._partial), "w", format="matroska")
            rate = Fraction(rate_hz).limit_denominator(1001)
            self._stream = self._container.add_stream("ffv1", rate=rate)
            self._stream.width, self._stream.height = size_px
            self._stream.pix_fmt = "bgr0"
        except (av.error.FFmpegError, OSError, ValueError) as error:
            raise self._failed(error) from error

    def add(self, codes: Codes) -> None:
        """The next frame: sRGB codes, (H, W, 3)."""
        try:
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(codes), format="rgb24")
            self._container.mux(self._stream.encode(frame.reformat(format="bgr0")))
        except (av.error.FFmpegError, OSError, ValueError) as error:
            raise self._failed(error) from error

    def finish(self) -> None:
        """Put the film in its place."""
        try:
            self._container.mux(self._stream.encode())
            self._container.close()
            with self._partial.open("rb") as file:
                os.fsync(file.fileno())
            os.replace(self._partial, self._target)
        except (av.error.FFmpegError, OSError, ValueError) as error:
            raise self._failed(error) from error
        except BaseException:  # an interrupt must not leave the partial file either
            self.drop()
            raise

    def _failed(self, error: Exception) -> OutputError:
        self.drop()
        return OutputError(f"{self._name}: found {_words(error)}, wanted room for the whole film")

    def drop(self) -> None:
        """Leave nothing behind."""
        container = getattr(self, "_container", None)
        if container is not None:
            # The file goes anyway.
            with contextlib.suppress(av.error.FFmpegError, OSError, ValueError):
                container.close()
        self._partial.unlink(missing_ok=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is None:
            self.finish()
        else:
            self.drop()


def _words(error: Exception) -> str:
    text = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return f"'{' '.join(text.split())[:120]}'"
