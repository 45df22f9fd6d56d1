"""``vrlf reproduce``: the thesis's results and ours, side by side."""

from __future__ import annotations

import json
from pathlib import Path

import click
from rich.console import Console

from vrlf.app.options import json_option, put_json, say
from vrlf.app.sources import SourceOptions, target_of
from vrlf.files import atomic_write_bytes, atomic_write_text, check_target, make_folder, shown
from vrlf.model import Rig
from vrlf.renderer import GpuRenderer, Image
from vrlf.studies.plots import require_matplotlib
from vrlf.studies.reproduce.item import Item, Workbench
from vrlf.studies.reproduce.page import report_html
from vrlf.studies.reproduce.run import ITEMS, Report, chosen, reproduce_table, run_reproduce

_PAGE, _NUMBERS = "index.html", "reproduce.json"
_COVER = SourceOptions(fit="cover")


@click.command(short_help="Make the thesis's results with this program, and say where they differ.")
@click.option(
    "-o",
    "--output",
    default="reproduce-out",
    show_default=True,
    metavar="DIR",
    help="The folder for pictures, numbers and page; it is made if it is not there.",
)
@click.option(
    "--only", "names", multiple=True, metavar="NAME", help="Make this item; can be given again."
)
@click.option("--list", "only_list", is_flag=True, help="Say what items there are, make none.")
@json_option
def reproduce(output: str, names: tuple[str, ...], only_list: bool, as_json: bool) -> int:
    """Make this program's counterpart of the thesis's figures and tables.

    Next to each stands what the thesis says and where it errs. DIR gets a picture for each
    item, all numbers in reproduce.json, and index.html, the one to open, which stands by itself.
    Takes some five minutes where the CPU does the GPU's work. An item that fails stops no other;
    the exit status is then 1.

    \b
    Examples:
      vrlf reproduce -o thesis
      vrlf reproduce --only table-8-1 --only fig-3-4
      vrlf reproduce --list
    """
    if only_list:
        _list(as_json)
        return 0
    wanted = chosen(names)
    require_matplotlib("reproduce")
    folder = make_folder(output)
    for file in (_PAGE, _NUMBERS, *(f"{name}.png" for name in wanted)):
        check_target(folder / file)

    def put(item: Item) -> None:
        for picture in item.pictures:
            atomic_write_bytes(folder / picture.name, picture.png)

    with Workbench(_draw, say) as bench:
        report = run_reproduce(bench, wanted, put)
    _put_report(report, folder, as_json)
    return 1 if report.failed else 0


def _draw(source: str, rig: Rig, renderer: GpuRenderer) -> Image:
    return target_of(source, rig, renderer, _COVER)


def _list(as_json: bool) -> None:
    if as_json:
        put_json({name: words for name, (words, _) in ITEMS.items()})
        return
    for name, (words, _) in ITEMS.items():
        click.echo(f"{name:<12} {words}")


def _put_report(report: Report, folder: Path, as_json: bool) -> None:
    """Numbers and page into the folder, then the result to standard output."""
    found = report.to_json()
    text = json.dumps(found, indent=2, allow_nan=False) + "\n"
    atomic_write_text(folder / _NUMBERS, text)
    atomic_write_text(folder / _PAGE, report_html(report))
    page = str(folder / _PAGE)
    if as_json:
        put_json({"page": page, **found})
        return
    Console().print(reproduce_table(report))
    click.echo(f"The page to open: {shown(page)}")
    for name, why in report.failed.items():
        say(f"{name} failed: {why}")
