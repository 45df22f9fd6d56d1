"""``vrlf bench``."""

from __future__ import annotations

import click
from rich.console import Console

from vrlf.app.options import json_option, put_json, rays_option, say, whole_number
from vrlf.gpu import Device
from vrlf.model import DEFAULT_RIG
from vrlf.studies.bench import bench_table, run_bench


@click.command(short_help="Time each step at several panel sizes.")
@click.option(
    "-r",
    "--rig",
    default=DEFAULT_RIG,
    show_default=True,
    metavar="RIG",
    help="The rig whose headset, array and eyes are timed.",
)
@rays_option(64)
@click.option(
    "--runs",
    type=whole_number(3, 1000),
    default=9,
    show_default=True,
    metavar="N",
    help="Runs of each step, 3 to 1000; fewer where the time would get long.",
)
@json_option
def bench(rig: str, rays: int, runs: int, as_json: bool) -> None:
    """Time each step, both eyes, at three panel sizes, and the float64 twin at the smallest.

    The steps are prepare (a picture becomes the target), forward (the target becomes the panel
    image), perceive and encode (8 bits); 'tables ...' is what a change of eyes or rig costs.
    Takes a minute or two.

    \b
    Example:
      vrlf bench --rays 16 --runs 3
    """
    with Device.headless() as device:
        report = run_bench(device, rig=rig, rays=rays, runs=runs, progress=say)
    if as_json:
        put_json(report.to_json())
    else:
        Console().print(bench_table(report))
