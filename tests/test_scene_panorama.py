"""The world all around: where things stand, seams and poles, and the twin."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from vrlf.content.panorama import load_panorama
from vrlf.errors import ImageReadError
from vrlf.gpu import Device, Texture
from vrlf.images import write_picture
from vrlf.model import Rig, load_rig
from vrlf.optics.bench import bench_of
from vrlf.optics.viewport import SIDES, axis_in_viewport_px, pitch_mm, viewport
from vrlf.reference.panorama import panorama
from vrlf.scene.camera import HeadPose, head_axes
from vrlf.scene.panorama import Panorama, samples_for

# Odd, the axes off the middle; a wide field, so that seams and poles come into view.
SIZE = ["panel.width_px=97", "panel.height_px=61", "headset.lens_separation_mm=35"]
WIDE = load_rig("bare", overrides=[*SIZE, "panel.pixel_pitch_um=1000", "headset.lens_height_mm=3"])
BENT = load_rig(
    "bare", overrides=[*SIZE, "panel.pixel_pitch_um=700", "headset.distortion=[0.3, -0.1]"]
)
POSES = [
    HeadPose(),
    HeadPose(yaw_deg=30.0, pitch_deg=20.0, roll_deg=10.0),
    HeadPose(yaw_deg=-175.0, pitch_deg=-5.0),
    HeadPose(yaw_deg=100.0, pitch_deg=88.0),
    HeadPose(pitch_deg=-80.0, roll_deg=-30.0),
]


def world(seed: int, height: int = 24) -> NDArray[np.float32]:
    """Random; 256ths, which 16-bit floats hold exactly."""
    codes = np.random.default_rng(seed).integers(0, 256, (height, 2 * height, 3))
    return (codes / 256).astype(np.float32)


def drawn(device: Device, rig: Rig, worlds: Any, head: HeadPose, samples: int) -> NDArray[Any]:
    made = Panorama(device, *worlds)
    made.ease(samples)
    size = (rig.panel.width_px, rig.panel.height_px)
    target = Texture(device, size, label="target")
    made.draw(target, rig, head=head)
    light = np.asarray(target.read()[..., :3])
    made.release()
    target.release()
    return light


@pytest.mark.parametrize("rig", [WIDE, BENT], ids=["wide", "bent"])
@pytest.mark.parametrize("head", POSES, ids=str)
def test_both_eyes_see_what_the_twin_sees(device: Device, rig: Rig, head: HeadPose) -> None:
    worlds = (world(1), world(2))
    light = drawn(device, rig, worlds, head, 2)
    twin = panorama((worlds[0].astype(float), worlds[1].astype(float)), rig, head_axes(head), 2)
    # llvmpipe's atan is off by 3e-6 rad, 1e-5 of a pixel here; a neighbour differs by up to 1.
    assert np.abs(light - twin).max() < 1e-4
    assert not light[:, 48].any()
    assert np.abs(light[:, :48] - light[:, 49:]).max() > 0.1


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize(("yaw_deg", "pitch_deg"), [(0.0, 0.0), (5.5, -5.0), (-6.0, 7.0)])
def test_a_light_stands_where_it_is(
    device: Device, side: Any, yaw_deg: float, pitch_deg: float
) -> None:
    """At yaw and pitch from straight ahead: slope tan(yaw) right, tan(pitch) / cos(yaw) up."""
    height = 720  # four pixels a degree
    sky = np.zeros((height, 2 * height, 3), np.float32)
    row, column = round((90.0 - pitch_deg) * 4), round((yaw_deg + 180.0) * 4)
    sky[row - 2 : row + 2, column - 2 : column + 2] = 1.0
    sizes = [*SIZE[:2], "headset.lens_separation_mm=15", "panel.pixel_pitch_um=300"]
    rig = load_rig("bare", overrides=sizes)
    view = viewport(rig, side)
    light = drawn(device, rig, (sky, sky), HeadPose(), 6)[:, view.columns, 1]
    rows, columns = np.indices(light.shape) + 0.5
    found = np.array([(columns * light).sum(), (rows * light).sum()]) / light.sum()
    yaw, pitch = np.radians(yaw_deg), np.radians(pitch_deg)
    slope = np.array([np.tan(yaw), -np.tan(pitch) / np.cos(yaw)])
    px_per_slope = bench_of(rig).panel_per_slope_mm / pitch_mm(rig)
    wanted = axis_in_viewport_px(rig, view) + slope * px_per_slope
    # The light is a degree wide, 2.7 pixels, whose centroid bends with the projection.
    np.testing.assert_allclose(found, wanted, atol=0.05)


def test_a_turn_of_the_head_is_a_turn_of_the_world(device: Device) -> None:
    """Yaw by whole columns: the same picture from a world that is rolled."""
    sky = world(3)
    turned = drawn(device, WIDE, (sky, sky), HeadPose(yaw_deg=7.5 * 3), 2)
    rolled = np.roll(sky, -3, axis=1)
    still = drawn(device, WIDE, (rolled, rolled), HeadPose(), 2)
    np.testing.assert_allclose(turned, still, atol=1e-4)


def test_a_world_of_one_colour_has_neither_seam_nor_pole(device: Device) -> None:
    even = np.full((32, 64, 3), 0.5, np.float32)
    for head in POSES:
        light = drawn(device, WIDE, (even, even), head, 3)
        assert light[:, :48].min() == light[:, 49:].max() == 0.5


def test_samples_follow_the_picture() -> None:
    rig = load_rig("bare")
    assert samples_for(rig, 1024) == 2
    assert samples_for(rig, 8192) == 3
    assert samples_for(rig, 65536) == 6


def test_panoramas_from_files(tmp_path: Path) -> None:
    mono, stereo = tmp_path / "mono.exr", tmp_path / "stereo.exr"
    write_picture(mono, world(1, 8))
    write_picture(stereo, np.concatenate([world(1, 8), world(2, 8)]))
    left, right = load_panorama(mono)
    assert left is right
    np.testing.assert_array_equal(left, world(1, 8))
    left, right = load_panorama(stereo)
    np.testing.assert_array_equal(left, world(1, 8))
    np.testing.assert_array_equal(right, world(2, 8))
    odd = tmp_path / "odd.exr"
    write_picture(odd, np.zeros((7, 15, 3), np.float32))
    for path, layout, wanted in (
        (odd, "auto", "found 15x7 pixels, wanted 2:1, or 1:1"),
        (mono, "over-under", "found 16x8 pixels, wanted 1:1"),
        (stereo, "mono", "found 16x16 pixels, wanted 2:1"),
        (mono, "side-by-side", "found the layout side-by-side"),
    ):
        with pytest.raises(ImageReadError, match=wanted):
            load_panorama(path, layout=layout)
