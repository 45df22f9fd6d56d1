"""RMSE, PSNR, gain and SSIM by hand, inside the border, eye by eye."""

from __future__ import annotations

from math import ceil, inf, log10
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from optics_by_hand import PITCH_MM, rig

from vrlf.errors import InputError
from vrlf.evaluation.measure import border_px, likeness
from vrlf.model import Rig
from vrlf.optics.viewport import Side

Light = NDArray[np.float32]

LENSES = {"kind": "microlens", "pitch_um": 390.0, "gap_mm": 3.0, "focal_mm": 1.95}
# 4 mm of pupil at -2 D blur over 4 * 46 * 0.002 = 0.368 mm, 4.72 px: 2.36 and 5 px of a lenslet.
BLURRED = {"sphere_d": -2.0, "vertex_mm": 0.0, "pupil_mm": 4.0}


def small(width_px: int = 60, **tables: dict[str, Any]) -> Rig:
    """Two perfect eyes before a bare panel of 60 x 30 pixels, but for what is given."""
    return rig(panel={"width_px": width_px}, **tables)


def light(seed: int, width_px: int = 60) -> Light:
    return np.random.default_rng(seed).random((30, width_px, 3), dtype=np.float32)


# --- the border -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("eye", "array", "wanted_px"),
    [
        ({}, {}, 0),
        (BLURRED, {}, 3),
        (BLURRED, LENSES, 8),
        ({}, LENSES, 5),
        # The worst meridian, -2 - 3 D: 4 * 46 * 0.005 / 2 = 0.46 mm, 5.9 px.
        (BLURRED | {"cylinder_d": -3.0, "axis_deg": 35.0}, {}, 6),
        # Far-sighted blur is blur.
        (BLURRED | {"sphere_d": 2.0}, LENSES, 8),
        # 2 mm of an accommodated far-sighted eye are sharp.
        (BLURRED | {"sphere_d": 2.0, "accommodation": "best"}, {}, 0),
    ],
)
def test_border_is_half_the_blur_and_a_lenslet(
    eye: dict[str, Any], array: dict[str, Any], wanted_px: int
) -> None:
    given_rig = small(array=array or {"kind": "none"}, right=eye)
    assert border_px(given_rig, "right") == wanted_px
    # The other eye is perfect: a lenslet of five pixels, if there is one.
    assert border_px(given_rig, "left") == (5 if array else 0)


@settings(max_examples=50, deadline=None)
@given(st.floats(-6, 3), st.floats(2, 7), st.floats(100, 900))
def test_border_of_any_eye(sphere_d: float, pupil_mm: float, pitch_um: float) -> None:
    eye = {"sphere_d": sphere_d, "vertex_mm": 0.0, "pupil_mm": pupil_mm}
    found = border_px(small(array=LENSES | {"pitch_um": pitch_um}, left=eye), "left")
    exact = (pupil_mm * 46.0 * abs(sphere_d) / 2000.0 + pitch_um / 1000.0) / PITCH_MM
    assert found in {ceil(exact - 1e-9), ceil(exact + 1e-9)}


# --- the numbers ------------------------------------------------------------------------------


@pytest.mark.parametrize("side", ["left", "right"])
def test_numbers_by_hand(side: Side) -> None:
    """White seen at 0.4 and 0.6 in turn: the gain 0.5 / 0.26 leaves 1/13 and 2/13 ..."""
    seen = np.zeros((30, 60, 3), np.float32)
    seen[0::2], seen[1::2] = 0.4, 0.6
    found = likeness(seen, np.ones_like(seen), small(), side)
    # sum(ab)/sum(aa) = (0.4 + 0.6) / (0.16 + 0.36); what is left: 1 - 0.4 g, 1 - 0.6 g.
    gain = 1.0 / 0.52
    mean_square = ((1.0 - 0.4 * gain) ** 2 + (1.0 - 0.6 * gain) ** 2) / 2.0
    # The pictures are float32: 0.4 is good to 3e-8 of it.
    assert found.gain == pytest.approx(gain, rel=1e-7)
    assert found.rmse == pytest.approx(mean_square**0.5, rel=1e-6)
    assert found.psnr_db == pytest.approx(10.0 * log10(1.0 / mean_square), rel=1e-6)


def test_a_constant_factor_is_no_difference() -> None:
    target = light(1)
    for factor in (0.037, 1.0, 2.5):
        found = likeness((target * factor).astype(np.float32), target, small(), "left")
        assert found.gain == pytest.approx(1.0 / factor, rel=1e-6)
        # float32's rounding of the scaled picture alone.
        assert found.rmse < 1e-7
    assert likeness(target, target, small(), "right").psnr_db == inf


@settings(max_examples=30, deadline=None)
@given(st.floats(0.3, 3.0), st.integers(0, 1000))
def test_no_other_gain_is_better(factor: float, seed: int) -> None:
    seen, target = light(seed), light(seed + 1)
    found = likeness(seen, target, small(), "left")
    other = factor * found.gain * seen[:, :30].astype(np.float64) - target[:, :30]
    assert found.rmse <= np.sqrt(np.mean(other**2)) * (1.0 + 1e-12)


def test_nothing_seen_is_all_error() -> None:
    target = light(3)
    found = likeness(np.zeros_like(target), target, small(), "left")
    wanted = np.sqrt(np.mean(target[:, :30].astype(np.float64) ** 2))
    assert found.rmse == pytest.approx(wanted, rel=1e-12)
    assert np.isfinite(found.gain)


