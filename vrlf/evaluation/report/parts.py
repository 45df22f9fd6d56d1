"""Pieces of the page: pictures, tables, scales, lists. Text in, HTML out."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Final

import numpy as np

from vrlf.evaluation.metrics import false_colour
from vrlf.evaluation.report.model import Report
from vrlf.evaluation.report.numbers import Column, columns_of, flat, short_names

_SCALE_STEPS: Final = 17
MISSING: Final = "–"


def data_uri(kind: str, data: bytes) -> str:
    """Bytes as an address that holds them."""
    return f"data:{kind};base64,{b64encode(data).decode('ascii')}"


def picture(png: bytes, words: str, name: str = "") -> str:
    """A picture; ``words`` for those who cannot see it, ``name`` for the script to find it by."""
    marked = f' id="{escape(name)}"' if name else ""
    return f'<img{marked} src="{data_uri("image/png", png)}" alt="{escape(words)}">'


def figure(image: str, caption: str) -> str:
    """A picture above its caption, which is HTML already."""
    return f"<figure>{image}<figcaption>{caption}</figcaption></figure>"


def number_text(value: float | None) -> str:
    """Four significant digits, without an exponent where that is short."""
    return MISSING if value is None else f"{value:#.4g}".rstrip(".")


def bullets(lines: Iterable[str]) -> str:
    """A list of plain sentences."""
    return "<ul>" + "".join(f"<li>{escape(line)}</li>" for line in lines) + "</ul>"


def colour_scale(least: str, most: str) -> str:
    """What the false colours mean, from black to pale yellow."""
    codes = false_colour(np.linspace(0.0, 1.0, _SCALE_STEPS)[None])[0]
    stops = ", ".join(f"rgb({r} {g} {b})" for r, g, b in codes.tolist())
    return (
        f'<div class="scale"><span>{escape(least)}</span>'
        f'<i style="background: linear-gradient(90deg, {stops})"></i>'
        f"<span>{escape(most)}</span></div>"
    )


def definition_table(caption: str, rows: Iterable[tuple[str, str]]) -> str:
    """Two columns of text."""
    body = "".join(
        f'<tr><th scope="row">{escape(name)}</th><td>{escape(value)}</td></tr>'
        for name, value in rows
    )
    table = f'<table aria-label="{escape(caption)}"><tbody>{body}</tbody></table>'
    return f'<div class="wide">{table}</div>'


def numbers_table(report: Report) -> str:
    """A row for each source, rig, eye and method, sorted by a click on a heading."""
    columns = columns_of(report)
    heads = "".join(_head(name, "") for name in ("source", "rig", "eye", "method"))
    heads += "".join(_head(column.heading, "number") for column in columns)
    sources = short_names(pair.source for pair in report.pairs)
    rigs = short_names(pair.rig for pair in report.pairs)
    rows = []
    for pair in report.pairs:
        for eye in pair.eyes:
            values = [flat(view.values) for view in eye.views]
            best = [_best([each.get(column.name) for each in values], column) for column in columns]
            for view, each in zip(eye.views, values, strict=True):
                cells = _named(sources, pair.source) + _named(rigs, pair.rig)
                cells += f"<td>{escape(eye.side)}</td><td>{escape(view.method)}</td>"
                cells += "".join(
                    _cell(each.get(column.name), top)
                    for column, top in zip(columns, best, strict=True)
                )
                rows.append(f"<tr>{cells}</tr>")
    return (
        '<div class="wide"><table class="sortable" aria-label="All numbers">'
        f"<thead><tr>{heads}</tr></thead><tbody>{''.join(rows)}</tbody></table></div>"
    )


def _head(text: str, kind: str) -> str:
    return (
        f'<th scope="col" class="{kind}" aria-sort="none">'
        f'<button type="button">{escape(text)}</button></th>'
    )


def _named(short: Mapping[str, str], whole: str) -> str:
    return f'<td class="name" title="{escape(whole)}">{escape(short[whole])}</td>'


def _best(values: Sequence[float | None], column: Column) -> float | None:
    """The best of several methods; None where there is nothing to choose."""
    there = [value for value in values if value is not None]
    if column.better is None or len(there) < 2:
        return None
    return max(there) if column.better == "higher" else min(there)


def _cell(value: float | None, best: float | None) -> str:
    kind = "number best" if value is not None and value == best else "number"
    exact = "" if value is None else repr(value)
    return f'<td class="{kind}" data-value="{exact}">{number_text(value)}</td>'
