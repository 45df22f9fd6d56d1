"""Rig files: reading them, following ``extends``, laying changes over them."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from vrlf.errors import InputError, RigError
from vrlf.model.cardboard_rig import with_profile
from vrlf.model.complaints import wrong_keys
from vrlf.model.overrides import parse_override
from vrlf.model.parts import laid_over
from vrlf.model.prescription import parse_prescription
from vrlf.model.rig import Rig
from vrlf.model.shelf import label, shipped_rig
from vrlf.model.toml_file import parse_tables, read_tables
from vrlf.model.wording import quoted, shown

_LONGEST_CHAIN: Final = 8

Chain = list[tuple[Path, dict[str, Any]]]
# Tables that are laid over others, the folder that paths in them count from, what they are called.
Layer = tuple[Path, str, Mapping[str, Any]]


def load_rig(
    source: str | Path,
    *,
    overrides: Sequence[str] = (),
    left: str | None = None,
    right: str | None = None,
    both: str | None = None,
) -> Rig:
    """Read a rig and lay the changes of a command line over it.

    Parameters
    ----------
    source : str or Path
        A path (it has a separator or ends in ``.toml``) or a shipped rig's name.
    overrides : sequence of str
        ``table.key=value``; a later one wins. ``panel.extends=NAME`` takes a shipped panel.
    left, right, both : str, optional
        Prescriptions as written on paper. They set sphere, cylinder and axis;
        ``left`` and ``right`` win over ``both``, overrides over all three.

    Returns
    -------
    Rig

    Raises
    ------
    RigError
        If the file, a file it extends or the changes make no rig; all wrong
        keys are named.
    InputError
        If the source names neither a file nor a shipped rig.
    """
    chain = _chain(_located(source, Path()))
    name = " extends ".join(label(path) for path, _ in chain)
    changes = _changes(name, overrides, left=left, right=right, both=both)
    layers = [*_layers(chain), *((Path(), name, change) for change in changes)]
    return rig_from_tables(_laid(layers, name), source=name)


def load_rig_text(text: str, path: Path) -> Rig:
    """A rig from the text of a file that lies, or will lie, at ``path``.

    Raises
    ------
    RigError
        As `load_rig`.
    """
    chain = _chain(path, text.removeprefix("\ufeff"))
    name = " extends ".join(label(each) for each, _ in chain)
    return rig_from_tables(_laid(_layers(chain), name), source=name)


def rig_with(tables: Mapping[str, Any], changes: Mapping[str, Any], *, source: str) -> Rig:
    """A whole rig's tables with changes laid over them, as ``--set`` lays them.

    Raises
    ------
    RigError
        Naming ``source`` and every wrong key.
    """
    layers: list[Layer] = [(Path(), source, tables), (Path(), source, changes)]
    return rig_from_tables(_laid(layers, source), source=source)


def rig_from_tables(tables: Mapping[str, Any], *, source: str = "rig") -> Rig:
    """Validate nested tables, as TOML yields them, into a rig.

    Raises
    ------
    RigError
        Naming ``source`` and every wrong key.
    """
    tables = laid_over({}, tables, Path(), source=source)
    try:
        return Rig.model_validate(tables)
    except ValidationError:
        raise RigError(source, wrong_keys(tables)) from None


def _layers(chain: Chain) -> list[Layer]:
    """The tables of a chain of files, innermost first, each with the folder it counts from."""
    return [(path.parent, label(path), tables) for path, tables in reversed(chain)]


def _laid(layers: Sequence[Layer], name: str) -> dict[str, Any]:
    """Each layer's tables over those before it; a viewer profile stands for the keys it gives.

    A profile says how high the lenses are above the phone's edge. How high that is above the
    panel's middle is the panel's to say, whichever layer gives that.
    """
    panel: dict[str, Any] = {}
    for folder, source, layer in layers:
        given = {key: value for key, value in layer.items() if key == "panel"}
        panel = laid_over(panel, given, folder, source=source)
    tables: dict[str, Any] = {}
    for folder, source, layer in layers:
        try:
            layer = with_profile(layer, _table(panel, "panel"), folder)
        except InputError as error:
            raise RigError(name, [f"headset.{error}"]) from None
        tables = laid_over(_outdated_left_out(tables, layer), layer, folder, source=source)
    return tables


def _table(tables: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """A table, or an empty one where something else stands in its place."""
    table = tables.get(name)
    return table if isinstance(table, Mapping) else {}


def _outdated_left_out(tables: Mapping[str, Any], layer: Mapping[str, Any]) -> Mapping[str, Any]:
    """The tables without what a new layer's lenslet replaces.

    That is the focal length of the one before it, and its surfaces where they are given another
    way: one lens, or lists.
    """
    array, change = tables.get("array"), layer.get("array")
    if not isinstance(array, Mapping) or not isinstance(change, Mapping):
        return tables
    lenslet, old = change.get("lenslet"), array.get("lenslet")
    if not isinstance(lenslet, Mapping):
        return tables
    kept = {key: value for key, value in array.items() if key != "focal_mm"}
    other_way = isinstance(old, Mapping) and ("radii_mm" in lenslet) != ("radii_mm" in old)
    if other_way and not {"radii_mm", "radius_mm"}.isdisjoint(lenslet):
        kept.pop("lenslet")
    return {**tables, "array": kept}


def _located(source: str | Path, folder: Path) -> Path:
    """The file that a path, relative to ``folder``, or a shipped rig's name stands for."""
    if "\0" in str(source):
        raise InputError(f"rig: found a NUL in the path {quoted(str(source))}, wanted a path")
    if isinstance(source, str) and not source.endswith(".toml") and not re.search(r"[/\\]", source):
        return shipped_rig(source)
    return folder / source


