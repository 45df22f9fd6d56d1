"""Print: letters, text in its box, and the shader's box means against plain sums."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from vrlf.gpu import Block, Canvas, Device, DrawPass, Field, Texture, draw
from vrlf.resources import shaders_dir
from vrlf.scene.glyphs import TEXEL_M, glyph, set_text, summed_area, word
from vrlf.scene.pages import LEFT_PAGE, NOTICE, RIGHT_PAGE, SLIP, printed

Ink = NDArray[np.float32]


def as_text(ink: Ink) -> list[str]:
    """Rows of ink, a sign a texel."""
    return ["".join(".#"[int(value)] for value in row) for row in ink]


def test_letters_are_upright_and_not_mirrored() -> None:
    assert as_text(glyph("F")) == ["#####", "#....", "#....", "###..", "#....", "#....", "#...."]
    assert as_text(glyph("j")) == ["...#", "....", "..##", "...#", "...#", "#..#", ".##."]


def test_a_word_has_gaps_of_one_column() -> None:
    assert word("Ii,").shape == (7, 3 + 1 + 3 + 1 + 2)
    assert not word("HH")[:, 5].any()


def test_text_stays_in_its_box_and_breaks_between_words() -> None:
    page = np.zeros((60, 60), np.float32)
    # Three words of 2 * 5 + 1 = 11 columns and 4 between: two fit into 26 columns.
    free = set_text(page, "HH HH HH", box=(7, 9, 33, 50), scale=1)
    inked = np.argwhere(page > 0)
    assert inked.min(axis=0).tolist() == [9, 7]
    assert inked.max(axis=0).tolist() == [9 + 10 + 6, 7 + 11 + 4 + 11 - 1]
    assert free == 9 + 2 * 10


def test_what_does_not_fit_is_left_out() -> None:
    page = np.zeros((30, 40), np.float32)
    set_text(page, "HH HH HH", box=(2, 2, 14, 20), scale=1)
    assert page[20:].sum() == 0
    assert page[:, 14:].sum() == 0
    set_text(page, "HHHHHHHHHH", box=(20, 2, 30, 20), scale=1)
    assert page[:, 20:].sum() == 0


def test_sheets_do_not_overlap_and_all_carry_print() -> None:
    ink = printed()
    owner = np.zeros(ink.shape, int)
    for sheet in (LEFT_PAGE, RIGHT_PAGE, SLIP, NOTICE):
        here = (slice(sheet.top, sheet.top + sheet.height),)
        here += (slice(sheet.left, sheet.left + sheet.width),)
        owner[here] += 1
        # Body text covers a tenth of a page and more; the notice has wide margins.
        assert ink[here].mean() > 0.05
        assert owner[here].shape == (sheet.height, sheet.width)
    assert owner.max() == 1
    assert ink[owner == 0].sum() == 0
    assert set(np.unique(ink)) == {0.0, 1.0}


def test_table_sums_by_hand() -> None:
    table, mean = summed_area(np.array([[1, 0, 0], [1, 1, 1]], np.float32))
    assert mean == pytest.approx(2.0 / 3.0)
    whole = table[2, 2] - table[2, 0] - table[0, 2] + table[0, 0]
    assert whole + 4 * mean == pytest.approx(3.0, abs=1e-6)
    assert table[-1, -1] == pytest.approx(0.0, abs=1e-6)


def ink_by_hand(ink: Ink, centre: tuple[float, float], size: tuple[float, float]) -> float:
    """Mean over a box: every texel weighted with the part of it that the box covers."""
    weights = []
    for at, length, count in zip(centre, size, ink.shape[::-1], strict=True):
        edges = np.arange(count + 1)
        inside = np.clip(edges, at - length / 2, at + length / 2)
        weights.append(np.diff(inside))
    return float(weights[1] @ ink @ weights[0] / (size[0] * size[1]))


PROBE = Block("Probe", (Field("vec4", "asked", "centre and box of the mean, metres"),))
_PROBE_VERT = """void main() {
    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}
"""
_PROBE_FRAG = """#include "block/Probe"
layout(binding = 0) uniform sampler2D print_sums;
out vec4 light;
#include "scene/print.glsl"
void main() { light = vec4(ink_over(asked.xy, asked.zw)); }
"""


def test_the_shader_means_over_any_box(
    device: Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "scene").mkdir()
    source = (shaders_dir() / "scene" / "print.glsl").read_text(encoding="utf-8")
    (tmp_path / "scene" / "print.glsl").write_text(source, encoding="utf-8")
    (tmp_path / "probe.vert").write_text(_PROBE_VERT, encoding="utf-8")
    (tmp_path / "probe.frag").write_text(_PROBE_FRAG, encoding="utf-8")
    monkeypatch.setattr(draw, "shaders_dir", lambda: tmp_path)
    ink = printed()[:900, :700]
    table, mean = summed_area(ink)
    sums = Texture.from_array(device, table, label="sums")
    canvas = Canvas(device, (1, 1), kind="f4")
    defines: dict[str, int | float | str] = {"TEXEL_M": repr(TEXEL_M), "PRINT_MEAN": repr(mean)}
    probe = DrawPass(device, "probe.vert", "probe.frag", PROBE, defines=defines)
    try:
        for centre, size in (
            ((300.3, 211.8), (3.7, 1.2)),
            ((120.0, 90.0), (40.0, 9.0)),
            ((333.3, 700.1), (150.5, 260.25)),
            ((61.25, 57.5), (1.0, 1.0)),
        ):
            probe.set({"asked": (*np.multiply(centre, TEXEL_M), *np.multiply(size, TEXEL_M))})
            canvas.begin()
            sums.bind_sampler(0)
            probe.draw_screen()
            found = float(canvas.colour.read()[0, 0, 0])
            # A float32 place is good to 3e-5 texels here, the sums to 5e-4: a strip of that
            # width along a box's side, over a box of a texel or more.
            assert found == pytest.approx(ink_by_hand(ink, centre, size), abs=2e-3)
    finally:
        for thing in (probe, canvas, sums):
            thing.release()
