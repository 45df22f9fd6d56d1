"""``vrlf bench`` and ``vrlf bench quality``."""

from __future__ import annotations

import click
from rich.console import Console

from vrlf.app.options import json_option, put_json, rays_option, say, whole_number
from vrlf.app.sources import SCENE, SourceOptions, target_of
from vrlf.gpu import Device
from vrlf.model import DEFAULT_RIG, load_rig
from vrlf.renderer import GpuRenderer
from vrlf.studies.bench import bench_table, run_bench
from vrlf.studies.quality import ITERATIONS, JUDGING_RAYS, quality_table, run_quality


@click.group(
    invoke_without_command=True, short_help="Time each step; 'bench quality' measures sharpness."
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


@bench.command(short_help="Measure how sharp each prefilter makes what is seen.")
@click.option(
    "-r",
    "--rig",
    "rigs",
    multiple=True,
    default=[DEFAULT_RIG],
    show_default=True,
    metavar="RIG",
    help="A rig; can be given again.",
)
@click.option(
    "--source",
    "sources",
    multiple=True,
    default=[SCENE],
    show_default=True,
    metavar="SOURCE",
    help="A picture, 'scene' or chart:NAME; can be given again.",
)
@click.option(
    "--iterations",
    multiple=True,
    type=whole_number(0, 1000),
    default=list(ITERATIONS),
    show_default=True,
    metavar="N",
    help="Steps of the optimal prefilter; can be given again.",
)
@rays_option(JUDGING_RAYS)
@json_option
def quality(
    rigs: tuple[str, ...],
    sources: tuple[str, ...],
    iterations: tuple[int, ...],
    rays: int,
    as_json: bool,
) -> None:
    """Measure the PSNR of what is perceived: bare, forward, and optimal after some steps.

    \b
    Example:
      vrlf bench quality -r matched-wide -r pinhole --iterations 8 --rays 256
    """
    given = {name: load_rig(name) for name in rigs}
    with GpuRenderer() as renderer:
        fit = SourceOptions(fit="cover")
        pictures = {
            source: lambda rig, source=source: target_of(source, rig, renderer, fit)
            for source in sources
        }
        report = run_quality(
            renderer, given, pictures, iterations=iterations, rays=rays, progress=say
        )
    if as_json:
        put_json(report.to_json())
    else:
        Console().print(quality_table(report))
