"""Layouts of sub-pixels: their files, what they emit, and what is said of a wrong one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from vrlf.errors import InputError, RigError
from vrlf.model import layout_names, subpixel_layout
from vrlf.model.layouts import layout_from_tables
from vrlf.optics.subpixels import layout, layout_of


def test_stripes() -> None:
    """Red at the left of rgb, at the right of bgr; what a colour lacks in area it gains."""
    rgb, bgr = layout("rgb-stripe"), layout("bgr-stripe")
    # Exactly these: known results depend on the last bit.
    thirds = [[k / 3.0, 0.0, (k + 1) / 3.0, 1.0] for k in range(3)]
    assert rgb.rectangles.tolist() == thirds
    assert bgr.rectangles.tolist() == thirds[::-1]
    assert rgb.gain == pytest.approx([3.0, 3.0, 3.0])
    assert layout("full").rectangles.tolist() == [[0.0, 0.0, 1.0, 1.0]] * 3
    assert layout("full").gain.tolist() == [1.0, 1.0, 1.0]
    assert [name for name in layout_names() if layout(name).is_shared] == ["full"]


def test_a_black_border_is_brought_in_by_radiance() -> None:
    bordered = layout("rgb-stripe-bordered")
    plain = layout("rgb-stripe").rectangles
    size = bordered.rectangles[:, 2:] - bordered.rectangles[:, :2]
    assert size == pytest.approx(np.tile([0.25, 0.75], (3, 1)))
    assert bordered.gain == pytest.approx([16 / 3] * 3)
    middle = (bordered.rectangles[:, 2:] + bordered.rectangles[:, :2]) / 2.0
    assert middle == pytest.approx((plain[:, 2:] + plain[:, :2]) / 2.0)


@pytest.mark.parametrize("name", layout_names())
def test_a_white_field_gives_the_same_light_in_every_layout(name: str) -> None:
    emission = layout(name)
    size = emission.rectangles[:, 2:] - emission.rectangles[:, :2]
    light = size.prod(axis=1).reshape(-1, 3) * emission.gain
    assert light.mean(axis=0) == pytest.approx(np.ones(3))
    assert emission.rectangles.min() >= 0.0
    assert emission.rectangles.max() <= 1.0
    assert len(emission.rectangles) == 3 * emission.period[0] * emission.period[1]
    assert subpixel_layout(name).source


@pytest.mark.parametrize("name", ["pentile-rgbg", "pentile-diamond"])
def test_pentile_has_green_everywhere_and_red_or_blue_by_turns(name: str) -> None:
    emission = layout(name)
    rows, columns = np.indices((6, 8))
    boxes = emission.at(columns, rows)
    has = boxes[..., 2] > boxes[..., 0]
    assert has[..., 1].all()
    even = (rows + columns) % 2 == 0
    assert np.array_equal(has[..., 0], even)
    assert np.array_equal(has[..., 2], ~even)
    # Before the panel's corner the period goes on.
    assert np.array_equal(emission.at(-1, -2), emission.at(1, 0))
    assert len(emission.lit) == 8


FULL = [0.0, 0.0, 1.0, 1.0]


def tables(**changes: Any) -> dict[str, Any]:
    """Two columns, red and green, then blue alone."""
    pixels = [{"red": [0.0, 0.0, 0.5, 1.0], "green": FULL}, {"blue": [0.5, 0.25, 1.0, 1.0]}]
    return {"source": "a test", "columns": 2, "rows": 1, "pixels": pixels} | changes


def test_periods_of_columns_and_of_rows() -> None:
    across = layout_of(layout_from_tables(tables(), source="test"))
    down = layout_of(layout_from_tables(tables(columns=1, rows=2), source="test"))
    assert across.period == (2, 1)
    assert across.gain == pytest.approx([4.0, 2.0, 2 / 0.375])
    rows, columns = np.indices((4, 4))
    lacking = across.at(columns, rows)[..., 2] == 0.0
    assert np.array_equal(lacking[..., 0], columns % 2 == 1)
    assert np.array_equal(down.at(columns, rows), across.at(rows, columns))


@pytest.mark.parametrize(
    ("changes", "wanted"),
    [
        ({"columns": 0}, "columns: found 0, wanted a whole number from 1 to 2"),
        ({"rows": 3}, "rows: found 3, wanted a whole number from 1 to 2"),
        ({"pixels": []}, "pixels: found 0 pixels, wanted 2 of them"),
        ({"columns": 1}, "pixels: found 2 pixels, wanted 1 of them"),
        ({"colour": 1}, "colour: found an unknown key, wanted one of source, columns"),
        ({"pixels": [{"red": FULL}, {"green": FULL}]}, "pixels: found no blue, wanted blue"),
        (
            {"pixels": [{"white": FULL}, {"blue": FULL}]},
            r"pixels\[0\]\.white: found an unknown key, wanted one of red, green, blue",
        ),
        (
            {"pixels": [{"red": FULL}, {"blue": [0.5, 0.0, 1.5, 1.0]}]},
            r"pixels\[1\]\.blue: found \[0\.5, 0\.0, 1\.5, 1\.0\], wanted \[left, top, right",
        ),
        (
            {"pixels": [{"red": [0.5, 0.0, 0.5, 1.0]}, {"blue": FULL}]},
            r"pixels\[0\]\.red: found \[0\.5, 0\.0, 0\.5, 1\.0\], wanted left < right",
        ),
        ({"source": ""}, 'source: found "", wanted a text'),
        ({"pixels": "none"}, 'pixels: found "none", wanted a table'),
    ],
)
def test_a_wrong_layout_is_one_line(changes: dict[str, Any], wanted: str) -> None:
    with pytest.raises(RigError, match=wanted) as caught:
        layout_from_tables(tables(**changes), source="layouts/test.toml")
    assert str(caught.value).startswith("layouts/test.toml: ")
    assert "\n" not in str(caught.value)
    assert len(caught.value.problems) == 1


def test_an_unknown_layout_is_one_line() -> None:
    wanted = r'panel\.subpixels: found "delta", wanted one of "full", "rgb-stripe"'
    with pytest.raises(InputError, match=wanted):
        layout("delta")
