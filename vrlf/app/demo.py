"""``vrlf demo``: the whole chain on shipped content, and one picture of all of it."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import click

from vrlf.app.options import (
    json_option,
    put_json,
    rays_option,
    rig_choice,
    rig_options,
    say,
    say_of_wavefronts,
)
from vrlf.app.sheet import Column, draw_sheet
from vrlf.app.sources import SCENE, SourceOptions, require_picture_size, target_of
from vrlf.errors import RigError
from vrlf.evaluation.measure import Likeness, border_px, likeness
from vrlf.files import atomic_write_text, check_target, make_folder, shown
from vrlf.images import write_encoded
from vrlf.model import Rig, focal_mm, load_rig, rig_from_tables
from vrlf.optics.inspect import inspect_rig
from vrlf.optics.viewport import SIDES, Side, viewport
from vrlf.renderer import DEFAULT_RAYS, GpuRenderer, Image, bare_rig

# Shown beside the rig of the demo, on the same eyes and the same scene: another array that
# serves, and the thesis's own, which gains nothing in a headset.
_OTHERS = ("matched-full", "thesis-minus-5d")
_PICTURES = ("target", "panel", "perceived-without", "perceived-with", "overview")
_OPTIMAL = "optimal prefilter"
_OPTIMAL_PICTURE = "perceived-with-optimal"


@dataclass(frozen=True)
class Gain:
    """How near an eye's view comes to the target without and with the correction."""

    without: Likeness
    corrected: Likeness

    @property
    def psnr_db(self) -> float:
        """What the correction adds; not finite where a view is the target itself."""
        return self.corrected.psnr_db - self.without.psnr_db


@dataclass(frozen=True)
class Chain:
    """One rig's pictures and numbers, from the target to what is seen.

    ``gains`` has None for an eye whose viewport is all border: nothing is left to compare.
    """

    name: str
    rig: Rig
    target: Image
    panel: Image
    uncorrected: Image
    corrected: Image
    gains: tuple[Gain | None, Gain | None]


@click.command(short_help="Show the whole chain in pictures and numbers.")
@rig_options
@click.option(
    "-o",
    "--output",
    default="demo-out",
    show_default=True,
    metavar="DIR",
    help="The folder for the pictures; it is made if it is not there.",
)
@click.option(
    "--source",
    default=SCENE,
    show_default=True,
    metavar="SOURCE",
    help="Instead of the shipped scene a picture of your own or chart:NAME.",
)
@rays_option(DEFAULT_RAYS)
@json_option
def demo(output: str, source: str, rays: int, as_json: bool, **options: Any) -> None:
    """Show the whole chain: target, panel image, and what each eye sees with and without it.

    Writes target.png, panel.png, perceived-without.png, perceived-with.png, numbers.json and
    overview.png, the one to open, into the folder DIR. The optimal prefilter and two other
    arrays before the same eyes are measured for comparison. Takes one to two minutes where the
    CPU does the GPU's work.

    \b
    Examples:
      vrlf demo
      vrlf demo --left "-5.00 / -1.25 x 170" --right "-4.50" --source photo.jpg -o mine
    """
    choice = rig_choice(options)
    rig = choice.load()
    say_of_wavefronts(rig)
    require_picture_size(rig)
    rigs = {choice.name: rig} | _optimal(rig, choice.name) | _comparisons(rig, choice.name)
    with _results_folder(output) as folder:
        with GpuRenderer() as renderer:
            say(f"GPU: {renderer.device.info.renderer}")
            plain: dict[Any, tuple[Image, Image]] = {}
            chains = [
                run_chain(name, each, source, renderer, rays, plain) for name, each in rigs.items()
            ]
            _write_pictures(folder, chains, renderer)
        numbers = _numbers(chains, source, rays)
        atomic_write_text(folder / "numbers.json", json.dumps(numbers, indent=2) + "\n")
    overview = str(folder / "overview.png")
    if as_json:
        put_json({"overview": overview, **numbers})
    else:
        click.echo("\n".join(_table(chains)))
        click.echo(f"The picture to open: {shown(overview)}")


