"""``vrlf render``: the live window's frames without a window, into files."""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from vrlf import __version__
from vrlf.app.encoder import Encoder
from vrlf.app.options import (
    json_option,
    put_json,
    rays_option,
    rig_choice,
    rig_options,
    say,
    say_of_wavefronts,
    whole_number,
)
from vrlf.app.preview.layout import PICTURES
from vrlf.app.sources import (
    SourceOptions,
    open_live,
    require_picture_size,
    require_source,
    source_options,
)
from vrlf.content.video import FilmWriter
from vrlf.errors import InputError, OutputPathError
from vrlf.files import atomic_write_text, check_target, make_folder, shown
from vrlf.gpu import Device, Texture
from vrlf.images import read_codes, write_encoded, write_picture
from vrlf.model import Rig
from vrlf.model.saving import rig_text
from vrlf.renderer import DEFAULT_RAYS, Stream
from vrlf.renderer.live import Live
from vrlf.scene import HeadPose
from vrlf.scene.path import HeadPath, head_at, load_path

_MANIFEST = "render.json"
_FILM = ".mkv"
_OURS = re.compile(rf"({'|'.join(PICTURES)})_[0-9]{{6,}}\.(png|exr)")
_LOOKS = frozenset({"perceived", "uncorrected"})


@dataclass(frozen=True)
class Job:
    """What is rendered; frames of the same job are the same bytes.

    Attributes
    ----------
    rig : Rig
    source : str
    options : SourceOptions
    frames : int
    rate_hz, start_s : float
    path : HeadPath or None
    whats : tuple of str
        Of ``panel``, ``perceived``, ``uncorrected``, ``target``.
    rays : int
    ending : str
        ``.png`` or ``.exr``.
    is_film : bool
        Whether the frames are for a film, which has 8 bits a colour.
    """

    rig: Rig
    source: str
    options: SourceOptions
    frames: int
    rate_hz: float
    start_s: float
    path: HeadPath | None
    whats: tuple[str, ...]
    rays: int
    ending: str
    is_film: bool

    def bits(self, what: str) -> int:
        """Of each colour in a PNG: the panel's own in a panel image."""
        return self.rig.panel.bits if what == "panel" and not self.is_film else 8

    def manifest(self) -> str:
        """All that the frames depend on, for a later run to compare."""
        told = {
            "vrlf": __version__,
            "rig": rig_text(self.rig),
            "sources": [_stamp(name) for name in (self.source, self.options.right_source) if name],
            "options": repr(self.options),
            "rate_hz": self.rate_hz,
            "start_s": self.start_s,
            "path": repr(self.path),
            "rays": self.rays,
        }
        return json.dumps(told, indent=2) + "\n"


def _stamp(source: str) -> list[Any]:
    """A source and what changes when its file is written."""
    path = Path(source)
    if not path.exists():
        return [source]
    found = path.stat()
    return [str(path.resolve()), found.st_size, found.st_mtime_ns]


def _whats(text: str) -> tuple[str, ...]:
    names = tuple(dict.fromkeys(part.strip() for part in text.split(",")))
    for name in names:
        if name not in PICTURES:
            raise click.BadParameter(f"found {name[:40]!r}, wanted some of {', '.join(PICTURES)}")
    return names


def _positive(least: float, most: float) -> Any:
    def convert(text: str | float) -> float:
        try:
            number = float(text)
        except ValueError:
            number = float("nan")
        if not least <= number <= most:
            raise click.BadParameter(f"found {str(text)[:40]!r}, wanted {least:g} to {most:g}")
        return number

    return convert


