"""Sweeps on real worker processes that are killed, stopped and begun again."""

from __future__ import annotations

import os
import random
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from sweep_runs import (
    expected,
    is_worker,
    kill,
    kit_for,
    plan_for,
    quick,
    require_whole,
    rows_so_far,
    start,
    wait_for,
    workers_of,
)

from vrlf.renderer import GpuRenderer
from vrlf.studies.sweep import cluster
from vrlf.studies.sweep.cluster import WorkersLostError
from vrlf.studies.sweep.jobs import Kit, Scores
from vrlf.studies.sweep.plan import Job
from vrlf.studies.sweep.run import A_WORKER, DEATHS, Progress, run_sweep
from vrlf.studies.sweep.store import Store

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="finds worker processes by /proc"
)


def test_killed_workers_cost_time_and_no_row(tmp_path: Path) -> None:
    draw, jobs = random.Random(4), 60
    with start(tmp_path, jobs, 0.05) as process:
        for _ in range(5):
            rows = rows_so_far(tmp_path) + draw.randint(2, 8)
            wait_for(
                lambda rows=rows: rows_so_far(tmp_path) >= rows and workers_of(process.pid),
                process,
            )
            assert kill(draw.choice(workers_of(process.pid)))
        out, err = process.communicate(timeout=120)
    assert (process.returncode, err) == (0, ""), out
    require_whole(tmp_path, plan_for(jobs))


def test_stopped_and_killed_runs_go_on_to_the_same_rows(tmp_path: Path) -> None:
    jobs = 200  # ten seconds of work: none is over before it is stopped
    for stop in (signal.SIGINT, signal.SIGKILL):
        with start(tmp_path, jobs, 0.1) as process:
            before = rows_so_far(tmp_path)
            wait_for(lambda before=before: rows_so_far(tmp_path) >= before + 5, process)
            workers = workers_of(process.pid)
            # Ctrl-C reaches every process of a terminal's group, SIGKILL the one alone.
            os.killpg(process.pid, stop) if stop is signal.SIGINT else kill(process.pid)
            process.communicate(timeout=60)
            wait_for_end(workers)
        assert rows_so_far(tmp_path) < jobs
    kept = rows_so_far(tmp_path)
    with start(tmp_path, jobs, 0.0) as process:
        out, err = process.communicate(timeout=120)
    assert (process.returncode, err) == (0, "")
    assert out.splitlines() == [f"kept {kept}", "finished"]
    require_whole(tmp_path, plan_for(jobs))


def wait_for_end(workers: list[int]) -> None:
    """No worker outlives the run that started it."""
    end = time.monotonic() + 30.0
    while any(is_worker(each) for each in workers):
        assert time.monotonic() < end, "a worker has outlived its run"
        time.sleep(0.05)


def troubled(kit: Kit, job: Job, renderer: Callable[[], GpuRenderer]) -> Scores:
    """One job that ends its worker, and one that fails; the others are quick."""
    if job.index == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    if job.index == 5:
        raise ValueError("out of\nluck")
    return quick(kit, job, renderer)


def test_jobs_that_kill_or_fail_are_noted_and_the_others_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan, seen = plan_for(20), []
    make, made = cluster._scheduler_here, []

    async def kept() -> Any:
        made.append(await make())
        return made[0]

    def told(progress: Progress) -> None:
        seen.append((progress.workers, len(made[0].tasks)))

    monkeypatch.setattr(cluster, "_scheduler_here", kept)
    with Store.open(tmp_path, plan) as store:
        run_sweep(plan, kit_for(plan, troubled), store, workers=2, told=told)
        failures = {row["index"]: row["reason"] for row in store.failures()}
        store.finish()
    assert failures == {
        3: f"found that its workers died {DEATHS} times, wanted its row",
        5: "unexpected ValueError: out of luck",
    }
    from pyarrow import parquet

    rows = parquet.read_table(tmp_path / "results.parquet").to_pylist()
    wanted = [row for row in expected(plan) if row["index"] not in failures]
    assert [{k: v for k, v in row.items() if k != "checksum"} for row in rows] == wanted
    # However many jobs wait, the scheduler knows of a few for each worker.
    assert max(tasks for _, tasks in seen) <= 2 * A_WORKER


def marking(kit: Kit, job: Job, renderer: Callable[[], GpuRenderer]) -> Scores:
    """Writes down each context that is made, and each that is given back."""
    device, notes = renderer().device, Path(os.environ["VRLF_TEST_NOTES"])

    def release() -> None:
        type(device).release(device)
        note("released")

    def note(what: str) -> None:
        with notes.open("a") as file:
            file.write(f"{what} {os.getpid()}\n")

    if "release" not in vars(device):
        vars(device)["release"] = release
        note("made")
    return quick(kit, job, renderer)


def test_each_worker_makes_one_context_and_gives_it_back_at_its_exit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    notes, plan = tmp_path / "notes", plan_for(20)
    monkeypatch.setenv("VRLF_TEST_NOTES", str(notes))
    with Store.open(tmp_path / "out", plan) as store:
        run_sweep(plan, kit_for(plan, marking), store, workers=2)
        assert store.done == 20
    lines = notes.read_text().splitlines()
    made = [line.split()[1] for line in lines if line.startswith("made")]
    assert len(made) == len(set(made)) >= 1
    assert sorted(f"released {each}" for each in made) == sorted(
        line for line in lines if line.startswith("released")
    )


def deadly(*_: Any) -> Scores:
    """No worker lives to tell."""
    os.kill(os.getpid(), signal.SIGKILL)
    return {}


def test_workers_that_never_live_end_the_run_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vrlf.studies.sweep.run.MOST_KILLERS", 1)
    monkeypatch.setattr("vrlf.studies.sweep.run.ASKED", 1)
    plan = plan_for(10)
    with Store.open(tmp_path, plan) as store:
        with pytest.raises(WorkersLostError, match="one after another ended them"):
            run_sweep(plan, kit_for(plan, deadly), store, workers=2)
        assert (store.done, store.failed) == (0, 0)


def test_workers_that_cannot_start_end_the_run_with_their_last_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vrlf.studies.sweep.run.NO_WORKER_HERE_S", 3.0)
    monkeypatch.setattr(sys, "executable", "/bin/false-no-such-python")
    plan = plan_for(10)
    complaint = r"found none for 3 s.*No such file"
    with Store.open(tmp_path, plan) as store, pytest.raises(WorkersLostError, match=complaint):
        run_sweep(plan, kit_for(plan), store, workers=1)
