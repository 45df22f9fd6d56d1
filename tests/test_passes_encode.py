"""Linear light to 8-bit sRGB: the pass, its float64 twin and the standard's own formula."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from vrlf.gpu import Device, Texture
from vrlf.passes import Encode
from vrlf.reference.encode import encode as twin
from vrlf.reference.encode import noise

Light = NDArray[Any]
Codes = NDArray[np.uint8]
Encoded = Callable[..., Codes]


def decode(code: Light) -> Light:
    """IEC 61966-2-1, written here once more: linear light of codes in 0 to 255, any between."""
    v = np.asarray(code, np.float64) / 255.0
    return np.where(v <= 0.04045, v / 12.92, ((np.maximum(v, 0.04) + 0.055) / 1.055) ** 2.4)


def by_pass(device: Device, light: Light, *, dither: bool = False) -> Codes:
    """Codes by the GPU."""
    owned: list[Any] = [Encode(device)]
    try:
        pixels = np.ascontiguousarray(light, np.float32)
        owned.append(source := Texture.from_array(device, pixels, label="light"))
        owned.append(code := Texture(device, source.size_px, kind="u1", label="code"))
        owned[0].run(source, code, dither=dither)
        codes = np.asarray(code.read(), np.uint8)
        assert (codes[..., 3] == 255).all(), "a code picture is opaque"
        return codes[..., :3]
    finally:
        for each in owned:
            each.release()


@pytest.fixture(params=["twin", "pass"])
def encoded(request: pytest.FixtureRequest, device: Device) -> Encoded:
    """Whoever encodes: the standard holds for both."""
    if request.param == "twin":
        return twin
    return lambda *args, **options: by_pass(device, *args, **options)


def as_picture(values: Light) -> Light:
    """Values as the pixels of a picture 17 wide, each in another channel too."""
    flat = np.asarray(values, np.float32).ravel()
    padded = np.concatenate([flat, np.zeros(-len(flat) % 17, np.float32)]).reshape(-1, 17)
    return np.stack([padded, padded[::-1], padded[:, ::-1]], axis=-1)


def test_all_codes_come_back(encoded: Encoded) -> None:
    codes = np.arange(256)
    picture = as_picture(decode(codes))
    assert np.array_equal(encoded(picture)[..., 0].ravel()[:256], codes)
    assert np.array_equal(encoded(picture)[::-1, :, 1].ravel()[:256], codes)


def test_rounding_is_exact_to_the_last_bit_of_float32(encoded: Encoded) -> None:
    """At each of the 255 thresholds and one float32 below and above it."""
    exact = decode(np.arange(255) + 0.5)
    nearest = exact.astype(np.float32)
    around = [np.nextafter(nearest, np.float32(0)), nearest, np.nextafter(nearest, np.float32(2))]
    for values in around:
        # float64 tells on which side of the threshold a float32 lies: its spacing is 1e-9 of it.
        wanted = np.arange(255) + (values.astype(np.float64) >= exact)
        assert np.array_equal(encoded(as_picture(values))[..., 0].ravel()[:255], wanted)


def test_pass_and_twin_give_the_same_codes(device: Device) -> None:
    light = np.random.default_rng(1).random((61, 83, 3), dtype=np.float32) * 1.2 - 0.1
    # Dark values get as many codes as their share of light gets values.
    light[30:] **= 3
    assert np.array_equal(by_pass(device, light), twin(light))


@settings(max_examples=200, deadline=None)
@given(st.floats(0.0, 1.0, width=32))
def test_twin_gives_the_nearest_code(value: float) -> None:
    code = int(twin(np.full((1, 1, 3), value, np.float32))[0, 0, 0])
    assert decode(np.array(code - 0.5)) <= value or code == 0
    assert value < decode(np.array(code + 0.5)) or code == 255


ODD_VALUES = [
    (np.nan, 0),
    (-np.nan, 0),
    (np.inf, 255),
    (-np.inf, 0),
    (-1.0, 0),
    (-0.0, 0),
    (1e-40, 0),  # denormal
    (1.0, 255),
    (1.5, 255),
    (3e38, 255),
]


@pytest.mark.parametrize("dither", [False, True])
def test_what_is_no_light_never_flashes(encoded: Encoded, dither: bool) -> None:
    for value, code in ODD_VALUES:
        # 19 x 33 pixels: dither may not light a single one.
        picture = np.full((33, 19, 3), value, np.float32)
        assert (encoded(picture, dither=dither) == code).all(), f"{value} is shown as {code}"


def test_one_bad_channel_spoils_no_other(encoded: Encoded) -> None:
    picture = np.array([[[np.nan, 1.0, 0.0], [0.5, np.nan, 1.0]]], np.float32)
    assert encoded(picture).tolist() == [[[0, 255, 0], [188, 0, 255]]]


# --- dither -----------------------------------------------------------------------------------

PATCH = (256, 256, 3)
# Light between codes, at both branches of the curve and near its ends.
LEVELS = [
    1e-4,
    0.0007,
    0.003,
    0.0031308,
    0.00341,
    0.0123,
    0.05,
    0.1234,
    0.21404,
    0.333,
    0.5,
    0.77,
    0.9993,
]


@pytest.mark.parametrize("level", LEVELS)
def test_dither_keeps_the_mean_light(encoded: Encoded, level: float) -> None:
    codes = encoded(np.full(PATCH, level, np.float32), dither=True)
    below = int(codes.min())
    step = float(decode(np.array(below + 1)) - decode(np.array(below)))
    assert decode(np.array(below)) <= level <= decode(np.array(below + 1)), "codes enclose it"
    assert codes.max() <= below + 1
    # Each code is off by at most half a step RMS, and 196608 are independent: four standard
    # errors are 0.0045 steps. Without dither the mean is off by up to half a step, and where
    # the place between two codes is told in codes and not in light by up to 0.007 of one.
    assert abs(decode(codes).mean() - level) < 4.0 * 0.5 * step / np.sqrt(codes.size)


def test_dither_leaves_the_codes_own_values_alone(encoded: Encoded) -> None:
    """float32 rounds a code's light by up to 1e-5 of a step, less than any noise but one in 1e5."""
    picture = np.repeat(np.repeat(decode(np.arange(256))[None, :, None], 20, axis=0), 3, axis=2)
    codes = encoded(picture.astype(np.float32), dither=True)
    assert (codes != np.arange(256)[None, :, None]).sum() <= 2


