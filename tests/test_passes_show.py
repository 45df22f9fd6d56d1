"""What a window shows of pictures, held to the twin code by code."""

from __future__ import annotations

from typing import Any

import numpy as np
import pass_rigs
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.optics.tile import BACKGROUND_CODE, GREY_CODE, LINE_CODE, Tile, tile_at
from vrlf.passes import Encode
from vrlf.passes.show import Show, Shown
from vrlf.reference.show import on_grid, show_tile

# 21 x 13 pixels, an odd width; each pixel another colour.
RIG = pass_rigs.rig(21, 13, panel={"subpixels": "bgr-stripe"})
WINDOW = (61, 43)
FIRST, SECOND = pass_rigs.picture(RIG, 1), pass_rigs.picture(RIG, 2)
FIRST[3, 4] = (np.nan, np.inf, -1.0)

WHOLE_PX = (0, 0, 21, 13)
TILES = {
    "one to one": Tile((3, 5, 21, 13), WHOLE_PX, (0.0, 0.0), 1.0),
    "four times": Tile((2, 1, 50, 40), WHOLE_PX, (1.25, 0.5), 0.25),
    "right eye": Tile((2, 1, 50, 40), (11, 0, 10, 13), (10.0, -2.0), 0.25),
    "shrunk": Tile((7, 2, 16, 9), WHOLE_PX, (-0.7, 0.3), 1.43),
    "over the window's edge": Tile((40, 30, 40, 30), WHOLE_PX, (0.0, 0.0), 0.5),
}
HOW: dict[str, dict[str, Any]] = {
    "plain": {},
    "difference": {"second": SECOND},
    "divider": {"second": SECOND, "divider_px": 14},
    "subpixels": {"subpixels": True},
    "fading": {"fade": 0.4},
}


def shown(
    device: Device, tile: Tile, strides: tuple[int, int] = (1, 1), rig: Rig = RIG, **how: Any
) -> NDArray[Any]:
    """The canvas, row 0 at the top."""
    show = Show(device)
    canvas = Texture(device, WINDOW, kind="f1", label="canvas")
    canvas.write(np.full((*WINDOW[::-1], 4), 7, np.uint8))
    first = Texture.from_array(device, FIRST, label="first")
    second = Texture.from_array(device, SECOND, label="second")
    if "second" in how:
        how["second"] = Shown(second, strides[1])
    show.run(rig, tile, Shown(first, strides[0]), canvas, **how)
    codes = np.asarray(canvas.read()[::-1, :, :3])
    for each in (show, canvas, first, second):
        each.release()
    return codes


def expected(tile: Tile, first: NDArray[Any] = FIRST, rig: Rig = RIG, **how: Any) -> NDArray[Any]:
    """The twin's tile in a window."""
    codes = np.full((*WINDOW[::-1], 3), 7, np.uint8)
    x, y, width, height = tile.window_px
    part = show_tile(rig, tile, first.astype(np.float64), **how)
    here = codes[y : y + height, x : x + width]
    here[:] = part[: here.shape[0], : here.shape[1]]
    return codes


@pytest.mark.parametrize("how", HOW)
@pytest.mark.parametrize("name", TILES)
def test_a_tile_is_the_twins(device: Device, name: str, how: str) -> None:
    tile = TILES[name]
    difference = np.abs(
        shown(device, tile, **HOW[how]).astype(int) - expected(tile, **HOW[how]).astype(int)
    )
    # Means over areas round in 32 bits; hard pixels must be the twin's very codes.
    assert difference.max() <= (1 if tile.scale > 1.0 else 0)


def test_diamonds_stand_where_their_pixel_is_on_the_panel(device: Device) -> None:
    """The right eye's tile begins with an odd column; where a pixel lacks a colour it is dark."""
    rig = pass_rigs.rig(21, 13, panel={"subpixels": "pentile-diamond"})
    tile = Tile((2, 1, 50, 40), (11, 0, 10, 13), (11.0, 0.0), 0.125)
    codes = shown(device, tile, rig=rig, subpixels=True)
    np.testing.assert_array_equal(codes, expected(tile, rig=rig, subpixels=True))
    # Column 11, row 0 has blue and green; the next one red and green.
    assert not codes[1:9, 2:10, 0].any()
    assert codes[1:9, 2:10, 2].any()
    assert not codes[1:9, 10:18, 2].any()
    assert codes[1:9, 10:18, 0].any()


