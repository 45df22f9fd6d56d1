"""How a picture lies in a viewport."""

from __future__ import annotations

import pytest
from optics_by_hand import rig

from vrlf.errors import InputError
from vrlf.optics.fitting import fit_picture
from vrlf.optics.viewport import Viewport, viewport

VIEW = viewport(rig(), "left")  # 30 x 30


def test_all_of_a_wide_picture_with_black_above_and_below() -> None:
    fit = fit_picture((60, 20), 1.0, VIEW)
    assert fit.start_px == pytest.approx((0.0, 10.0))
    assert fit.source_px == pytest.approx((2.0, 2.0))


def test_all_of_the_viewport_with_the_picture_cut() -> None:
    """20 rows fill 30: scale 1.5, 90 pixels wide, 30 beyond each border."""
    fit = fit_picture((60, 20), 1.0, VIEW, "cover")
    assert fit.start_px == pytest.approx((-30.0, 0.0))
    assert fit.source_px == pytest.approx((2 / 3, 2 / 3))


def test_pixels_that_are_not_square() -> None:
    """10 x 20 pixels, each twice as wide as high, are seen as a square."""
    fit = fit_picture((10, 20), 2.0, VIEW)
    assert fit.start_px == pytest.approx((0.0, 0.0))
    assert fit.source_px == pytest.approx((10 / 30, 20 / 30))


def test_axis_centres_on_the_lens_and_keeps_the_picture_whole() -> None:
    """About (30, 12) of 40 x 30 there is room for 20 x 24: 60 x 20 fits at a third."""
    fit = fit_picture((60, 20), 1.0, Viewport(0, 40, 30, (0.0, 0.0)), "axis", (30.0, 12.0))
    assert fit.source_px == pytest.approx((3.0, 3.0))
    assert fit.start_px == pytest.approx((20.0, 12.0 - 20.0 / 3.0 / 2.0))


def test_an_axis_beside_the_viewport_has_no_room() -> None:
    with pytest.raises(InputError, match="found 'axis' with the axis at 41, 12"):
        fit_picture((60, 20), 1.0, Viewport(0, 40, 30, (0.0, 0.0)), "axis", (41.0, 12.0))
