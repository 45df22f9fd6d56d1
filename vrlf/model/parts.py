"""Tables of a rig that lean on other files: an eye or a panel by name, a measured wavefront.

``extends`` within [left], [right] or [panel] takes a whole table from elsewhere, of which the
rig changes what it gives itself; ``file`` within an eye's zernike table reads a CSV. Both are
found from where the rig lies.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from vrlf.errors import InputError, RigError
from vrlf.model.overrides import merged
from vrlf.model.shelf import Shelf, label, names_on, shipped
from vrlf.model.toml_file import read_tables
from vrlf.model.wavefront_file import wavefront_table
from vrlf.model.wording import shown

_SHELVES: Final[dict[str, Shelf]] = {"left": "eyes", "right": "eyes", "panel": "panels"}


def laid_over(
    base: Mapping[str, Any], layer: Mapping[str, Any], folder: Path, *, source: str
) -> dict[str, Any]:
    """Tables of ``base`` with those of a layer over them, and what the layer leans on filled in.

    A table that extends another takes its place whole: nothing of the base's is left in it.

    Parameters
    ----------
    folder : Path
        From which the layer's relative paths are found.
    source : str
        What messages call the layer.

    Raises
    ------
    RigError
        If a file it leans on is missing or wrong.
    """
    below, above = dict(base), dict(layer)
    for name, shelf in _SHELVES.items():
        table = above.get(name)
        if not isinstance(table, Mapping):
            continue
        if "extends" in table:
            below[name], table = _extended(name, shelf, table, folder, source)
        if shelf == "eyes":
            table = _with_wavefront(name, table, folder, source)
        above[name] = table
    return merged(below, above)


def _extended(
    name: str, shelf: Shelf, table: Mapping[str, Any], folder: Path, source: str
) -> tuple[dict[str, Any], dict[str, Any]]:
    """The table that one extends, and what is left of this one."""
    path = _located(name, shelf, table["extends"], folder, source)
    base = read_tables(path, label(path), f"file of a{'n' if shelf == 'eyes' else ''} {shelf[:-1]}")
    if "extends" in base:
        raise RigError(label(path), ["extends: found it, wanted a table that stands by itself"])
    if shelf == "eyes":
        base = _with_wavefront(name, base, path.parent, label(path))
    return base, {key: value for key, value in table.items() if key != "extends"}


def _located(name: str, shelf: Shelf, value: Any, folder: Path, source: str) -> Path:
    if not isinstance(value, str) or "\0" in value:
        problem = f"{name}.extends: found {shown(value)}, wanted {_wanted(shelf)}"
        raise RigError(source, [problem])
    if value.endswith(".toml") or re.search(r"[/\\]", value):
        return folder / value
    try:
        return shipped(shelf, value)
    except InputError as error:
        raise RigError(source, [f"{name}.extends: {str(error).partition(': ')[2]}"]) from None


def _wanted(shelf: Shelf) -> str:
    return f"a path to a .toml file or one of {', '.join(names_on(shelf))}"


def _with_wavefront(name: str, eye: Mapping[str, Any], folder: Path, source: str) -> dict[str, Any]:
    """An eye's table whose wavefront's file, if it names one, has been read."""
    zernike = eye.get("zernike")
    if not isinstance(zernike, Mapping) or "file" not in zernike:
        return dict(eye)
    rest = {key: value for key, value in zernike.items() if key != "file"}
    for other in ("coefficients", "coefficients_um"):
        if other in rest:
            problem = f'{name}.zernike.file: found it beside "{other}", wanted one of the two'
            raise RigError(source, [problem])
    file = zernike["file"]
    if not isinstance(file, str) or not file or "\0" in file:
        problem = f"{name}.zernike.file: found {shown(file)}, wanted a path in quotes"
        raise RigError(source, [problem])
    read = wavefront_table(folder / file, rest.get("wavelength_nm"))
    return {**eye, "zernike": {**rest, "coefficients_um": read}}
