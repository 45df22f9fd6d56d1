"""TOML files of ours: rigs, layouts and panels, read with one line for what is wrong."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, Final

from vrlf.errors import RigError

_LARGEST_FILE_BYTES: Final = 2**20


def read_tables(path: Path, label: str, kind: str) -> dict[str, Any]:
    """The tables of one file.

    Parameters
    ----------
    label : str
        What messages call the file.
    kind : str
        What it should be: "rig file".

    Raises
    ------
    RigError
        In one line.
    """
    return parse_tables(read_text(path, label, kind), label)


def parse_tables(text: str, label: str) -> dict[str, Any]:
    """The tables of a file's text; see `read_tables`."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        reason = str(error)
    except RecursionError:
        reason = "brackets nested too deep"
    except ValueError:
        # Python refuses to convert integers of more than 4300 digits.
        reason = "a number too long to read"
    raise RigError(label, [f"found a syntax error, {reason}, wanted TOML"]) from None


def read_text(path: Path, label: str, kind: str) -> str:
    """The text of a file that is not absurdly large; see `read_tables`."""
    try:
        with path.open("rb") as file:
            raw = file.read(_LARGEST_FILE_BYTES + 1)
    except IsADirectoryError:
        raise RigError(label, [f"found a folder, wanted a {kind}"]) from None
    except FileNotFoundError:
        raise RigError(label, [f"found no such file, wanted a {kind}"]) from None
    except OSError as error:
        raise RigError(label, [f"found {error.strerror}, wanted a readable file"]) from None
    if len(raw) > _LARGEST_FILE_BYTES:
        raise RigError(label, [f"found more than 1 MiB, wanted a {kind}"])
    try:
        # Windows editors put a byte order mark first, which TOML does not allow.
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw[: error.start].count(b"\n") + 1
        problem = f"found bytes that are not UTF-8 in line {line}, wanted UTF-8 text"
        raise RigError(label, [problem]) from None
