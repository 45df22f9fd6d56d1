"""A worker process of this machine: ``python -m vrlf.studies.sweep.worker ADDRESS``.

It has one thread for jobs, talks over the loopback alone, and ends with whoever started it:
its standard input closes then, however that one ended.
"""

from __future__ import annotations

import asyncio
import os
import sys
import threading
from importlib import import_module
from typing import Any, Final

_SCHEDULER_S: Final = 30.0


def main(address: str) -> None:
    """Serve a scheduler to its end."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    asyncio.run(_serve(address))


async def _serve(address: str) -> None:
    distributed: Any = import_module("distributed")
    async with distributed.Worker(
        address,
        nthreads=1,
        host="127.0.0.1",
        memory_limit=0,  # else it would rest at 80 % of its share, for ever
        dashboard=False,
        death_timeout=_SCHEDULER_S,
    ) as worker:
        await worker.finished()


def _end_with_parent() -> None:
    sys.stdin.buffer.read()
    os._exit(1)


if __name__ == "__main__":
    main(sys.argv[1])
