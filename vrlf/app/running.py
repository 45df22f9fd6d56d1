"""``vrlf bench change`` and ``bench memory``: what happens to frames that follow one another."""

from __future__ import annotations

from typing import Any

import click
from rich.console import Console

from vrlf.app.options import (
    json_option,
    put_json,
    rig_choice,
    rig_options,
    say,
    whole_number,
)
from vrlf.gpu import Device
from vrlf.studies.change import FRAMES as CHANGE_FRAMES
from vrlf.studies.change import change_table, run_change
from vrlf.studies.endurance import FRAMES, WARM_AFTER, endurance_table, run_endurance
from vrlf.studies.quality import cropped

# Small enough for ten thousand frames, twice, on software GL in some minutes.
_MEMORY_PX = (96, 48)


@click.command(short_help="Whether anything grows over ten thousand frames.")
@rig_options
@click.option(
    "--frames",
    type=whole_number(WARM_AFTER + 1, 10_000_000),
    default=FRAMES,
    show_default=True,
    metavar="N",
    help=f"How many frames run, more than the {WARM_AFTER} to warm up.",
)
@click.option("--full", is_flag=True, help="The rig's whole panel instead of a small piece of it.")
@json_option
def memory(frames: int, full: bool, as_json: bool, **options: Any) -> None:
    """Run frames, the prescription changing every 500, and note what is alive.

    GPU objects and bytes, Python's memory and the process's, after 1000 frames and at the end.
    All runs twice: Python's memory is traced apart, for tracing takes some itself.

    \b
    Example:
      vrlf bench memory --set prefilter.method=optimal --frames 2000
    """
    given = rig_choice(options).load()
    rig = given if full else cropped(given, _MEMORY_PX)
    with Device.headless() as device:
        report = run_endurance(device, rig, frames=frames, progress=say)
    if as_json:
        put_json(report.to_json())
    else:
        Console().print(endurance_table(report))


@click.command(short_help="What a change of prescription does to the frames that run.")
@rig_options
@click.option(
    "--frames",
    type=whole_number(1, 100_000),
    default=CHANGE_FRAMES,
    show_default=True,
    metavar="N",
    help="Frames timed before the change, and after it.",
)
@click.option(
    "--making-ms",
    type=whole_number(1, 10_000),
    metavar="MS",
    help="Time that each frame gives to the tables that are being made. Default: 4, or half of "
    "a frame's own time where that is over 50.",
)
@json_option
def change(frames: int, making_ms: int | None, as_json: bool, **options: Any) -> None:
    """Time each frame before, while and after another prescription's tables are made.

    \b
    Example:
      vrlf bench change --set prefilter.method=optimal --frames 10
    """
    rig = rig_choice(options).load()
    with Device.headless() as device:
        report = run_change(device, rig, frames=frames, making_ms=making_ms, progress=say)
    if as_json:
        put_json(report.to_json())
    else:
        Console().print(change_table(report))
