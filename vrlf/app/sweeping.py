"""``vrlf sweep``: rig keys, sources and methods, tried in all combinations on many workers."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.progress import Progress as Bar

from vrlf.app.options import json_option, put_json, say, whole_number
from vrlf.app.sources import CHART_PREFIX, SourceOptions, is_chart, require_source, target_of
from vrlf.content.charts import CHART_NAMES
from vrlf.errors import InputError, VrlfError
from vrlf.evaluation.metrics import missing
from vrlf.files import shown
from vrlf.model import Rig
from vrlf.model.sweep import read_sweep
from vrlf.renderer import GpuRenderer, Image
from vrlf.studies.sweep.cluster import require_libraries, require_scheduler, worker_count
from vrlf.studies.sweep.jobs import kit_of
from vrlf.studies.sweep.plan import Plan, plan_of
from vrlf.studies.sweep.rows import INDEX
from vrlf.studies.sweep.run import Progress, Told, run_sweep
from vrlf.studies.sweep.store import FAILURES, REASON, Store

_MOST_FAILURES_SAID = 10
_MOST_WORKERS = 1024
_COVER = SourceOptions(fit="cover")
# Where there is no terminal, a line now and then.
_SAID_S = 30.0


class InterruptedSweepError(VrlfError):
    """Ctrl-C; what is done is kept."""


@click.command(short_help="Try a grid or sample of rigs, sources and methods on many workers.")
@click.argument("spec", metavar="SPEC.toml")
@click.option(
    "-o", "--output", required=True, metavar="DIR", help="A folder for this sweep's results alone."
)
@click.option(
    "--workers",
    type=whole_number(1, _MOST_WORKERS),
    default=None,
    metavar="N",
    help="Worker processes on this machine.  [default: one for each core]",
)
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Use the workers of a Dask scheduler, e.g. tcp://host:8786. They need this vrlf, and the "
    "sources' files at the same paths.",
)
@click.option("--retry-failed", "retry", is_flag=True, help="Try again what failed before.")
@click.option(
    "--restart", is_flag=True, help="Begin anew, whatever an earlier run left in the folder."
)
@json_option
def sweep(
    spec: str,
    output: str,
    workers: int | None,
    scheduler: str | None,
    retry: bool,
    restart: bool,
    as_json: bool,
) -> None:
    """Measure what both eyes perceive for every rig, source and method that SPEC.toml asks for.

    Each job is a row of DIR/results.parquet, with a checksum over its values. Stopped at any
    moment, the same command goes on where it stood. A worker that dies is replaced and its job
    done again; a job that fails is listed in DIR/failures.jsonl, the others go on, and the exit
    status is 1.

    \b
    SPEC.toml:
      rig = "matched-wide"                    # or a list, names or files
      sources = ["scene", "photo.jpg"]        # pictures, scenes, chart:NAME
      methods = ["none", "forward", "optimal"]
      metrics = ["rmse", "psnr_db", "ssim"]
      rays = 256                              # for each retinal pixel
      panel_px = [440, 220]                   # the middle of the panel: the default
      [grid]                                  # every combination
      both.sphere_d = [-5.0, -3.0]            # 'both.' is left. and right.
      array.gap_mm = { from = 4.0, to = 8.0, count = 5 }
      [sample]                                # each point with every combination
      count = 100
      seed = 1
      kind = "latin-hypercube"                # or "sobol"
      left.pupil_mm = { from = 2.0, to = 7.0 }
      array.pitch_um = { from = 200.0, to = 800.0, log = true }

    \b
    Example:
      vrlf sweep spec.toml -o sweep-out
    """
    if scheduler is not None and workers is not None:
        raise InputError("--workers: found it beside --scheduler, wanted one of the two")
    require_libraries()
    path = Path(spec)
    plan = plan_of(read_sweep(path), path.parent, shown(spec))
    kit = kit_of(plan, cover_target)
    for line in missing(kit.metrics).values():
        say(f"left empty: {line}")
    _require_sources(plan)
    if scheduler is not None:
        require_scheduler(scheduler)
    started = time.monotonic()
    with Store.open(Path(output), plan, restart=restart, retry=retry) as store:
        for note in store.notes:
            say(note)
        kept = store.done
        if kept or store.failed:
            say(f"{shown(output)}: {kept + store.failed} of {plan.count} jobs are there already")
        _do(plan, kit, store, output, workers or worker_count(), scheduler)
        failures = store.failures()
        place = store.finish()
    _say_failures(failures, output)
    if as_json:
        put_json(
            {
                "output": str(place),
                "jobs": plan.count,
                "rows": plan.count - len(failures),
                "computed": plan.count - len(failures) - kept,
                "kept": kept,
                "failed": [{INDEX: row[INDEX], REASON: row[REASON]} for row in failures],
                "seconds": round(time.monotonic() - started, 3),
            }
        )
    else:
        click.echo(f"{plan.count - len(failures)} rows in {shown(place)}")
    if failures:
        raise _failed(failures, plan, output)


def cover_target(place: str, rig: Rig, renderer: GpuRenderer) -> Image:
    """A source's picture filling both eyes' views, as ``vrlf bench quality`` takes it."""
    return target_of(place, rig, renderer, _COVER)


def _do(
    plan: Plan, kit: Any, store: Store, output: str, workers: int, scheduler: str | None
) -> None:
    """The jobs that are left; whatever stops them, say what is kept."""
    try:
        with _bar(plan.count) as told:
            run_sweep(plan, kit, store, workers=workers, scheduler=scheduler, told=told)
    except InputError:
        raise
    except (VrlfError, KeyboardInterrupt) as error:
        kept = (
            f"{store.done + store.failed} of {plan.count} jobs are kept in {shown(output)}, and "
            "the same command goes on from there"
        )
        if isinstance(error, KeyboardInterrupt):
            raise InterruptedSweepError(f"interrupted; {kept}") from None
        say(kept)
        raise


@contextlib.contextmanager
def _bar(total: int) -> Iterator[Told]:
    """A bar on standard error where that is a terminal, else a line now and then."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _Lines().told
        return
    columns = (
        TextColumn("jobs"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[note]}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Bar(*columns, console=console) as bar:
        task: TaskID = bar.add_task("jobs", total=total, note="starting workers")

        def told(now: Progress) -> None:
            bar.update(task, completed=now.done + now.failed, note=_note(now))

        yield told


def _note(now: Progress) -> str:
    failed = f", {now.failed} failed" if now.failed else ""
    return f"{now.workers} workers{failed}" if now.workers != 1 else f"1 worker{failed}"


class _Lines:
    """Says how far it is, at most every half minute."""

    def __init__(self) -> None:
        self._said_s = time.monotonic()

    def told(self, now: Progress) -> None:
        if time.monotonic() - self._said_s >= _SAID_S:
            self._said_s = time.monotonic()
            say(f"{now.done + now.failed} of {now.total} jobs, {_note(now)}")


def _require_sources(plan: Plan) -> None:
    """Refuse what is no picture, scene or chart, before anything is made for it."""
    for source in plan.sources:
        require_source(source.place)
        chart = source.place.removeprefix(CHART_PREFIX)
        if source.sha256 is None and is_chart(source.place) and chart not in CHART_NAMES:
            raise InputError(f"chart: found {chart!r}, wanted one of {', '.join(CHART_NAMES)}")


def _say_failures(failures: list[Any], output: str) -> None:
    for row in failures[:_MOST_FAILURES_SAID]:
        say(f"job {row[INDEX]} failed: {row[REASON]}")
    if len(failures) > _MOST_FAILURES_SAID:
        say(f"and {len(failures) - _MOST_FAILURES_SAID} more, in {shown(Path(output) / FAILURES)}")


def _failed(failures: list[Any], plan: Plan, output: str) -> VrlfError:
    return VrlfError(
        f"sweep: found {len(failures)} of {plan.count} jobs failed, wanted none; they are in "
        f"{shown(Path(output) / FAILURES)}, and --retry-failed tries them again"
    )
