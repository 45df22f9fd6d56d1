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
    rays_option,
    renderer_of,
    rig_choice,
    rig_options,
    say,
    say_of_wavefronts,
)
from vrlf.app.sources import (
    SourceOptions,
    as_target,
    encoding_option,
    require_picture_size,
    source_options,
    target_of,
)
from vrlf.content.charts import draw_chart
from vrlf.errors import InputError
from vrlf.files import shown
from vrlf.images import check_picture_target, read_picture, write_encoded, write_picture
from vrlf.model import Rig
from vrlf.optics.tracing import Tracing
from vrlf.optics.viewport import SIDES
from vrlf.renderer import DEFAULT_RAYS, GpuRenderer, Image, Renderer
from vrlf.renderer.live import viewport_size

_LOSSY = (".jpg", ".jpeg")
_DEEP = (".png", ".tif", ".tiff", ".exr")

output_option = click.option(
    "-o",
    "--output",
    required=True,
    metavar="FILE",
    help="Where it is written: sRGB in .png .tif .jpg .webp .bmp, linear floats in .exr.",
)
bits_option = click.option(
    "--bits",
    type=click.Choice(["8", "10", "16"]),
    help="Bits a channel; 16, and 10 within 16, in PNG and TIFF only, an EXR has floats anyway. "
    "Without it a panel image has the panel's, all else 8.",
)
dither_option = click.option(
    "--dither",
    is_flag=True,
    help="Spread the rounding to 8 bits as fine noise, the same each time.",
)


def check_outputs(
    paths: list[str], rig: Rig, bits: str | None, *, is_panel: bool = False
) -> tuple[str, str]:
    """Refuse what cannot be written, before any work is done for it.

    Parameters
    ----------
    paths : list of str
        The result's first.
    bits : str or None
        As asked for.
    is_panel : bool
        Whether the first is a panel image.

    Returns
    -------
    (str, str)
        Bits of the first, and of any other.
    """
    require_picture_size(rig)
    targets = [check_picture_target(path) for path in paths]
    if len(set(targets)) < len(targets):
        raise InputError(
            f"--target: found {shown(paths[1])}, the same file as --output, wanted another one"
        )
    own = str(rig.panel.bits) if bits is None and is_panel else bits or "8"
    for path, wanted in zip(paths, (own, bits or "8"), strict=False):
        ending = Path(path).suffix.lower()
        if wanted != "8" and ending not in _DEEP:
            raise InputError(
                f"{'--bits' if bits else 'panel.bits'}: found {wanted} for the ending '{ending}' "
                f"of {shown(path)}, wanted {'' if bits else '--bits '}8, "
                f"or one of {' '.join(_DEEP)}"
            )
    return own, bits or "8"


def write_result(path: str, light: Image, renderer: Renderer, *, bits: str, dither: bool) -> None:
    """Write linear light: EXR as it is, 8 bits through the encode pass, more bits exactly."""
    ending = Path(path).suffix.lower()
    if ending == ".exr":
        write_picture(path, light)
    elif bits != "8":
        write_picture(path, light, bits=int(bits))
    else:
        write_encoded(path, renderer.encode(light, dither=dither))
    if dither and (ending == ".exr" or bits != "8"):
        say(f"{shown(path)}: not dithered, for that is for 8 bits")
    say(f"wrote {shown(path)}")


@click.command(short_help="Write the panel image that shows a picture sharp to given eyes.")
@click.argument("source")
@rig_options
@output_option
@source_options
@click.option(
    "--target",
    "target_file",
    metavar="FILE",
    help="Also write the target: SOURCE as both eyes should see it, on the panel's pixels.",
)
@bits_option
@dither_option
@device_option
@json_option
def prefilter(
    source: str,
    output: str,
    target_file: str | None,
    bits: str | None,
    dither: bool,
    device: Any,
    as_json: bool,
    **options: Any,
) -> None:
    """Write the panel image that shows SOURCE sharp to this rig's eyes.

    SOURCE is a picture for both eyes or a stereo picture (PNG, JPEG, EXR, TIFF, WebP, HDR ...),
    'scene' (the shipped stereo scene) or 'chart:NAME' (see 'vrlf chart --help'). A picture of
    exactly the panel's size is taken pixel for pixel, left half to the left eye. How it is
    computed is a key of the rig: --set prefilter.method=forward is fast, optimal is slow and
    sharper, none shows the target itself.

    \b
    Examples:
      vrlf prefilter photo.jpg --left "-5.00 / -1.25 x 170" --right "-4.50" -o panel.png
      vrlf prefilter film_sbs.png -r mine.toml --fit cover -o panel.exr --target target.exr
      vrlf prefilter chart:logmar -r pinhole -o panel.png --json
    """
    rig = rig_choice(options).load()
    say_of_wavefronts(rig)
    outputs = [output] if target_file is None else [output, target_file]
    own_bits, other_bits = check_outputs(outputs, rig, bits, is_panel=True)
    if Path(output).suffix.lower() in _LOSSY:
        say(f"{shown(output)}: JPEG alters single pixels; a panel image wants .png or .exr")
    with renderer_of(device) as renderer:
        target = target_of(source, rig, renderer, SourceOptions(**options))
        panel = renderer.prefilter(target, rig)
        if target_file is not None:
            write_result(target_file, target, renderer, bits=other_bits, dither=dither)
        write_result(output, panel, renderer, bits=own_bits, dither=dither)
    if as_json:
        put_json(_written(output, rig, method=rig.prefilter.method, target=target_file))


