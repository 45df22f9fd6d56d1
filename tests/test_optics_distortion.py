"""The lens's distortion and its inverse, over all that a viewport shows."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, sqrt
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from pass_rigs import rig

from vrlf.errors import InputError
from vrlf.gpu import Block, Buffer, ComputePass, Device, Field, compute
from vrlf.model import load_rig
from vrlf.optics.distortion import (
    edge_radius,
    most_seen,
    panel_radius,
    panel_slopes,
    seen_radius,
    seen_slopes,
    turning_radius,
)
from vrlf.optics.inspect import inspect_rig
from vrlf.resources import shaders_dir

# In units of the tangent: a ten-thousandth of a pixel of the sharpest headset's.
ACCURATE = 1e-9
# What viewers have: the first Cardboard, two later ones, one whose k2 is below 0.
VIEWERS = [(0.441, 0.156), (0.34, 0.55), (0.2416, 0.30125), (0.36, -0.01)]
coefficient = st.floats(-5.0, 5.0).filter(lambda k: k == 0.0 or abs(k) > 1e-12)


@pytest.mark.parametrize("k", VIEWERS)
def test_there_and_back_over_a_whole_field(k: tuple[float, float]) -> None:
    """Beyond 70 degrees each way: a phone's corner is at 55."""
    x, y = np.meshgrid(np.linspace(-1.5, 1.4, 301), np.linspace(-1.3, 1.6, 301))
    slopes = np.stack([x, y], axis=-1)
    back = panel_slopes(seen_slopes(slopes, k), k)
    assert np.abs(back - slopes).max() < ACCURATE
    # And far better: what is left is rounding.
    assert np.abs(back - slopes).max() < 1e-14


@settings(max_examples=400, deadline=None)
@given(k1=coefficient, k2=coefficient, share=st.floats(0.0, 1.0), far=st.floats(0.1, 20.0))
@example(k1=0.0, k2=0.0, share=0.7, far=3.0)
@example(k1=-1.0, k2=0.0, share=1.0, far=1.0)
@example(k1=-2.0, k2=1.8, share=1.0, far=1.0)
@example(k1=0.0, k2=-1e-9, share=1.0, far=1.0)
def test_what_is_found_is_shown_where_it_was_wanted(
    k1: float, k2: float, share: float, far: float
) -> None:
    """Up to the turn itself, where the way back is as flat as can be."""
    k = (k1, k2)
    reach = min(turning_radius(k), far)
    r = np.array(share * reach)
    seen = seen_radius(r, k)
    found = panel_radius(np.minimum(seen, most_seen(k)), k)
    scale = max(1.0, float(seen))
    assert abs(float(seen_radius(found, k)) - float(seen)) <= ACCURATE * scale
    # Where it is not flat the place itself is as good.
    rising = 1.0 + 3.0 * k1 * float(r) ** 2 + 5.0 * k2 * float(r) ** 4
    if rising > 1e-3:
        assert abs(float(found) - float(r)) <= ACCURATE * max(1.0, float(r))


@settings(max_examples=200, deadline=None)
@given(k1=coefficient, k2=coefficient)
def test_it_rises_up_to_the_turn_and_falls_behind(k1: float, k2: float) -> None:
    k = (k1, k2)
    turn = turning_radius(k)
    before = np.linspace(0.0, min(turn, 50.0), 400)
    assert np.all(np.diff(seen_radius(before, k)) >= 0.0)
    if turn < inf:
        assume(turn > 1e-3)
        # Beyond the next turn it may rise again: just behind this one it does not.
        assert seen_radius(np.array(turn * (1.0 + 1e-4)), k) <= most_seen(k)


