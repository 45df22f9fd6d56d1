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
from vrlf.model.shelf import Shelf, shipped
from vrlf.model.toml import label, tables_of
from vrlf.model.wavefront_file import wavefront_table
from vrlf.model.wording import shown

_SHELVES: Final[dict[str, Shelf]] = {"left": "eyes", "right": "eyes", "panel": "panels"}


def laid_over(base: Mapping[str, Any], layer: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Tables of ``base`` with those of a layer over them, and what the layer leans on filled in.

    A table that extends another takes its place whole: nothing of the base's is left in it.

    Parameters
    ----------
    folder : Path
        From which the layer's relative paths are found.

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
            below[name], table = _extended(name, shelf, table, folder)
        if shelf == "eyes":
            table = _with_wavefront(name, table, folder)
        above[name] = table
    return merged(below, above)


def _extended(
    name: str, shelf: Shelf, table: Mapping[str, Any], folder: Path
) -> tuple[dict[str, Any], dict[str, Any]]:
    """The table that one extends, and what is left of this one."""
    path = _located(name, shelf, table["extends"], folder)
    base = tables_of(path)
    if "extends" in base:
        raise RigError(label(path), ["extends: found it, wanted a table that stands by itself"])
    if shelf == "eyes":
        base = _with_wavefront(name, base, path.parent)
    return base, {key: value for key, value in table.items() if key != "extends"}


def _located(name: str, shelf: Shelf, value: Any, folder: Path) -> Path:
    if not isinstance(value, str) or "\0" in value:
        raise InputError(f"{name}.extends: found {shown(value)}, wanted a name or a path in quotes")
    if value.endswith(".toml") or re.search(r"[/\\]", value):
        return folder / value
    try:
        return shipped(shelf, value)
    except InputError as error:
        raise InputError(f"{name}.extends: {error}") from None


def _with_wavefront(name: str, eye: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """An eye's table whose wavefront's file, if it names one, has been read."""
    zernike = eye.get("zernike")
    if not isinstance(zernike, Mapping) or "file" not in zernike:
        return dict(eye)
    rest = {key: value for key, value in zernike.items() if key != "file"}
    for other in ("coefficients", "coefficients_um"):
        if other in rest:
            raise InputError(
                f'{name}.zernike.file: found it beside "{other}", wanted one of the two'
            )
    file = zernike["file"]
    if not isinstance(file, str) or not file or "\0" in file:
        raise InputError(f"{name}.zernike.file: found {shown(file)}, wanted a path in quotes")
    read = wavefront_table(folder / file, rest.get("wavelength_nm"))
    return {**eye, "zernike": {**rest, "coefficients_um": read}}
