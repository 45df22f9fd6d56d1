"""The sharpening pass against its twin, and the twin against scipy and by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pass_rigs
import pytest
import scipy.ndimage
from numpy.typing import NDArray

from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.passes.sharpen import Sharpen, SharpenTables
from vrlf.reference.sharpen import sharpen as twin

Light = NDArray[Any]

# Two viewports of 22 pixels with a column between them that is nobody's.
ODD = pass_rigs.rig(45, 31)
STILL = np.zeros((2, 2), int)
# Left and right eye, right and down: no two alike.
MOVED = np.array([[3, -5], [-4, 2]])


def random_taps(radius: int, seed: int = 3) -> Light:
    """Kernels of sum 1, another for each eye and colour, without any symmetry."""
    side = 2 * radius + 1
    taps = np.random.default_rng(seed).normal(0.0, 0.7 / side, (2, 3, side, side))
    taps[..., radius, radius] += 1.0 - taps.sum(axis=(-1, -2))
    return taps


def sharpened(device: Device, rig: Rig, target: Light, taps: Light, shift_px: Light) -> Light:
    """What the pass makes of a target, (H, W, 3)."""
    owned: list[Any] = [Sharpen(device)]
    try:
        owned.append(tables := SharpenTables(device, rig, taps, shift_px))
        owned.append(wanted := Texture.from_array(device, target, label="target"))
        owned.append(result := Texture(device, wanted.size_px, label="sharpened"))
        owned[0].run(tables, wanted, result)
        return result.read()[..., :3]
    finally:
        for each in owned:
            each.release()


@pytest.mark.parametrize("shift_px", [STILL, MOVED], ids=["still", "moved"])
@pytest.mark.parametrize("radius", [2, 5, 8])
@pytest.mark.parametrize(("width", "height"), [(45, 31), (44, 8), (7, 3), (140, 65)])
def test_the_pass_matches_its_twin(
    device: Device, width: int, height: int, radius: int, shift_px: Light
) -> None:
    """Also on panels smaller than a kernel, and on such as no group of pixels fits."""
    rig = pass_rigs.rig(width, height)
    target, taps = pass_rigs.picture(rig), random_taps(radius)
    got = sharpened(device, rig, target, taps, shift_px)
    # 289 products of float32 taps, the sum of whose sizes is below 10: 10 * 6e-8 * sqrt(289).
    assert got == pytest.approx(twin(target, rig, taps, shift_px), abs=1e-5)


@pytest.mark.parametrize("eye", [0, 1])
def test_the_twin_is_scipys_correlation(eye: int) -> None:
    target, taps = pass_rigs.picture(ODD).astype(np.float64), random_taps(3)
    columns = slice(0, 22) if eye == 0 else slice(23, 45)
    got = twin(target, ODD, taps, STILL)[:, columns]
    for colour in range(3):
        plain = scipy.ndimage.correlate(
            target[:, columns, colour], taps[eye, colour], mode="nearest"
        )
        assert got[..., colour] == pytest.approx(np.clip(plain, 0.0, 1.0), abs=1e-12)


def test_a_shift_says_where_to_read() -> None:
    """The left eye's pixel (10, 12) is read by the one 3 to its left and 5 below, and so on."""
    single = np.zeros((2, 3, 5, 5))
    single[..., 2, 2] = 1.0
    target = np.zeros((31, 45, 3))
    target[12, 10], target[12, 33] = 0.4, 0.9
    wanted = np.zeros_like(target)
    wanted[12 + 5, 10 - 3], wanted[12 - 2, 33 + 4] = 0.4, 0.9
    assert np.array_equal(twin(target, ODD, single, MOVED), wanted)


def test_a_flat_target_stays(device: Device) -> None:
    flat = np.empty((31, 45, 3), np.float32)
    flat[:] = (0.2, 0.5, 1.0)
    got = sharpened(device, ODD, flat, random_taps(8), MOVED)
    eyes = np.delete(got, 22, axis=1)
    # Float32 taps sum to 1 to a few 1e-7.
    assert eyes == pytest.approx(np.delete(flat, 22, axis=1), abs=3e-6)


def test_light_stays_within_the_panels_range(device: Device) -> None:
    target = (pass_rigs.picture(ODD) > 0.5).astype(np.float32)
    hard = np.zeros((2, 3, 5, 5))
    hard[..., 1:4, 1:4] = -1.0
    hard[..., 2, 2] = 9.0
    got = sharpened(device, ODD, target, hard, STILL)
    assert got.min() == 0.0
    assert got.max() == 1.0


def test_nothing_leaks_across_the_septum(device: Device) -> None:
    target, taps = pass_rigs.picture(ODD), random_taps(8)
    other = target.copy()
    other[:, 22:] = 1.0 - other[:, 22:]
    first, second = (sharpened(device, ODD, t, taps, MOVED) for t in (target, other))
    assert np.array_equal(first[:, :22], second[:, :22])
    assert np.all(np.any(first[:, 23:] != second[:, 23:], axis=(0, 2)))


def test_the_middle_column_is_dark(device: Device) -> None:
    white = np.ones((31, 45, 3), np.float32)
    assert not sharpened(device, ODD, white, random_taps(2), STILL)[:, 22].any()
    assert not twin(white, ODD, random_taps(2), STILL)[:, 22].any()
