"""The report as one HTML page that stands by itself: pictures inlined, no script, no network."""

from __future__ import annotations

import base64
from html import escape
from typing import Final

from vrlf import __version__
from vrlf.studies.reproduce.item import Item, Number, Picture
from vrlf.studies.reproduce.run import ITEMS, Report, cells

_POLICY: Final = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
_STYLE: Final = """
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 75rem; padding: 0 1rem; }
h2 { margin-top: 3rem; border-top: 1px solid #8888; padding-top: 1rem; }
.sides { display: grid; grid-template-columns: repeat(auto-fit, minmax(20rem, 1fr)); gap: 1rem; }
.sides > div { border: 1px solid #8888; border-radius: .4rem; padding: .2rem 1rem; }
.sides h3 { margin: .5rem 0 0; font-size: 1rem; }
figure { margin: 1rem 0; }
figure img { max-width: 100%; height: auto; background: white; }
figcaption, .quiet { color: #777; font-size: .9rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; width: 100%; }
th, td { text-align: left; padding: .2rem .6rem; border-bottom: 1px solid #8884; }
td { vertical-align: top; }
th.n, td.n { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
.failed { border-left: .3rem solid #d55e00; padding-left: 1rem; }
"""


def report_html(report: Report) -> str:
    """The whole page."""
    body = [
        "<h1>The thesis's results and ours</h1>",
        "<p>L. Yang, <i>An Investigation into Microlens Array Based Light Field Display for Vision "
        "Aberration Correction and Applications to Virtual Reality</i>, UC Berkeley "
        "EECS-2020-27, beside what vrlf computes from content of its own. All numbers are in "
        "reproduce.json.</p>",
        f'<p class="quiet">vrlf {escape(__version__)}; {escape(report.device or "no GPU needed")}; '
        f"{sum(report.seconds.values()):.0f} s.</p>",
        _contents(report),
        *(_failure(name, why) for name, why in report.failed.items()),
        *(_section(item) for item in report.items),
    ]
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width">\n'
        f"<title>vrlf reproduce</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        + "\n".join(body)
        + "\n</body>\n</html>\n"
    )


def _contents(report: Report) -> str:
    links = "".join(
        f'<li><a href="#{escape(item.name)}">{escape(item.title)}</a></li>' for item in report.items
    )
    return f"<ul>{links}</ul>"


def _failure(name: str, why: str) -> str:
    return (
        f'<p class="failed"><b>{escape(name)}</b>, {escape(ITEMS[name][0])}, could not be made: '
        f"{escape(why)}</p>"
    )


def _section(item: Item) -> str:
    return (
        f'<section id="{escape(item.name)}">\n<h2>{escape(item.title)}</h2>\n<div class="sides">'
        f"<div><h3>The thesis says</h3><p>{escape(item.thesis_says)}</p></div>"
        f"<div><h3>We find</h3><p>{escape(item.we_find)}</p></div></div>\n"
        + "\n".join(_figure(each) for each in item.pictures)
        + f"\n{_numbers(item.numbers)}\n</section>"
    )


def _figure(picture: Picture) -> str:
    data = base64.b64encode(picture.png).decode("ascii")
    caption = escape(picture.caption)
    return (
        f'<figure><img src="data:image/png;base64,{data}" alt="{caption}">'
        f"<figcaption>{caption}</figcaption></figure>"
    )


def _numbers(numbers: tuple[Number, ...]) -> str:
    rows = []
    for each in numbers:
        ours, thesis, difference = (escape(text) for text in cells(each))
        rows.append(
            f'<tr><td>{escape(each.what)}</td><td class="n">{ours}</td><td class="n">{thesis}</td>'
            f'<td class="n">{difference}</td><td>{escape(each.unit)}</td>'
            f"<td>{escape(each.sentence)}</td></tr>"
        )
    return (
        '<div class="wide"><table><thead><tr><th>quantity</th><th class="n">ours</th>'
        '<th class="n">thesis</th><th class="n">difference</th><th>unit</th><th></th></tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table></div>"
    )
