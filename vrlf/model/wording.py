"""How values are quoted in messages: as TOML writes them, short, and safe to print."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any, Final

LONGEST: Final = 60


def clipped(text: str) -> str:
    """At most `LONGEST` characters of a text."""
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."


def quoted(text: str) -> str:
    """A string in double quotes; what cannot be printed is escaped."""
    return json.dumps(clipped(text), ensure_ascii=not text.isprintable())


def shown(value: Any) -> str:
    """A value of a TOML file as it is written there, clipped to a readable length."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, Sequence):
        return clipped("[" + ", ".join(shown(item) for item in value[:LONGEST]) + "]")
    if isinstance(value, int) and abs(value) > 10**LONGEST:
        return "a whole number too large to handle"
    return clipped(str(value))
