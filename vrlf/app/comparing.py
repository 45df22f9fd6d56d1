"""``vrlf compare``: how like one picture is to another."""

from __future__ import annotations

from collections.abc import Mapping
from math import nan
from pathlib import Path
from typing import Any, Final

import click
import numpy as np

from vrlf.app.options import json_option, put_json, say
from vrlf.app.sizes import decimal_number
from vrlf.errors import InputError, OutputPathError
from vrlf.evaluation.metrics import METRICS, Scores, Viewing, false_colour, score
from vrlf.evaluation.metrics.model import MOST_NIT, MOST_PIXELS_PER_DEGREE, Float, Picture, Value
from vrlf.files import shown
from vrlf.images import check_picture_target, read_picture, write_channels, write_encoded

_DEFAULT_METRICS: Final = ("rmse", "psnr_db", "ssim")
# Those of the shipped default rig: an iPhone 6 at 46 mm.
_DEFAULT_PPD: Final = 10.3
_DEFAULT_NIT: Final = 500.0
_EXR: Final = ".exr"
_LOSSLESS: Final = (".png", ".tif", ".tiff", ".bmp", ".webp")


def metric_name(text: str) -> str:
    """One of ``METRICS``."""
    if text not in METRICS:
        raise click.BadParameter(f"found {text[:40]!r}, wanted one of {', '.join(METRICS)}")
    return text


def black_level(text: str | float) -> float:
    """A luminance from 0 up."""
    try:
        black_nit = float(text)
    except ValueError:
        black_nit = nan
    if not 0.0 <= black_nit <= MOST_NIT:
        raise click.BadParameter(
            f"found {str(text)[:40]!r}, wanted a number from 0 to {MOST_NIT:g}"
        )
    return black_nit


@click.command(short_help="Say how like one picture is to another.")
@click.argument("reference")
@click.argument("test")
@click.option(
    "--metric",
    "names",
    multiple=True,
    type=metric_name,
    metavar="NAME",
    help="Which metric, one of those above. Can be given again.  [default: "
    f"{', '.join(_DEFAULT_METRICS)}]",
)
@click.option(
    "--ppd",
    type=decimal_number(0.0, MOST_PIXELS_PER_DEGREE),
    default=_DEFAULT_PPD,
    show_default=True,
    metavar="N",
    help="Pixels per degree; the default rig's unless told. 'vrlf inspect' says a rig's.",
)
@click.option(
    "--peak-nit",
    type=decimal_number(0.0, MOST_NIT),
    default=_DEFAULT_NIT,
    show_default=True,
    metavar="L",
    help="cd/m2 that full drive adds: luminance is black + peak x the linear value.",
)
@click.option(
    "--black-nit",
    type=black_level,
    default=0.0,
    show_default=True,
    metavar="L",
    help="cd/m2 of what is not driven at all.",
)
@click.option(
    "--map",
    "map_file",
    metavar="FILE",
    help="Write where the pictures differ, as the one metric that has a map sees it: false "
    "colours from 0 to 1 in .png, numbers in .exr (of hdr_vdp only these: channels P and S).",
)
@json_option
def compare(
    reference: str,
    test: str,
    names: tuple[str, ...],
    ppd: float,
    peak_nit: float,
    black_nit: float,
    map_file: str | None,
    as_json: bool,
) -> None:
    """Say how like the picture TEST is to the picture REFERENCE, both of the same size.

    EXR files hold linear light, others sRGB. Pictures are compared as they are, pixel by pixel
    and in linear light of peak 1, without any gain and without a border left out; 'vrlf
    evaluate' does what an eye in a headset asks for.

    \b
    Metrics
      rmse       root of the mean squared difference, 0 for equal pictures
      psnr_db    the same in decibels; none (null) for equal pictures
      ssim       structural similarity, 1 for equal pictures
      flip       FLIP's mean difference, 0 to 1 (needs vrlf[flip]); uses --ppd
      cvvdp_jod  ColorVideoVDP's quality, 10 for equal pictures (needs vrlf[cvvdp]); uses
                 --ppd, --peak-nit and --black-nit
      hdr_vdp    HDR-VDP-2.2's detection and quality; uses the same
      contrast   contrast kept, by cycles per degree; uses --ppd
      fringe     colour that is seen where none was meant, of the reference's light
      light      light kept, of the reference's

    A metric whose extra isn't installed is named, with the command that installs it, and the
    others go on.

    \b
    Examples:
      vrlf compare target.png seen.png
      vrlf compare target.exr seen.exr --metric flip --metric cvvdp_jod --ppd 10.3 --json
      vrlf compare target.exr seen.exr --metric hdr_vdp --peak-nit 500 --map where.exr
    """
    chosen = tuple(dict.fromkeys(names)) or _DEFAULT_METRICS
    mapped = None if map_file is None else _mapped(chosen, map_file)
    pictures = _pictures(reference, test)
    viewing = Viewing(ppd, peak_nit, black_nit)
    scores = score(chosen, *pictures, viewing)
    if not scores.values:
        raise InputError("; ".join(scores.failed.values()))
    for reason in scores.failed.values():
        say(f"vrlf: {reason}")
    if mapped is not None and mapped in scores.maps:
        _write_map(str(map_file), mapped, scores.maps[mapped])
    if as_json:
        put_json(_numbers(reference, test, scores, viewing, pictures[0], map_file))
    else:
        click.echo(_words(scores))
    if mapped is not None and mapped not in scores.maps:
        raise InputError(f"--map: found no {mapped}, wanted it for {shown(str(map_file))}")


