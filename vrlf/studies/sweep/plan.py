"""What a sweep consists of: job number ``index`` to a rig's changes, a source and a method.

Jobs are made one at a time from their number, never all at once. Of neighbouring numbers the
method changes first, then the source, then the grid's keys from the last, then the sampled
point, then the rig: what a worker has made for one rig serves its neighbours.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil, log2
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from vrlf import __version__
from vrlf.errors import InputError, RigError
from vrlf.files import shown
from vrlf.model.overrides import merged
from vrlf.model.reading import load_rig, rig_with
from vrlf.model.saving import rig_tables
from vrlf.model.sweep import Sample, SweepSpec, places, written_places
from vrlf.optics.viewport import SIDES
from vrlf.studies.quality import CROP_PX
from vrlf.studies.sweep.rows import CHECKSUM, INDEX, Kind, Row, fitted, kind_of

# Of a key's values, so many are looked at before a sweep begins.
_MOST_TRIED: Final = 100
_PANEL_KEYS: Final = frozenset({"panel.width_px", "panel.height_px"})


@dataclass(frozen=True)
class Job:
    """One rig, source and method.

    Attributes
    ----------
    index : int
        Its number, 0 for the first.
    rig : str
        The base rig's name.
    changes : mapping
        Nested tables that are laid over it.
    source, method : str
    values : mapping
        What its row says of it.
    """

    index: int
    rig: str
    changes: Mapping[str, Any]
    source: str
    method: str
    values: Row


@dataclass(frozen=True)
class Axis:
    """The values of one key of the grid."""

    key: str
    values: Sequence[Any]
    kind: Kind

    def at(self, number: int) -> Any:
        """A value as a rig takes it."""
        value = self.values[number]
        return list(value) if isinstance(value, tuple) else value


@dataclass(frozen=True)
class SourceFile:
    """A source as it is written, what it stands for, and the SHA-256 of its file.

    Attributes
    ----------
    place : str
        A path, or the name of a chart or scene.
    sha256 : str or None
        None for what is no file.
    """

    name: str
    place: str
    sha256: str | None


@dataclass(frozen=True)
class Plan:
    """A whole sweep.

    Attributes
    ----------
    spec : SweepSpec
    rigs : mapping
        Each base rig's whole tables.
    sources : tuple of SourceFile
    """

    spec: SweepSpec
    rigs: Mapping[str, Mapping[str, Any]]
    sources: tuple[SourceFile, ...]

    @property
    def count(self) -> int:
        """How many jobs there are."""
        return self.spec.count

    @property
    def panel_px(self) -> tuple[int, int] | None:
        """The panel's size if it is cut; as ``vrlf bench quality`` cuts it, unless told."""
        if self.spec.panel_px is None:
            keys = [*self.spec.grid, *(self.spec.sample.keys if self.spec.sample else ())]
            own = any(place in _PANEL_KEYS for key in keys for place in written_places(key))
            return None if own else CROP_PX
        return self.spec.panel_px

    @cached_property
    def axes(self) -> tuple[Axis, ...]:
        """The grid."""
        return tuple(Axis(key, values, kind_of(values)) for key, values in self.spec.grid.items())

    @cached_property
    def points(self) -> NDArray[np.float64]:
        """The sample, one row a point; one point without a key where nothing is sampled."""
        return np.empty((1, 0)) if self.spec.sample is None else drawn(self.spec.sample)

    @cached_property
    def columns(self) -> dict[str, Kind]:
        """What is tried, by the columns of the results."""
        given: dict[str, Kind] = {INDEX: "int", "rig": "text"}
        given |= dict.fromkeys(self._sampled, "float")
        given |= {axis.key: axis.kind for axis in self.axes}
        return given | {"source": "text", "method": "text"}

    def columns_of(self, names: Collection[str]) -> dict[str, Kind]:
        """The columns of some rows, in their order: what is tried, its metrics, the checksum.

        A metric may have several values, each with a name of its own behind the metric's and a
        dot. So its columns are known by the rows.

        Parameters
        ----------
        names : collection of str
            All names that the rows have.
        """
        columns = dict(self.columns)
        for side in SIDES:
            for metric in self.spec.metrics:
                name = f"{side}_{metric}"
                several = sorted(each for each in names if each.startswith(f"{name}."))
                columns |= dict.fromkeys(several or [name], "float")
        return columns | {CHECKSUM: "text"}

    @property
    def _sampled(self) -> tuple[str, ...]:
        return tuple(self.spec.sample.keys) if self.spec.sample is not None else ()

    def job(self, index: int) -> Job:
        """The job of that number."""
        spec, rest = self.spec, index
        rest, method = divmod(rest, len(spec.methods))
        rest, source = divmod(rest, len(spec.sources))
        chosen: list[tuple[Axis, int]] = []
        for axis in reversed(self.axes):
            rest, number = divmod(rest, len(axis.values))
            chosen.insert(0, (axis, number))
        rig, point = divmod(rest, len(self.points))
        values: Row = {INDEX: index, "rig": spec.rig[rig]}
        changes: dict[str, Any] = {}
        for key, value in zip(self._sampled, self.points[point].tolist(), strict=True):
            values[key] = value
            changes = merged(changes, change(key, value))
        for axis, number in chosen:
            values[axis.key] = fitted(axis.values[number], axis.kind)
            changes = merged(changes, change(axis.key, axis.at(number)))
        names = {"source": spec.sources[source], "method": spec.methods[method]}
        return Job(index, spec.rig[rig], changes, **names, values=values | names)

    def told(self) -> dict[str, Any]:
        """All that the rows depend on, for a later run to compare and for the results' file."""
        return {
            "vrlf": __version__,
            "spec": self.spec.model_dump(mode="json"),
            "rigs": {name: dict(tables) for name, tables in self.rigs.items()},
            "sources": {each.name: each.sha256 for each in self.sources},
            "sample": hashlib.sha256(self.points.tobytes()).hexdigest(),
            "jobs": self.count,
        }

    @property
    def name(self) -> str:
        """SHA-256 of `told`: what a folder's sweep is known by."""
        text = json.dumps(self.told(), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode("utf-8")).hexdigest()


