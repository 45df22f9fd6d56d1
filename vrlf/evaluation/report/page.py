"""The whole page: one file, all that it shows inside it, and no way for it to fetch more."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from html import escape
from string import Template
from typing import Final

from vrlf import __version__
from vrlf.evaluation.metrics import METRICS
from vrlf.evaluation.report.model import Eye, Map, Pair, Plot, Report, View
from vrlf.evaluation.report.numbers import flat, results_csv, results_json, short_names
from vrlf.evaluation.report.parts import (
    bullets,
    colour_scale,
    data_uri,
    definition_table,
    figure,
    number_text,
    numbers_table,
    picture,
)
from vrlf.resources import assets_dir

TITLE: Final = "What is seen, with and without correction"
METHOD_WORDS: Final[Mapping[str, str]] = {
    "none": "uncorrected",
    "forward": "corrected, forward",
    "optimal": "corrected, optimal",
}
# What a map's colours go from and to.
_MAP_WORDS: Final[Mapping[str, tuple[str, str, str]]] = {
    "flip": ("FLIP: how much a person notices", "0, nothing", "1, the most"),
    "cvvdp_jod": ("ColorVideoVDP: what is objected to", "0 JOD", "1 JOD and more"),
    "hdr_vdp": ("HDR-VDP-2: how likely it is detected", "0, never", "1, for certain"),
}
_HOW: Final = (
    "Each eye's view is compared with its target in linear light of peak 1, after one gain on "
    "what is seen, inside a border as wide as the blur's radius plus one lenslet; metrics that "
    "go by the viewer take the rig's true pixels per degree and its panel's luminance. A click "
    "on a heading sorts; bold is the best method of an eye. What is seen was traced with "
)


def report_html(report: Report) -> str:
    """The page.

    Returns
    -------
    str
        HTML that opens from a disk: pictures, plots, style and script are inside it, and its
        content security policy forbids any request.
    """
    folder = assets_dir() / "report"
    page, style, script = (
        (folder / name).read_text(encoding="utf-8")
        for name in ("page.html", "report.css", "report.js")
    )
    rigs = short_names(pair.rig for pair in report.pairs)
    sources = short_names(pair.source for pair in report.pairs)
    titles = [f"{sources[pair.source]}, {rigs[pair.rig]}" for pair in report.pairs]
    numbers = json.dumps(results_json(report), indent=2, allow_nan=False)
    return Template(page).substitute(
        version=escape(__version__),
        title=escape(TITLE),
        style=style,
        script=script,
        lead=f"{_counted(len(sources), 'source')} before {_counted(len(rigs), 'rig')}, each eye "
        f"and method by itself. Made by vrlf {escape(__version__)}.",
        notes=_notes(report),
        contents=_contents(titles),
        how=f"{_HOW}{report.rays} rays a pixel.",
        plots=_plots(report.plots),
        table=numbers_table(report),
        csv=data_uri("text/csv", results_csv(report).encode()),
        json=data_uri("application/json", numbers.encode()),
        pairs="\n".join(_pair(pair, titles[n], f"pair{n}") for n, pair in enumerate(report.pairs)),
        rigs="\n".join(_rig(name, text) for name, text in report.rig_texts.items()),
        versions="<h3>Versions</h3>" + definition_table("Versions", report.versions.items()),
    )


def _counted(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def _notes(report: Report) -> str:
    failed = [
        f"{each['source']}, {each['rig']}, {each['method']}: {each['reason']}"
        for each in report.failures
    ]
    parts = ""
    if failed:
        parts += f'<div class="notes" role="note">These cases failed:{bullets(failed)}</div>'
    if report.notes:
        parts += f'<div class="notes" role="note">Take note:{bullets(report.notes)}</div>'
    return parts


def _contents(titles: Sequence[str]) -> str:
    links = [("numbers", "Numbers")]
    links += [(f"pair{n}", title) for n, title in enumerate(titles)]
    links.append(("rigs", "Rigs and versions"))
    return "\n".join(f'<li><a href="#{name}">{escape(text)}</a></li>' for name, text in links)


def _plots(plots: tuple[Plot, ...]) -> str:
    if not plots:
        return ""
    drawn = [
        figure(
            f'<img src="{data_uri("image/svg+xml", plot.svg)}" alt="{escape(plot.words)}">',
            escape(plot.title),
        )
        for plot in plots
    ]
    return f'<div class="plots">{"".join(drawn)}</div>'


def _pair(pair: Pair, title: str, name: str) -> str:
    eyes = "\n".join(_eye(eye, f"{name}-{eye.side}") for eye in pair.eyes)
    return (
        f'<section class="pair" id="{name}"><h2>{escape(title)}</h2>'
        f'<p class="facts">{escape(pair.facts)}</p>{eyes}</section>'
    )


def _eye(eye: Eye, name: str) -> str:
    title = f"{eye.side.capitalize()} eye"
    head = f'<section class="eye" aria-label="{title}"><h3>{title}</h3>'
    head += f'<p class="facts">{escape(eye.paper)}</p>'
    if not eye.views:
        return f"{head}<p>No case of it was computed.</p></section>"
    target = picture(eye.target, f"{title}: the target", f"{name}-target")
    seen = [figure(target, "<b>target</b>: what should be seen")]
    seen += [
        _seen(view, f"{title}: seen {_words(view)}", f"{name}-{view.method}") for view in eye.views
    ]
    panels = [
        figure(
            picture(
                view.panel, f"{title}: the panel, {view.method}", f"{name}-{view.method}-panel"
            ),
            f"<b>panel</b>, {escape(view.method)}",
        )
        for view in eye.views
        if view.method != "none"
    ]
    shown = f'<div class="gallery">{"".join(seen)}</div>'
    if panels:
        shown += f'<h4>What the panel shows</h4><div class="gallery">{"".join(panels)}</div>'
    notes = list(dict.fromkeys(note for view in eye.views for note in view.notes))
    said = f'<div class="notes" role="note">{bullets(notes)}</div>' if notes else ""
    return (
        head
        + _compare(eye, name)
        + shown
        + _maps(eye, title)
        + _plots(eye.plots)
        + said
        + "</section>"
    )


def _words(view: View) -> str:
    return METHOD_WORDS.get(view.method, view.method)


def _seen(view: View, words: str, name: str) -> str:
    values = flat(view.values)
    said = [
        f"{METRICS[key].title} {number_text(values[key])} {METRICS[key].unit}".rstrip()
        for key in ("psnr_db", "ssim")
        if values.get(key) is not None
    ]
    caption = f"<b>seen</b> {escape(_words(view))}" + "".join(f", {each}" for each in said)
    return figure(picture(view.seen, words, name), caption)


def _compare(eye: Eye, name: str) -> str:
    """Two pictures one over the other; the script fills them in from those that are shown."""
    choices = [(f"{name}-target", "target")]
    choices += [(f"{name}-{view.method}", f"seen, {_words(view)}") for view in eye.views]
    choices += [
        (f"{name}-{view.method}-panel", f"panel, {view.method}")
        for view in eye.views
        if view.method != "none"
    ]
    first = f"{name}-none" if any(view.method == "none" for view in eye.views) else choices[0][0]
    second = f"{name}-{eye.views[-1].method}"
    if first == second:
        first = choices[0][0]
    zooms = (("fit", "fit"), ("1", "1 : 1"), ("2", "2 : 1"), ("4", "4 : 1"), ("8", "8 : 1"))
    return (
        "<noscript><p>The comparison needs scripts; all pictures are below.</p></noscript>"
        f'<div class="compare" role="group" aria-label="Compare pictures of the {eye.side} eye">'
        '<div class="controls">'
        f"{_select('first', 'Left of the border', choices, first)}"
        f"{_select('second', 'Right of it', choices, second)}"
        f"{_select('zoom', 'Size', zooms, 'fit')}"
        '<label class="cut">Border between them'
        '<input type="range" min="0" max="100" step="0.5" value="50"></label></div>'
        '<div class="scroll" tabindex="0" role="region" aria-label="The two pictures">'
        '<div class="stage"><img class="under" alt=""><img class="over" alt="">'
        '<span class="edge"></span></div></div></div>'
    )


def _select(kind: str, label: str, choices: Sequence[tuple[str, str]], chosen: str) -> str:
    options = "".join(
        f'<option value="{escape(value)}"{" selected" if value == chosen else ""}>'
        f"{escape(text)}</option>"
        for value, text in choices
    )
    return f'<label>{label}<select class="{kind}">{options}</select></label>'


def _maps(eye: Eye, title: str) -> str:
    kinds = dict.fromkeys(each.title for view in eye.views for each in view.maps)
    return "".join(_kind_of_map(kind, eye, title) for kind in kinds)


def _kind_of_map(kind: str, eye: Eye, title: str) -> str:
    heading, least, most = _MAP_WORDS.get(kind, (kind, "0", "1"))
    shown: list[tuple[View, Map]] = [
        (view, each) for view in eye.views for each in view.maps if each.title == kind
    ]
    figures = [
        figure(picture(each.png, f"{title}: {heading}, {_words(view)}"), escape(_words(view)))
        for view, each in shown
    ]
    scale = colour_scale(least, most)
    return (
        f'<h4>{escape(heading)}</h4>{scale}<div class="gallery">{"".join(figures)}</div>'
        f'<p class="facts">Grey: the border of {eye.border_px} pixels, which is not judged.</p>'
    )


def _rig(name: str, text: str) -> str:
    return f"<details><summary>{escape(name)}</summary><pre>{escape(text)}</pre></details>"
