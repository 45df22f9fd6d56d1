"""What a sweep is to try: rigs, a grid and a sample of their keys, sources, methods, metrics."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterator, Mapping
from math import isfinite, prod
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self

from pydantic import (
    BaseModel,
    BeforeValidator,
    Field,
    ValidationError,
    field_validator,
    model_validator,
)

from vrlf.errors import RigError
from vrlf.model.complaints import dotted
from vrlf.model.fields import GIVEN, FromList, between, refusal
from vrlf.model.shelf import DEFAULT_RIG
from vrlf.model.toml_file import read_tables
from vrlf.model.wording import shown

# A value that a rig's key may take; a list stands for keys such as array.offset_um.
Scalar = bool | int | float | str
Value = Scalar | tuple[Scalar, ...]
Method = Literal["none", "forward", "optimal"]

MOST_JOBS: Final = 10_000_000
_MOST_VALUES: Final = 1_000_000
# Whole numbers beyond this are no longer exact as floats, which a column may have to hold.
_MOST_WHOLE: Final = 2**53
_GRID_KEYS: Final = frozenset({"from", "to", "count"})
_SPREAD_KEYS: Final = frozenset({"from", "to", "log"})
_SAMPLE_KEYS: Final = ("count", "seed", "kind")


def _listed(value: Any) -> Any:
    """One name stands for a list of one."""
    return [value] if isinstance(value, str) else value


_Names = Annotated[tuple[str, ...], FromList, BeforeValidator(_listed)]


class Spread(BaseModel):
    """Between what a sampled key lies, evenly or evenly in its logarithm.

    Attributes
    ----------
    low, high : float
        ``from`` and ``to`` in the file.
    log : bool
    """

    model_config = GIVEN

    low: float
    high: float
    log: bool = False


class Sample(BaseModel):
    """Points spread over the box of all sampled keys.

    Attributes
    ----------
    count : int
        How many points.
    seed : int
    kind : {"latin-hypercube", "sobol"}
        Latin hypercube (McKay, Beckman & Conover 1979), or Sobol's sequence, scrambled (Owen
        1998).
    keys : mapping of str to Spread
        By dotted key.
    """

    model_config = GIVEN

    count: Annotated[int, between(1, _MOST_VALUES)]
    seed: Annotated[int, between(0, 2**32 - 1)] = 0
    kind: Literal["latin-hypercube", "sobol"] = "latin-hypercube"
    keys: Mapping[str, Spread]


class SweepSpec(BaseModel):
    """All that a sweep's file says.

    Attributes
    ----------
    rig : tuple of str
        Base rigs: shipped names or files.
    sources, methods, metrics : tuple of str
    rays : int
        For each retinal pixel, of the judge.
    panel_px : (int, int) or None
        The panel is cut to its middle of this size; None keeps the rig's own.
    grid : mapping of str to tuple of values
        By dotted key; every combination is tried.
    sample : Sample or None
        Every point of it is tried with every combination of the grid.
    """

    model_config = GIVEN

    rig: _Names = (DEFAULT_RIG,)
    sources: _Names
    methods: Annotated[tuple[Method, ...], FromList, BeforeValidator(_listed)] = (
        "none",
        "forward",
        "optimal",
    )
    metrics: _Names = ("rmse", "psnr_db", "ssim")
    rays: Annotated[int, between(1, 1_000_000)] = 256
    panel_px: (
        Annotated[
            tuple[Annotated[int, between(2, 65536)], Annotated[int, between(1, 65536)]], FromList
        ]
        | None
    ) = None
    grid: Mapping[str, tuple[Value, ...]] = Field(default_factory=dict)
    sample: Sample | None = None

    @field_validator("rig", "sources", "methods", "metrics", mode="after")
    @classmethod
    def _some_and_each_once(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        if not names:
            raise refusal("at least one", found="none")
        if len(set(names)) < len(names):
            raise refusal("each once")
        return names

    @field_validator("grid", mode="before")
    @classmethod
    def _grid_of_values(cls, table: Any) -> Any:
        if not isinstance(table, Mapping):
            raise refusal("a table [grid]")
        return {key: _values(f"grid.{key}", given) for key, given in flat(table, _GRID_KEYS)}

    @field_validator("sample", mode="before")
    @classmethod
    def _sample_of_keys(cls, table: Any) -> Any:
        if not isinstance(table, Mapping):
            raise refusal("a table [sample]")
        rest = {key: value for key, value in table.items() if key not in _SAMPLE_KEYS}
        keys = {key: _spread(f"sample.{key}", given) for key, given in flat(rest, _SPREAD_KEYS)}
        if not keys:
            raise refusal('at least one key, such as "left.pupil_mm"', found="no key to sample")
        return {key: table[key] for key in _SAMPLE_KEYS if key in table} | {"keys": keys}

    @model_validator(mode="after")
    def _each_key_once(self) -> Self:
        keys = [*self.grid, *(self.sample.keys if self.sample else ())]
        seen: dict[str, str] = {}
        for key in keys:
            for place in written_places(key):
                if place in seen:
                    found = f"it beside {seen[place]}" if seen[place] != key else "it twice"
                    raise refusal("each key once", key=key, found=found)
                seen[place] = key
        if self.panel_px is not None and {"panel.width_px", "panel.height_px"} & seen.keys():
            raise refusal("one of the two", key="panel_px", found="it beside the panel's own keys")
        if self.count > MOST_JOBS:
            raise refusal(f"at most {MOST_JOBS}", key="grid", found=f"{self.count} jobs")
        return self

    @property
    def count(self) -> int:
        """How many jobs there are."""
        points = self.sample.count if self.sample is not None else 1
        lists = (self.rig, self.sources, self.methods, *self.grid.values())
        return points * prod(len(values) for values in lists)


def read_sweep(path: Path) -> SweepSpec:
    """A sweep's file.

    Raises
    ------
    RigError
        In one line, naming the file and each wrong key.
    """
    tables = read_tables(path, str(path), "sweep's file")
    return sweep_from_tables(tables, source=str(path))


def sweep_from_tables(tables: Mapping[str, Any], *, source: str = "sweep") -> SweepSpec:
    """Validate nested tables, as TOML yields them.

    Raises
    ------
    RigError
        Naming ``source`` and every wrong key.
    """
    try:
        return SweepSpec.model_validate(tables)
    except ValidationError as error:
        details = error.errors(include_url=False)
    raise RigError(source, list(dict.fromkeys(_line(tables, each) for each in details)))


def places(key: str) -> list[tuple[str, ...]]:
    """Where in a rig a dotted key is set; ``both.`` stands for the left eye and the right.

    Raises
    ------
    ValueError
        If the text is no dotted key.
    """
    table: Any = tomllib.loads(f"{key} = 0")
    parts: list[str] = []
    while isinstance(table, dict):
        ((part, table),) = table.items()
        parts.append(part)
    if len(parts) < 2:
        raise ValueError("a table's name alone")
    if parts[0] == "both":
        return [("left", *parts[1:]), ("right", *parts[1:])]
    return [tuple(parts)]


def written_places(key: str) -> list[str]:
    """`places` as text."""
    return [dotted(place) for place in places(key)]


def flat(
    table: Mapping[str, Any], ends: frozenset[str], above: tuple[str, ...] = ()
) -> Iterator[tuple[str, Any]]:
    """Dotted keys and what they are given, whether TOML wrote ``"a.b"`` or ``a.b``.

    A table that holds one of ``ends`` is a value, any other leads on.
    """
    for key, value in table.items():
        inside = isinstance(value, Mapping) and value and ends.isdisjoint(value)
        name = dotted((*above, key)) if above or "." not in key else key
        if inside:
            yield from flat(value, ends, (*above, *key.split(".")))
            continue
        try:
            places(name)
        except ValueError:
            wanted = "a key of the rig with its table, such as left.sphere_d"
            raise refusal(wanted, key="grid or sample", found=shown(name)) from None
        yield name, value


def _values(key: str, given: Any) -> tuple[Value, ...]:
    """The values that a grid's key takes: a list, or a range in equal steps."""
    if isinstance(given, Mapping):
        return _stepped(key, given)
    if not isinstance(given, list):
        raise refusal("a list of values or a range {from, to, count}", key=key, found=shown(given))
    if not given:
        raise refusal("at least one value", key=key, found="an empty list")
    values = tuple(tuple(v) if isinstance(v, list) else v for v in given)
    for value in values:
        if not all(map(_is_value, value if isinstance(value, tuple) else (value,))):
            raise refusal("numbers, words, true or false", key=key, found=shown(given))
    if len(set(map(repr, values))) < len(values):
        raise refusal("each value once", key=key, found=shown(given))
    return values


