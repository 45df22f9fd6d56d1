"""``vrlf eye``: what each eye makes of a point, in numbers and in one picture."""

from __future__ import annotations

from typing import Any

import click

from vrlf.app.options import json_option, put_json, rig_choice, rig_options, say_of_wavefronts
from vrlf.app.sizes import decimal_number
from vrlf.optics.pupil import looking_far
from vrlf.optics.viewport import SIDES
from vrlf.studies.eyeplot import plot_eyes, summary
from vrlf.studies.eyes import COLOURS, EyeReport, eye_report
from vrlf.studies.plots import ENDINGS, check_plot
from vrlf.units import ARCMIN_PER_DEGREE

_LARGEST_LETTER_ARCMIN = 60.0 * ARCMIN_PER_DEGREE


@click.command(short_help="Draw each eye's wavefront and what it makes of a point.")
@rig_options
@click.option("-o", "--output", metavar="FILE", help=f"Draw it, to {' or '.join(ENDINGS)}.")
@click.option(
    "--alone",
    is_flag=True,
    help="The eyes by themselves: a point at infinity in place of the panel's.",
)
@click.option(
    "--letter",
    "letter_arcmin",
    type=decimal_number(0.0, _LARGEST_LETTER_ARCMIN),
    metavar="ARCMIN",
    help="Height of the blurred letter. [default: for each eye the one its blur is about to hide]",
)
@json_option
def eye(
    output: str | None, alone: bool, letter_arcmin: float | None, as_json: bool, **options: Any
) -> None:
    """Draw each eye's wavefront, what it makes of a point, its contrast and a blurred letter.

    For each eye before the bare panel, through the headset's lens (an array is not in it): the
    wavefront error over the pupil; a point of light by rays and by diffraction, in the colours
    of the panel; how much contrast is left at each fineness; a letter. All as the wearer sees
    it. Said in numbers too: the error's RMS, the Strehl ratio, the width that holds half of a
    point's light. Needs no GPU.

    \b
    Examples:
      vrlf eye -r two-eyes -o eye.png
      vrlf eye --alone --left "-0.50" --set left.pupil_mm=3 --json
    """
    choice = rig_choice(options)
    rig = choice.load()
    if output is not None:
        check_plot(output, "-o")
    say_of_wavefronts(rig)
    if alone:
        rig = looking_far(rig)
    reports = {side: eye_report(rig, side) for side in SIDES}
    if output is not None:
        where = "at infinity" if alone else "of the bare panel"
        title = f"What each eye makes of a point {where}, as the wearer sees it ({choice.name})"
        named = {side.capitalize(): report for side, report in reports.items()}
        plot_eyes(named, output, title=title, letter_arcmin=letter_arcmin)
    if as_json:
        put_json({side: report.to_json() for side, report in reports.items()})
    else:
        click.echo("\n\n".join(_words(side, report) for side, report in reports.items()))


def _words(side: str, report: EyeReport) -> str:
    """One eye's numbers as text."""
    lines = [f"{side.capitalize()} eye", f"  {summary(report)}"]
    lines.append("             wavelength   Strehl   half of a point's light within   by rays")
    rows = zip(
        COLOURS,
        report.seen.wavelengths_nm,
        report.strehl,
        report.half_light_arcmin,
        report.geometric_half_light_arcmin,
        strict=True,
    )
    for colour, nm, strehl, width, by_rays in rows:
        lines.append(
            f"  {colour:<8} {nm:9.0f} nm {strehl:9.2g} {width:24.2f} arcmin {by_rays:9.2f} arcmin"
        )
    return "\n".join(lines)
