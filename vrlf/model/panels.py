"""Panels of real phones and headsets, by name: ``[panel] extends = "iphone-6"``."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from typing import Any

from vrlf.errors import RigError
from vrlf.model.overrides import merged
from vrlf.model.toml_file import read_tables
from vrlf.model.wording import shown
from vrlf.resources import assets_dir


def panel_names() -> tuple[str, ...]:
    """Names of the shipped panels, sorted."""
    return tuple(sorted(path.stem for path in (assets_dir() / "panels").glob("*.toml")))


def laid_over(
    tables: Mapping[str, Any], change: Mapping[str, Any], *, source: str
) -> dict[str, Any]:
    """A rig's tables with a change over them, key by key.

    A change that names a shipped panel takes the whole of it: no key of another panel below
    shines through.

    Raises
    ------
    RigError
        Naming ``source``, if no panel of that name ships.
    """
    panel = change.get("panel")
    if not isinstance(panel, Mapping) or "extends" not in panel:
        return merged(tables, change)
    own = {key: value for key, value in panel.items() if key != "extends"}
    below = {key: value for key, value in tables.items() if key != "panel"}
    whole = merged(_shipped(panel["extends"], source), own)
    return merged(below, {**change, "panel": whole})


def _shipped(name: Any, source: str) -> dict[str, Any]:
    """The keys of a shipped panel."""
    names = panel_names()
    if not isinstance(name, str) or name not in names:
        near = difflib.get_close_matches(str(name), names, n=1)
        hint = f' (did you mean "{near[0]}"?)' if near else ""
        wanted = ", ".join(map(shown, names))
        problem = f"panel.extends: found {shown(name)}{hint}, wanted one of {wanted}"
        raise RigError(source, [problem])
    return read_tables(assets_dir() / "panels" / f"{name}.toml", f"panels/{name}.toml", "panel")
