"""Which part of which file belongs to which eye."""

from __future__ import annotations

import shutil
from pathlib import Path

import files_by_hand as by_hand
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vrlf.content.pictures import Layout, join_viewports, load_stereo, split_viewports
from vrlf.errors import ImageReadError
from vrlf.images import srgb_decode

PANEL = (13, 6)  # odd, so that there is a middle column


def put(path: Path, width: int, height: int) -> np.ndarray:
    """Write a picture of some size; its light comes back."""
    codes = by_hand.asymmetric(height, width)
    path.write_bytes(by_hand.png(codes))
    return srgb_decode(codes / 255).astype(np.float32)


def test_a_picture_of_the_panels_size_is_taken_pixel_for_pixel(tmp_path: Path) -> None:
    light = put(tmp_path / "a_ou.png", *PANEL)  # the size outweighs the name
    source = load_stereo(tmp_path / "a_ou.png", panel_size=PANEL)
    assert np.array_equal(source.left, light[:, :6])
    assert np.array_equal(source.right, light[:, 7:])  # column 6 is nobody's
    assert (source.layout, source.pixel_for_pixel, source.pixel_aspect) == (
        "side-by-side",
        True,
        1.0,
    )


def test_the_panels_size_can_still_be_called_mono(tmp_path: Path) -> None:
    light = put(tmp_path / "a.png", *PANEL)
    source = load_stereo(tmp_path / "a.png", panel_size=PANEL, layout="mono")
    assert np.array_equal(source.left, light)
    assert source.right is source.left
    assert not source.pixel_for_pixel


@pytest.mark.parametrize(
    ("name", "size", "layout"),
    [
        ("plain.png", (20, 10), "mono"),
        ("cinema.png", (24, 10), "mono"),  # exactly 2.4 is not wider than 2.4
        ("wide.png", (25, 10), "side-by-side"),
        ("a_sbs.png", (20, 10), "side-by-side"),
        ("a_SBS_1080p.png", (20, 10), "side-by-side"),
        ("a_lr.png", (20, 10), "side-by-side"),
        ("a_hsbs.png", (20, 10), "half-side-by-side"),
        ("a_ou.png", (25, 10), "over-under"),
        ("a_tb.png", (20, 10), "over-under"),
        ("a_hou.png", (20, 10), "half-over-under"),
        ("a_htb.png", (20, 10), "half-over-under"),
        ("a_outside.png", (20, 10), "mono"),
        ("sbs.png", (20, 10), "mono"),
    ],
)
def test_hints_in_the_name_and_the_shape(
    tmp_path: Path, name: str, size: tuple[int, int], layout: Layout
) -> None:
    put(tmp_path / name, *size)
    assert load_stereo(tmp_path / name, panel_size=PANEL).layout == layout


@pytest.mark.parametrize("cross_eyed", [False, True])
@pytest.mark.parametrize(
    ("layout", "first", "second", "aspect"),
    [
        ("side-by-side", np.s_[:, :10], np.s_[:, 11:], 1.0),
        ("half-side-by-side", np.s_[:, :10], np.s_[:, 11:], 2.0),
        ("over-under", np.s_[:4], np.s_[5:], 1.0),
        ("half-over-under", np.s_[:4], np.s_[5:], 0.5),
        ("mono", np.s_[:], np.s_[:], 1.0),
    ],
)
def test_layouts_on_odd_sizes(
    tmp_path: Path,
    layout: Layout,
    first: tuple[slice, ...],
    second: tuple[slice, ...],
    aspect: float,
    cross_eyed: bool,
) -> None:
    light = put(tmp_path / "a_sbs.png", 21, 9)
    source = load_stereo(
        tmp_path / "a_sbs.png", panel_size=PANEL, layout=layout, cross_eyed=cross_eyed
    )
    left, right = (second, first) if cross_eyed else (first, second)
    assert np.array_equal(source.left, light[left])
    assert np.array_equal(source.right, light[right])
    assert (source.layout, source.pixel_aspect, source.pixel_for_pixel) == (layout, aspect, False)
    assert source.left.flags.c_contiguous
    assert source.right.flags.c_contiguous


