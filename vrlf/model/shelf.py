"""The rigs that ship with vrlf, by name."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Final

from vrlf.errors import InputError
from vrlf.model.wording import quoted
from vrlf.resources import assets_dir

DEFAULT_RIG: Final = "matched-microlens"


def rig_names() -> tuple[str, ...]:
    """Names of the shipped rigs, sorted."""
    return tuple(sorted(path.stem for path in (assets_dir() / "rigs").glob("*.toml")))


def shipped_rig(name: str) -> Path:
    """File of the shipped rig ``name``.

    Raises
    ------
    InputError
        If no such rig ships; the message lists those that do.
    """
    names = rig_names()
    if name not in names:
        near = difflib.get_close_matches(name, names, n=1)
        hint = f' (did you mean "{near[0]}"?)' if near else ""
        raise InputError(
            f"rig: found the unknown name {quoted(name)}{hint}, "
            f"wanted a path to a .toml file or one of {', '.join(names)}"
        )
    return assets_dir() / "rigs" / f"{name}.toml"


def is_shipped(path: Path) -> bool:
    """Whether a file is one of the shipped rigs."""
    return path.parent == assets_dir() / "rigs"


def rig_summary(name: str) -> str:
    """One line on the shipped rig ``name``: the first comment of its file.

    Raises
    ------
    InputError
        If no such rig ships.
    """
    first = shipped_rig(name).read_text(encoding="utf-8").partition("\n")[0]
    return first.removeprefix("#").strip() if first.startswith("#") else "(no description)"