@click.command(short_help="The window's frames without a window, into files or a film.")
@click.argument("source")
@rig_options
@click.option(
    "--frames", type=whole_number(1, 1_000_000), required=True, metavar="N", help="How many."
)
@click.option(
    "-o",
    "--output",
    required=True,
    metavar="PLACE",
    help="A folder for numbered files, or a film's name ending in .mkv (lossless FFV1).",
)
@click.option(
    "--what",
    "whats",
    type=_whats,
    default="panel",
    show_default=True,
    metavar="A,B",
    help=f"Some of {', '.join(PICTURES)}; uncorrected is what the eyes see of the target itself "
    "on the panel without its array.",
)
@click.option(
    "--format",
    "ending",
    type=click.Choice(["png", "exr"]),
    default="png",
    show_default=True,
    help="Of numbered files: sRGB in 8 bits (the panel's own for a panel image), or linear floats.",
)
@click.option(
    "--fps",
    "rate_hz",
    type=_positive(0.01, 1000.0),
    default=30.0,
    show_default=True,
    metavar="HZ",
    help="Frames a second.",
)
@click.option(
    "--start",
    "start_s",
    type=_positive(0.0, 1e6),
    default=0.0,
    show_default=True,
    metavar="S",
    help="The first frame's time.",
)
@click.option(
    "--path",
    "path_name",
    metavar="PATH",
    help="Where the head goes: 'orbit', or a .json file with key poses. It rests without one.",
)
@click.option(
    "--restart", is_flag=True, help="Begin anew, whatever an earlier run left in its place."
)
@rays_option(DEFAULT_RAYS)
@source_options
@json_option
def render(
    source: str,
    frames: int,
    output: str,
    whats: tuple[str, ...],
    ending: str,
    rate_hz: float,
    start_s: float,
    path_name: str | None,
    restart: bool,
    rays: int,
    as_json: bool,
    **options: Any,
) -> None:
    """Render N frames of SOURCE as 'vrlf preview' shows them, headless.

    Stopped half-way, the same command goes on where it stood: frames that are whole are kept.
    Each frame depends on its own time alone ('optimal' starts each one cold), so that a run that
    was stopped leaves the same bytes as one that was not.

    \b
    Examples:
      vrlf render scene --frames 240 --path orbit -o frames/
      vrlf render film_sbs.mp4 --frames 100 --what panel,perceived -o out.mkv --both "-4.50"
    """
    rig = rig_choice(options).load()
    say_of_wavefronts(rig)
    require_picture_size(rig)
    path = load_path(path_name) if path_name is not None else None
    is_film = Path(output).suffix.lower() == _FILM
    if is_film and ending == "exr":
        raise InputError("--format: found exr for a film, wanted png, or a folder for the output")
    given = SourceOptions(**options)
    require_source(source)
    # A limit on time would make a frame depend on the machine's speed.
    unhurried = rig.prefilter.model_copy(update={"budget_ms": None})
    rig = rig.model_copy(update={"prefilter": unhurried})
    job = Job(
        rig, source, given, frames, rate_hz, start_s, path, whats, rays, f".{ending}", is_film
    )  # fmt: skip
    if is_film:
        for name in _films(output, whats):
            check_target(name)
    folder = make_folder(f"{output}.frames" if is_film else output)
    check_target(folder / _MANIFEST)
    _claim(folder, job, restart=restart)
    done = _render(folder, job)
    written = [str(folder)]
    if is_film:
        written = _assemble(output, folder, job)
    for name in written:
        say(f"wrote {shown(name)}")
    if as_json:
        put_json({"output": written, "frames": frames, "rendered": done, "kept": frames - done})


def _claim(folder: Path, job: Job, *, restart: bool) -> None:
    """Make sure that what lies in the folder comes from the same job, or begin anew."""
    manifest = folder / _MANIFEST
    if manifest.exists() and not restart:
        try:
            is_same = manifest.read_text(encoding="utf-8") == job.manifest()
        except (OSError, UnicodeDecodeError):
            is_same = False
        if not is_same:
            raise OutputPathError(
                f"{shown(folder)}: found frames of another rig, source or time, wanted an empty "
                "folder, or --restart"
            )
        return
    if not restart and any(_frames_in(folder)):
        raise OutputPathError(
            f"{shown(folder)}: found numbered frames that no run has noted, wanted an empty "
            "folder, or --restart, which takes them away"
        )
    _empty(folder)
    atomic_write_text(manifest, job.manifest())


