"""A job's row: its values in a fixed order, and a checksum over them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from typing import Any, Final, Literal

Row = dict[str, Any]
Kind = Literal["bool", "int", "float", "text"]

CHECKSUM: Final = "checksum"
INDEX: Final = "index"


def checksum(row: Mapping[str, Any]) -> str:
    """SHA-256 over a row's names and values, in hexadecimal.

    Over the JSON of the pairs in the order of their names, but for the checksum itself and for
    names without a value: a Parquet file has those for each row that lacks what another one has.
    Python writes a float64 so that it reads back as the same number, so that a row has the same
    checksum in a journal and in a Parquet file.
    """
    values = sorted(
        (name, value) for name, value in row.items() if name != CHECKSUM and value is not None
    )
    text = json.dumps(values, ensure_ascii=True, separators=(",", ":"))
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def signed(row: Mapping[str, Any]) -> Row:
    """The row with its checksum."""
    return {**row, CHECKSUM: checksum(row)}


def is_whole(row: Any) -> bool:
    """Whether a row is one, and what its checksum says."""
    return (
        isinstance(row, dict)
        and isinstance(row.get(INDEX), int)
        and row.get(CHECKSUM) == checksum(row)
    )


def kind_of(values: Iterable[Any]) -> Kind:
    """The column that values of a key fit into; lists and mixtures are written as text."""
    kinds = {type(value) for value in values}
    if kinds == {bool}:
        return "bool"
    if kinds == {int}:
        return "int"
    return "float" if kinds and kinds <= {int, float} else "text"


def fitted(value: Any, kind: Kind) -> Any:
    """A value as its column holds it."""
    if kind == "float":
        return float(value)
    if kind == "text":
        return value if isinstance(value, str) else json.dumps(value)
    return value