def test_a_stereo_jpeg_has_the_right_eye_first(tmp_path: Path) -> None:
    light = put(tmp_path / "a.png", 20, 10)
    shutil.copy(tmp_path / "a.png", tmp_path / "a.jps")
    for cross_eyed in (False, True):  # saying so as well changes nothing
        source = load_stereo(tmp_path / "a.jps", panel_size=PANEL, cross_eyed=cross_eyed)
        assert source.layout == "side-by-side"
        assert np.array_equal(source.left, light[:, 10:])
    named = load_stereo(tmp_path / "a.jps", panel_size=PANEL, layout="side-by-side")
    assert np.array_equal(named.left, light[:, :10])


@pytest.mark.parametrize(
    ("size", "layout", "fits"),
    [
        ((6, 6), "mono", True),
        ((6, 12), "over-under", True),
        ((12, 6), "side-by-side", True),  # another width than the panel's, the same halves
        ((12, 6), "half-side-by-side", False),  # the pixels are not square
        ((7, 6), "mono", False),
    ],
)
def test_pictures_that_have_the_viewports_raster(
    tmp_path: Path, size: tuple[int, int], layout: Layout, fits: bool
) -> None:
    put(tmp_path / "a.png", *size)
    source = load_stereo(tmp_path / "a.png", panel_size=PANEL, layout=layout)
    assert source.pixel_for_pixel is fits


def test_a_file_for_each_eye(tmp_path: Path) -> None:
    light = put(tmp_path / "l_sbs.png", 6, 6)
    (tmp_path / "r.png").write_bytes(by_hand.png(by_hand.asymmetric(6, 6)[::-1]))
    pair = {"panel_size": PANEL, "right_path": tmp_path / "r.png"}
    source = load_stereo(tmp_path / "l_sbs.png", **pair)  # type: ignore[arg-type]
    assert np.array_equal(source.left, light)
    assert np.array_equal(source.right, light[::-1])
    assert (source.layout, source.pixel_for_pixel) == ("mono", True)
    crossed = load_stereo(tmp_path / "l_sbs.png", cross_eyed=True, **pair)  # type: ignore[arg-type]
    assert np.array_equal(crossed.left, light[::-1])


def test_files_that_do_not_go_together(tmp_path: Path) -> None:
    put(tmp_path / "l.png", 6, 6)
    put(tmp_path / "r.png", 7, 6)
    with pytest.raises(ImageReadError, match=r"found 7x6 pixels, wanted 6x6 like .*l\.png"):
        load_stereo(tmp_path / "l.png", panel_size=PANEL, right_path=tmp_path / "r.png")
    with pytest.raises(ImageReadError, match="wanted the layout mono"):
        load_stereo(
            tmp_path / "l.png",
            panel_size=PANEL,
            layout="over-under",
            right_path=tmp_path / "l.png",
        )


@pytest.mark.parametrize(
    ("layout", "size", "found"),
    [("side-by-side", (1, 9), "1x9"), ("half-over-under", (9, 1), "9x1")],
)
def test_pictures_too_small_to_be_split(
    tmp_path: Path, layout: Layout, size: tuple[int, int], found: str
) -> None:
    put(tmp_path / "a.png", *size)
    with pytest.raises(ImageReadError, match=f"found {found} pixels, wanted at least 2"):
        load_stereo(tmp_path / "a.png", panel_size=PANEL, layout=layout)


def test_encoding_is_passed_on(tmp_path: Path) -> None:
    put(tmp_path / "a.png", 6, 6)
    source = load_stereo(tmp_path / "a.png", panel_size=PANEL, encoding="linear")
    assert np.array_equal(source.left, (by_hand.asymmetric(6, 6) / 255).astype(np.float32))


@given(st.integers(2, 31), st.integers(1, 9), st.sampled_from([(), (3,)]))
def test_split_and_join_are_inverse_but_for_a_dark_middle(
    width: int, height: int, channels: tuple[int, ...]
) -> None:
    count = width * height * (3 if channels else 1)
    panel = np.arange(1, count + 1, dtype=np.float32).reshape(height, width, *channels)
    left, right = split_viewports(panel)
    joined = join_viewports(left, right, (width, height))
    expected = panel.copy()
    if width % 2:
        expected[:, width // 2] = 0
    assert np.array_equal(joined, expected)
    assert joined.dtype == panel.dtype


def test_viewports_of_another_size_are_refused() -> None:
    left = np.zeros((6, 6, 3))
    with pytest.raises(ValueError, match="right viewport"):
        join_viewports(left, np.zeros((6, 7, 3)), PANEL)
    with pytest.raises(ValueError, match="left viewport"):
        join_viewports(left, left, (14, 6))
