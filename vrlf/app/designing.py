"""``vrlf design``: the array that serves an eye best."""

from __future__ import annotations

import json
import os
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import click
from rich.console import Console

from vrlf.app.judging import panel_option
from vrlf.app.options import json_option, put_json, rig_choice, rig_options, say, whole_number
from vrlf.app.sources import SCENE, SourceOptions, target_of
from vrlf.errors import InputError, OutputPathError
from vrlf.files import atomic_write_text, check_target, make_folder, shown
from vrlf.model.reading import load_rig_text
from vrlf.model.searching import SearchLimits, search_limits
from vrlf.renderer import GpuRenderer
from vrlf.studies.design.design import CHECK_PX, Picture, Task, run_design
from vrlf.studies.design.pictures import MAP_NAME, SENSITIVITY_NAME, draw_map, draw_sensitivity
from vrlf.studies.design.report import DesignReport, best_text, design_table
from vrlf.studies.design.search import Effort

_COVER = SourceOptions(fit="cover")
BEST_NAME = "best.toml"
JSON_NAME = "design.json"
_EFFORTS = {
    "quick": Effort(grid=5, trials=64, turned=2, polished=2, steps=30),
    "normal": Effort(),
    "thorough": Effort(grid=10, trials=1000, turned=10, polished=10, steps=120),
}


def _range_option(name: str, what: str) -> Any:
    """``--NAME FROM..TO``."""

    def convert(text: str | None) -> list[float] | None:
        if text is None or isinstance(text, list):
            return text
        ends = text.split("..")
        try:
            numbers = [float(each) for each in ends]
        except ValueError:
            numbers = []
        if len(numbers) not in (1, 2):
            raise click.BadParameter(f"found {text[:40]!r}, wanted a number or two as in 300..800")
        return [numbers[0], numbers[-1]]

    return click.option(f"--{name}", type=convert, metavar="FROM..TO", help=what)


def limit_options(command: Any) -> Any:
    """Ranges and what is on sale."""
    for option in reversed(
        (
            click.option("--limits", metavar="FILE", help="A small TOML file with all of these."),
            _range_option("pitch", "Pitches in um. [default: 300..1000]"),
            _range_option("gap", "Gaps between array and panel in mm. [default: 1.5..7]"),
            _range_option("focal", "Focal lengths in mm. [default: what serves]"),
            _range_option("hole", "Sides or diameters of holes in um. [default: 40..250]"),
            _range_option("turn", "Turns of the lattice in degrees. [default: all that differ]"),
            _range_option(
                "brightness",
                "Of the picture; the brightest within 0.2 dB of the best. [default: 0.8..1]",
            ),
            click.option(
                "--barriers",
                multiple=True,
                metavar="KIND",
                help="none, converging or perpendicular; can be given again. [default: none]",
            ),
            click.option(
                "--arrays",
                metavar="NAME,...",
                help="Arrays on sale (names in assets/catalogue.toml), not made to order.",
            ),
            click.option(
                "--spacers",
                metavar="NAME,...",
                help="Spacers on sale (names there), or thicknesses of an air gap in mm.",
            ),
        )
    ):
        command = option(command)
    return command