def _chain(path: Path, text: str | None = None) -> Chain:
    """The file and those it extends, outermost first, each with its own tables.

    ``text`` stands for what the first file holds.
    """
    chain: Chain = []
    seen: set[str] = set()
    while True:
        tables = _tables(path, text)
        text = None
        seen.add(os.path.realpath(path))
        base = tables.pop("extends", None)
        chain.append((path, tables))
        if base is None:
            return chain
        path = _base(path, base)
        if os.path.realpath(path) in seen:
            raise _extends_error(chain[-1][0], base, "a rig that doesn't lead back to this one")
        if len(chain) >= _LONGEST_CHAIN:
            raise _extends_error(chain[-1][0], base, f"at most {_LONGEST_CHAIN} files in a chain")


def _base(path: Path, base: Any) -> Path:
    if not isinstance(base, str):
        raise _extends_error(path, base, "a shipped rig's name or a path in quotes")
    try:
        return _located(base, path.parent)
    except InputError as error:
        raise RigError(label(path), [f"extends: {error}"]) from None


def _extends_error(path: Path, base: Any, wanted: str) -> RigError:
    return RigError(label(path), [f"extends: found {shown(base)}, wanted {wanted}"])


def _tables(path: Path, text: str | None = None) -> dict[str, Any]:
    """The tables of one rig file, or of the text that stands for it."""
    if text is None:
        return read_tables(path, label(path), "rig file")
    return parse_tables(text, label(path))


def _changes(
    name: str,
    overrides: Sequence[str],
    *,
    left: str | None,
    right: str | None,
    both: str | None,
) -> list[dict[str, Any]]:
    """Tables that the command line's options stand for, in the order of application."""
    options: list[tuple[str, Callable[[str], dict[str, Any]], str | None]] = [
        ("--both", lambda text: _prescribed(text, "left", "right"), both),
        ("--left", lambda text: _prescribed(text, "left"), left),
        ("--right", lambda text: _prescribed(text, "right"), right),
        *(("", parse_override, text) for text in overrides),
    ]
    changes: list[dict[str, Any]] = []
    problems: list[str] = []
    for option, parse, text in options:
        if text is None:
            continue
        try:
            changes.append(parse(text))
        except InputError as error:
            problems.append(f"{option} {error}".strip())
    if problems:
        raise RigError(name, problems)
    return changes


def _prescribed(text: str, *eyes: str) -> dict[str, Any]:
    sphere_d, cylinder_d, axis_deg = parse_prescription(text)
    table = {"sphere_d": sphere_d, "cylinder_d": cylinder_d, "axis_deg": axis_deg}
    return dict.fromkeys(eyes, table)
