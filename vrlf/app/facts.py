"""``vrlf inspect``, ``vrlf rigs`` and ``vrlf doctor``."""

from __future__ import annotations

import os
import platform
import sys
from importlib.metadata import version
from typing import Any

import click
import numpy as np

from vrlf.app.options import json_option, put_json, rig_choice, rig_options
from vrlf.app.words import inspection
from vrlf.errors import VrlfError
from vrlf.gpu import Device
from vrlf.model import DEFAULT_RIG, load_rig
from vrlf.model.shelf import SHELVES, Shelf, summaries
from vrlf.optics.inspect import inspect_rig
from vrlf.reference.quadrature import perceive_well as perceive_reference
from vrlf.renderer import GpuRenderer

_CHECK_RIG = ("panel.width_px=64", "panel.height_px=48", "headset.lens_separation_mm=2.5")
_CHECK_RAYS = 32
# What an error says that came up elsewhere.
_SEE_DOCTOR = "; 'vrlf doctor' tells more"
# What the passes promise against their float64 twins.
_AGREEMENT = 1e-4


@click.command(short_help="Say what follows from a rig: blur, focus, light, warnings.")
@rig_options
@json_option
def inspect(as_json: bool, **options: Any) -> None:
    """Say what follows from a rig: blur, focus, what the array can correct, the light left.

    For each eye: the error that is left when it looks at the bare panel through the headset's
    lens, at what distance it sees sharp, and over how many pixels a point blurs without and
    with the array. For the array: its limits, and how much light it lets through. Needs no GPU.

    \b
    Examples:
      vrlf inspect --left "-5.00 / -1.25 x 170" --right "-4.50"
      vrlf inspect -r pinhole --set array.aperture_um=100 --json
    """
    rig = rig_choice(options).load()
    numbers = inspect_rig(rig)
    if as_json:
        put_json(numbers)
    else:
        click.echo(inspection(rig, numbers))


@click.command(short_help="List the rigs, eyes and panels that ship with vrlf.")
@click.option("--eyes", "shelf", flag_value="eyes", help="The example eyes, for extends in [left].")
@click.option("--panels", "shelf", flag_value="panels", help="The panels, for extends in [panel].")
@json_option
def rigs(as_json: bool, shelf: Shelf | None) -> None:
    """List the rigs that ship with vrlf.

    A rig of your own is a TOML file that names one of them and what is different. Lengths are
    in millimetres or micrometres, powers in dioptres with the signs of the prescription, as
    the keys' names say:

    \b
      extends = "matched-microlens"
      [panel]
      width_px = 2532
      height_px = 1170
      pixel_pitch_um = 55.0
      [headset]
      lens_to_panel_mm = 39.0
      [left]
      sphere_d = -5.0
      cylinder_d = -1.25
      axis_deg = 170.0
      [right]
      sphere_d = -4.5

    An eye may be an example's too: extends = "keratoconus-like" in [left]; --eyes lists them.
    Save it as mine.toml, then 'vrlf inspect -r mine.toml' says what follows from it. A wrong
    key is answered with those that there are.
    """
    if as_json:
        shelves: dict[str, Any] = {each: summaries(each) for each in SHELVES}
        put_json({"default": DEFAULT_RIG, **shelves})
        return
    found = summaries(shelf or "rigs")
    width = max(map(len, found), default=0)
    for name, summary in found.items():
        click.echo(f"{name:<{width}}  {summary}")


@click.command(short_help="Say whether this GPU serves, and what to do if not.")
@json_option
def doctor(as_json: bool) -> int:
    """Say what GPU, driver and context there are, and what to do if they don't serve.

    A small picture is rendered and held against the float64 reference. Exit status 1 if the
    GPU does not serve.
    """
    report: dict[str, Any] = {"python": platform.python_version(), "system": platform.platform()}
    report["libraries"] = {name: version(name) for name in ("moderngl", "numpy", "OpenImageIO")}
    report["display"] = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    try:
        with GpuRenderer() as renderer:
            report.update(_device_report(renderer))
    except VrlfError as error:
        report.update(ok=False, problem=str(error).removesuffix(_SEE_DOCTOR))
    if as_json:
        put_json(report)
    else:
        click.echo(_doctor_text(report))
    return 0 if report["ok"] else 1


def _device_report(renderer: GpuRenderer) -> dict[str, Any]:
    device: Device = renderer.device
    error = _worst_disagreement(renderer)
    report: dict[str, Any] = {
        "device": device.info.renderer,
        "vendor": device.info.vendor,
        "opengl": device.info.version,
        "software": device.info.is_software,
        "max_texture_px": device.info.max_texture_px,
        "self_check_error": error,
        "ok": error <= _AGREEMENT,
    }
    if error > _AGREEMENT:
        report["problem"] = (
            f"the GPU's picture differs from the float64 reference by {error:.2g}, wanted at most "
            f"{_AGREEMENT:g}; update the graphics driver, or use --device reference"
        )
    return report


def _worst_disagreement(renderer: GpuRenderer) -> float:
    """Largest difference between GPU and reference on a small rig.

    All but one pixel in a hundred count: single rays may fall on either side of a border.
    """
    rig = load_rig(DEFAULT_RIG, overrides=_CHECK_RIG)
    panel = np.random.default_rng(1).random((48, 64, 3)).astype(np.float32)
    seen = renderer.perceive(panel, rig, rays=_CHECK_RAYS, exposure="none")
    wanted = perceive_reference(panel.astype(np.float64), rig, _CHECK_RAYS)
    return float(np.quantile(np.abs(seen - wanted).max(axis=-1), 0.99))


def _doctor_text(report: dict[str, Any]) -> str:
    libraries = ", ".join(f"{name} {found}" for name, found in report["libraries"].items())
    lines = [
        f"Python          {report['python']} on {report['system']}",
        f"libraries       {libraries}",
        f"display         {report['display'] or 'none (windows need one, headless work does not)'}",
    ]
    if "device" in report:
        kind = "software: the CPU does it, correct but slow" if report["software"] else "hardware"
        lines += [
            f"GPU             {report['device']} ({kind})",
            f"OpenGL          {report['opengl']}",
            f"largest texture {report['max_texture_px']} pixels a side",
            f"self-check      differs from the float64 reference by "
            f"{report['self_check_error']:.1e}",
        ]
    lines.append("All is well." if report["ok"] else f"Problem         {report['problem']}")
    if not report["ok"]:
        lines += [
            "until then      'inspect', 'eye', 'rigs' and 'chart' need no GPU, nor do 'prefilter'",
            "                and 'perceive' with --device reference, which is slow",
        ]
        if sys.platform.startswith("linux"):
            lines.append("no GPU at all?  Mesa's llvmpipe lets the CPU do its work: see the README")
    return "\n".join(lines)
