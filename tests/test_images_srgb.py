"""The sRGB formulas against the standard's text, and their integers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vrlf.images import quantise_srgb, srgb_decode, srgb_encode


def standard_decode(value: float) -> float:
    """IEC 61966-2-1:1999, typed again from its text."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def standard_encode(light: float) -> float:
    return 12.92 * light if light <= 0.0031308 else 1.055 * light ** (1 / 2.4) - 0.055


@given(st.floats(0.0, 1.0))
def test_both_ways_follow_the_standard(value: float) -> None:
    # 1e-12: both are float64; only the rounding of a power differs.
    assert srgb_decode(value) == pytest.approx(standard_decode(value), abs=1e-12)
    assert srgb_encode(value) == pytest.approx(standard_encode(value), abs=1e-12)


def test_a_value_known_from_elsewhere() -> None:
    # sRGB 188 of 255 is the well-known mid grey that looks like a half-and-half dither.
    assert srgb_decode(188 / 255) == pytest.approx(0.5028864580, abs=1e-9)


@given(st.floats(0.0, 1.0))
def test_there_and_back(light: float) -> None:
    # 4e-8: the standard's rounded thresholds leave a step of 3e-8 where the branches meet.
    assert srgb_decode(srgb_encode(light)) == pytest.approx(light, abs=4e-8)


@pytest.mark.parametrize("bits", [8, 16])
def test_every_integer_survives_float32_light(bits: int) -> None:
    full = 2**bits - 1
    codes = np.arange(full + 1)
    light = srgb_decode(codes / full).astype(np.float32)
    assert np.array_equal(quantise_srgb(light, bits), codes)


def test_ten_bits_are_1023_steps_within_sixteen() -> None:
    light = srgb_decode(np.arange(1024) / 1023)
    codes = quantise_srgb(light, 10)
    assert codes.dtype == np.uint16
    assert (codes[0], codes[-1]) == (0, 65535)
    # Read back as 16 bits, each is nearest to its own step.
    assert np.array_equal(np.round(codes / 65535 * 1023), np.arange(1024))
    # What lies between is rounded to the nearest step, not cut.
    assert quantise_srgb(srgb_decode([500.49 / 1023, 500.51 / 1023]), 10).tolist() == [
        *codes[500:502]
    ]


def test_integers_are_clamped_and_rounded() -> None:
    half_a_step_up = srgb_decode(100.51 / 255)
    codes = quantise_srgb(np.array([-3.0, 0.0, half_a_step_up, 1.0, 7.0]))
    assert codes.tolist() == [0, 0, 101, 255, 255]
    assert codes.dtype == np.uint8


def test_another_width_is_refused() -> None:
    with pytest.raises(ValueError, match="12 bits"):
        quantise_srgb(np.zeros(3), 12)


def test_negatives_go_on_along_the_straight_branch() -> None:
    assert srgb_decode(-0.1292) == pytest.approx(-0.01, abs=1e-15)  # one division
    assert srgb_encode(-0.01) == pytest.approx(-0.1292, abs=1e-15)
