"""RMSE and PSNR from a GPU's sums: the pass against its twin, the sums against the measure."""

from __future__ import annotations

from math import inf

import numpy as np
import pass_rigs
import pytest
from numpy.typing import NDArray

from vrlf.evaluation.live import borders_px, live_likeness
from vrlf.evaluation.measure import likeness
from vrlf.gpu import Device, Texture
from vrlf.model import Rig, load_rig
from vrlf.optics.viewport import SIDES
from vrlf.passes import squares as module
from vrlf.passes.squares import Squares, Sums
from vrlf.reference.squares import squares
from vrlf.studies.quality import cropped

Float32 = NDArray[np.float32]
# An odd width: the middle column is nobody's.
SMALL = pass_rigs.rig(41, 23)
# Eyes with different borders, from its own optics.
WORN = cropped(load_rig("two-eyes"), (280, 150))


def summed(
    device: Device, rig: Rig, seen: Float32, target: Float32, borders: tuple[int, int]
) -> Sums:
    """By the GPU; on one that runs ahead, after as many frames as it needs."""
    made = Squares(device)
    textures = [Texture.from_array(device, each, label="picture") for each in (seen, target)]
    made.run(rig, *textures, borders)
    found = None
    while found is None:
        assert made.is_waiting
        found = made.poll()
    assert not made.is_waiting
    assert made.poll() is None
    for each in (*textures, made):
        each.release()
    return found


@pytest.mark.parametrize("borders", [(0, 0), (2, 5), (9, 0)])
def test_the_sums_are_the_twins(device: Device, borders: tuple[int, int]) -> None:
    seen, target = pass_rigs.picture(SMALL, 1), pass_rigs.picture(SMALL, 2)
    found = summed(device, SMALL, seen, target, borders)
    wanted = squares(SMALL, seen.astype(float), target.astype(float), borders)
    # A group adds a few numbers in float32.
    assert found.values == pytest.approx(wanted, rel=1e-6, abs=1e-4)
    assert (found.rig, found.borders) == (SMALL, borders)


def test_a_border_that_leaves_nothing_makes_no_number(device: Device) -> None:
    picture = pass_rigs.picture(SMALL, 1)
    found = summed(device, SMALL, picture, picture / 2, (3, 12))
    assert found.values[1] == pytest.approx(0.0, abs=0.0)
    assert list(live_likeness(found)) == ["left"]


def test_many_pixels_an_invocation(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_GROUPS", 2)
    seen, target = pass_rigs.picture(WORN, 1), pass_rigs.picture(WORN, 2)
    found = summed(device, WORN, seen, target, (0, 0))
    # 160 pixels an invocation in float32.
    assert found.values == pytest.approx(
        squares(WORN, seen.astype(float), target.astype(float), (0, 0)), rel=1e-5, abs=1e-2
    )


@pytest.mark.parametrize("noise", [0.2, 1e-2, 3e-4])
@pytest.mark.parametrize("gain", [1.0, 0.6])
def test_it_is_the_measure_of_evaluation(device: Device, noise: float, gain: float) -> None:
    """Down to 70 dB; where the perceived picture is dimmer, to a fifth of a dB."""
    rng = np.random.default_rng(8)
    target = pass_rigs.picture(WORN, 3)
    spoilt = target + noise * rng.standard_normal(target.shape)
    seen = (gain * spoilt).astype(np.float32)
    found = live_likeness(summed(device, WORN, seen, target, borders_px(WORN)))
    assert set(found) == set(SIDES)
    for side in SIDES:
        wanted = likeness(seen, target, WORN, side)
        # A dimmer picture's difference is large, and what is left of it has fewer digits.
        close_db = 0.2 if gain < 1.0 and noise < 1e-3 else 0.002
        assert found[side].psnr_db == pytest.approx(wanted.psnr_db, abs=close_db)
        assert found[side].rmse == pytest.approx(wanted.rmse, rel=close_db / 8.0)
        assert found[side].gain == pytest.approx(wanted.gain, rel=1e-5)


def test_equal_dark_and_broken_pictures(device: Device) -> None:
    target = pass_rigs.picture(WORN, 3)
    borders = borders_px(WORN)
    for each in live_likeness(summed(device, WORN, target, target, borders)).values():
        assert (each.psnr_db, each.gain) == (inf, 1.0)
    dark = np.zeros_like(target)
    for side, each in live_likeness(summed(device, WORN, dark, target, borders)).items():
        assert each.rmse == pytest.approx(likeness(dark, target, WORN, side).rmse, rel=1e-5)
    broken = target.copy()
    broken[:, : WORN.panel.width_px // 2] = np.nan
    assert list(live_likeness(summed(device, WORN, broken, target, borders))) == ["right"]


def test_a_gpu_is_never_waited_for(device: Device) -> None:
    """Where frames are in flight a result is read three frames later, each by itself."""
    made = Squares(device)
    made._behind = 3
    target = Texture.from_array(device, pass_rigs.picture(SMALL, 1), label="target")
    found = []
    for _ in range(5):
        made.run(SMALL, target, target, (0, 0))
        found.append(made.poll() is not None)
    assert found == [False, False, False, True, True]
    found = [made.poll() is not None for _ in range(4)]
    assert found == [True, True, True, False]
    assert not made.is_waiting
    for each in (target, made):
        each.release()
