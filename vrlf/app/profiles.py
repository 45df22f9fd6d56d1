"""``vrlf profile``: what a viewer's code says, as a rig."""

from __future__ import annotations

import os
from dataclasses import asdict
from math import radians, tan
from pathlib import Path
from typing import Any

import click
import numpy as np

from vrlf.app.options import json_option, put_json, say
from vrlf.errors import InputError
from vrlf.files import atomic_write_text, check_target
from vrlf.model import (
    DEFAULT_RIG,
    Rig,
    ViewerProfile,
    headset_table,
    load_rig,
    read_profile,
    rig_text_of_profile,
    viewer_name,
)
from vrlf.model.reading import load_rig_text
from vrlf.model.shelf import is_shipped
from vrlf.optics.distortion import most_seen, panel_radius
from vrlf.units import UM_PER_MM

_MOST_BEZEL_MM = 100.0


@click.command(short_help="Turn a viewer's code into a rig's headset.")
@click.argument("source")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write a rig that is RIG but for the headset, a .toml file.",
)
@click.option(
    "-r",
    "--rig",
    "rig_name",
    default=DEFAULT_RIG,
    show_default=True,
    metavar="RIG",
    help="Whose panel stands in the viewer: a shipped rig's name or a .toml file.",
)
@click.option(
    "--bezel-mm",
    type=float,
    default=0.0,
    show_default=True,
    metavar="MM",
    help="Border between the phone's edge in the tray and the panel; Google's software takes 3.",
)
@json_option
def profile(
    source: str, output: Path | None, rig_name: str, bezel_mm: float, as_json: bool
) -> None:
    """Turn the code on a Cardboard viewer's box into a rig's headset.

    SOURCE is the code's text, an address that begins with google.com/cardboard/cfg?p=, what
    stands behind its p=, or a file that holds either or the profile itself. g.co/cardboard is
    the first Cardboard. Nothing is fetched: follow a shortened address in a browser first.

    A profile gives the panel's distance, the lenses' separation and distortion, and their
    height above the edge that the phone rests on. It says nothing of their power (the panel
    is taken to stand at the focus) and of the eye's distance: see headset.lens_power_d and
    headset.eye_relief_mm. A rig may also name it by itself: profile = "..." under [headset].

    \b
    Examples:
      vrlf profile g.co/cardboard
      vrlf profile 'https://google.com/cardboard/cfg?p=CgZH...' -r phone.toml -o mine.toml
    """
    if not 0.0 <= bezel_mm <= _MOST_BEZEL_MM:
        raise InputError(
            f"--bezel-mm: found {bezel_mm:g}, wanted a number from 0 to {_MOST_BEZEL_MM:g}"
        )
    found, rig = read_profile(source), load_rig(rig_name)
    height_mm = rig.panel.height_px * rig.panel.pixel_pitch_um / UM_PER_MM
    headset = headset_table(found, height_mm, bezel_mm)
    if output is not None:
        _write(output, rig_text_of_profile(found, headset, _extended(rig_name, output)))
        say(f"wrote {output}")
    report = {**asdict(found), "field_on_panel_mm": _field_on_panel(found), "headset": headset}
    if as_json:
        put_json(report)
    else:
        click.echo(_text(found, report, rig))


def _write(output: Path, text: str) -> None:
    """Write the rig if it is one: an array of the other rig may not fit before this lens."""
    if output.suffix != ".toml":
        raise InputError(f"{output}: found another ending, wanted .toml")
    target = check_target(output)
    if is_shipped(target):
        raise InputError(f"{output}: found a shipped rig, wanted a file of your own")
    load_rig_text(text, output)
    atomic_write_text(target, text)


def _extended(rig_name: str, output: Path) -> str:
    """The other rig as a file in the output's folder names it."""
    if not rig_name.endswith(".toml") and not any(mark in rig_name for mark in "/\\"):
        return rig_name
    relative = os.path.relpath(os.path.abspath(rig_name), os.path.abspath(output.parent))
    return Path(relative).as_posix()


def _field_on_panel(found: ViewerProfile) -> dict[str, float | None] | None:
    """How far from the axis the panel is seen to each side, where the field of view ends.

    None for a side where the distortion turns back before that.
    """
    if found.field_of_view_deg is None:
        return None
    ends_mm: dict[str, float | None] = {}
    for side, deg in asdict(found.field_of_view_deg).items():
        slope = np.asarray(tan(radians(deg)))
        shown = slope <= most_seen(found.distortion)
        radius = panel_radius(slope, found.distortion) if shown else None
        ends_mm[side] = None if radius is None else found.screen_to_lens_mm * float(radius)
    return ends_mm


def _text(found: ViewerProfile, report: dict[str, Any], rig: Rig) -> str:
    headset, field, on_panel = (
        report[key] for key in ("headset", "field_of_view_deg", "field_on_panel_mm")
    )
    k1, k2 = found.distortion
    rests = {
        "bottom": "rests on its lower edge",
        "top": "hangs by its upper edge",
        "center": "is held in the middle",
    }[found.vertical_alignment]
    tray = found.tray_to_lens_mm
    lines = [
        viewer_name(found),
        f"  panel           {found.screen_to_lens_mm:g} mm behind the lenses",
        f"  lenses          {found.inter_lens_mm:g} mm apart",
        f"  the phone       {rests}" + ("" if tray is None else f", {tray:g} mm from the lenses"),
        f"  axes            {headset['lens_height_mm']:+.2f} mm above the middle of the "
        f"{rig.panel.height_px} rows of {rig.panel.pixel_pitch_um:g} um",
        f"  distortion      k1 {k1:g}, k2 {k2:g}",
        f"  button          {found.primary_button}",
    ]
    if field is not None:
        sides = ", ".join(f"{side} {deg:g}{_mm(on_panel[side])}" for side, deg in field.items())
        lines.append(f"  degrees seen    {sides}")
    return "\n".join(lines)


def _mm(end_mm: float | None) -> str:
    return "" if end_mm is None else f" ({end_mm:.1f} mm of panel)"