def plan_of(spec: SweepSpec, folder: Path, label: str) -> Plan:
    """A sweep whose rigs and pictures are there and whose keys are a rig's.

    Parameters
    ----------
    folder : Path
        Where the sweep's file lies; paths in it count from there.
    label : str
        What messages call the file.

    Raises
    ------
    InputError
        A rig is none, a picture cannot be read, or no value of a key makes a rig.
    """
    rigs = {name: rig_tables(load_rig(_place(name, folder))) for name in spec.rig}
    sources = tuple(_source(name, folder) for name in spec.sources)
    plan = Plan(spec, rigs, sources)
    tried = [(axis.key, [axis.at(n) for n in range(len(axis.values))]) for axis in plan.axes]
    if spec.sample is not None:
        tried += [
            (key, [s.low, s.high, (s.low + s.high) / 2]) for key, s in spec.sample.keys.items()
        ]
    for key, values in tried:
        _require_key(next(iter(rigs.values())), key, values[:_MOST_TRIED], label)
    return plan


def _place(name: str, folder: Path) -> str:
    """A rig's name, or its file seen from ``folder``."""
    is_file = name.endswith(".toml") or "/" in name or "\\" in name
    return str(folder / name) if is_file else name


def _source(name: str, folder: Path) -> SourceFile:
    path = folder / name
    try:
        if not path.exists():
            return SourceFile(name, name, None)
        with path.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{shown(name)}: found {reason}, wanted a readable picture") from None
    return SourceFile(name, str(path.resolve()), digest)


def _require_key(tables: Mapping[str, Any], key: str, values: Sequence[Any], label: str) -> None:
    """Refuse a key that no rig has, or of which every value is wrong by itself."""
    first = ""
    for value in values:
        try:
            rig_with(tables, change(key, value), source=label)
        except RigError as error:
            own = [
                p
                for p in error.problems
                if p.startswith(tuple(f"{w}:" for w in written_places(key)))
            ]
            own += [p for p in error.problems if "found an unknown key" in p]
            if not own:  # a key that another one of the sweep may set right
                return
            first = first or own[0]
        else:
            return
    raise InputError(f"{label}: {first}")


def change(key: str, value: Any) -> dict[str, Any]:
    """Nested tables that set a dotted key, for both eyes where it says so."""
    tables: dict[str, Any] = {}
    for place in places(key):
        nested: Any = value
        for part in reversed(place):
            nested = {part: nested}
        tables = merged(tables, nested)
    return tables


def drawn(sample: Sample) -> NDArray[np.float64]:
    """The points of a sample, (count, keys); the same for the same seed."""
    spreads, rng = list(sample.keys.values()), np.random.default_rng(sample.seed)
    if sample.kind == "sobol":
        # Whole powers of two alone are balanced; the first of them are taken.
        sobol = qmc.Sobol(len(spreads), seed=rng)
        unit = sobol.random_base2(ceil(log2(sample.count)))[: sample.count]
    else:
        unit = qmc.LatinHypercube(len(spreads), seed=rng).random(sample.count)
    points = np.empty(unit.shape, np.float64)
    for column, spread in enumerate(spreads):
        if spread.log:
            points[:, column] = spread.low * (spread.high / spread.low) ** unit[:, column]
        else:
            points[:, column] = spread.low + (spread.high - spread.low) * unit[:, column]
    return points
