"""What a sweep bears, measured for real; by hand, because it takes minutes.

``python tests/sweep_by_hand.py kills`` ends a random worker 20 times in a sweep of 500 jobs, and
looks at each row. ``python tests/sweep_by_hand.py memory [JOBS]`` runs 100,000 jobs that do
nothing, and says every some seconds how much memory the client with its scheduler takes.
"""

from __future__ import annotations

import random
import shutil
import sys
import tempfile
import time
from pathlib import Path

from sweep_runs import kill, plan_for, require_whole, rows_so_far, start, wait_for, workers_of


def kills(jobs: int = 500, count: int = 20, seconds_a_job: float = 0.2) -> None:
    """Random SIGKILLs of workers, each after some more rows."""
    folder, draw = Path(tempfile.mkdtemp()) / "sweep", random.Random(6)
    started = time.monotonic()
    process = start(folder, jobs, seconds_a_job)
    for number in range(1, count + 1):
        rows = rows_so_far(folder) + draw.randint(3, jobs // count - 2)
        wait_for(lambda rows=rows: rows_so_far(folder) >= rows and workers_of(process.pid), process)
        kill(draw.choice(workers_of(process.pid)))
        print(f"{time.monotonic() - started:6.1f} s: kill {number}, {rows_so_far(folder)} rows")
    out, err = process.communicate()
    assert process.returncode == 0, (out, err)
    require_whole(folder, plan_for(jobs))
    print(f"{time.monotonic() - started:6.1f} s: {jobs} rows, each once, all checksums right")
    shutil.rmtree(folder.parent)


def memory(jobs: int = 100_000, every_s: float = 10.0) -> None:
    """The client's resident memory while many jobs run."""
    folder = Path(tempfile.mkdtemp()) / "sweep"
    started = time.monotonic()
    process = start(folder, jobs, 0.0)
    while process.poll() is None:
        print(
            f"{time.monotonic() - started:6.1f} s: {rows_so_far(folder):6d} rows, "
            f"{resident_mb(process.pid):6.1f} MB",
            flush=True,
        )
        time.sleep(every_s)
    out, err = process.communicate()
    assert process.returncode == 0, (out, err)
    require_whole(folder, plan_for(jobs))
    print(f"{time.monotonic() - started:6.1f} s: {jobs} rows, each once, all checksums right")
    shutil.rmtree(folder.parent)


def resident_mb(process: int) -> float:
    """What a process holds, from /proc."""
    try:
        text = Path(f"/proc/{process}/status").read_text()
    except OSError:
        return 0.0
    line = next((line for line in text.splitlines() if line.startswith("VmRSS")), "VmRSS: 0 kB")
    return int(line.split()[1]) / 1024


if __name__ == "__main__":
    if sys.argv[1:2] == ["kills"]:
        kills(*map(int, sys.argv[2:]))
    else:
        memory(*map(int, sys.argv[2:]))
