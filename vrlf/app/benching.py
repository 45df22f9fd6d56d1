"""``vrlf bench`` and ``vrlf bench speed``; the others stand in ``judging`` and ``running``."""

from __future__ import annotations

import click
from rich.console import Console

from vrlf.app.judging import frames, quality
from vrlf.app.options import json_option, put_json, rays_option, say, whole_number
from vrlf.app.running import change, memory
from vrlf.app.sizes import decimal_number, panel_sizes, plot_option, require_plot
from vrlf.app.tolerating import tolerance
from vrlf.gpu import Device
from vrlf.model import DEFAULT_RIG, load_rig
from vrlf.studies.bench import bench_table, run_bench
from vrlf.studies.plots import plot_speed
from vrlf.studies.speed import (
    SIZES_PX,
    SOFTWARE_MEGAPIXELS,
    default_megapixels,
    run_speed,
    speed_table,
)


@click.group(
    invoke_without_command=True,
    short_help="Time each step; 'speed', 'quality', 'frames' measure more.",
)
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
@click.pass_context
def bench(context: click.Context, rig: str, rays: int, runs: int, as_json: bool) -> None:
    """Time each step, both eyes, at three panel sizes, and the float64 twin at the smallest.

    The steps are prepare (a picture becomes the target), forward (the target becomes the panel
    image), perceive and encode (8 bits); 'tables ...' is what a change of eyes or rig costs.
    Takes a minute or two.

    \b
    Example:
      vrlf bench --rays 16 --runs 3
    """
    if context.invoked_subcommand is not None:
        return
    with Device.headless() as device:
        report = run_bench(device, rig=rig, rays=rays, runs=runs, progress=say)
    if as_json:
        put_json(report.to_json())
    else:
        Console().print(bench_table(report))


@bench.command(short_help="Time every pass and whole frames from 0.25 to 33 megapixels.")
@click.option(
    "-r",
    "--rig",
    default=DEFAULT_RIG,
    show_default=True,
    metavar="RIG",
    help="The rig whose headset, array and eyes are timed; its pixels get finer.",
)
@click.option(
    "--sizes",
    type=panel_sizes,
    metavar="WxH,...",
    help="Panel sizes in pixels, with commas between. Default: "
    f"{', '.join(f'{width}x{height}' for width, height in SIZES_PX)}.",
)
@click.option(
    "--max-megapixels",
    type=decimal_number(0.0, 1e4),
    metavar="X",
    help="Leave larger sizes out. Default: of the default sizes those above "
    f"{SOFTWARE_MEGAPIXELS:g} on software GL, otherwise none.",
)
@rays_option(64)
@click.option(
    "--runs",
    type=whole_number(1, 1000),
    default=9,
    show_default=True,
    metavar="N",
    help="Runs of each step, 1 to 1000; fewer where a step takes seconds.",
)
@json_option
@plot_option("Draw time against megapixels")
def speed(
    rig: str,
    sizes: list[tuple[int, int]] | None,
    max_megapixels: float | None,
    rays: int,
    runs: int,
    as_json: bool,
    plot: str | None,
) -> None:
    """Time every pass and whole frames against the panel's size and the device's limits.

    'frame ...' is a target on the GPU that becomes the encoded panel image, 'seen' with what both
    eyes perceive of it. 'limit' is the share of the time that a plain copy of the least bytes
    would take, or, marked f, the least fetches. Takes about four minutes on software GL.

    \b
    Examples:
      vrlf bench speed --plot speed.png
      vrlf bench speed -r thesis-minus-5d --sizes 1334x750,3840x2160 --json
    """
    require_plot(plot)
    given = load_rig(rig)
    with Device.headless() as device:
        if sizes is None and max_megapixels is None:
            max_megapixels = default_megapixels(device)
        report = run_speed(
            device,
            rig=given,
            sizes=sizes or SIZES_PX,
            max_megapixels=max_megapixels,
            rays=rays,
            runs=runs,
            progress=say,
        )
    if plot is not None:
        plot_speed(report, plot)
    if as_json:
        put_json(report.to_json())
    else:
        Console().print(speed_table(report))


bench.add_command(quality)
bench.add_command(frames)
bench.add_command(change)
bench.add_command(memory)
bench.add_command(tolerance)