def _is_value(value: Any) -> bool:
    if isinstance(value, float):
        return isfinite(value)
    return isinstance(value, str) or (isinstance(value, int) and abs(value) <= _MOST_WHOLE)


def _stepped(key: str, given: Mapping[str, Any]) -> tuple[Value, ...]:
    """A range in equal steps; whole numbers where ends and steps are whole."""
    low, high = _ends(key, given, _GRID_KEYS)
    count: Any = given.get("count")
    if not isinstance(count, int) or isinstance(count, bool) or not 2 <= count <= _MOST_VALUES:
        found = shown(count) if "count" in given else "nothing"
        raise refusal(f"a whole number from 2 to {_MOST_VALUES}", key=f"{key}.count", found=found)
    steps = count - 1
    if isinstance(low, int) and isinstance(high, int) and (high - low) % steps == 0:
        return tuple(range(low, high + 1, (high - low) // steps))
    return tuple((low * (steps - i) + high * i) / steps for i in range(count))


def _spread(key: str, given: Any) -> Spread:
    if not isinstance(given, Mapping):
        raise refusal("a range {from, to}", key=key, found=shown(given))
    low, high = _ends(key, given, _SPREAD_KEYS)
    log = given.get("log", False)
    if not isinstance(log, bool):
        raise refusal("true or false", key=f"{key}.log", found=shown(log))
    if log and low <= 0:
        raise refusal("a number above 0 beside log", key=f"{key}.from", found=shown(low))
    return Spread(low=float(low), high=float(high), log=log)


def _ends(key: str, given: Mapping[str, Any], known: frozenset[str]) -> tuple[float, float]:
    """The two ends of a range that is not empty."""
    for name in given:
        if name not in known:
            wanted = f"one of {', '.join(sorted(known))}"
            raise refusal(wanted, key=f"{key}.{dotted((name,))}", found="an unknown key")
    for name in ("from", "to"):
        value = given.get(name)
        if isinstance(value, bool) or not isinstance(value, int | float) or not _is_value(value):
            found = shown(value) if name in given else "nothing"
            raise refusal("a number", key=f"{key}.{name}", found=found)
    low, high = given["from"], given["to"]
    if low >= high:
        found = f"an empty range from {shown(low)} to {shown(high)}"
        raise refusal("from below to", key=key, found=found)
    return low, high


def _line(tables: Mapping[str, Any], detail: Any) -> str:
    """One wrong key: ``grid.array.gap_mm: found ..., wanted ...``."""
    context = detail.get("ctx", {})
    place = [part for part in detail["loc"] if isinstance(part, str)][:2]
    key = context.get("key") or dotted(tuple(place))
    if detail["type"] == "extra_forbidden":
        known = list(SweepSpec.model_fields)
        near = difflib.get_close_matches(str(place[-1]), known, n=1)
        wanted = f'"{near[0]}"' if near else f"one of {', '.join(known)}"
        return f"{key}: found an unknown key, wanted {wanted}"
    value: Any = tables
    for part in place:
        value = value.get(part) if isinstance(value, Mapping) else None
    found = context.get("found", "nothing" if value is None else shown(value))
    return f"{key}: found {found}, wanted {context.get('wanted') or _WANTED.get(key, 'another')}"


_WANTED: Final = {
    "rig": "a rig's name or file, or a list of them",
    "sources": 'a list of pictures, charts or scenes, such as ["scene", "chart:siemens"]',
    "methods": "some of none, forward, optimal",
    "metrics": "a list of metrics' names",
    "rays": "a whole number from 1 to 1000000",
    "panel_px": "width and height in pixels, as in [220, 110]",
    "sample.count": f"a whole number from 1 to {_MOST_VALUES}",
    "sample.seed": "a whole number from 0 to 4294967295",
    "sample.kind": "latin-hypercube or sobol",
}