def test_turns_by_hand() -> None:
    """1 - 3 r^2 = 0 for k1 = -1; 1 - 5 r^4 = 0 for k2 = -1; 1 + r^2 (3 k1 + 5 k2 r^2) else."""
    assert turning_radius((-1.0, 0.0)) == pytest.approx(1.0 / sqrt(3.0))
    assert turning_radius((0.0, -1.0)) == pytest.approx(0.2**0.25)
    assert most_seen((-1.0, 0.0)) == pytest.approx(2.0 / 3.0 / sqrt(3.0))
    # (1 - r^2 / 4) (1 - r^2 / 9): k1 = -13/108, k2 = 1/180.
    assert turning_radius((-13.0 / 108.0, 1.0 / 180.0)) == pytest.approx(2.0)
    # (1 - r^2)^2: it rests at 1 and rises again.
    assert turning_radius((-2.0 / 3.0, 0.2)) == inf
    for k in VIEWERS[:3]:
        assert turning_radius(k) == inf


def test_what_the_lens_shows_nowhere_is_said() -> None:
    with pytest.raises(InputError, match=r"headset\.distortion: found \[-1\.0, 0\.0\].*0\.3849"):
        panel_radius(np.array([0.1, 0.4]), (-1.0, 0.0))


def test_the_farthest_corner() -> None:
    """44 x 31 pixels of 78 um, the axis 0.5 mm beside the left viewport's middle, 0.37 mm high."""
    given_rig = rig(44, 31, headset={"lens_separation_mm": 2.716, "lens_height_mm": 0.37})
    # 22 columns are 1.716 mm; the axis is at -1.358 mm, so the inner border is the farther.
    expected = np.hypot(1.358, 31 * 0.078 / 2 + 0.37) / 46.0
    for side in ("left", "right"):
        assert edge_radius(given_rig, side) == pytest.approx(expected)


def test_a_rig_whose_distortion_turns_back_is_warned_of() -> None:
    warned = inspect_rig(load_rig("bare", overrides=["headset.distortion=[-1.0,0.0]"]))["warnings"]
    assert any("turns back at 30 degrees" in text for text in warned)
    plain = inspect_rig(load_rig("bare", overrides=["headset.distortion=[0.441,0.156]"]))
    assert not any("turns back" in text for text in plain["warnings"])


# The shaders' own, by the way back.

SHADER = """
#include "block/Probe"
#include "include/distortion.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Slopes { vec2 slopes[]; };
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < uint(count)) slopes[i] = as_seen(slopes[i]);
}
"""
PROBE = Block("Probe", (Field("vec2", "distortion", ""), Field("int", "count", "")))


@pytest.fixture
def probe(device: Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ComputePass]:
    (tmp_path / "probe.comp").write_text(SHADER, encoding="utf-8")
    (tmp_path / "include").symlink_to(shaders_dir() / "include")
    monkeypatch.setattr(compute, "shaders_dir", lambda: tmp_path)
    made = ComputePass(device, "probe.comp", PROBE)
    yield made
    made.release()


@pytest.mark.parametrize("k", [*VIEWERS, (-0.3, 0.05), (0.0, 0.0)])
def test_glsl_is_led_back_to_where_it_came_from(
    device: Device, probe: ComputePass, k: tuple[float, float]
) -> None:
    x, y = np.meshgrid(np.linspace(-1.0, 0.9, 61), np.linspace(-0.8, 1.0, 61))
    slopes = np.stack([x, y], axis=-1).reshape(-1, 2).astype(np.float32)
    buffer = Buffer(device, slopes, label="slopes")
    buffer.bind(0)
    probe.set({"distortion": k, "count": len(slopes)})
    probe.run_linear(len(slopes), 64)
    seen = buffer.read(np.float32).reshape(-1, 2).astype(np.float64)
    buffer.release()
    wanted = seen_slopes(slopes.astype(np.float64), tuple(float(np.float32(each)) for each in k))
    # A handful of roundings of 6e-8 each, of what is at most 3.
    assert np.abs(seen - wanted).max() < 1e-6
    # What the lens shows least steeply rises by 0.1 here: ten times as much at most.
    assert np.abs(panel_slopes(seen, k) - slopes).max() < 1e-5
