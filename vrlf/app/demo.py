"""``vrlf demo``: the whole chain on shipped content, and one picture of all of it."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import click

from vrlf.app.options import json_option, put_json, rig_choice, rig_options, say
from vrlf.app.sheet import Column, detail_for, draw_sheet
from vrlf.app.sources import SCENE, SourceOptions, target_of
from vrlf.evaluation.measure import Likeness, likeness
from vrlf.files import atomic_write_text, make_folder
from vrlf.images import write_encoded
from vrlf.model import Rig, load_rig
from vrlf.optics.inspect import inspect_rig
from vrlf.optics.viewport import SIDES, viewport
from vrlf.renderer import DEFAULT_RAYS, GpuRenderer, Image

# Shown beside the rig of the demo, on the same eyes and the same scene: another array that
# serves, and the thesis's own, which gains nothing in a headset.
_OTHERS = ("matched-full", "thesis-minus-5d")


@dataclass(frozen=True)
class Chain:
    """One rig's pictures and numbers, from the target to what is seen."""

    name: str
    rig: Rig
    target: Image
    panel: Image
    uncorrected: Image
    corrected: Image
    before: tuple[Likeness, Likeness]
    after: tuple[Likeness, Likeness]


@click.command()
@rig_options
@click.option(
    "-o",
    "--output",
    default="demo-out",
    show_default=True,
    metavar="DIR",
    help="The folder for the pictures.",
)
@click.option(
    "--source",
    default=SCENE,
    show_default=True,
    metavar="SOURCE",
    help="A picture of your own instead of the shipped scene.",
)
@click.option(
    "--rays",
    type=click.IntRange(1),
    default=DEFAULT_RAYS,
    show_default=True,
    help="Rays for each retinal pixel.",
)
@json_option
def demo(output: str, source: str, rays: int, as_json: bool, **options: Any) -> None:
    """Show the whole chain: target, panel image, and what each eye sees with and without it.

    Writes the pictures, numbers.json and overview.png, the one to open.
    """
    choice = rig_choice(options)
    rig = choice.load()
    folder = make_folder(output)
    with GpuRenderer() as renderer:
        say(f"GPU: {renderer.device.info.renderer}")
        chains = [run_chain(choice.name, rig, source, renderer, rays)]
        chains += [
            run_chain(name, _with_eyes_of(rig, name), source, renderer, rays)
            for name in _OTHERS
            if name != choice.name
        ]
        _write_pictures(folder, chains, renderer)
    numbers = _numbers(chains, source, rays)
    atomic_write_text(folder / "numbers.json", json.dumps(numbers, indent=2) + "\n")
    overview = str(folder / "overview.png")
    if as_json:
        put_json({"overview": overview, **numbers})
    else:
        click.echo("\n".join(_table(chains)))
        click.echo(f"The picture to open: {overview}")


def _with_eyes_of(rig: Rig, name: str) -> Rig:
    """Another shipped rig's array before the same panel size, headset and eyes."""
    other = load_rig(name)
    panel = rig.panel.model_copy(update={"subpixels": other.panel.subpixels})
    return rig.model_copy(update={"panel": panel, "array": other.array})


def run_chain(name: str, rig: Rig, source: str, renderer: GpuRenderer, rays: int) -> Chain:
    """Target, panel image, and what both eyes see of the target bare and of the panel image."""
    say(f"{name}: target")
    target = target_of(source, rig, renderer, SourceOptions(fit="cover"))
    say(f"{name}: panel image")
    panel = renderer.prefilter(target, rig)
    say(f"{name}: what the eyes see ({rays} rays a pixel)")
    bare = bare_rig(rig)
    uncorrected = renderer.perceive(target, bare, rays=rays)
    corrected = renderer.perceive(panel, rig, rays=rays)
    # One border for both, the wider: the same pixels are compared.
    before = tuple(likeness(uncorrected, target, rig, side) for side in SIDES)
    after = tuple(likeness(corrected, target, rig, side) for side in SIDES)
    return Chain(
        name,
        rig,
        target,
        panel,
        uncorrected,
        corrected,
        (before[0], before[1]),
        (after[0], after[1]),
    )


def bare_rig(rig: Rig) -> Rig:
    """The same headset and eyes before the panel without an array."""
    return rig.model_copy(update={"array": rig.array.model_copy(update={"kind": "none"})})


