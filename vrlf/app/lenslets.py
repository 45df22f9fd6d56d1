"""``vrlf lenslet``: how well a lenslet focuses the rig's panel."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import click

from vrlf.app.lenslet_words import report_text, table_text
from vrlf.app.options import RigChoice, json_option, put_json, rig_choice, rig_options, say
from vrlf.errors import InputError
from vrlf.model import Rig
from vrlf.optics.lenslet.given import lens_of
from vrlf.optics.lenslet.report import lenslet_report
from vrlf.optics.lenslet.setting import USUAL_GLASS, Setting, achromat_of, setting_of
from vrlf.optics.lenslet.surfaces import Lens
from vrlf.optics.lenslet.table import achromat_table
from vrlf.studies.lenslet import check_drawable, plot_lenslet
from vrlf.studies.plots import check_plot

_KEYS = ("radius_mm", "thickness_mm", "glass", "facing")


@click.command(short_help="Say how well the array's lenslets focus: spots, MTF, colours, field.")
@rig_options
@click.option(
    "--radius-mm", type=float, metavar="MM", help="Plano-convex: the curved face's radius."
)
@click.option("--thickness-mm", type=float, metavar="MM", help="Its thickness in the middle.")
@click.option(
    "--glass",
    metavar="GLASS",
    help="What it is made of: pmma, polycarbonate, polystyrene, n-bk7, fused-silica, or index and "
    "Abbe number as 1.52/55.",
)
@click.option("--facing", type=click.Choice(["eye", "panel"]), help="Where its curved face looks.")
@click.option(
    "--achromat",
    metavar="CROWN+FLINT",
    help="Design a cemented doublet of the rig's focal length instead, e.g. pmma+polycarbonate.",
)
@click.option(
    "--focus",
    type=click.Choice(["left", "right", "infinity"]),
    default="left",
    show_default=True,
    help="What is to be imaged on the panel: the plane that an eye focuses on, or infinity.",
)
@click.option("-o", "--output", metavar="FILE", help="Draw it all, as .png or .svg.")
@click.option(
    "--table",
    is_flag=True,
    help="Say instead what the thesis's doublet (Table 7.1) is, as printed and put right, and what "
    "achromats of the rig's focal length and pitch are.",
)
@json_option
def lenslet(
    achromat: str | None,
    focus: Any,
    output: str | None,
    table: bool,
    as_json: bool,
    **options: Any,
) -> None:
    """Say how well the array's lenslets focus: spots, MTF, focus of each colour, field curvature.

    Exact rays go from the plane that the eye focuses on through the lenslet's surfaces to the
    panel, for the panel's colours and the field that one lenslet shows. The surfaces are those of
    the rig's [array.lenslet] table, or of the options; a rig without them is taken to have
    plano-convex lenslets of PMMA. Needs no GPU.

    \b
    Examples:
      vrlf lenslet -r thesis-minus-5d --focus infinity -o lenslet.png
      vrlf lenslet --radius-mm 1.13 --thickness-mm 0.5 --glass pmma
      vrlf lenslet --achromat pmma+polycarbonate --json
      vrlf lenslet -r thesis-minus-5d --table
    \b
    In a rig, from the eye's side on (a radius is 0 for a flat face):
      [array.lenslet]
      radii_mm = [3.66, -2.64, -8.47]
      thicknesses_mm = [0.35, 0.2]
      glasses = ["pmma", "polycarbonate"]
    """
    given = {key: options.pop(key) for key in _KEYS}
    target = None if output is None else check_plot(output, "-o")
    rig = _with(rig_choice(options), given, achromat).load()
    if table:
        if output is not None:
            raise InputError("--table: found -o beside it, wanted one of them")
        _say_table(rig, as_json)
        return
    lens, origin = _lens(rig, achromat)
    setting = setting_of(rig, lens, focus)
    report = lenslet_report(setting)
    if target is not None:
        check_drawable(setting)
        plot_lenslet(setting, report, _title(setting, origin, focus), target)
        say(f"wrote {target}")
    if as_json:
        put_json({"lenslet": _surfaces(setting.lens), "given": origin, **asdict(report)})
    else:
        click.echo(report_text(setting, report, origin, focus))


def _with(choice: RigChoice, given: dict[str, Any], achromat: str | None) -> RigChoice:
    """The rig with the options' lenslet, each a key of its table."""
    keys = {key: value for key, value in given.items() if value is not None}
    if not keys:
        return choice
    if achromat is not None:
        option = "--" + next(iter(keys)).replace("_", "-")
        raise InputError(f"--achromat: found {option} beside it, wanted one of them")
    changes = tuple(f"array.lenslet.{key}={value}" for key, value in keys.items())
    return RigChoice(
        choice.name, (*choice.overrides, *changes), choice.left, choice.right, choice.both
    )


def _lens(rig: Rig, achromat: str | None) -> tuple[Lens | None, str]:
    """The lens that stands in for the rig's own, if one does, and where it is from."""
    if achromat is None:
        return None, "given" if lens_of(
            rig
        ) is not None else f"assumed: plano-convex, {USUAL_GLASS}"
    parts = achromat.split("+")
    if len(parts) != 2:
        raise InputError(f"--achromat: found {achromat!r}, wanted CROWN+FLINT")
    if rig.array.kind != "microlens":
        return None, ""
    return achromat_of(rig, *parts), "designed: achromat"


def _surfaces(lens: Lens) -> dict[str, Any]:
    """A lenslet as its rig keys have it."""
    inner = lens.surfaces[:-1]
    return {
        "radii_mm": [
            1.0 / each.curvature_per_mm if each.curvature_per_mm else 0.0 for each in lens.surfaces
        ],
        "conics": [each.conic for each in lens.surfaces],
        "thicknesses_mm": [each.thickness_mm for each in inner],
        "glasses": [each.medium.name for each in inner],
        "aperture_mm": lens.aperture_mm,
    }


def _title(setting: Setting, origin: str, focus: str) -> str:
    surfaces = _surfaces(setting.lens)
    radii = ", ".join(f"{radius:.4g}" if radius else "flat" for radius in surfaces["radii_mm"])
    onto = "infinity" if focus == "infinity" else f"the {focus} eye's plane of focus"
    made_of, wide_mm = " + ".join(surfaces["glasses"]), setting.lens.aperture_mm
    return (
        f"lenslet of {made_of}, radii {radii} mm, {wide_mm:g} mm wide ({origin}), imaging {onto} "
        "on the panel"
    )


def _say_table(rig: Rig, as_json: bool) -> None:
    rows, missing = achromat_table(rig)
    if not as_json:
        click.echo(table_text(rows, missing))
        return
    numbers = [{**asdict(row), "lens": _surfaces(row.lens)} for row in rows]
    put_json({"rows": numbers, "missing": missing})