def test_all_colours_count() -> None:
    target = np.full((30, 60, 3), 0.5, np.float32)
    for colour in range(3):
        seen = target.copy()
        seen[..., colour] = 0.1
        rest = likeness(seen, target, small(), "right").rmse
        # By least squares g = (0.5 + 0.02) / (0.5 + 0.01) ... the same for each colour.
        gain = (2 * 0.25 + 0.05) / (2 * 0.25 + 0.01)
        left_over = (2 * (0.5 * gain - 0.5) ** 2 + (0.1 * gain - 0.5) ** 2) / 3
        assert rest == pytest.approx(left_over**0.5, rel=1e-6)


def ssim_by_hand(test: NDArray[Any], reference: NDArray[Any]) -> float:
    """Wang et al. 2004, equation 13, window by window; colours alike, weights 11 x 11."""
    steps = np.arange(-5, 6)
    line = np.exp(-0.5 * (steps / 1.5) ** 2)
    window = np.outer(line, line) / line.sum() ** 2
    c1, c2 = 0.01**2, 0.03**2
    values = []
    for channel in range(3):
        for row in range(test.shape[0] - 10):
            for column in range(test.shape[1] - 10):
                place = (slice(row, row + 11), slice(column, column + 11), channel)
                x, y = test[place].astype(np.float64), reference[place].astype(np.float64)
                mx, my = (window * x).sum(), (window * y).sum()
                vx, vy = (window * (x - mx) ** 2).sum(), (window * (y - my) ** 2).sum()
                cov = (window * (x - mx) * (y - my)).sum()
                values.append(
                    (2 * mx * my + c1) * (2 * cov + c2) / ((mx**2 + my**2 + c1) * (vx + vy + c2))
                )
    return float(np.mean(values))


def test_ssim_by_hand_after_the_gain() -> None:
    """The right eye's half, at half the light and with noise."""
    target = light(11)
    seen = (0.5 * (target + 0.2 * light(12))).astype(np.float32)
    found = likeness(seen, target, small(), "right")
    wanted = ssim_by_hand(found.gain * seen[:, 30:].astype(np.float64), target[:, 30:])
    # float64 sums of some hundred in another order.
    assert found.ssim == pytest.approx(wanted, rel=1e-9)
    assert likeness(target, target, small(), "left").ssim == pytest.approx(1.0, rel=1e-12)


def test_a_picture_smaller_than_the_window_has_no_ssim() -> None:
    """30 rows and a border of 10 leave 10, one less than a window; 9 leave 12."""
    # pupil * 46 * D / 2000 mm: 6 mm and 5.4 D make 9.6 px, 4.8 D 8.5.
    for sphere_d, has_ssim in ((-5.4, False), (-4.8, True)):
        eye = {"sphere_d": sphere_d, "vertex_mm": 0.0, "pupil_mm": 6.0}
        found = likeness(light(1), light(2), small(left=eye), "left").ssim
        assert (found is not None) == has_ssim


# --- what is compared -------------------------------------------------------------------------


@pytest.mark.parametrize("width", [60, 61])
def test_only_the_eyes_own_inner_part_counts(width: int) -> None:
    """Change everything else, the last pixel before the border too, and nothing changes."""
    given_rig = small(width, left=BLURRED, right=BLURRED | {"sphere_d": -1.0})
    seen, target = light(5, width), light(6, width)
    # -1 D: 1.18 px of radius, a border of 2.
    parts = {
        "left": (slice(3, 27), slice(3, 27)),
        "right": (slice(2, 28), slice(width - 28, width - 2)),
    }
    for side, inner in parts.items():
        found = likeness(seen, target, given_rig, side)
        spoilt = np.full_like(seen, 9.0)
        spoilt[inner] = seen[inner]
        assert likeness(spoilt, target, given_rig, side) == found
        # And each corner pixel of the inner part does count.
        for row in (inner[0].start, inner[0].stop - 1):
            for column in (inner[1].start, inner[1].stop - 1):
                touched = seen.copy()
                touched[row, column] = 9.0
                assert likeness(touched, target, given_rig, side) != found


def test_each_eye_has_its_own_gain() -> None:
    target = light(7)
    seen = target.copy()
    seen[:, :30] *= 0.5
    seen[:, 30:] *= 0.25
    found = {side: likeness(seen, target, small(), side) for side in ("left", "right")}
    assert found["left"].gain == pytest.approx(2.0)
    assert found["right"].gain == pytest.approx(4.0)
    assert max(each.rmse for each in found.values()) < 1e-7


def test_a_viewport_without_an_inner_part_is_refused() -> None:
    """30 rows and a border of 15: nothing is left. With 14 two rows are."""
    # pupil * 46 * D / 2000 mm: 6 mm and 8.2 D make 14.5 px, 7.8 D 13.8.
    for sphere_d, border in ((-8.2, 15), (-7.8, 14)):
        eye = {"sphere_d": sphere_d, "vertex_mm": 0.0, "pupil_mm": 6.0}
        given_rig = small(left=eye)
        assert border_px(given_rig, "left") == border
        if border == 14:
            assert likeness(light(1), light(1), given_rig, "left").rmse == 0.0
            continue
        with pytest.raises(InputError) as caught:
            likeness(light(1), light(1), given_rig, "left")
        text = str(caught.value)
        assert "\n" not in text
        assert all(part in text for part in ("left eye", "30x30", "border of 15", "wanted"))
        # The other eye is judged by its own.
        assert likeness(light(1), light(1), given_rig, "right").rmse == 0.0