def _write_pictures(folder: Path, chains: list[Chain], renderer: GpuRenderer) -> None:
    first = chains[0]
    for name, picture in (
        ("target", first.target),
        ("panel", first.panel),
        ("perceived-without", first.uncorrected),
        ("perceived-with", first.corrected),
        ("overview", _overview(chains)),
    ):
        write_encoded(folder / f"{name}.png", renderer.encode(picture))


def _overview(chains: list[Chain]) -> Image:
    first = chains[0]
    numbers = inspect_rig(first.rig)
    views = (viewport(first.rig, "left"), viewport(first.rig, "right"))
    blur = [f"a point blurs over {numbers[side]['blur_px']:.1f} pixels" for side in SIDES]
    before = [
        f"{each.psnr_db:.1f} dB, {text}" for each, text in zip(first.before, blur, strict=True)
    ]
    after = [
        f"{each.psnr_db:.1f} dB, {each.psnr_db - old.psnr_db:+.1f} dB"
        for each, old in zip(first.after, first.before, strict=True)
    ]
    columns = [
        Column("meant: the target", first.target, ("what the eye should see",) * 2),
        Column("shown: the panel image", first.panel, (_array_note(first.rig),) * 2),
        Column("seen without correction", first.uncorrected, (before[0], before[1])),
        Column("seen with correction", first.corrected, (after[0], after[1])),
    ]
    rig = first.rig
    subtitle = (
        f"left {_paper(rig, 'left')}, right {_paper(rig, 'right')}, pupils {rig.left.pupil_mm:g} "
        f"and {rig.right.pupil_mm:g} mm; {rig.panel.width_px} x {rig.panel.height_px} pixels of "
        f"{rig.panel.pixel_pitch_um:g} um, {rig.headset.lens_to_panel_mm:g} mm behind the lens; "
        f"{numbers['display']['pixels_per_degree']:.1f} pixels per degree"
    )
    return draw_sheet(
        f"vrlf: {first.name}",
        subtitle,
        columns,
        views,
        detail_for(views[0]),
        numbers["display"]["pixels_per_degree"],
        _table(chains),
    )


def _paper(rig: Rig, side: str) -> str:
    eye = rig.left if side == "left" else rig.right
    text = f"{eye.sphere_d:+.2f}"
    return text if eye.cylinder_d == 0.0 else f"{text} / {eye.cylinder_d:+.2f} x {eye.axis_deg:g}"


def _array_note(rig: Rig) -> str:
    array = rig.array
    if array.kind == "none":
        return "no array: the target itself"
    what = f"holes of {array.aperture_um:g}" if array.kind == "pinhole" else "lenslets of"
    size = "" if array.kind == "pinhole" else f" {array.focal_mm:g} mm focus,"
    turned = f", turned {array.rotation_deg:g} deg" if array.rotation_deg else ""
    unit = " um" if array.kind == "pinhole" else ""
    return f"{what}{unit}{size} {array.pitch_um:g} um apart, gap {array.gap_mm:g} mm{turned}"


def _table(chains: list[Chain]) -> list[str]:
    """A line for each array: how much nearer to the target each eye's view comes."""
    lines = ["PSNR in linear light after one gain, the same scene and eyes:"]
    for chain in chains:
        eyes = [
            f"{side} {old.psnr_db:.1f} -> {new.psnr_db:.1f} dB ({new.psnr_db - old.psnr_db:+.1f})"
            for side, old, new in zip(SIDES, chain.before, chain.after, strict=True)
        ]
        lines.append(f"    {chain.name}: {', '.join(eyes)}{_verdict(chain)}")
    return lines


def _verdict(chain: Chain) -> str:
    gains = [new.psnr_db - old.psnr_db for old, new in zip(chain.before, chain.after, strict=True)]
    if max(gains) < 1.0:
        return " - this array gains nothing here"
    return ""


def _numbers(chains: list[Chain], source: str, rays: int) -> dict[str, Any]:
    return {
        "source": source,
        "rays": rays,
        "rigs": {
            chain.name: {
                side: {"without": asdict(chain.before[eye]), "with": asdict(chain.after[eye])}
                for eye, side in enumerate(SIDES)
            }
            for chain in chains
        },
    }
