"""Cropping and scaling keep what they must: places, and light."""

from __future__ import annotations

import files_by_hand as by_hand
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vrlf.images import crop, resize_area, resize_nearest

PICTURE = by_hand.asymmetric().astype(np.float32)


def test_crop_copies_the_rectangle() -> None:
    cut = crop(PICTURE, 2, 1, 4, 3)
    assert np.array_equal(cut, PICTURE[1:4, 2:6])
    cut[:] = -1
    assert PICTURE.min() >= 0


@pytest.mark.parametrize("rectangle", [(-1, 0, 2, 2), (0, 0, 8, 2), (0, 3, 2, 3), (0, 0, 0, 1)])
def test_a_rectangle_outside_is_refused(rectangle: tuple[int, int, int, int]) -> None:
    with pytest.raises(ValueError, match="wanted one inside 7x5"):
        crop(PICTURE, *rectangle)


def test_nearest_makes_blocks() -> None:
    large = resize_nearest(PICTURE, 3)
    assert large.shape == (15, 21, 3)
    for row, column in ((0, 0), (1, 2), (2, 1)):
        assert np.array_equal(large[row::3, column::3], PICTURE)
    with pytest.raises(ValueError, match="at least 1"):
        resize_nearest(PICTURE, 0)


def test_area_by_hand() -> None:
    row = np.array([[[6.0], [3.0], [0.0]]], np.float32)
    # Two new pixels of one and a half old ones: (6 + 3/2) / 1.5 and (3/2 + 0) / 1.5.
    assert resize_area(row, 2, 1).ravel().tolist() == [5.0, 1.0]
    assert resize_area(row, 3, 1).ravel().tolist() == [6.0, 3.0, 0.0]
    assert resize_area(row, 6, 1).ravel().tolist() == [6.0, 6.0, 3.0, 3.0, 0.0, 0.0]


def test_area_averages_blocks_in_their_places() -> None:
    # 1e-4 of values up to 255: one float32 rounding.
    assert np.allclose(resize_area(resize_nearest(PICTURE, 4), 7, 5), PICTURE, atol=1e-4)


@given(st.integers(1, 23), st.integers(1, 17))
def test_area_keeps_the_mean_and_the_range(width: int, height: int) -> None:
    small = resize_area(PICTURE, width, height)
    assert small.shape == (height, width, 3)
    # 1e-4 of values up to 255: float32 results of float64 sums.
    assert np.allclose(small.mean((0, 1), dtype=np.float64), PICTURE.mean((0, 1)), atol=1e-4)
    assert small.min() >= PICTURE.min() - 1e-4
    assert small.max() <= PICTURE.max() + 1e-4


def test_a_size_of_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="at least 1x1"):
        resize_area(PICTURE, 0, 5)
