"""What a window remembers from one time to the next, in the user's configuration folder."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, get_args

import platformdirs

from vrlf.app.preview.session import VIEWS, Eyes
from vrlf.errors import VrlfError
from vrlf.files import atomic_write_text, make_folder, shown

VERSION = 1
FOLDER_VARIABLE = "VRLF_CONFIG_DIR"
_NAME = "preview.json"
_BROKEN = "preview.broken.json"
# On a desktop of any size; windows beyond these are no windows.
_LEAST_PX, _MOST_PX = 64, 32_768


@dataclass(frozen=True)
class State:
    """What is remembered.

    Attributes
    ----------
    rig, source : str
        As they were named; empty if none were.
    window_px : (x, y, width, height)
        Its place on the desktop.
    view, eyes : str
    has_panels : bool
    monitor : int
    """

    rig: str = ""
    source: str = ""
    window_px: tuple[int, int, int, int] = (-1, -1, 1280, 720)
    view: str = "perceived"
    eyes: str = "both"
    has_panels: bool = True
    monitor: int = 0


def state_folder() -> Path:
    """The user's folder for vrlf."""
    named = os.environ.get(FOLDER_VARIABLE)
    return Path(named) if named else Path(platformdirs.user_config_dir("vrlf", appauthor=False))


def load_state() -> tuple[State, str | None]:
    """What was remembered, and a message where it could not be read.

    A broken file is set aside, so that it is neither lost nor in the way.
    """
    path = state_folder() / _NAME
    try:
        return _state_of(json.loads(path.read_text(encoding="utf-8"))), None
    except FileNotFoundError:
        return State(), None
    except OSError as error:
        return State(), f"{shown(path)}: found '{error.strerror}', wanted the last window's state"
    except (ValueError, RecursionError) as error:
        return State(), _set_aside(path, " ".join(str(error).split())[:120])


def _set_aside(path: Path, reason: str) -> str:
    aside = path.with_name(_BROKEN)
    try:
        os.replace(path, aside)
    except OSError as error:
        return f"{shown(path)}: found it broken ({reason}) and not movable ({error.strerror})"
    return f"{shown(path)}: found it broken ({reason}); it is {_BROKEN} now, all begins anew"


def save_state(state: State) -> str | None:
    """Remember; a message where that cannot be done."""
    folder = state_folder()
    try:
        make_folder(folder)
        text = json.dumps({"version": VERSION, **asdict(state)}, indent=2)
        atomic_write_text(folder / _NAME, text + "\n")
    except VrlfError as error:
        return str(error)
    return None


def _state_of(found: Any) -> State:
    """The state, every field checked: a file may have been edited.

    Raises
    ------
    ValueError
        If it is none of this version.
    """
    if not isinstance(found, dict) or found.pop("version", None) != VERSION:
        raise ValueError(f"no state of version {VERSION}")
    known = {field.name for field in fields(State)}
    if set(found) - known:
        raise ValueError(f"unknown keys {sorted(set(found) - known)}")
    if isinstance(found.get("window_px"), list):
        found["window_px"] = tuple(found["window_px"])
    state = State(**found)
    _check(state)
    return state


def _check(state: State) -> None:
    box = state.window_px
    whole = isinstance(box, tuple) and len(box) == 4 and all(type(n) is int for n in box)
    if not whole or not all(_LEAST_PX <= n <= _MOST_PX for n in box[2:]):
        raise ValueError("window_px is no place and size")
    if not all(abs(n) <= _MOST_PX for n in box[:2]):
        raise ValueError("window_px is off every desktop")
    if state.view not in VIEWS or state.eyes not in get_args(Eyes):
        raise ValueError("no such view")
    if not (isinstance(state.rig, str) and isinstance(state.source, str)):
        raise ValueError("rig and source are no names")
    if type(state.has_panels) is not bool or type(state.monitor) is not int or state.monitor < 0:
        raise ValueError("has_panels or monitor is of another type")
