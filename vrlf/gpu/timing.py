"""How long the GPU took, by its own clock."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from vrlf.gpu.device import Device


class GpuTimer:
    """A timer query; software drivers, whose query sees little, are timed to completion.

    On a GPU the query measures the work itself; on a software driver the "GPU" is the
    CPU, and the wall time until ``finish`` returns is the honest figure.
    """

    def __init__(self, device: Device) -> None:
        self._device = device
        self._query = None if device.info.is_software else device.context.query(time=True)
        self.milliseconds = 0.0

    @contextmanager
    def measure(self) -> Iterator[None]:
        """Time what is dispatched inside."""
        self._device.finish()
        started = time.perf_counter()
        if self._query is None:
            yield
            self._device.finish()
            self.milliseconds = 1e3 * (time.perf_counter() - started)
        else:
            with self._query:
                yield
            self.milliseconds = self._query.elapsed / 1e6


class FrameTimers:
    """How long the steps of a frame took on the GPU, without making it wait.

    Each step's query is read some frames later, when its result is there. On a software
    driver the CPU does the work inside the call, and the wall time is the honest figure.
    """

    _BEHIND = 3  # frames in flight

    def __init__(self, device: Device) -> None:
        self._device = device
        self._is_software = device.info.is_software
        self._frames: deque[dict[str, Any]] = deque()
        self._spare: list[Any] = []
        self._current: dict[str, Any] = {}
        self.milliseconds: dict[str, float] = {}

    @contextmanager
    def measure(self, step: str) -> Iterator[None]:
        """Time what is dispatched inside; once a frame for each step, not nested."""
        if self._is_software:
            began = time.perf_counter()
            yield
            self._current[step] = 1e3 * (time.perf_counter() - began)
            return
        query = self._spare.pop() if self._spare else self._device.context.query(time=True)
        with query:
            yield
        self._current[step] = query

    def end_frame(self) -> None:
        """Close the frame; ``milliseconds`` then holds the last frame whose results are there."""
        self._frames.append(self._current)
        self._current = {}
        if self._is_software:
            self.milliseconds = self._frames.popleft()
        elif len(self._frames) > self._BEHIND:
            ended = self._frames.popleft()
            self.milliseconds = {step: query.elapsed / 1e6 for step, query in ended.items()}
            self._spare.extend(ended.values())