def test_one_to_one_shows_the_codes_that_files_get(device: Device) -> None:
    encode, code = Encode(device), Texture(device, (21, 13), kind="u1", label="code")
    light = Texture.from_array(device, FIRST, label="light")
    encode.run(light, code)
    codes = np.asarray(code.read()[..., :3])
    np.testing.assert_array_equal(shown(device, TILES["one to one"])[5:18, 3:24], codes)
    for each in (encode, code, light):
        each.release()


def test_what_is_no_number_is_dark(device: Device) -> None:
    assert shown(device, TILES["one to one"])[5 + 3, 3 + 4].tolist() == [0, 255, 0]


@pytest.mark.parametrize("stride", [2, 8])
def test_pixels_that_are_not_there_yet_take_the_nearest_of_their_eye(
    device: Device, stride: int
) -> None:
    tile = TILES["one to one"]
    wanted = expected(tile, on_grid(RIG, FIRST, stride))
    np.testing.assert_array_equal(shown(device, tile, (stride, 1)), wanted)
    filled = on_grid(RIG, np.dstack([np.indices((13, 21))[1]] * 3), stride)[0, :, 0]
    assert filled[:10].max() < 10
    assert filled[11:].min() >= 11
    off = filled - np.arange(21)
    # No bias to one side, but at a viewport's far edge.
    assert abs(off).max() <= max(stride // 2, stride - 1 - (10 - 1) % stride)


def test_faded_away_all_is_grey(device: Device) -> None:
    codes = shown(device, TILES["one to one"], fade=1.0)[5:18, 3:24]
    assert (codes == GREY_CODE).all()


def test_the_divider_stands_where_it_was_put(device: Device) -> None:
    codes = shown(device, TILES["one to one"], second=None, divider_px=14)
    assert (codes[6, 13:16] == LINE_CODE).all()
    codes = shown(device, TILES["one to one"], **HOW["divider"])
    left, right = (expected(TILES["one to one"], each) for each in (FIRST, SECOND))
    np.testing.assert_array_equal(codes[:, :13], left[:, :13])
    np.testing.assert_array_equal(codes[:, 16:], right[:, 16:])


def test_beside_the_crop_lies_the_background(device: Device) -> None:
    codes = shown(device, TILES["right eye"])
    assert (codes[1:9, 2:6] == BACKGROUND_CODE).all()


boxes = st.tuples(
    st.integers(-50, 50), st.integers(-50, 50), st.integers(1, 900), st.integers(1, 900)
)
zooms = st.one_of(st.none(), st.sampled_from([0.25, 1.0, 2.0, 3.0, 8.0]))
middles = st.one_of(st.none(), st.tuples(st.floats(-2000, 2000), st.floats(-2000, 2000)))


@given(window=boxes, crop=boxes, zoom=zooms, middle=middles)
def test_a_tile_shows_as_much_as_it_can(window: Any, crop: Any, zoom: Any, middle: Any) -> None:
    tile = tile_at(window, crop, zoom, middle)
    step = tile.scale if tile.scale <= 1.0 else 0.0
    if zoom is None:
        assert tile.scale >= 1.0 or (1.0 / tile.scale).is_integer()
    for axis in (0, 1):
        seen = tile.scale * window[axis + 2]
        start, first, length = tile.start_px[axis], crop[axis], crop[axis + 2]
        if seen >= length:  # all of it, with equal borders
            assert start + seen / 2 == pytest.approx(first + length / 2, abs=0.51 * step + 1e-6)
        else:
            assert first - step - 1e-6 <= start
            assert start + seen <= first + length + step + 1e-6
    if zoom is not None and zoom >= 1.0:
        assert tile.start_px[0] * zoom == pytest.approx(round(tile.start_px[0] * zoom), abs=1e-6)


def test_the_pixel_under_the_cursor() -> None:
    tile = TILES["right eye"]
    assert tile.pixel_of((2.0 + 4.0, 1.0 + 8.0)) == (11, 0)
    assert tile.pixel_of((2.0 + 7.9, 1.0 + 8.0)) == (11, 0)
    assert tile.pixel_of((2.0 + 8.1, 1.0 + 12.5)) == (12, 1)
    assert tile.pixel_of((2.0 + 3.9, 1.0 + 8.0)) is None
    assert tile.pixel_of((60.0, 9.0)) is None