def test_dither_is_the_twins(device: Device) -> None:
    light = np.random.default_rng(2).random((120, 90, 3), dtype=np.float32) ** 2
    got, wanted = by_pass(device, light, dither=True), twin(light, dither=True)
    # The place between two codes is a float32 quotient, good to 1e-5: so many noises decide
    # otherwise. 32400 codes: one is expected, none by more than its neighbour.
    apart = got.astype(int) - wanted
    assert np.abs(apart).max() <= 1
    assert np.count_nonzero(apart) <= 4


def test_dither_is_fixed(device: Device) -> None:
    light = np.random.default_rng(3).random((40, 50, 3), dtype=np.float32)
    first = by_pass(device, light, dither=True)
    assert np.array_equal(by_pass(device, light, dither=True), first)
    with Device.headless() as other:
        assert np.array_equal(by_pass(other, light, dither=True), first)
    # And it does something.
    assert not np.array_equal(by_pass(device, light), first)


def test_noise_has_no_pattern() -> None:
    """Uniform, and neither channels nor neighbours know of each other."""
    n = noise((128, 96, 3))
    assert n.min() >= 0.0
    assert n.max() < 1.0
    # Four standard errors: 1/sqrt(12 N) of the mean, 1/sqrt(N) of a correlation.
    assert n.mean() == pytest.approx(0.5, abs=4.0 / np.sqrt(12.0 * n.size))
    around = [
        (n[..., 0], n[..., 1]),
        (n[..., 1], n[..., 2]),
        (n[:, 1:], n[:, :-1]),
        (n[1:], n[:-1]),
        (n[1:, 1:], n[:-1, :-1]),
        (n[:96], n[:96].swapaxes(0, 1)),
    ]
    for a, b in around:
        off_diagonal = a != b
        r = np.corrcoef(a[off_diagonal], b[off_diagonal])[0, 1]
        assert abs(r) < 5.0 / np.sqrt(off_diagonal.sum())
