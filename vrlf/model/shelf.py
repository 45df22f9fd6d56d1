"""What ships with vrlf by name: rigs, and the eyes and panels that a rig may name."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Final, Literal

from vrlf.errors import InputError
from vrlf.model.wording import quoted
from vrlf.resources import assets_dir

DEFAULT_RIG: Final = "matched-microlens"

Shelf = Literal["rigs", "eyes", "panels"]
_ONE: Final[dict[Shelf, str]] = {"rigs": "rig", "eyes": "eye", "panels": "panel"}
SHELVES: Final = tuple(_ONE)


def names_on(shelf: Shelf) -> tuple[str, ...]:
    """What ships on a shelf, sorted."""
    return tuple(sorted(path.stem for path in (assets_dir() / shelf).glob("*.toml")))


def shipped(shelf: Shelf, name: str) -> Path:
    """The file of that name on a shelf.

    Raises
    ------
    InputError
        If there is none; the message lists those that there are.
    """
    names = names_on(shelf)
    if name not in names:
        near = difflib.get_close_matches(name, names, n=1)
        hint = f' (did you mean "{near[0]}"?)' if near else ""
        raise InputError(
            f"{_ONE[shelf]}: found the unknown name {quoted(name)}{hint}, "
            f"wanted a path to a .toml file or one of {', '.join(names)}"
        )
    return assets_dir() / shelf / f"{name}.toml"


def summary_of(shelf: Shelf, name: str) -> str:
    """One line on what a shelf holds by that name: the first comment of its file.

    Raises
    ------
    InputError
        If there is no such file.
    """
    first = shipped(shelf, name).read_text(encoding="utf-8").partition("\n")[0]
    return first.removeprefix("#").strip() if first.startswith("#") else "(no description)"


def summaries(shelf: Shelf) -> dict[str, str]:
    """One line on everything on a shelf, by name."""
    return {name: summary_of(shelf, name) for name in names_on(shelf)}


def rig_names() -> tuple[str, ...]:
    """Names of the shipped rigs, sorted."""
    return names_on("rigs")


def shipped_rig(name: str) -> Path:
    """File of the shipped rig ``name``; InputError as `shipped`."""
    return shipped("rigs", name)


def rig_summary(name: str) -> str:
    """One line on the shipped rig ``name``; InputError as `shipped`."""
    return summary_of("rigs", name)


def is_shipped(path: Path) -> bool:
    """Whether a file is one of those on the shelves."""
    return path.parent.parent == assets_dir() and path.parent.name in _ONE


def label(path: Path) -> str:
    """A file in a message: a shipped one by its name, a path so that it can be printed."""
    if is_shipped(path):
        return path.stem
    return str(path) if str(path).isprintable() else ascii(str(path))
