"""What can stand where a command wants a SOURCE: a picture, the shipped scene, a chart."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np

from vrlf.app.options import Command, say
from vrlf.content.charts import CHART_NAMES
from vrlf.content.panorama import load_panorama
from vrlf.content.pictures import StereoSource, join_viewports, load_stereo
from vrlf.content.video import FILM_ENDINGS, Film
from vrlf.errors import InputError
from vrlf.files import shown
from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.optics.fitting import FitMode
from vrlf.renderer import GpuRenderer, Image, Renderer
from vrlf.renderer.live import Chart, Drawn, FilmShown, Live, Picture, World, chart_light
from vrlf.resources import assets_dir
from vrlf.scene import MODEL_ENDINGS, HeadPose, ModelScene, Panorama, Scene, render_stereo

SCENE = "scene"
SHIPPED_SCENES = ("orrery",)
CHART_PREFIX = "chart:"
_PANORAMA_HINT = "_360"
# What a picture file here can have at most, so that it can be written and read again.
_MOST_SIDE_PX = 16384
_MOST_PX = 2**29 // 3


_LAYOUTS = ["auto", "mono", "side-by-side", "half-side-by-side", "over-under", "half-over-under"]
encoding_option = click.option(
    "--encoding",
    type=click.Choice(["auto", "srgb", "linear"]),
    default="auto",
    show_default=True,
    help="What the file's numbers mean. auto: EXR, HDR and floats are linear, the rest is sRGB.",
)


def source_options(command: Command) -> Command:
    """How a picture is to be taken; ``SourceOptions`` holds what was said."""
    for option in reversed(
        (
            click.option(
                "--layout",
                type=click.Choice(_LAYOUTS),
                default="auto",
                show_default=True,
                help="How a stereo picture lies in its file; half-...: each eye's is squeezed to "
                "half its width or height. auto goes by size, name (_sbs, _hsbs, _lr, _ou, _tb, "
                "_hou, _htb, .jps) and shape: wider than 2.4 to 1 is side-by-side, all else mono.",
            ),
            click.option("--cross-eyed", is_flag=True, help="The right eye's picture comes first."),
            click.option(
                "--right-source",
                metavar="FILE",
                help="A picture of its own for the right eye; SOURCE is then the left eye's.",
            ),
            click.option(
                "--fit",
                type=click.Choice(["contain", "cover", "axis"]),
                default="contain",
                show_default=True,
                help="contain shows all of the picture; cover fills all of the eye's view and cuts "
                "the rest; axis shows all of it straight ahead, about the lens's axis, which is "
                "easier to fuse.",
            ),
            click.option(
                "--panorama",
                is_flag=True,
                help="SOURCE is a panorama of 360 by 180 degrees: 2:1, or over-under 1:1. A file "
                "with _360 in its name is taken for one anyway.",
            ),
            encoding_option,
        )
    ):
        command = option(command)
    return command


@dataclass(frozen=True)
class SourceOptions:
    """How a picture is to be taken."""

    layout: Any = "auto"
    cross_eyed: bool = False
    right_source: str | None = None
    encoding: Any = "auto"
    fit: FitMode = "contain"
    panorama: bool = False


def target_of(source: str, rig: Rig, renderer: Renderer, options: SourceOptions) -> Image:
    """The target on the panel's raster.

    Parameters
    ----------
    source : str
        A picture's path; ``scene``; or ``chart:NAME``. A file of that very name goes first.
    """
    if not _is_there(source):
        if source == SCENE:
            return scene_target(rig, renderer)
        if source in SHIPPED_SCENES:
            return live_target(source, rig, renderer, options)
        if source.startswith(CHART_PREFIX):
            return chart_light(source.removeprefix(CHART_PREFIX), rig)
        if source in CHART_NAMES:
            raise InputError(
                f"{shown(source)}: found no such file, wanted one; the chart is chart:{source}"
            )
    if is_moving(source, options):
        return live_target(source, rig, renderer, options)
    return renderer.target(_picture(source, rig, options), rig, options.fit)


def open_live(source: str, rig: Rig, device: Device, options: SourceOptions) -> Live:
    """The same, to be shown frame after frame."""
    if not _is_there(source):
        if source == SCENE:
            return Drawn(Scene(device))
        if source in SHIPPED_SCENES:
            return Drawn(ModelScene(device, assets_dir() / "scenes" / f"{source}.glb"))
        if source.startswith(CHART_PREFIX):
            name = source.removeprefix(CHART_PREFIX)
            chart_light(name, rig)  # an unknown name is said now
            return Chart(name)
    if _is_model(source):
        scene = ModelScene(device, source)
        for note in scene.notes:
            say(f"{shown(source)}: {note}")
        return Drawn(scene)
    if options.right_source is not None and is_moving(source, options):
        raise InputError(
            f"--right-source: found {shown(options.right_source)} beside {shown(source)}, wanted "
            "it with a picture alone; films and panoramas hold both eyes' in one file"
        )
    if _is_film(source):
        film = Film(source, layout=options.layout, cross_eyed=options.cross_eyed)
        size = (
            f"{film.size_px[0]}x{film.size_px[1]}, {film.rate_hz:.4g} Hz, {film.duration_s:.1f} s"
        )
        say(f"{shown(source)}: taken as a film, {film.layout}, {options.fit} ({size})")
        return FilmShown(device, film, options.fit)
    if _is_panorama(source, options):
        say(f"{shown(source)}: taken as a panorama")
        left, right = load_panorama(source, layout=options.layout, encoding=options.encoding)
        return World(Panorama(device, left, right))
    return Picture(device, _picture(source, rig, options), options.fit)


def is_moving(source: str, options: SourceOptions) -> bool:
    """Whether what it shows depends on the head or the time."""
    return _is_film(source) or _is_model(source) or _is_panorama(source, options)


def _is_model(source: str) -> bool:
    return Path(source).suffix.lower() in MODEL_ENDINGS


def _is_film(source: str) -> bool:
    return Path(source).suffix.lower() in FILM_ENDINGS


def _is_panorama(source: str, options: SourceOptions) -> bool:
    return options.panorama or _PANORAMA_HINT in Path(source).stem.lower()


def live_target(source: str, rig: Rig, renderer: Renderer, options: SourceOptions) -> Image:
    """What a moving source shows at its beginning to a head at rest; always on a GPU."""
    with ExitStack() as owned:
        if isinstance(renderer, GpuRenderer):
            device = renderer.device
            device.make_current()
        else:
            device = owned.enter_context(Device.headless())
        live = open_live(source, rig, device, options)
        owned.callback(live.release)
        target = Texture(device, (rig.panel.width_px, rig.panel.height_px), label="target")
        owned.callback(target.release)
        live.draw(target, rig, time_s=0.0, head=HeadPose())
        return np.ascontiguousarray(target.read()[..., :3], np.float32)


def _picture(source: str, rig: Rig, options: SourceOptions) -> StereoSource:
    """A picture from a file; says what it was taken for."""
    picture = load_stereo(
        source,
        panel_size=(rig.panel.width_px, rig.panel.height_px),
        layout=options.layout,
        cross_eyed=options.cross_eyed,
        right_path=options.right_source,
        encoding=options.encoding,
    )
    how = "pixel for pixel" if picture.panel is not None else f"{picture.layout}, {options.fit}"
    say(f"{shown(source)}: taken as {how}")
    _say_clipped(source, picture)
    return picture


def require_source(source: str) -> None:
    """Refuse a source that is not there, before anything is made for it."""
    names = (SCENE, *SHIPPED_SCENES)
    if not (_is_there(source) or source in names or is_chart(source)):
        raise InputError(f"{shown(source)}: found no such file or scene, wanted one to show")


def is_chart(source: str) -> bool:
    """Whether it names a chart."""
    return source.startswith(CHART_PREFIX)


def _is_there(path: str) -> bool:
    try:
        return Path(path).exists()
    except (OSError, ValueError):  # too long for a name, or with a NUL: reading it says so
        return False


def require_picture_size(rig: Rig) -> None:
    """Refuse a panel too large for a picture file, before anything is made for it."""
    width, height = rig.panel.width_px, rig.panel.height_px
    if max(width, height) > _MOST_SIDE_PX or width * height > _MOST_PX:
        raise InputError(
            f"panel: found {width}x{height} pixels, wanted at most {_MOST_SIDE_PX} a side and "
            f"{_MOST_PX // 10**6} million in all"
        )


def _say_clipped(source: str, picture: StereoSource) -> None:
    """A panel cannot show more than its full drive; say so where a picture asks for it."""
    beyond = sum(
        int(np.count_nonzero((p < 0.0) | (p > 1.0))) for p in (picture.left, picture.right)
    )
    if beyond:
        share = 100.0 * beyond / (picture.left.size + picture.right.size)
        say(f"{shown(source)}: {share:.2g} % of the values lie outside 0 to 1 and are clipped")


def scene_target(rig: Rig, renderer: Renderer) -> Image:
    """The shipped stereo scene, drawn for this rig's eyes; always on a GPU."""
    if isinstance(renderer, GpuRenderer):
        eyes = render_stereo(renderer.device, rig)
    else:
        with GpuRenderer() as own:
            eyes = render_stereo(own.device, rig)
    return as_target(eyes[0], eyes[1], rig)


def as_target(left: Image, right: Image, rig: Rig) -> Image:
    """Both viewports on the panel."""
    return join_viewports(left, right, (rig.panel.width_px, rig.panel.height_px))
