"""``vrlf evaluate``: numbers, pictures and a report for every source, rig, eye and method."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import click
from rich.console import Console

from vrlf.app.options import (
    json_option,
    put_json,
    rays_option,
    rig_choices,
    say,
    say_of_wavefronts,
    several_rig_options,
)
from vrlf.app.sources import (
    SourceOptions,
    require_picture_size,
    require_source,
    source_options,
    target_of,
)
from vrlf.errors import InputError
from vrlf.files import make_folder, shown
from vrlf.model import Rig
from vrlf.renderer import GpuRenderer
from vrlf.studies.evaluate import METHODS, METRIC_NAMES, Pictures, Question, run_evaluation
from vrlf.studies.evaluate_report import (
    REPORT,
    check_places,
    evaluation_table,
    report_of,
    versions_of,
    write_report,
)
from vrlf.studies.quality import JUDGING_RAYS


@click.command(short_help="Measure what is seen with and without correction; write a report.")
@click.argument("source", metavar="SOURCE...", nargs=-1, required=True)
@several_rig_options
@click.option(
    "-o",
    "--output",
    required=True,
    metavar="DIR",
    help="The folder for report, numbers and pictures; it is made if it is not there. A run that "
    "was stopped goes on there.",
)
@click.option(
    "--method",
    "methods",
    multiple=True,
    type=click.Choice(METHODS),
    default=list(METHODS),
    show_default=True,
    help="Can be given again. none: the bare target on a panel without an array.",
)
@click.option(
    "--metric",
    "metrics",
    multiple=True,
    type=click.Choice(METRIC_NAMES),
    default=list(METRIC_NAMES),
    show_default=True,
    help="Can be given again. One whose library is not installed is left out, and named.",
)
@source_options
@rays_option(JUDGING_RAYS)
@json_option
def evaluate(
    source: tuple[str, ...],
    output: str,
    methods: tuple[str, ...],
    metrics: tuple[str, ...],
    rays: int,
    as_json: bool,
    **options: Any,
) -> int:
    """Measure what each eye sees of each SOURCE, with and without correction, rig by rig.

    Writes report.html, the file to open, into the folder DIR: pictures side by side, maps of
    what differs, plots, and a table of all numbers, which lie beside it as results.json and
    results.csv. SOURCE is a picture, 'scene' or chart:NAME. Takes a few minutes for each source
    and rig where the CPU does the GPU's work; cases that are finished are not computed again.

    \b
    Examples:
      vrlf evaluate photo.jpg -r matched-wide -o report
      vrlf evaluate scene chart:logmar -r matched-microlens -r pinhole -o report --both -4.50
      vrlf evaluate photo.jpg --method none --method optimal --metric psnr_db -o report --json
    """
    rigs = _rigs(options)
    named = list(dict.fromkeys(source))
    taken = SourceOptions(**options)
    _check(named, rigs, taken)
    # In one order whatever was said first: a finished case is then the same.
    question_methods = [each for each in METHODS if each in methods]
    question_metrics = [each for each in METRIC_NAMES if each in metrics]
    with _results_folder(output) as folder, GpuRenderer() as renderer:
        versions = versions_of(renderer.device.info)
        # What a system's update changes is recorded, but no reason to compute all again.
        decisive = {name: each for name, each in versions.items() if name != "platform"}
        question = Question(question_methods, question_metrics, rays, decisive)
        pictures = _pictures(named, renderer, taken)
        found = run_evaluation(renderer, pictures, rigs, question, folder, progress=say)
        report = report_of(found, named, rigs, folder, rays=rays, versions=versions)
        for note in report.notes:
            say(f"take note: {note}")
        numbers = write_report(report, folder)
    file = str(folder / REPORT)
    if as_json:
        put_json({**numbers, "report": file})
    else:
        Console().print(evaluation_table(report))
        click.echo(f"The report to open: {shown(file)}")
    for failure in found.failures:
        say(
            f"failed: {shown(failure.source)}, {shown(failure.rig)}, {failure.method}: "
            f"{failure.reason}"
        )
    return 1 if found.failures else 0


def _rigs(options: dict[str, Any]) -> dict[str, Rig]:
    """Every rig by the name that was given, all of them loaded before anything is done."""
    return {choice.name: choice.load() for choice in rig_choices(options)}


def _check(sources: Sequence[str], rigs: dict[str, Rig], taken: SourceOptions) -> None:
    """Refuse what cannot be evaluated before anything is made for it."""
    if taken.right_source is not None and len(sources) > 1:
        raise InputError(
            f"--right-source: found it with {len(sources)} sources, wanted it with one, whose "
            "left eye's picture that is"
        )
    for source in sources:
        require_source(source)
    for rig in rigs.values():
        say_of_wavefronts(rig)
        require_picture_size(rig)


def _pictures(sources: Sequence[str], renderer: GpuRenderer, taken: SourceOptions) -> Pictures:
    return {
        source: partial(target_of, source, renderer=renderer, options=taken) for source in sources
    }


@contextlib.contextmanager
def _results_folder(output: str) -> Iterator[Path]:
    """The folder, checked before the work; an empty one that was made for it goes on failure."""
    was_there = Path(output).exists() if "\0" not in output else False
    folder = make_folder(output)
    try:
        check_places(folder)
        yield folder
    except BaseException:
        if not was_there:
            with contextlib.suppress(OSError):  # something is in it, and stays
                folder.rmdir()
        raise
