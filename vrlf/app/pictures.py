"""``vrlf prefilter``, ``vrlf perceive`` and ``vrlf chart``."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from vrlf.app.options import (
    device_option,
    json_option,
    put_json,
    renderer_of,
    rig_choice,
    rig_options,
    say,
)
from vrlf.app.sources import SourceOptions, as_target, target_of, viewport_size
from vrlf.content.charts import draw_chart
from vrlf.errors import InputError
from vrlf.images import check_picture_target, read_picture, write_encoded, write_picture
from vrlf.model import Rig
from vrlf.optics.samples import MAX_POINTS
from vrlf.optics.viewport import SIDES
from vrlf.renderer import DEFAULT_RAYS, Image, Renderer

_LAYOUTS = ["auto", "mono", "side-by-side", "half-side-by-side", "over-under", "half-over-under"]
_LOSSY = (".jpg", ".jpeg")

output_option = click.option(
    "-o", "--output", required=True, metavar="FILE", help="Where it is written (.png, .exr, ...)."
)
bits_option = click.option(
    "--bits",
    type=click.Choice(["8", "16"]),
    default="8",
    show_default=True,
    help="Bits a channel of PNG and TIFF files.",
)
dither_option = click.option(
    "--dither", is_flag=True, help="Spread the rounding of 8 bits as fine, fixed noise."
)


def write_result(path: str, light: Image, renderer: Renderer, *, bits: str, dither: bool) -> None:
    """Write linear light: EXR as it is, 8 bits through the encode pass, 16 bits exactly."""
    ending = Path(path).suffix.lower()
    if ending == ".exr":
        write_picture(path, light)
    elif bits == "16":
        write_picture(path, light, bits=16)
    else:
        write_encoded(path, renderer.encode(light, dither=dither))
    say(f"wrote {path}")


@click.command()
@click.argument("source")
@rig_options
@output_option
@click.option(
    "--layout",
    type=click.Choice(_LAYOUTS),
    default="auto",
    show_default=True,
    help="How a stereo picture lies in its file.",
)
@click.option("--cross-eyed", is_flag=True, help="The right eye's picture comes first.")
@click.option("--right-source", metavar="FILE", help="A file of its own for the right eye.")
@click.option(
    "--fit",
    type=click.Choice(["contain", "cover"]),
    default="contain",
    show_default=True,
    help="All of the picture, or all of the viewport.",
)
@click.option(
    "--encoding",
    type=click.Choice(["auto", "srgb", "linear"]),
    default="auto",
    show_default=True,
    help="auto: EXR and float files are linear, the rest is sRGB.",
)
@click.option("--target", "target_file", metavar="FILE", help="Write the fitted target as well.")
@bits_option
@dither_option
@device_option
@json_option
def prefilter(
    source: str,
    output: str,
    target_file: str | None,
    bits: str,
    dither: bool,
    device: Any,
    as_json: bool,
    **options: Any,
) -> None:
    """Write the panel image that shows SOURCE sharp to this rig's eyes.

    SOURCE is a picture for both eyes, a stereo picture in any format that OpenImageIO reads,
    'scene' (the shipped stereo scene) or 'chart:NAME'. One of exactly the panel's size is
    taken pixel for pixel, left half to the left eye.
    """
    rig = rig_choice(options).load()
    outputs = [output] if target_file is None else [output, target_file]
    for path in outputs:
        check_picture_target(path)
    if Path(output).suffix.lower() in _LOSSY:
        say(f"{output}: JPEG alters single pixels; a panel image wants .png or .exr")
    with renderer_of(device) as renderer:
        target = target_of(source, rig, renderer, SourceOptions(**options))
        panel = renderer.prefilter(target, rig)
        if target_file is not None:
            write_result(target_file, target, renderer, bits=bits, dither=dither)
        write_result(output, panel, renderer, bits=bits, dither=dither)
    if as_json:
        put_json(_written(output, rig, method=rig.prefilter.method, target=target_file))


@click.command()
@click.argument("panel")
@rig_options
@output_option
@click.option(
    "--rays",
    type=click.IntRange(1, MAX_POINTS),
    default=DEFAULT_RAYS,
    show_default=True,
    help="Rays let through for each retinal pixel.",
)
@click.option(
    "--exposure",
    type=click.Choice(["auto", "none"]),
    default="auto",
    show_default=True,
    help="auto divides by the array's throughput.",
)
@click.option(
    "--encoding",
    type=click.Choice(["auto", "srgb", "linear"]),
    default="auto",
    show_default=True,
    help="auto: EXR and float files are linear, the rest is sRGB.",
)
@bits_option
@dither_option
@device_option
@json_option
def perceive(
    panel: str,
    output: str,
    rays: int,
    exposure: Any,
    encoding: Any,
    bits: str,
    dither: bool,
    device: Any,
    as_json: bool,
    **options: Any,
) -> None:
    """Write what both eyes see of the panel image PANEL, side by side in the panel's size."""
    rig = rig_choice(options).load()
    check_picture_target(output)
    shown = read_picture(panel, encoding=encoding)
    _require_panel_size(shown, rig, panel)
    with renderer_of(device) as renderer:
        seen = renderer.perceive(shown, rig, rays=rays, exposure=exposure)
        write_result(output, seen, renderer, bits=bits, dither=dither)
    if as_json:
        put_json(_written(output, rig, rays=rays, exposure=exposure))


def _require_panel_size(picture: Image, rig: Rig, path: str) -> None:
    height, width = picture.shape[:2]
    if (width, height) != (rig.panel.width_px, rig.panel.height_px):
        raise InputError(
            f"{path}: found {width}x{height} pixels, wanted {rig.panel.width_px}x"
            f"{rig.panel.height_px} like the rig's panel"
        )


def _written(path: str, rig: Rig, **more: Any) -> dict[str, Any]:
    size = {"width_px": rig.panel.width_px, "height_px": rig.panel.height_px}
    return {"output": path, **size, **more}


@click.command()
@click.argument("name", metavar="NAME")
@rig_options
@output_option
@json_option
def chart(name: str, output: str, as_json: bool, **options: Any) -> None:
    """Write the chart NAME at the panel's exact pixels, for both eyes.

    NAME is one of logmar, usaf1951, siemens, grid, points, marks. What its lines mean for
    this rig goes to standard output.
    """
    rig = rig_choice(options).load()
    check_picture_target(output)
    charts = [draw_chart(name, **viewport_size(rig, side), eye=side) for side in SIDES]
    write_picture(output, as_target(charts[0].image, charts[1].image, rig))
    say(f"wrote {output}")
    notes = list(charts[0].notes)
    if as_json:
        lines = [asdict(line) for line in charts[0].lines]
        put_json(_written(output, rig, chart=name, notes=notes, lines=lines))
    else:
        click.echo("\n".join(notes))
