"""What of a window of the operator is kept."""

from __future__ import annotations

import numpy as np

from vrlf.passes.tabulate import _FAINT, lit


def test_a_row_keeps_its_light_in_each_colour() -> None:
    random = np.random.default_rng(5)
    # From bright to far below what is kept; blue is a thousandth of the others.
    dense = (10.0 ** random.uniform(-4.0, 0.0, (7, 60, 3))).astype(np.float32)
    dense[..., 2] *= 1e-3
    place, kept = lit(dense, 1e-9)
    assert 7 < len(place) < 7 * 60
    for row in range(7):
        here = place // 60 == row
        # Sums of 32-bit floats.
        np.testing.assert_allclose(kept[here].sum(axis=0), dense[row].sum(axis=0), rtol=1e-5)


def test_what_is_faint_in_every_colour_goes() -> None:
    dense = np.zeros((2, 5, 3), np.float32)
    dense[0, 1] = (1.0, 0.5, 0.001)
    dense[0, 3] = (0.5 * _FAINT, 0.4 * _FAINT, 0.0005)  # blue is half of the brightest blue
    dense[0, 4] = 0.0000001
    dense[1, 2] = (0.0, 0.0, 0.3)
    place, kept = lit(dense, 1e-6)
    assert place.tolist() == [1, 3, 7]
    np.testing.assert_allclose(kept[2], (0.0, 0.0, 0.3), rtol=1e-6)


def test_dark_rows_hold_nothing() -> None:
    place, kept = lit(np.zeros((3, 4, 3), np.float32), 1e-6)
    assert len(place) == 0
    assert kept.shape == (0, 3)
