"""``vrlf bench tolerance``: what serving many cases at once gains and costs."""

from __future__ import annotations

import click
from rich.console import Console

from vrlf.app.judging import panel_option, rigs_option
from vrlf.app.options import json_option, put_json, rays_option, say, whole_number
from vrlf.app.sources import SCENE, SourceOptions, target_of
from vrlf.model import load_rig
from vrlf.renderer import GpuRenderer
from vrlf.studies.quality import CROP_PX, cropped
from vrlf.studies.tolerance import CASES, JUDGING_RAYS, run_tolerance, tolerance_table

_COVER = SourceOptions(fit="cover")


@click.command(short_help="Measure what a tolerance gains where things are off.")
@rigs_option
@click.option(
    "--source",
    default=SCENE,
    show_default=True,
    metavar="SOURCE",
    help="What is shown: a picture, 'scene' or chart:NAME.",
)
@click.option(
    "--iterations",
    type=whole_number(1, 1000),
    default=16,
    show_default=True,
    metavar="N",
    help="Steps of the optimal prefilter.",
)
@click.option(
    "--cases",
    type=whole_number(1, 64),
    default=CASES,
    show_default=True,
    metavar="N",
    help="Cases to judge by, none of which was solved for.",
)
@panel_option
@rays_option(JUDGING_RAYS)
@json_option
def tolerance(
    rigs: tuple[str, ...],
    source: str,
    iterations: int,
    cases: int,
    panel: tuple[int, int] | None,
    rays: int,
    as_json: bool,
) -> None:
    """Measure how sharp optimal is where array, pupil and focus are off, plain and tolerant.

    The rig's own [tolerance], or what a headset that is put on by hand is off by: 15 um of the
    array, 1 mm of the pupil, its size from 4 to 6 mm, 0.25 D of focus. What shifts the whole
    picture is no loss.

    \b
    Example:
      vrlf bench tolerance -r matched-wide --source photo.jpg --panel 240x120
    """
    given = {name: cropped(load_rig(name), panel or CROP_PX) for name in rigs}
    with GpuRenderer() as renderer:
        report = run_tolerance(
            renderer,
            given,
            lambda rig: target_of(source, rig, renderer, _COVER),
            iterations=iterations,
            cases=cases,
            rays=rays,
            progress=say,
        )
    if as_json:
        put_json(report.to_json())
    else:
        Console().print(tolerance_table(report))
