"""``vrlf bench``."""

from __future__ import annotations

import click
from rich.console import Console

from vrlf.app.options import json_option, put_json, say
from vrlf.gpu import Device
from vrlf.model import DEFAULT_RIG
from vrlf.studies.bench import bench_table, run_bench


@click.command()
@click.option(
    "-r",
    "--rig",
    default=DEFAULT_RIG,
    show_default=True,
    metavar="RIG",
    help="The rig whose headset, array and eyes are timed.",
)
@click.option(
    "--rays",
    type=click.IntRange(1, 65536),
    default=64,
    show_default=True,
    help="Rays for each retinal pixel in perceive.",
)
@click.option(
    "--runs",
    type=click.IntRange(3, 1000),
    default=9,
    show_default=True,
    help="Runs of each pass; fewer where the time would get long.",
)
@json_option
def bench(rig: str, rays: int, runs: int, as_json: bool) -> None:
    """Time each pass, both eyes, at three panel sizes, and the float64 twin at the smallest."""
    with Device.headless() as device:
        report = run_bench(device, rig=rig, rays=rays, runs=runs, progress=say)
    if as_json:
        put_json(report.to_json())
    else:
        Console().print(bench_table(report))
