"""Labels: in their box, upright, cut at the edges, and nothing else is touched."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from vrlf.errors import VrlfError
from vrlf.images import draw_text, text, text_size


def blank(height: int = 60, width: int = 200) -> np.ndarray:
    return np.zeros((height, width, 3), np.float32)


def test_the_ink_lies_in_its_box() -> None:
    label = "Hägyp -5.00 D"
    width, height = text_size(label, 24)
    image = draw_text(blank(80, 300), label, 30, 20, size_px=24)
    rows, columns = np.nonzero(image[..., 1])
    assert rows.min() >= 20
    assert rows.max() < 20 + height
    # One pixel of smoothing may stand beyond each side.
    assert 29 <= columns.min() <= 34
    assert 30 + width - 4 <= columns.max() <= 30 + width


def test_letters_stand_upright_and_unmirrored() -> None:
    image = draw_text(blank(), "L", 10, 10, size_px=40)[..., 0]
    rows, columns = np.nonzero(image > 0.5)
    glyph = image[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
    left, right = glyph[:, : glyph.shape[1] // 3], glyph[:, -glyph.shape[1] // 3 :]
    top, bottom = glyph[: glyph.shape[0] // 3], glyph[-glyph.shape[0] // 3 :]
    assert left.mean() > 2 * right.mean()
    assert bottom.mean() > 1.5 * top.mean()


def test_full_ink_has_the_colour_and_no_ink_changes_nothing() -> None:
    ground = np.random.default_rng(1).random((60, 200, 3)).astype(np.float32)
    colour = (0.8, 0.1, 0.4)
    image = ground.copy()
    assert draw_text(image, "I", 20, 5, size_px=48, color=colour) is image
    changed = (image != ground).any(axis=2)
    rows, columns = np.nonzero(changed)
    assert columns.min() >= 19
    assert columns.max() <= 20 + text_size("I", 48)[0]
    middle = image[(rows.min() + rows.max()) // 2, (columns.min() + columns.max()) // 2]
    assert np.allclose(middle, colour, rtol=0, atol=1e-6)  # float32, there and back


def test_an_edge_of_half_ink_is_half_way_in_srgb() -> None:
    ink = np.array([[0.5]], np.float32)
    image = np.zeros((1, 1, 3), np.float32)
    text._blend(image, ink, 0, 0, (1.0, 1.0, 1.0))
    # sRGB 0.5 in linear light, IEC 61966-2-1; 1e-6 for float32.
    assert np.allclose(image, ((0.5 + 0.055) / 1.055) ** 2.4, rtol=0, atol=1e-6)


@pytest.mark.parametrize(("x", "y"), [(-20, 10), (190, 10), (10, -9), (10, 55), (-500, 0), (0, 99)])
def test_what_lies_outside_is_cut_off(x: int, y: int) -> None:
    large = draw_text(blank(260, 1400), "Cut", x + 600, y + 100, size_px=24)
    small = draw_text(blank(), "Cut", x, y, size_px=24)
    assert np.array_equal(small, large[100:160, 600:800])


def test_lines_are_drawn_one_below_the_other() -> None:
    width, height = text_size("wide line\nI", 20)
    assert (width, height) == (text_size("wide line", 20)[0], 2 * text_size("I", 20)[1])
    both = draw_text(blank(80), "A\nB", 5, 3, size_px=20)
    apart = draw_text(blank(80), "A", 5, 3, size_px=20)
    draw_text(apart, "B", 5, 3 + height // 2, size_px=20)
    assert np.array_equal(both, apart)


def test_no_text_is_no_ink() -> None:
    assert text_size("", 20)[0] == 0
    assert not draw_text(blank(), "", 5, 5, size_px=20).any()
    assert not draw_text(blank(), "   ", 5, 5, size_px=20).any()


def test_sizes_grow_with_the_font() -> None:
    widths = [text_size("headset", size)[0] for size in (8, 16, 32, 64)]
    for small, large in pairwise(widths):
        assert large == pytest.approx(2 * small, rel=0.15)  # widths are whole pixels


def test_a_size_of_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="at least 1"):
        draw_text(blank(), "a", 0, 0, size_px=0)


def test_a_missing_font_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text, "assets_dir", lambda: tmp_path)
    with pytest.raises(VrlfError, match=r"DejaVuSans\.ttf"):
        draw_text(blank(), "a", 0, 0, size_px=10)