@contextlib.contextmanager
def _results_folder(output: str) -> Iterator[Path]:
    """The folder, checked before the work; an empty one that was made for it goes on failure."""
    was_there = Path(output).exists() if "\0" not in output else False
    folder = make_folder(output)
    try:
        for picture in (*_PICTURES, _OPTIMAL_PICTURE):
            check_target(folder / f"{picture}.png")
        check_target(folder / "numbers.json")
        yield folder
    except BaseException:
        if not was_there:
            with contextlib.suppress(OSError):  # something is in it, and stays
                folder.rmdir()
        raise


def _optimal(rig: Rig, name: str) -> dict[str, Rig]:
    """The same rig with the optimal prefilter, where that is not its own and can be had."""
    bare, walled = rig.array.kind == "none", rig.array.barriers == "perpendicular"
    if rig.prefilter.method != "forward" or bare or walled:
        return {}
    prefilter = rig.prefilter.model_copy(update={"method": "optimal"})
    return {f"{name}, {_OPTIMAL}": rig.model_copy(update={"prefilter": prefilter})}


def _comparisons(rig: Rig, name: str) -> dict[str, Rig]:
    """Other shipped rigs' arrays before the same panel size, headset and eyes."""
    found = {}
    for other_name in _OTHERS:
        if other_name == name:
            continue
        other, tables = load_rig(other_name), rig.model_dump(mode="json", by_alias=True)
        tables["panel"]["subpixels"] = other.panel.subpixels
        tables["array"] = other.array.model_dump(mode="json", by_alias=True)
        try:
            found[other_name] = rig_from_tables(tables, source=other_name)
        except RigError as error:
            say(f"left out, since its array does not fit this headset: {error}")
    return found


def run_chain(
    name: str,
    rig: Rig,
    source: str,
    renderer: GpuRenderer,
    rays: int,
    plain: dict[Any, tuple[Image, Image]],
) -> Chain:
    """Target, panel image, and what both eyes see of the target bare and of the panel image.

    ``plain`` keeps targets and bare views, which rigs with the same panel and eyes share.
    """
    key = (rig.panel, rig.headset, rig.left, rig.right)
    if key not in plain:
        say(f"{shown(name)}: target, and what the eyes see of it")
        target = target_of(source, rig, renderer, SourceOptions(fit="cover"))
        plain[key] = (target, renderer.perceive(target, bare_rig(rig), rays=rays))
    target, bare = plain[key]
    say(f"{shown(name)}: panel image")
    panel = renderer.prefilter(target, rig)
    say(f"{shown(name)}: what the eyes see ({rays} rays a pixel)")
    seen = renderer.perceive(panel, rig, rays=rays)
    gains = [_gain(bare, seen, target, rig, side) for side in SIDES]
    return Chain(name, rig, target, panel, bare, seen, (gains[0], gains[1]))


def _gain(bare: Image, seen: Image, target: Image, rig: Rig, side: Side) -> Gain | None:
    view = viewport(rig, side)
    if 2 * border_px(rig, side) >= min(view.width_px, view.height_px):
        return None
    # One border for both, the wider: the same pixels are compared.
    return Gain(likeness(bare, target, rig, side), likeness(seen, target, rig, side))


def _write_pictures(folder: Path, chains: list[Chain], renderer: GpuRenderer) -> None:
    first = chains[0]
    pictures = (first.target, first.panel, first.uncorrected, first.corrected, _overview(chains))
    for name, picture in zip(_PICTURES, pictures, strict=True):
        write_encoded(folder / f"{name}.png", renderer.encode(picture))
    optimal = _optimal_chain(chains)
    if optimal is not None:
        write_encoded(folder / f"{_OPTIMAL_PICTURE}.png", renderer.encode(optimal.corrected))


def _optimal_chain(chains: list[Chain]) -> Chain | None:
    return next((chain for chain in chains if chain.name.endswith(_OPTIMAL)), None)