@click.command(short_help="Find the array that serves an eye best.")
@rig_options
@limit_options
@click.option(
    "--kind",
    type=click.Choice(["microlens", "pinhole"]),
    default="microlens",
    show_default=True,
    help="Lenslets or holes.",
)
@click.option(
    "--method",
    type=click.Choice(["optimal", "forward"]),
    default="optimal",
    show_default=True,
    help="The prefilter that the array is for.",
)
@click.option(
    "--robust",
    type=click.Choice(["none", "mean", "worst"]),
    default="none",
    show_default=True,
    help="Judge over cases in which array, pupil and focus are off: the rig's [tolerance], or what "
    "a headset that is put on by hand is off by. Takes five to nine times as long.",
)
@click.option(
    "--effort",
    type=click.Choice(list(_EFFORTS)),
    default="normal",
    show_default=True,
    help="How many candidates are tried.",
)
@click.option(
    "--seed",
    type=whole_number(0, 2**31 - 1),
    default=1,
    show_default=True,
    metavar="N",
    help="Another one searches another way; the same one finds the same.",
)
@click.option(
    "--workers",
    type=whole_number(1, 256),
    metavar="N",
    help="Processes that judge candidates. [default: one a core]",
)
@click.option(
    "--check",
    "source",
    default=SCENE,
    show_default=True,
    metavar="SOURCE",
    help="What the best ten are shown with at the end, by the whole chain: a picture, 'scene', "
    "chart:NAME, or 'none'.",
)
@panel_option
@click.option(
    "-o",
    "--output",
    metavar="DIR|FILE",
    help=f"A folder for {BEST_NAME}, {JSON_NAME} and pictures; or the best rig's .toml file alone.",
)
@json_option
def design(
    kind: Any,
    method: Any,
    robust: Any,
    effort: str,
    seed: int,
    workers: int | None,
    source: str,
    panel: tuple[int, int] | None,
    output: str | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Search pitch, gap, focal length or hole, turn and walls of the array for a rig's eyes.

    The rig gives panel, headset and eyes; its own array is tried, too. Candidates are judged on a
    small patch of the panel's true sub-pixels: a coarse grid about the focus that matches the
    eye, Optuna, all turns of the best few, then a simplex. Takes some minutes on two cores.

    \b
    Examples:
      vrlf design -r matched-microlens --both "-3.00" -o minus3
      vrlf design --both "-2.00 / -1.50 x 30" --spacers 2,3,4,5 -o best.toml
      vrlf design --arrays fresnel-630 --spacers acrylic-3,acrylic-4,acrylic-6
      vrlf design --kind pinhole --gap 3..6 --hole 50..150 --check photo.jpg
    """
    choice = rig_choice(options)
    limits = limits_of(options)
    rig = choice.load()
    _require("optuna")
    place = _place(output)
    task = Task(
        limits=limits, kind=kind, method=method, robust=robust, effort=_EFFORTS[effort], seed=seed
    )
    count = workers or os.cpu_count() or 1
    if source == "none":
        report = run_design(rig, task, workers=count, say=say)
    else:
        with GpuRenderer() as renderer:
            size = panel or CHECK_PX
            picture = Picture(source, lambda r: target_of(source, r, renderer, _COVER), size)
            report = run_design(
                rig, task, workers=count, renderer=renderer, picture=picture, say=say
            )
    if place is not None:
        _write(report, place, choice.name)
    if as_json:
        put_json(report.to_json())
    else:
        Console().print(design_table(report))
        click.echo("\n".join(each.sentence() for each in report.curves))


def limits_of(options: dict[str, Any]) -> SearchLimits:
    """Take the limits' options out of a command's keyword arguments."""
    path = options.pop("limits")
    given: dict[str, Any] = {}
    for option, key in (
        ("pitch", "pitch_um"),
        ("gap", "gap_mm"),
        ("focal", "focal_mm"),
        ("hole", "aperture_um"),
        ("turn", "rotation_deg"),
        ("brightness", "brightness"),
    ):
        value = options.pop(option)
        if value is not None:
            given[key] = value
    for key in ("arrays", "spacers"):
        text = options.pop(key)
        if text is not None:
            given[key] = [each.strip() for each in text.split(",") if each.strip()]
    barriers = options.pop("barriers")
    if barriers:
        given["barriers"] = list(barriers)
    return search_limits(path, given)


def _require(extra: str) -> None:
    if find_spec(extra) is None:
        raise InputError(
            f"design: found no {extra}, wanted it installed; pip install 'vrlf[design]'"
        )


def _place(output: str | None) -> Path | None:
    """Where results go, seen to before minutes pass."""
    if output is None:
        return None
    if output.endswith(".toml"):
        return check_target(output)
    if Path(output).suffix in (".json", ".png", ".svg", ".csv"):
        raise OutputPathError(
            f"{shown(output)}: found that ending, wanted a folder or a .toml file"
        )
    _require("matplotlib")
    return make_folder(output)


def _write(report: DesignReport, place: Path, source: str) -> None:
    is_folder = place.is_dir()
    path = place / BEST_NAME if is_folder else place
    text = best_text(report, source)
    load_rig_text(text, path)  # what is written can be used
    atomic_write_text(path, text)
    say(f"wrote {shown(path)}")
    if is_folder:
        draw_map(report, place / MAP_NAME)
        draw_sensitivity(report, place / SENSITIVITY_NAME)
        atomic_write_text(place / JSON_NAME, json.dumps(report.to_json(), indent=2) + "\n")
        say(f"wrote {MAP_NAME}, {SENSITIVITY_NAME}, {JSON_NAME} beside it")
