"""``vrlf preview``: the live window."""

from __future__ import annotations

import importlib.util
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from vrlf.app.options import (
    RigChoice,
    rays_option,
    rig_choice,
    rig_options,
    say,
    say_of_wavefronts,
    whole_number,
)
from vrlf.app.preview.session import VIEWS, Session
from vrlf.app.preview.state import State, load_state, save_state
from vrlf.app.serving import require_server
from vrlf.app.sources import SCENE, SourceOptions, is_chart, open_live, source_options
from vrlf.errors import DeviceError, InputError
from vrlf.files import check_target, shown
from vrlf.model import Rig
from vrlf.renderer import DEFAULT_RAYS


@dataclass(frozen=True)
class Wish:
    """What is to be shown, and how, before there is a window.

    Attributes
    ----------
    source : str
    options : SourceOptions
    choice : RigChoice
    session : Session
    state : State
        The last window's, with what the command line changes.
    folder : Path
        For screenshots and new rigs.
    rays : int
    fullscreen : bool
    phone_host : str or None
        Where to listen for a phone, if one is to be served.
    """

    source: str
    options: SourceOptions
    choice: RigChoice
    session: Session
    state: State
    folder: Path
    rays: int
    fullscreen: bool
    phone_host: str | None = None


@click.command(short_help="The live window: prescriptions by keyboard, both eyes' views.")
@click.argument("source", required=False)
@rig_options
@source_options
@rays_option(DEFAULT_RAYS)
@click.option("--view", type=click.Choice(list(VIEWS)), help="What is shown first; keys change it.")
@click.option("--fullscreen", is_flag=True, help="Begin fullscreen (F11 changes it).")
@click.option(
    "--monitor",
    type=whole_number(1, 64),
    metavar="N",
    help="The monitor for fullscreen, counted from 1 (a phone that is connected as one).",
)
@click.option(
    "--phone",
    is_flag=True,
    help="Serve the panel image to a phone too, as 'vrlf serve' does; P shows its QR code.",
)
@click.option(
    "--host",
    default="127.0.0.1",
    show_default=True,
    metavar="ADDRESS",
    help="With --phone: the address to listen on, 0.0.0.0 for a phone on the same network.",
)
@click.option(
    "--folder",
    default=".",
    show_default=True,
    metavar="DIR",
    help="Where screenshots and new rig files go.",
)
def preview(
    source: str | None,
    rays: int,
    view: Any,
    fullscreen: bool,
    monitor: int | None,
    phone: bool,
    host: str,
    folder: str,
    **options: Any,
) -> None:
    """Show SOURCE live, and what both eyes see of it, while keys change their prescriptions.

    SOURCE is what 'vrlf prefilter' takes: a picture, 'scene' (which moves) or 'chart:NAME'. Without
    one, and without a rig, the last window's are shown again. F1 lists every key.

    \b
    Examples:
      vrlf preview
      vrlf preview photo_sbs.jpg --left "-5.00 / -1.25 x 170" --right "-4.50"
      vrlf preview chart:logmar -r mine.toml --view panel --fullscreen --monitor 2
    """
    _require_panels()
    state, message = load_state()
    _say_if(message)
    is_rig_given = (
        click.get_current_context().get_parameter_source("rig_name") != ParameterSource.DEFAULT
    )
    choice, rig = _first_rig(rig_choice(options), state, is_given=is_rig_given)
    say_of_wavefronts(rig)
    check_target(Path(folder) / "vrlf.png")
    seen: Any = {"view": view or state.view, "eyes": state.eyes, "has_panels": state.has_panels}
    wish = Wish(
        source=source or _last_source(state),
        options=SourceOptions(**options),
        choice=choice,
        session=Session(rig=rig, loaded=rig, **seen),
        state=state if monitor is None else replace(state, monitor=monitor - 1),
        folder=Path(folder),
        rays=rays,
        fullscreen=fullscreen,
        phone_host=host if phone else None,
    )
    _say_if(save_state(show(wish)))


def show(wish: Wish) -> State:
    """Open the window and run until it is left; what to remember."""
    # The panels' library names the glfw that the window must load: it is imported first.
    from vrlf.app.preview.files import Files
    from vrlf.app.preview.loop import Opening, Preview
    from vrlf.gpu.window import Window

    with ExitStack() as owned:
        window = owned.enter_context(
            Window(wish.state.window_px[2:], "vrlf", place_px=_place(wish.state))
        )
        device = owned.enter_context(window.device())
        live = open_live(wish.source, wish.session.rig, device, wish.options)
        owned.callback(live.release)
        files = Files(wish.choice, wish.folder)
        opening = Opening(wish.rays, wish.state.monitor, wish.fullscreen)
        preview = Preview(window, device, wish.session, live, files, opening)
        owned.callback(preview.release)
        if wish.phone_host is not None:
            _serve_phone(preview, device, wish, wish.phone_host, owned)
        session = preview.run()
        return State(
            rig=_lasting(files.name),
            source=_lasting(wish.source),
            window_px=window.windowed_box_px,
            view=session.view,
            eyes=session.eyes,
            has_panels=session.has_panels,
            monitor=preview.monitor,
        )


def _serve_phone(preview: Any, device: Any, wish: Wish, host: str, owned: ExitStack) -> None:
    """Let the window have a phone that shows its panel image too."""
    require_server("preview --phone")
    from vrlf.app.preview.companion import Companion
    from vrlf.app.serve.loop import Broadcast
    from vrlf.app.serve.mirrored import Mirrored
    from vrlf.app.serve.where import Where

    where = Where(host, 0, None, None)
    owned.callback(where.close)
    mirrored = Mirrored(preview, device, wish.folder, wish.choice.name)
    owned.callback(mirrored.release)
    broadcast = Broadcast(mirrored, where.plan_of(preview.session.rig, "auto"), [where.socket])
    owned.callback(broadcast.release)
    preview.companion = Companion(broadcast, where.modules())
    preview.session = replace(preview.session, has_phone=True)
    for line in where.words(has_qr=False):
        say(line)
    say(where.url)


def _require_panels() -> None:
    if importlib.util.find_spec("imgui_bundle") is None:
        raise DeviceError(
            "preview: found no imgui-bundle, wanted it for the window's panels; "
            "pip install 'vrlf[window]'"
        )


def _first_rig(choice: RigChoice, state: State, *, is_given: bool) -> tuple[RigChoice, Rig]:
    """The rig that was named, or the last window's, if that is still there."""
    if not is_given and state.rig:
        last = replace(choice, name=state.rig)
        try:
            return last, last.load()
        except InputError as error:
            say(f"the last window's rig: {error}; {choice.name} instead")
    return choice, choice.load()


def _last_source(state: State) -> str:
    """The last window's source, if it is still there."""
    if not state.source or state.source == SCENE or is_chart(state.source):
        return state.source or SCENE
    if Path(state.source).exists():
        return state.source
    say(f"the last window's source: found no {shown(state.source)}; {SCENE} instead")
    return SCENE


def _lasting(name: str) -> str:
    """A name that means the same from another folder."""
    return str(Path(name).resolve()) if Path(name).exists() else name


def _place(state: State) -> tuple[int, int] | None:
    x, y = state.window_px[:2]
    return None if (x, y) == State().window_px[:2] else (x, y)


def _say_if(message: str | None) -> None:
    if message:
        say(message)
