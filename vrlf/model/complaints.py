"""A failed validation in our words: one ``key: found ..., wanted ...`` for each wrong key.

What is wanted comes out of the models' own JSON schema, so that limits stand
in one place: the field they belong to.
"""

from __future__ import annotations

import difflib
import functools
import re
from collections.abc import Mapping
from typing import Any, Final

from pydantic import ValidationError

from vrlf.model.rig import Rig, rig_json_schema
from vrlf.model.wording import clipped, quoted, shown

Location = tuple[int | str, ...]

# More than these come from a file that is no rig at all.
_MOST_LINES: Final = 100
_BARE_KEY: Final = re.compile(r"[A-Za-z0-9_-]+")
_NO_VALUE: Final = object()


def wrong_keys(tables: Mapping[str, Any]) -> list[str]:
    """All that is wrong with a rig, a line for each key; empty for a good rig.

    A key that is wrong by itself keeps pydantic from checks that involve its
    table's neighbours, so the rig is looked at again without the wrong keys.
    """
    lines: dict[str, str] = {}
    remaining: Any = tables
    while details := _errors(remaining):
        for detail in details[:_MOST_LINES]:
            place = _location(detail)
            lines.setdefault(dotted(place), _line(tables, place, detail))
        if len(details) > _MOST_LINES:
            return [*lines.values(), f"and {len(details) - _MOST_LINES} more"]
        fewer = functools.reduce(_without, map(_location, details), remaining)
        if fewer == remaining:
            break
        remaining = fewer
    return list(lines.values())


def _errors(tables: Any) -> list[Any]:
    """Pydantic's account of what is wrong."""
    try:
        Rig.model_validate(tables)
    except ValidationError as error:
        return list(error.errors(include_url=False))
    return []


def _location(detail: Any) -> Location:
    """The key that a pydantic error is about: the table's key, not an item of its list."""
    place = tuple(part for part in detail["loc"] if isinstance(part, str) and part != "[key]")
    key = detail.get("ctx", {}).get("key")
    if key is None:
        return place
    neighbour = key.removeprefix("*.")
    return (*place[:-1], neighbour) if neighbour != key else tuple(key.split("."))


def _line(tables: Mapping[str, Any], place: Location, detail: Any) -> str:
    context = detail.get("ctx", {})
    if detail["type"] in ("extra_forbidden", "invalid_key"):
        return f"{dotted(place)}: found an unknown key, wanted {_nearest_key(place)}"
    value = _at(tables, place)
    found = context.get("found", "nothing" if value is _NO_VALUE else shown(value))
    wanted = context.get("wanted") or _described(_schema_at(place), place)
    return f"{dotted(place)}: found {found}, wanted {wanted}"


def dotted(place: Location) -> str:
    """A key as TOML writes it, with quotes where they are needed."""
    parts = (str(part) for part in place)
    return ".".join(clipped(part) if _BARE_KEY.fullmatch(part) else quoted(part) for part in parts)


def _at(tables: Any, place: Location) -> Any:
    for part in place:
        if not isinstance(tables, Mapping) or part not in tables:
            return _NO_VALUE
        tables = tables[part]
    return tables


def _without(tables: Any, place: Location) -> Any:
    """A copy of nested tables that lacks the key at ``place``."""
    if not place or not isinstance(tables, Mapping) or place[0] not in tables:
        return tables
    rest = {key: value for key, value in tables.items() if key != place[0]}
    if len(place) == 1:
        return rest
    return rest | {place[0]: _without(tables[place[0]], place[1:])}


@functools.cache
def _schema() -> dict[str, Any]:
    return rig_json_schema()


def _resolved(node: dict[str, Any]) -> dict[str, Any]:
    """A schema node behind its references; of an optional one, the part that is not null."""
    while True:
        if "$ref" in node:
            node = _schema()["$defs"][node["$ref"].rsplit("/", 1)[-1]]
        elif "anyOf" in node:
            node = next(option for option in node["anyOf"] if option.get("type") != "null")
        else:
            return node


def _schema_at(place: Location) -> dict[str, Any]:
    """The JSON schema of the value at a key, {} where the models know none."""
    node = _resolved(_schema())
    for part in place:
        below = node.get("properties", {}).get(part, node.get("additionalProperties"))
        if not isinstance(below, dict):
            return {}
        node = _resolved(below)
    return node


def _nearest_key(place: Location) -> str:
    """The key that a misspelt one was probably meant to be, or all that the table knows."""
    known = list(_schema_at(place[:-1]).get("properties", {}))
    near = difflib.get_close_matches(str(place[-1]), known, n=1)
    if near:
        return f'"{near[0]}"'
    return "one of " + ", ".join(known)


def _described(node: dict[str, Any], place: Location) -> str:
    """What a schema node allows, in words."""
    if "const" in node or "enum" in node:
        options = node.get("enum", [node.get("const")])
        return ("one of " if len(options) > 1 else "") + ", ".join(map(shown, options))
    match node.get("type"):
        case "integer":
            return "a whole number" + _bounds(node)
        case "number":
            return "a number" + _bounds(node)
        case "array":
            if "items" in node:  # of any length
                kind = "names" if _resolved(node["items"]).get("type") == "string" else "numbers"
                return f"a list of {kind}" + _bounds(_resolved(node["items"]))
            items = node.get("prefixItems", [{}])
            return f"a list of {len(items)} numbers" + _bounds(items[0])
        case "boolean":
            return "true or false"
        case "object":
            return f"a table [{dotted(place)}]"
        case _:
            return "something else"


def _bounds(node: dict[str, Any]) -> str:
    most = node.get("maximum")
    if "exclusiveMinimum" in node:
        return f" above {node['exclusiveMinimum']:g} and up to {most:g}"
    if "minimum" in node:
        if node["minimum"] == most:
            return f" equal to {most:g}"
        return f" from {node['minimum']:g} to {most:g}"
    return ""