@click.command(short_help="Write what both eyes see of a panel image.")
@click.argument("panel")
@rig_options
@output_option
@rays_option(DEFAULT_RAYS)
@click.option(
    "--exposure",
    type=click.Choice(["auto", "none"]),
    default="auto",
    show_default=True,
    help="auto makes up for the light that the array takes, none shows it as dim as it is.",
)
@click.option(
    "--diffraction",
    is_flag=True,
    help="Trace ray by ray, each spread as its hole or lenslet diffracts its colour's light.",
)
@click.option(
    "--exact",
    is_flag=True,
    help="Trace ray by ray through plano-convex lenslets of index 1.49 instead of thin lenses.",
)
@encoding_option
@bits_option
@dither_option
@device_option
@json_option
def perceive(
    panel: str,
    output: str,
    rays: int,
    exposure: Any,
    diffraction: bool,
    exact: bool,
    encoding: Any,
    bits: str | None,
    dither: bool,
    device: Any,
    as_json: bool,
    **options: Any,
) -> None:
    """Write what both eyes see of the panel image PANEL, side by side in the panel's size.

    PANEL has exactly the size of the rig's panel; 'vrlf prefilter' writes one. Give the rig
    and the eyes that it was made for, or others to see what those get of it. --diffraction and
    --exact, together or apart, trace each ray by itself: slower, and closer to real hardware.

    \b
    Examples:
      vrlf perceive panel.png -r mine.toml -o seen.png
      vrlf perceive target.png -r mine.toml --set array.kind=none -o without-correction.png
      vrlf perceive panel.png -r pinhole --diffraction -o spread-by-the-holes.png
    """
    rig = rig_choice(options).load()
    say_of_wavefronts(rig)
    own_bits, _ = check_outputs([output], rig, bits)
    tracing = Tracing(diffraction=diffraction, exact=exact)
    tracing.check(rig)
    shown = read_picture(panel, encoding=encoding)
    _require_panel_size(shown, rig, panel)
    with renderer_of(device) as renderer:
        seen, error = _seen(renderer, shown, rig, rays, exposure, tracing)
        write_result(output, seen, renderer, bits=own_bits, dither=dither)
    if as_json:
        traced = {"diffraction": diffraction, "exact": exact} if tracing else {}
        numbers = {"rays": rays, "exposure": exposure, "quadrature_rms": error, **traced}
        put_json(_written(output, rig, **numbers))
    elif error is not None:
        say(f"quadrature error about {error:.1g} RMS")


def _seen(
    renderer: Renderer, panel: Image, rig: Rig, rays: int, exposure: Any, tracing: Tracing
) -> tuple[Image, float | None]:
    """What both eyes see, and how far off that is; a twin and a single ray can't say."""
    if rays < 2 or not isinstance(renderer, GpuRenderer):
        seen = renderer.perceive(panel, rig, rays=rays, exposure=exposure, tracing=tracing)
        return seen, None
    return renderer.perceive_with_error(panel, rig, rays=rays, exposure=exposure, tracing=tracing)


def _require_panel_size(picture: Image, rig: Rig, path: str) -> None:
    height, width = picture.shape[:2]
    if (width, height) != (rig.panel.width_px, rig.panel.height_px):
        raise InputError(
            f"{shown(path)}: found {width}x{height} pixels, wanted {rig.panel.width_px}x"
            f"{rig.panel.height_px} like the rig's panel"
        )


def _written(path: str, rig: Rig, **more: Any) -> dict[str, Any]:
    size = {"width_px": rig.panel.width_px, "height_px": rig.panel.height_px}
    return {"output": path, **size, **more}


@click.command(short_help="Write a test chart at the panel's exact pixels.")
@click.argument("name", metavar="NAME")
@rig_options
@output_option
@json_option
def chart(name: str, output: str, as_json: bool, **options: Any) -> None:
    """Write the chart NAME at the panel's exact pixels, for both eyes.

    \b
    NAME is one of
      logmar    letters, a line smaller than the last, for visual acuity
      usaf1951  groups of three bars, finer and finer
      siemens   a star of spokes
      grid      lines about a degree apart and a circle, for distortion
      points    single pixels, for the shape of the blur
      marks     which half is which eye's, and which way is up

    What its lines mean for this rig goes to standard output. The file is a target: 'vrlf
    prefilter' makes the panel image of it, which 'vrlf prefilter chart:NAME' does in one step.

    \b
    Example:
      vrlf chart logmar -r mine.toml -o logmar.png
    """
    rig = rig_choice(options).load()
    check_outputs([output], rig, bits="8")
    charts = [draw_chart(name, **viewport_size(rig, side), eye=side) for side in SIDES]
    write_picture(output, as_target(charts[0].image, charts[1].image, rig))
    say(f"wrote {shown(output)}")
    notes = list(charts[0].notes)
    if as_json:
        lines = [asdict(line) for line in charts[0].lines]
        put_json(_written(output, rig, chart=name, notes=notes, lines=lines))
    else:
        click.echo("\n".join(notes))