def _file(folder: Path, what: str, index: int, job: Job) -> Path:
    return folder / f"{what}_{index + 1:06d}{job.ending}"


def _render(folder: Path, job: Job) -> int:
    """Render what is not there yet; how many frames that were."""
    missing = [
        index
        for index in range(job.frames)
        if not all(_file(folder, what, index, job).exists() for what in job.whats)
    ]
    if len(missing) < job.frames:
        say(
            f"{shown(folder)}: {job.frames - len(missing)} of {job.frames} frames are there already"
        )
    if not missing:
        return 0
    with ExitStack() as owned:
        device = owned.enter_context(Device.headless())
        live = open_live(job.source, job.rig, device, job.options)
        owned.callback(live.release)
        rays = job.rays if _LOOKS & set(job.whats) else None
        stream = owned.enter_context(
            Stream(device, job.rig, rays=rays, uncorrected="uncorrected" in job.whats)
        )
        encoder = Encoder(device, job.rig)
        owned.callback(encoder.release)
        for index in _told(missing):
            _frame(stream, live, job, index)
            for what in job.whats:
                place = _file(folder, what, index, job)
                _write(place, _picture(stream, what), encoder, job.bits(what))
        if live.fault:
            say(live.fault)
    return len(missing)


def _told(indices: list[int]) -> Iterator[int]:
    """With a bar on standard error where that is a terminal."""
    console = Console(stderr=True)
    columns = (TextColumn("frames"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    if not console.is_terminal:
        yield from indices
        return
    with Progress(*columns, console=console) as progress:
        yield from progress.track(indices)


def _frame(stream: Stream, live: Live, job: Job, index: int) -> None:
    """Everything that a frame may be asked for, depending on its own time alone."""
    time_s = job.start_s + index / job.rate_hz
    head = head_at(job.path, time_s) if job.path is not None else HeadPose()
    stream.begin()
    stream.forget()
    shown_s = time_s % live.duration_s if live.duration_s is not None else time_s
    live.draw(stream.target, job.rig, time_s=shown_s, head=head)
    if {"panel", "perceived"} & set(job.whats):
        stream.show()
    if "perceived" in job.whats:
        stream.look()
    if "uncorrected" in job.whats:
        stream.look_uncorrected()


def _picture(stream: Stream, what: str) -> Texture:
    match what:
        case "panel":
            return stream.panel
        case "perceived":
            return stream.seen
        case "uncorrected":
            return stream.seen_uncorrected
        case _:
            return stream.target


def _write(path: Path, light: Texture, encoder: Encoder, bits: int) -> None:
    if path.suffix == ".exr" or bits != 8:
        write_picture(path, np.asarray(light.read()[..., :3], np.float32), bits=bits)
    else:
        write_encoded(path, encoder.codes(light))


def _films(output: str, whats: tuple[str, ...]) -> list[str]:
    """A film for each: NAME.mkv for one, NAME_panel.mkv and so on for several."""
    if len(whats) == 1:
        return [output]
    path = Path(output)
    return [str(path.with_name(f"{path.stem}_{what}{path.suffix}")) for what in whats]


def _assemble(output: str, folder: Path, job: Job) -> list[str]:
    """The films of the frames, whole; then the frames go."""
    size = (job.rig.panel.width_px, job.rig.panel.height_px)
    names = _films(output, job.whats)
    for name, what in zip(names, job.whats, strict=True):
        with FilmWriter(name, size, job.rate_hz) as film:
            for index in range(job.frames):
                film.add(read_codes(_file(folder, what, index, job)))
    _empty(folder)
    (folder / _MANIFEST).unlink()
    with contextlib.suppress(OSError):  # something of the user's lies in it
        folder.rmdir()
    return names


def _empty(folder: Path) -> None:
    """Take away the frames that earlier runs left."""
    for old in list(_frames_in(folder)):
        old.unlink()


def _frames_in(folder: Path) -> Iterator[Path]:
    """Files named as ours are, and no others: ``panel_1_final.png`` is the user's."""
    for path in folder.iterdir():
        if _OURS.fullmatch(path.name):
            yield path
