"""Keepers of the worker processes on this machine: each starts one, and another when it dies.

Dask's own nannies give up where a worker dies while it starts; a keeper never does.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
import time
from collections.abc import Mapping
from typing import Final

# A worker that lived as long as this had started well; the next may follow at once.
_WELL_S: Final = 10.0
_LONGEST_PAUSE_S: Final = 5.0
_END_S: Final = 10.0
_ENVIRONMENT: Final = {
    # One core each: jobs run side by side instead.
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "LP_NUM_THREADS": "1",
    "DASK_LOGGING__DISTRIBUTED": "critical",
}


class Keepers:
    """So many workers of a scheduler, whatever befalls them. End it."""

    def __init__(self, address: str, count: int) -> None:
        self._address = address
        self._ending = False
        self.last_words = ""
        self._tasks = [asyncio.create_task(self._keep()) for _ in range(count)]

    def ending(self) -> None:
        """Start no more."""
        self._ending = True

    async def end(self) -> None:
        """Wait until workers that were told to go are gone; the others are ended."""
        self._ending = True
        _, late = await asyncio.wait(self._tasks, timeout=_END_S)
        for each in late:
            each.cancel()
        await asyncio.gather(*late, return_exceptions=True)

    async def _keep(self) -> None:
        pause_s = 0.0
        while not self._ending:
            started = time.monotonic()
            try:
                await self._one()
            except OSError as error:  # no memory for a process, no more of them allowed
                self.last_words = error.strerror or type(error).__name__
            is_well = time.monotonic() - started > _WELL_S
            pause_s = 0.0 if is_well else min(2.0 * pause_s + 0.1, _LONGEST_PAUSE_S)
            if not self._ending:
                await asyncio.sleep(pause_s)

    async def _one(self) -> None:
        """A worker's life."""
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "vrlf.studies.sweep.worker", self._address),
            stdin=asyncio.subprocess.PIPE,  # its end tells the worker of ours
            stdout=asyncio.subprocess.DEVNULL,
            stderr=asyncio.subprocess.PIPE,
            env=_environment(),
            start_new_session=True,  # Ctrl-C is for us alone
        )
        assert process.stderr is not None
        try:
            async for line in process.stderr:
                self.last_words = line.decode(errors="replace").strip() or self.last_words
            await process.wait()
        finally:
            if process.returncode is None:
                with contextlib.suppress(ProcessLookupError):
                    process.kill()
                await process.wait()


def _environment() -> Mapping[str, str]:
    """This process's, so that a worker finds the same modules, and one thread for a library."""
    places = [os.getcwd() if place == "" else place for place in sys.path]
    return {**os.environ, **_ENVIRONMENT, "PYTHONPATH": os.pathsep.join(places)}