def _mapped(names: tuple[str, ...], path: str) -> str:
    """The metric whose map goes to ``path``, checked before any work is done for it."""
    able = [name for name, metric in METRICS.items() if metric.map_names]
    having = [name for name in names if name in able]
    if len(having) != 1:
        raise InputError(
            f"--map: found {' and '.join(having) or 'no metric that has a map'}, "
            f"wanted exactly one --metric of {', '.join(able)}"
        )
    check_picture_target(path)
    endings = (_EXR,) if len(METRICS[having[0]].map_names) > 1 else (_EXR, *_LOSSLESS)
    if Path(path).suffix.lower() not in endings:
        raise OutputPathError(
            f"--map {shown(path)}: found the ending '{Path(path).suffix}', wanted "
            f"{' or '.join(endings)} for {having[0]}"
        )
    return having[0]


def _pictures(reference: str, test: str) -> tuple[Picture, Picture]:
    pictures = read_picture(reference), read_picture(test)
    wanted, found = (each.shape[1::-1] for each in pictures)
    if found != wanted:
        raise InputError(
            f"{shown(test)}: found {found[0]}x{found[1]} pixels, wanted {wanted[0]}x{wanted[1]} "
            f"like {shown(reference)}"
        )
    return pictures


def _write_map(path: str, name: str, maps: Mapping[str, Float]) -> None:
    if Path(path).suffix.lower() == _EXR:
        write_channels(path, {key: np.asarray(each) for key, each in maps.items()})
    else:
        write_encoded(path, false_colour(maps[METRICS[name].map_names[0]]))
    say(f"wrote {shown(path)}")


def _numbers(
    reference: str,
    test: str,
    scores: Scores,
    viewing: Viewing,
    picture: Picture,
    map_file: str | None,
) -> dict[str, Any]:
    return {
        "reference": reference,
        "test": test,
        "width_px": picture.shape[1],
        "height_px": picture.shape[0],
        "pixels_per_degree": viewing.pixels_per_degree,
        "peak_nit": viewing.peak_nit,
        "black_nit": viewing.black_nit,
        **scores.values,
        "undefined": scores.reasons,
        "failed": scores.failed,
        "map": map_file,
    }


def _words(scores: Scores) -> str:
    lines = []
    for name, value in scores.values.items():
        metric = METRICS[name]
        said = scores.reasons[name] if value is None else f"{_said(value)} {metric.unit}"
        lines.append(f"{metric.title:<14} {said}".rstrip())
    return "\n".join(lines)


def _said(value: Value) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key}: {each:.4g}" for key, each in value.items())
    return f"{value:.4f}"
