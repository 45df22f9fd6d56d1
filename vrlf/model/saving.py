"""Writing a rig back into its file: only what has changed, every comment kept."""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import Comment, Table, Whitespace

from vrlf.errors import InputError, RigError
from vrlf.files import atomic_write_text, shown
from vrlf.model.reading import load_rig_text
from vrlf.model.rig import Rig
from vrlf.model.shelf import is_shipped

Tables = Mapping[str, Any]


def rig_tables(rig: Rig) -> dict[str, Any]:
    """A rig as nested tables, as TOML would yield them; what is not given is left out."""
    tables = rig.model_dump(mode="json", by_alias=True, exclude_none=True)
    return {key: value for key, value in tables.items() if key != "schema"}


def rig_text(rig: Rig) -> str:
    """A whole rig as TOML, without reference to another."""
    return tomlkit.dumps(rig_tables(rig))


def rig_of_text(text: str, path: Path, rig: Rig) -> str:
    """The text of a rig file, changed as little as it takes to yield another rig.

    Parameters
    ----------
    text : str
        As it is in the file.
    path : Path
        Where it lies: what it extends is found from there.
    rig : Rig
        What it is to yield.

    Returns
    -------
    str
        Comments, order and spelling are the old ones; line ends too.

    Raises
    ------
    RigError
        If the text is no rig, or cannot yield this one: what it extends gives a key that the
        rig has not.
    """
    before = load_rig_text(text, path)
    try:
        document = tomlkit.parse(text.removeprefix("\ufeff"))
    except TOMLKitError as error:
        raise RigError(shown(path), [f"found {error}, wanted TOML"]) from None
    _change(document, rig_tables(before), rig_tables(rig))
    after = _with_line_ends_of(text, tomlkit.dumps(document))
    if load_rig_text(after, path) != rig:
        raise RigError(
            shown(path),
            [
                "found that the rig it extends gives keys this one has not, "
                "wanted a rig that differs from it by values alone"
            ],
        )
    return after


def save_rig(path: Path, rig: Rig, text: str) -> str:
    """Write a rig into the file that it was read from, whole or not at all.

    Parameters
    ----------
    path : Path
    rig : Rig
    text : str
        What was read from the file; if the file holds something else now, another program
        wrote it, and nothing is overwritten.

    Returns
    -------
    str
        The file's new text.

    Raises
    ------
    RigError, OutputError, OutputPathError
    """
    if is_shipped(path) or is_shipped(path.resolve()):
        raise InputError(f"{shown(path)}: found a shipped rig, wanted a file of your own")
    if read_text(path) != text:
        raise InputError(
            f"{shown(path)}: found it changed by another program since it was read, "
            "wanted it as it was; read it again first"
        )
    after = rig_of_text(text, path, rig)
    atomic_write_text(path, after)
    return after


def new_rig_file(path: Path, rig: Rig, extends: str) -> str:
    """Write a file that extends a shipped rig by what differs; its text."""
    text = rig_of_text(f'extends = "{extends}"\n', path, rig)
    atomic_write_text(path, text)
    return text


def read_text(path: Path) -> str:
    """A rig file's text with its own line ends."""
    try:
        return path.read_bytes().decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise RigError(shown(path), [f"found {error}, wanted a readable rig file"]) from None


def _change(document: MutableMapping[str, Any], before: Tables, after: Tables) -> None:
    """Set what differs, table by table."""
    for key, value in after.items():
        if key in before and before[key] == value:
            continue
        if isinstance(value, Mapping):
            if not isinstance(document.get(key), Mapping):
                document[key] = tomlkit.table()
            _change(document[key], before.get(key, {}), value)
        else:
            _set(document, key, value)


def _set(document: MutableMapping[str, Any], key: str, value: Any) -> None:
    """Set one key, every comment where it was."""
    old = document.get(key)
    if isinstance(old, list) and isinstance(value, list) and len(old) == len(value):
        for index, part in enumerate(value):  # a comment may stand behind each
            if old[index] != part:
                old[index] = part
    elif key in document or not isinstance(document, Table):
        document[key] = value
    else:
        _append(document, key, value)


def _append(table: Table, key: str, value: Any) -> None:
    """A new key behind the table's last one, before the comment that leads to the next table."""
    body, trailing = table.value.body, []
    while body and body[-1][0] is None and isinstance(body[-1][1], Comment | Whitespace):
        trailing.append(body.pop())
    table.append(key, value)
    body.extend(reversed(trailing))


def _with_line_ends_of(text: str, after: str) -> str:
    plain = after.replace("\r\n", "\n")
    marked = "\ufeff" if text.startswith("\ufeff") else ""
    return marked + (plain.replace("\n", "\r\n") if "\r\n" in text else plain)