def _overview(chains: list[Chain]) -> Image:
    first = chains[0]
    rig, numbers = first.rig, inspect_rig(first.rig)
    ppd = numbers["display"]["pixels_per_degree"]
    before = []
    for side, gain in zip(SIDES, first.gains, strict=True):
        blur = f"a point blurs over {numbers[side]['blur_px']:.1f} pixels"
        before.append(blur if gain is None else f"{_db(gain.without)}, {blur}")
    columns = [
        Column("meant: the target", first.target, ("what the eye should see",) * 2),
        Column("shown: the panel image", first.panel, (_array_note(rig),) * 2),
        Column("seen without correction", first.uncorrected, (before[0], before[1])),
        Column(f"seen with correction ({rig.prefilter.method})", first.corrected, _after(first)),
    ]
    optimal = _optimal_chain(chains)
    if optimal is not None:
        columns.append(Column(f"seen with the {_OPTIMAL}", optimal.corrected, _after(optimal)))
    subtitle = (
        f"left {_paper(rig, 'left')}, right {_paper(rig, 'right')}, pupils {rig.left.pupil_mm:g} "
        f"and {rig.right.pupil_mm:g} mm; {rig.panel.width_px} x {rig.panel.height_px} pixels of "
        f"{rig.panel.pixel_pitch_um:g} um, {rig.headset.lens_to_panel_mm:g} mm behind the lens; "
        f"{ppd:.1f} pixels per degree"
    )
    views = (viewport(rig, "left"), viewport(rig, "right"))
    return draw_sheet(f"vrlf: {shown(first.name)}", subtitle, columns, views, ppd, _table(chains))


def _after(chain: Chain) -> tuple[str, str]:
    """What the correction gives each eye."""
    left, right = (
        "" if gain is None else f"{_db(gain.corrected)}{_added(gain)}" for gain in chain.gains
    )
    return left, right


def _paper(rig: Rig, side: Side) -> str:
    eye = rig.left if side == "left" else rig.right
    text = f"{eye.sphere_d:+.2f}"
    return text if eye.cylinder_d == 0.0 else f"{text} / {eye.cylinder_d:+.2f} x {eye.axis_deg:g}"


def _array_note(rig: Rig) -> str:
    array = rig.array
    if array.kind == "none":
        return "no array: the target itself"
    lattice = " in hexagons" if array.lattice == "hexagonal" else ""
    turned = f", turned {array.rotation_deg:g} deg" if array.rotation_deg else ""
    what = (
        f"holes of {array.aperture_um:g} um"
        if array.kind == "pinhole"
        else f"lenslets of {focal_mm(array):.4g} mm focus"
    )
    return f"{what}, {array.pitch_um:g} um apart{lattice}, gap {array.gap_mm:g} mm{turned}"


def _table(chains: list[Chain]) -> list[str]:
    """A line for each array: how much nearer to the target each eye's view comes."""
    lines = ["PSNR in linear light after one gain, the same scene and eyes:"]
    for chain in chains:
        eyes = [
            f"{side} too small a view to measure"
            if gain is None
            else f"{side} {_db(gain.without)} -> {_db(gain.corrected)}{_added(gain)}"
            for side, gain in zip(SIDES, chain.gains, strict=True)
        ]
        lines.append(f"    {shown(chain.name)}: {', '.join(eyes)}{_verdict(chain)}")
    return lines


def _db(each: Likeness) -> str:
    return f"{each.psnr_db:.1f} dB" if isfinite(each.psnr_db) else "the target itself"


def _added(gain: Gain) -> str:
    return f" ({gain.psnr_db:+.1f})" if isfinite(gain.psnr_db) else ""


def _verdict(chain: Chain) -> str:
    gains = [gain.psnr_db for gain in chain.gains if gain is not None]
    return " - this array gains nothing here" if gains and not max(gains) >= 1.0 else ""


def _numbers(chains: list[Chain], source: str, rays: int) -> dict[str, Any]:
    return {
        "source": source,
        "rays": rays,
        "rigs": {
            chain.name: {
                side: None
                if gain is None
                else {"without": _strict(gain.without), "with": _strict(gain.corrected)}
                for side, gain in zip(SIDES, chain.gains, strict=True)
            }
            for chain in chains
        },
    }


def _strict(each: Likeness) -> dict[str, float | None]:
    """Numbers that JSON has; infinity, the PSNR of equal pictures, is null."""
    return {name: value if isfinite(value) else None for name, value in asdict(each).items()}
