"""``vrlf bench quality`` and ``vrlf bench frames``: how sharp what is seen is."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil
from typing import Any, TypeVar

import click
import numpy as np
from rich.console import Console

from vrlf.app.options import json_option, put_json, rays_option, say, whole_number
from vrlf.app.sizes import panel_size, plot_option, require_plot
from vrlf.app.sources import SCENE, SourceOptions, target_of
from vrlf.errors import InputError
from vrlf.model import DEFAULT_RIG, Rig, load_rig
from vrlf.optics.viewport import viewport
from vrlf.renderer import GpuRenderer, Image
from vrlf.studies.frames import FRAMES, STEPS, frames_table, run_frames
from vrlf.studies.frames import JUDGING_RAYS as FRAME_RAYS
from vrlf.studies.plots import plot_quality
from vrlf.studies.quality import (
    CROP_PX,
    ITERATIONS,
    JUDGING_RAYS,
    cropped,
    quality_table,
    run_quality,
)

Command = TypeVar("Command", bound=Callable[..., Any])
_DEFAULT_PANEL = f"{CROP_PX[0]}x{CROP_PX[1]}"
_COVER = SourceOptions(fit="cover")
# A pan needs more picture than a viewport shows.
_WIDER = 1.4


def rigs_option(command: Command) -> Command:
    """Any number of rigs."""
    return click.option(
        "-r",
        "--rig",
        "rigs",
        multiple=True,
        default=[DEFAULT_RIG],
        show_default=True,
        metavar="RIG",
        help="A rig; can be given again.",
    )(command)


def panel_option(command: Command) -> Command:
    """The small panel that is judged on."""
    return click.option(
        "--panel",
        type=panel_size,
        metavar="WxH",
        help="Size of the small panel, of the rig's own pixels, whose halves' middles the axes "
        f"meet. [default: {_DEFAULT_PANEL}]",
    )(command)


@click.command(short_help="Measure how sharp each prefilter makes what is seen.")
@rigs_option
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
@panel_option
@click.option("--full", is_flag=True, help="The rig's own panel, whole: takes many minutes.")
@click.option(
    "--converged",
    "with_converged",
    is_flag=True,
    help="Solve in float64 too, by an operator of its own, until nothing is left to gain. For "
    "small panels: with --panel 220x110 it takes two to four minutes for a rig, and longer in "
    "proportion to the pixels.",
)
@rays_option(JUDGING_RAYS)
@json_option
@plot_option("Draw PSNR against the steps of optimal")
def quality(
    rigs: tuple[str, ...],
    sources: tuple[str, ...],
    iterations: tuple[int, ...],
    panel: tuple[int, int] | None,
    full: bool,
    with_converged: bool,
    rays: int,
    as_json: bool,
    plot: str | None,
) -> None:
    """Measure PSNR and SSIM of what is perceived: bare, forward, and optimal after some steps.

    On a small panel, unless told otherwise. Takes a minute or two for a rig and picture on
    software GL.

    \b
    Examples:
      vrlf bench quality -r matched-wide -r pinhole --iterations 8 --rays 256
      vrlf bench quality --source photo.jpg --converged --panel 220x110 --plot quality.png
    """
    if full and panel is not None:
        raise InputError("--full: found it beside --panel, wanted one of the two")
    require_plot(plot)
    given = {
        name: rig if full else cropped(rig, panel or CROP_PX)
        for name, rig in ((name, load_rig(name)) for name in rigs)
    }
    with GpuRenderer() as renderer:
        pictures = {
            source: lambda rig, source=source: target_of(source, rig, renderer, _COVER)
            for source in sources
        }
        for source in sources:  # what is missing is said before minutes pass
            target_of(source, next(iter(given.values())), renderer, _COVER)
        report = run_quality(
            renderer,
            given,
            pictures,
            iterations=iterations,
            rays=rays,
            with_converged=with_converged,
            progress=say,
        )
    if plot is not None:
        plot_quality(report, plot)
    if as_json:
        put_json(report.to_json())
    else:
        Console().print(quality_table(report))


@click.command(short_help="Measure each frame of a still, of pans and of a cut.")
@rigs_option
@click.option(
    "--source",
    default=SCENE,
    show_default=True,
    metavar="SOURCE",
    help="What is shown and moves: a picture, 'scene' or chart:NAME.",
)
@click.option(
    "--cut-to",
    default="chart:siemens",
    show_default=True,
    metavar="SOURCE",
    help="What a cut goes over to.",
)
@click.option(
    "--steps",
    multiple=True,
    type=whole_number(0, 1000),
    default=list(STEPS),
    show_default=True,
    metavar="N",
    help="Steps of the optimal prefilter a frame; can be given again.",
)
@click.option(
    "--frames",
    "count",
    type=whole_number(2, 1000),
    default=FRAMES,
    show_default=True,
    metavar="N",
    help="Frames of each motion, 2 to 1000.",
)
@panel_option
@rays_option(FRAME_RAYS)
@json_option
def frames(
    rigs: tuple[str, ...],
    source: str,
    cut_to: str,
    steps: tuple[int, ...],
    count: int,
    panel: tuple[int, int] | None,
    rays: int,
    as_json: bool,
) -> None:
    """Measure the optimal prefilter frame by frame, begun cold and begun from the last frame.

    'flicker' says how still the error stands from one frame to the next, as a PSNR: the higher
    the stiller. Takes some minutes for a rig on software GL.

    \b
    Example:
      vrlf bench frames --source photo.jpg --steps 2
    """
    given = {name: cropped(load_rig(name), panel or CROP_PX) for name in rigs}
    with GpuRenderer() as renderer:
        first = next(iter(given.values()))
        pictures = _wide_picture(source, first, renderer), _wide_picture(cut_to, first, renderer)
        report = run_frames(
            renderer.device, given, pictures, steps=steps, frames=count, rays=rays, progress=say
        )
    if as_json:
        put_json(report.to_json())
    else:
        Console().print(frames_table(report))


def _wide_picture(source: str, rig: Rig, renderer: GpuRenderer) -> Image:
    """What the left eye would be shown of a source on a panel wider and higher than the rig's."""
    size = (ceil(_WIDER * rig.panel.width_px), ceil(_WIDER * rig.panel.height_px))
    wide = cropped(rig, size)
    target = target_of(source, wide, renderer, _COVER)
    return np.ascontiguousarray(target[:, viewport(wide, "left").columns])
