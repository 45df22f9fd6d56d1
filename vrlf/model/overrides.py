"""Changes to a rig's tables: merging, and ``table.key=value`` from a command line."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from typing import Any, Final

from vrlf.errors import InputError
from vrlf.model.wording import quoted

# A dotted key may have quoted parts, and these may hold an equals sign.
_ASSIGNMENT: Final = re.compile(r"""((?:"[^"]*"|'[^']*'|[^"'=])*)=(.*)""", re.DOTALL)
_PLAIN_NUMBER: Final = re.compile(r"[+-]?(?:[0-9]+\.|\.[0-9]+)")


def merged(base: Mapping[str, Any], change: Mapping[str, Any]) -> dict[str, Any]:
    """Tables of ``base`` with those of ``change`` laid over them, key by key."""
    result = dict(base)
    for key, value in change.items():
        below = result.get(key)
        if isinstance(below, Mapping) and isinstance(value, Mapping):
            value = merged(below, value)
        result[key] = value
    return result


def parse_override(text: str) -> dict[str, Any]:
    """Tables that ``table.key=value`` stands for.

    The value is TOML; what is no TOML is taken as a string, so that
    ``array.kind=pinhole`` needs no quotes.

    Raises
    ------
    InputError
        If there is no equals sign or the key is no TOML key.
    """
    parts = _ASSIGNMENT.fullmatch(text)
    if parts is None or not text.isprintable():
        raise _no_assignment(text)
    key, value = parts[1].strip(), parts[2].strip()
    try:
        tables = tomllib.loads(f"{key} = 0")
    except (ValueError, RecursionError):
        raise _no_assignment(text) from None
    return _filled(tables, _value(value))


def _value(text: str) -> Any:
    try:
        tables = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        # ".5" and "5." are numbers to everybody but TOML.
        return float(text) if _PLAIN_NUMBER.fullmatch(text) else text
    return tables["value"]


def _filled(tables: dict[str, Any], value: Any) -> dict[str, Any]:
    """The single path of nested ``tables`` with ``value`` at its end."""
    innermost = tables
    while True:
        (key, below) = next(iter(innermost.items()))
        if not isinstance(below, dict):
            innermost[key] = value
            return tables
        innermost = below


def _no_assignment(text: str) -> InputError:
    return InputError(
        f"--set: found {quoted(text)}, wanted table.key=value such as left.sphere_d=-3.5"
    )
