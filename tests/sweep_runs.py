"""Sweeps of jobs that take no GPU, in a process of their own: to be killed and begun again.

``python sweep_runs.py FOLDER JOBS SECONDS_A_JOB [WORKERS] [SCHEDULER]`` runs one.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vrlf.model.sweep import sweep_from_tables
from vrlf.renderer import GpuRenderer
from vrlf.studies.sweep.jobs import Kit, Scores, kit_of
from vrlf.studies.sweep.plan import Job, Plan, plan_of
from vrlf.studies.sweep.rows import checksum
from vrlf.studies.sweep.run import Progress, run_sweep
from vrlf.studies.sweep.store import RESULTS, Store

HERE = Path(__file__).resolve().parent
SECONDS = "VRLF_TEST_SECONDS_A_JOB"


def plan_for(jobs: int) -> Plan:
    """That many jobs; the numbers of the grid are theirs."""
    half = {"from": -4.0, "to": 3.25, "count": jobs // 2}
    tables = {
        "sources": "chart:siemens",
        "methods": ["none", "forward"],
        "metrics": ["rmse", "psnr_db"],
        "grid": {"left": {"sphere_d": half}},
    }
    return plan_of(sweep_from_tables(tables), HERE, "sweep_runs")


def quick(kit: Kit, job: Job, renderer: Callable[[], GpuRenderer]) -> Scores:
    """Values that follow from the job, after a while."""
    del renderer
    time.sleep(float(os.environ.get(SECONDS, "0")))
    rng = np.random.default_rng(job.index)
    return {
        f"{side}_{name}": float(rng.normal()) for side in ("left", "right") for name in kit.metrics
    }


def kit_for(plan: Plan, judge: Any = quick) -> Kit:
    """The plan's own, but for what is judged."""
    return replace(kit_of(plan, _no_target), judge=judge)


def _no_target(*_: Any) -> Any:
    raise AssertionError("a job of these asked for a picture")


def expected(plan: Plan) -> list[dict[str, Any]]:
    """The rows that an uninterrupted run gives, without their checksums."""
    kit = kit_for(plan)
    jobs = (plan.job(index) for index in range(plan.count))
    return [job.values | quick(kit, job, _no_target) for job in jobs]


def require_whole(folder: Path, plan: Plan) -> None:
    """Every row once, in order, with the right values and a checksum that says so."""
    from pyarrow import parquet

    rows = parquet.read_table(folder / RESULTS).to_pylist()
    assert [row["index"] for row in rows] == list(range(plan.count))
    assert [row["checksum"] for row in rows] == [checksum(row) for row in rows]
    assert [{k: v for k, v in row.items() if k != "checksum"} for row in rows] == expected(plan)


def start(folder: Path, jobs: int, seconds_a_job: float, *more: str) -> subprocess.Popen[str]:
    """A sweep in a process and a group of its own."""
    return subprocess.Popen(
        [sys.executable, __file__, str(folder), str(jobs), str(seconds_a_job), *more],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def workers_of(process: int) -> list[int]:
    """The worker processes that a sweep has started."""
    numbers = (int(folder.name) for folder in Path("/proc").iterdir() if folder.name.isdigit())
    return sorted(
        number for number in numbers if is_worker(number) and parent_of(number) == process
    )


def is_worker(process: int) -> bool:
    """Whether it is a sweep's worker, and lives."""
    try:
        return b"vrlf.studies.sweep.worker" in Path(f"/proc/{process}/cmdline").read_bytes()
    except OSError:
        return False


def parent_of(process: int) -> int:
    """Who started it; 0 if it is gone."""
    try:
        return int(Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[1])
    except OSError:
        return 0


def rows_so_far(folder: Path) -> int:
    """Lines of the journal, and rows of the parts."""
    from pyarrow import parquet

    try:
        lines = (folder / "journal.jsonl").read_bytes().count(b"\n")
    except OSError:
        return 0
    return lines + sum(parquet.read_metadata(p).num_rows for p in (folder / "parts").glob("*"))


def wait_for(
    what: Callable[[], bool], process: subprocess.Popen[str], seconds: float = 60.0
) -> None:
    """Until something holds; the process must still run then."""
    end = time.monotonic() + seconds
    while not what():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end, "waited too long"
        time.sleep(0.02)


def kill(process: int) -> bool:
    """SIGKILL; whether it was there."""
    try:
        os.kill(process, signal.SIGKILL)
    except ProcessLookupError:
        return False
    return True


def main(folder: str, jobs: str, seconds: str, workers: str = "2", scheduler: str = "") -> None:
    """Run a sweep to its end."""
    os.environ[SECONDS] = seconds
    # Run as a script this module is __main__, which a worker cannot find by its name.
    import sweep_runs

    plan = plan_for(int(jobs))
    kit = sweep_runs.kit_for(plan)
    told: list[Progress] = []
    with Store.open(Path(folder), plan) as store:
        print(f"kept {store.done}", flush=True)
        run_sweep(
            plan, kit, store, workers=int(workers), scheduler=scheduler or None, told=told.append
        )
        store.finish()
    assert told[-1].done == plan.count
    print("finished", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
