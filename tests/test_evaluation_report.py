"""The report's page as text, and its numbers as JSON and CSV."""

from __future__ import annotations

import csv
import io
import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from report_by_hand import METHODS, SOURCES, report

from vrlf.evaluation.report import (
    columns_of,
    flat,
    report_html,
    results_csv,
    results_json,
    short_names,
)
from vrlf.evaluation.report.parts import number_text

VOID = {"meta", "link", "img", "input", "br"}


class Page(HTMLParser):
    """Tags with their attributes; holds that every one that opens is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[str] = []
        self._open: list[str] = []
        self.feed(text)
        self.close()
        assert self._open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self._open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)

    def all(self, tag: str) -> list[dict[str, str | None]]:
        """Attributes of every tag of that name."""
        return [attributes for name, attributes in self.tags if name == tag]


@pytest.fixture(scope="module")
def page() -> Page:
    """The invented report."""
    return Page(report_html(report()))


def test_nothing_comes_from_elsewhere(page: Page) -> None:
    for _, attributes in page.tags:
        for name in ("src", "href"):
            target = attributes.get(name) or ""
            assert target == "" or target.startswith(("data:", "#")), target
    (policy,) = [m["content"] for m in page.all("meta") if m.get("http-equiv")]
    assert policy is not None
    assert policy.startswith("default-src 'none'; img-src data:;")
    assert not re.search(r"https?:(?!//www\.w3\.org/)", report_html(report()))


def test_names_are_text_and_no_markup(page: Page) -> None:
    assert not page.all("b") or all(not attributes for attributes in page.all("b"))
    assert not page.all("i") or all("style" in attributes for attributes in page.all("i"))
    assert len(page.all("script")) == 1
    text = "".join(page.texts)
    for words in (*SOURCES, "</pre><script>", "<i>no</i> room", "cvvdp_jod: found no pycvvdp"):
        assert words in text


def test_every_picture_says_what_it_shows_and_names_are_unique(page: Page) -> None:
    names = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len(names) == len(set(names))
    pictures = [each for each in page.all("img") if "src" in each]
    # Target, three views, two panels, three maps for each of four eyes; one plot.
    assert len(pictures) == 4 * 9 + 1
    assert all(each["alt"] for each in pictures)
    for options in ("first", "second"):
        chosen = [each for each in page.all("select") if each.get("class") == options]
        assert len(chosen) == 4
    wanted = {each["value"] for each in page.all("option")} - {"fit", "1", "2", "4", "8"}
    assert wanted <= set(names)


def test_the_table_has_numbers_and_no_curves(page: Page) -> None:
    names = [column.name for column in columns_of(report())]
    assert names == ["psnr_db", "ssim", "hdr_vdp.q_mos", "hdr_vdp.q", "gain"]
    assert sum(attributes.get("class") == "number best" for attributes in page.all("td")) == 16
    assert "contrast.0.5" in [column.name for column in columns_of(report(), curves=True)]


def test_json_has_cases_or_one_at_the_top() -> None:
    both = results_json(report())
    assert [case["source"] for case in both["cases"]] == list(SOURCES)
    one = results_json(replace(report(), pairs=report().pairs[:1]))
    assert one["source"] == SOURCES[0]
    assert one["left"].keys() == set(METHODS)
    assert one["left"]["none"]["psnr_db"] is None
    assert one["left"]["forward"]["hdr_vdp"] == {"q_mos": 18.5, "q": -9.25}
    assert one["throughput"] == 0.25
    json.dumps(one, allow_nan=False)


def test_csv_has_a_line_for_each_eye_and_method() -> None:
    rows = list(csv.DictReader(io.StringIO(results_csv(report()))))
    assert len(rows) == 12
    assert rows[0]["source"] == SOURCES[0]
    assert rows[0]["psnr_db"] == ""
    assert float(rows[1]["psnr_db"]) == 9.25
    assert float(rows[1]["contrast.10"]) == 0.25


def test_a_report_of_failures_alone_is_a_page() -> None:
    bare = report()
    empty = tuple(
        replace(pair, eyes=tuple(replace(eye, views=()) for eye in pair.eyes))
        for pair in bare.pairs
    )
    page = Page(report_html(replace(bare, pairs=empty, plots=())))
    assert "No case of it was computed." in "".join(page.texts)


@pytest.mark.parametrize(
    ("names", "wanted"),
    [
        (["a/b.png", "c/d.png"], ["b.png", "d.png"]),
        (["a/b.png", "c/b.png", "x"], ["a/b.png", "c/b.png", "x"]),
        (["C:\\p\\b.png", "scene"], ["b.png", "scene"]),
        (["/"], ["/"]),
    ],
)
def test_short_names(names: list[str], wanted: list[str]) -> None:
    assert list(short_names(names).values()) == wanted


def test_flat_values() -> None:
    assert flat({"a": 1.0, "b": {"x": 2.0, "0.5": 3.0}, "c": None}) == {
        "a": 1.0,
        "b.x": 2.0,
        "b.0.5": 3.0,
        "c": None,
    }


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "–"), (0.0, "0.000"), (31.5234, "31.52"), (1234.5, "1234"), (1.2e7, "1.200e+07")],
)
def test_number_text(value: float | None, text: str) -> None:
    assert number_text(value) == text
