"""How long the GPU took, by its own clock."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

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
