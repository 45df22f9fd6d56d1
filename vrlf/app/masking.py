"""``vrlf mask``: a mask at true scale, a table of lenslets."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import click

from vrlf.app.options import json_option, put_json, rig_choice, rig_options, say
from vrlf.errors import InputError, OutputPathError
from vrlf.files import atomic_write_bytes, atomic_write_text, check_target, shown
from vrlf.studies.mask.dxf import dxf_text, require_ezdxf
from vrlf.studies.mask.plan import Plan, plan_of
from vrlf.studies.mask.table import table_text
from vrlf.studies.mask.vector import pdf_bytes, svg_text

DRAWINGS: Final = (".pdf", ".svg", ".dxf")
TABLE: Final = ".csv"


@click.command(short_help="Draw an array's mask at true scale, or table its lenslets.")
@rig_options
@click.option(
    "-o",
    "--output",
    required=True,
    metavar="FILE",
    help=f"{', '.join(DRAWINGS)}; or {TABLE}: a table of lenslets, which stands beside a drawing "
    "of them, too.",
)
@json_option
def mask(output: str, as_json: bool, **options: Any) -> None:
    """Draw a rig's pinhole mask at true scale, with crosses at the panel's corners and a ruler.

    One lattice for both eyes, as it lies before the panel and as the eyes see it. Of lenslets
    their outlines, with a table of centres and surfaces for a maker. Check the printed ruler:
    printers fit pages unless told not to.

    \b
    Examples:
      vrlf mask -r pinhole -o mask.pdf
      vrlf mask -r best.toml -o lenslets.csv
    """
    choice = rig_choice(options)
    ending = Path(output).suffix.lower()
    if ending not in (*DRAWINGS, TABLE):
        raise OutputPathError(
            f"{shown(output)}: found the ending {ending or 'none'!r}, wanted one of "
            f"{', '.join((*DRAWINGS, TABLE))}"
        )
    if ending == ".dxf":
        require_ezdxf()
    rig = choice.load()
    plan = plan_of(rig, choice.name)
    if ending == TABLE and plan.is_mask:
        raise InputError(
            f"{choice.name}: found a pinhole mask, wanted lenslets for a table; draw it to "
            f"{', '.join(DRAWINGS)}"
        )
    beside = None if plan.is_mask else Path(output).with_suffix(TABLE)
    check_target(output)
    table = None
    if beside is not None:
        check_target(beside)
        table = table_text(rig, plan)
    written = []
    if ending != TABLE:
        _draw(plan, output, ending)
        written.append(output)
    if beside is not None and table is not None:
        atomic_write_text(beside, table)
        written.append(str(beside))
    _tell(plan, written, as_json)


def _draw(plan: Plan, output: str, ending: str) -> None:
    if ending == ".pdf":
        atomic_write_bytes(output, pdf_bytes(plan))
    elif ending == ".svg":
        atomic_write_text(output, svg_text(plan))
    else:
        atomic_write_text(output, dxf_text(plan))


def _tell(plan: Plan, written: list[str], as_json: bool) -> None:
    kind = "holes" if plan.is_mask else "lenslets"
    if as_json:
        width, height = plan.panel_mm
        told = {"written": written, kind: len(plan.centres_mm), "panel_mm": [width, height]}
        put_json(told)
        return
    for path in written:
        say(f"wrote {shown(path)}")
    click.echo(
        f"{len(plan.centres_mm)} {kind} over {plan.panel_mm[0]:.2f} x {plan.panel_mm[1]:.2f} mm; "
        "the ruler must measure 100.00 mm where it is printed"
    )
