"""The numbers of a report: flat, for tables and CSV; nested, as scripts rely on, for JSON."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal

from vrlf.evaluation.metrics import METRICS
from vrlf.evaluation.metrics.model import Value
from vrlf.evaluation.report.model import Pair, Report

GAIN: Final = "gain"
Better = Literal["higher", "lower"]


@dataclass(frozen=True)
class Column:
    """A number that every row of a table has.

    Attributes
    ----------
    name : str
        Flat: ``hdr_vdp.q`` is the ``q`` of ``hdr_vdp``.
    title, unit : str
        For people.
    better : str or None
        Which way is better; None where neither is.
    """

    name: str
    title: str
    unit: str
    better: Better | None

    @property
    def heading(self) -> str:
        """Title and unit."""
        return f"{self.title}, {self.unit}" if self.unit else self.title


# Which way is better where a metric says several things.
_PARTS: Final[Mapping[str, Better]] = {
    "hdr_vdp.p_det": "lower",
    "hdr_vdp.c_max": "lower",
    "acuity.logmar": "lower",
}
# What ``METRICS`` has not: title, unit, which way is better.
_OTHERS: Final[Mapping[str, tuple[str, str, Better | None]]] = {
    "acuity": ("acuity", "", "higher"),
    "mtf50": ("half contrast at", "cycles/degree", "higher"),
    "mtf": ("MTF", "", "higher"),
    GAIN: ("gain", "", None),
}
# Values that are curves over frequency: plots show them, tables don't.
CURVES: Final = frozenset({"contrast", "mtf"})


def short_names(names: Iterable[str]) -> dict[str, str]:
    """Paths by their last part, where no other has the same; for people, not for scripts."""
    every = dict.fromkeys(names)
    ends = {name: re.split(r"[/\\]", name.rstrip("/\\"))[-1] or name for name in every}
    count = Counter(ends.values())
    return {name: end if count[end] == 1 else name for name, end in ends.items()}


def flat(values: Mapping[str, Value]) -> dict[str, float | None]:
    """Values by flat names; a value of several numbers gives several."""
    found: dict[str, float | None] = {}
    for name, value in values.items():
        if isinstance(value, Mapping):
            found |= {f"{name}.{part}": number for part, number in value.items()}
        else:
            found[name] = value
    return found


def columns_of(report: Report, *, curves: bool = False) -> list[Column]:
    """Every number that any row has, in the metrics' order, the gain last.

    ``curves`` has those at each frequency in as well.
    """
    views = [view for pair in report.pairs for eye in pair.eyes for view in eye.views]
    names = dict.fromkeys(name for view in views for name in flat(view.values))
    # A metric of several numbers that one row lacks stands there by its name alone.
    split = {_metric(name) for name in names if "." in name}
    shown = [name for name in names if name not in split]
    shown = [name for name in shown if curves or _metric(name) not in CURVES]
    order = [*METRICS, *_OTHERS]
    return [_column(name) for name in sorted(shown, key=lambda name: order.index(_metric(name)))]


def _metric(name: str) -> str:
    """Of a flat name; a frequency may have a dot of its own."""
    return name.partition(".")[0]


def _column(name: str) -> Column:
    metric, _, part = name.partition(".")
    if metric in METRICS:
        known = METRICS[metric]
        title, unit, better = known.title, known.unit, known.better
        return Column(name, f"{title} {part}".strip(), unit, _PARTS.get(name, better))
    title, unit, usual = _OTHERS[metric]
    return Column(name, f"{title} {part}".strip(), unit, _PARTS.get(name, usual))


def results_json(report: Report) -> dict[str, Any]:
    """The numbers as scripts rely on them.

    With one source and one rig ``left``, ``right`` and ``throughput`` stand at the top, beside
    ``source`` and ``rig``; with several, ``cases`` is a list of such objects.
    """
    pairs = [_pair_json(pair) for pair in report.pairs]
    shared: dict[str, Any] = {
        "rays": report.rays,
        "versions": dict(report.versions),
        "notes": list(report.notes),
        "failed": [dict(each) for each in report.failures],
    }
    return {**pairs[0], **shared} if len(pairs) == 1 else {"cases": pairs, **shared}


def _pair_json(pair: Pair) -> dict[str, Any]:
    eyes = {eye.side: {v.method: dict(v.values) for v in eye.views} for eye in pair.eyes}
    return {"source": pair.source, "rig": pair.rig, "throughput": pair.throughput, **eyes}


def results_csv(report: Report) -> str:
    """A line for each source, rig, eye and method; what isn't defined is empty."""
    columns = columns_of(report, curves=True)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\r\n")
    names = [column.name for column in columns]
    writer.writerow(["source", "rig", "eye", "method", "throughput", *names])
    for pair in report.pairs:
        for eye in pair.eyes:
            for view in eye.views:
                values = flat(view.values)
                numbers = ["" if values.get(n) is None else repr(values[n]) for n in names]
                place = [pair.source, pair.rig, eye.side, view.method, repr(pair.throughput)]
                writer.writerow([*place, *numbers])
    return text.getvalue()
