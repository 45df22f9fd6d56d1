"""TOML files as tables, and how a message names a file."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, Final

from vrlf.errors import RigError
from vrlf.model.shelf import is_shipped

_LARGEST_FILE_BYTES: Final = 2**20


def tables_of(path: Path, text: str | None = None) -> dict[str, Any]:
    """The tables of one TOML file, or of the text that stands for it.

    Raises
    ------
    RigError
        If it cannot be read or is no TOML.
    """
    if text is None:
        text = text_of(path, "a rig file")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        reason = str(error)
    except RecursionError:
        reason = "brackets nested too deep"
    except ValueError:
        # Python refuses to convert integers of more than 4300 digits.
        reason = "a number too long to read"
    raise RigError(label(path), [f"found a syntax error, {reason}, wanted TOML"]) from None


def text_of(path: Path, wanted: str) -> str:
    """The text of a file that is not absurdly large; ``wanted`` says what it should be.

    Raises
    ------
    RigError
        If there is no such file, or no text in it.
    """
    try:
        with path.open("rb") as file:
            raw = file.read(_LARGEST_FILE_BYTES + 1)
    except IsADirectoryError:
        raise RigError(label(path), [f"found a folder, wanted {wanted}"]) from None
    except FileNotFoundError:
        raise RigError(label(path), [f"found no such file, wanted {wanted}"]) from None
    except OSError as error:
        raise RigError(label(path), [f"found {error.strerror}, wanted a readable file"]) from None
    if len(raw) > _LARGEST_FILE_BYTES:
        raise RigError(label(path), [f"found more than 1 MiB, wanted {wanted}"])
    try:
        # Windows editors put a byte order mark first, which TOML does not allow.
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw[: error.start].count(b"\n") + 1
        problem = f"found bytes that are not UTF-8 in line {line}, wanted UTF-8 text"
        raise RigError(label(path), [problem]) from None


def label(path: Path) -> str:
    """A file in a message: a shipped one by its name, a path so that it can be printed."""
    if is_shipped(path):
        return path.stem
    return str(path) if str(path).isprintable() else ascii(str(path))
