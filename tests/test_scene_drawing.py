"""The drawn scene: everything at its place in both eyes, and a picture that looks natural."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from vrlf.errors import InputError
from vrlf.gpu import Device, Texture
from vrlf.model import Rig, load_rig
from vrlf.optics.bench import bench_of
from vrlf.optics.viewport import SIDES, Side, panel_points_mm, pitch_mm, viewport
from vrlf.scene import HeadPose, Scene, luminance, render_stereo, spectrum_slope
from vrlf.scene.foliage import LEAF
from vrlf.scene.garden import Garden
from vrlf.scene.solids import Material, merge, quad
from vrlf.scene.stereo import MOST_SAMPLES, canvas_size

Light = NDArray[Any]
Mask = NDArray[np.bool_]

# Nothing of it is symmetric: an odd width, axes off the middle of the viewports and above it.
SKEW = (
    "panel.width_px=97",
    "panel.height_px=64",
    "panel.pixel_pitch_um=400.0",
    "headset.lens_separation_mm=17.0",
    "headset.lens_height_mm=2.0",
)
# Both terms move the marker by several pixels.
BENT = (*SKEW, "headset.distortion=[-0.5,20.0]")

# An L in metres, lower left and upper right corners of its arms: long upward, short to the right.
MARKER_Z_M = -0.6
MARKER = ((-0.03, -0.05, 0.02, 0.12), (0.02, -0.05, 0.07, 0.0))


def scene_of(*rectangles: tuple[float, ...]) -> Garden:
    """Dark rectangles at the marker's distance, and one behind the head: nothing else."""
    quads = [quad((0, 0, 3), (1, 0, 0), (0, 1, 0), Material.GLASS)]
    for left, bottom, right, top in rectangles:
        corner, along, up = (left, bottom, MARKER_Z_M), (right - left, 0, 0), (0, top - bottom, 0)
        quads.append(quad(corner, along, up, Material.GLASS))
    return Garden(merge(quads), np.zeros(0, LEAF), np.zeros(0, LEAF))


def drawn(device: Device, rig: Rig, side: Side, garden: Garden | None = None, **how: Any) -> Light:
    """A view as an array."""
    scene = Scene(device, garden=garden)
    try:
        return seen_by(scene, device, rig, side, **how)
    finally:
        scene.release()


def seen_by(scene: Scene, device: Device, rig: Rig, side: Side, **how: Any) -> Light:
    """An eye's viewport of what a scene draws."""
    size = (rig.panel.width_px, rig.panel.height_px)
    target = Texture(device, size, label="target")
    target.write(np.full((*size[::-1], 4), 9.0, np.float32))
    try:
        scene.draw(target, rig, **how)
        light = np.asarray(target.read()[..., :3])
    finally:
        target.release()
    assert light.max() <= 1.0, "a pixel was not written"
    half = size[0] // 2
    assert not light[:, half : size[0] - half].any(), "nobody's column is dark"
    view = viewport(rig, side)
    return np.ascontiguousarray(light[:, view.first_column : view.first_column + view.width_px])


def covered(device: Device, rig: Rig, side: Side, **how: Any) -> Mask:
    """Pixels that the marker changes at all."""
    with_marker = drawn(device, rig, side, scene_of(*MARKER), **how)
    without = drawn(device, rig, side, scene_of(), **how)
    return np.any(with_marker != without, axis=-1)


def resolved_by_hand(rig: Rig, side: Side, offset_px: tuple[float, float]) -> Mask:
    """Whether the slope seen at an offset (right, down) from each pixel's centre meets the L."""
    view, m = viewport(rig, side), bench_of(rig).panel_per_slope_mm
    step = np.array([offset_px[0], -offset_px[1]]) * pitch_mm(rig)
    slope = (panel_points_mm(rig, view) + step) / m
    k1, k2 = rig.headset.distortion or (0.0, 0.0)
    r2 = np.sum(slope**2, axis=-1, keepdims=True)
    slope = slope * (1.0 + k1 * r2 + k2 * r2**2)
    half_m = rig.headset.lens_separation_mm / 2000.0
    eye_x = -half_m if side == "left" else half_m
    x, y = eye_x - MARKER_Z_M * slope[..., 0], -MARKER_Z_M * slope[..., 1]
    return np.logical_or.reduce(
        [(x > left) & (x < right) & (y > bottom) & (y < top) for left, bottom, right, top in MARKER]
    )


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("overrides", [SKEW, BENT], ids=["straight", "distorted"])
def test_a_marker_stands_where_geometry_puts_it(
    device: Device, side: Side, overrides: tuple[str, ...]
) -> None:
    """Neither mirrored nor upside down, in each eye at its own place."""
    rig = load_rig("bare", overrides=overrides)
    found = covered(device, rig, side)
    # Samples stand within a third of a pixel of its centre; a canvas that was stretched for
    # the distortion adds half of its own pixel. Between the two masks anything may happen.
    reach = 0.75
    corners = [(x, y) for x in (-reach, 0.0, reach) for y in (-reach, 0.0, reach)]
    masks = [resolved_by_hand(rig, side, corner) for corner in corners]
    surely, possibly = np.logical_and.reduce(masks), np.logical_or.reduce(masks)
    assert surely.sum() > 60
    assert np.all(found[surely])
    assert not np.any(found[~possibly])


def test_the_marker_is_further_right_in_the_left_eye(device: Device) -> None:
    """By m * separation / distance, in pixels: crossed disparity."""
    rig = load_rig("bare", overrides=SKEW)
    first = []
    for side in SIDES:
        columns = np.flatnonzero(covered(device, rig, side).any(axis=0))
        first.append(panel_points_mm(rig, viewport(rig, side))[0, columns[0], 0])
    wanted_mm = bench_of(rig).panel_per_slope_mm * 0.017 / -MARKER_Z_M
    # Each edge is found to a pixel.
    assert first[0] - first[1] == pytest.approx(wanted_mm, abs=1.01 * pitch_mm(rig))


def test_a_turned_head_moves_the_picture_the_other_way(device: Device) -> None:
    """Looking 3 degrees right and 2 up moves things left and down by m tan of them."""
    rig = load_rig("bare", overrides=SKEW)
    at_rest = np.argwhere(covered(device, rig, "left")).mean(axis=0)
    turned = covered(device, rig, "left", head=HeadPose(yaw_deg=3.0, pitch_deg=2.0))
    rows, columns = np.argwhere(turned).mean(axis=0) - at_rest
    px_per_slope = bench_of(rig).panel_per_slope_mm / pitch_mm(rig)
    # The marker lies up to 0.2 off the axis, where a turn moves things by 1.04 times as much,
    # and its middle is found to some tenths of a pixel.
    assert columns == pytest.approx(-px_per_slope * np.tan(np.radians(3.0)), abs=0.5)
    assert rows == pytest.approx(px_per_slope * np.tan(np.radians(2.0)), abs=0.5)


@pytest.fixture(scope="module")
def eyes(device: Device) -> tuple[Light, Light]:
    """Both views of the default rig."""
    return render_stereo(device, load_rig("matched-microlens"))


def test_views_have_the_viewports_shape_and_range(eyes: tuple[Light, Light]) -> None:
    for view in eyes:
        assert view.shape == (750, 667, 3)
        assert view.dtype == np.float32
        assert view.flags.owndata or view.base is None
        assert 0.0 <= view.min() < 0.02
        assert view.max() == 1.0


def test_the_spectrum_is_natural(eyes: tuple[Light, Light]) -> None:
    """Natural scenes spread by 0.3 about -1 (Tolhurst, Tadmor and Chao 1992)."""
    for view in eyes:
        assert spectrum_slope(luminance(view)) == pytest.approx(-1.0, abs=0.3)


def test_the_exposure_keeps_lights_and_shadows(eyes: tuple[Light, Light]) -> None:
    for view in eyes:
        assert np.mean(np.any(view >= 1.0, axis=-1)) < 0.01
        assert 0.2 < view.mean() < 0.35
        low, high = np.percentile(luminance(view), [1, 99])
        assert high > 15.0 * low


def test_print_is_as_fine_as_pixels(eyes: tuple[Light, Light]) -> None:
    """In the lines of the left page, neighbouring pixels go from ink to paper."""
    page = luminance(eyes[0])[530:700, 205:340]
    steps = np.abs(np.diff(page, axis=1))
    assert np.mean(steps > 0.3 * (page.max() - page.min())) > 0.1


def test_the_sky_is_above(eyes: tuple[Light, Light]) -> None:
    """Blue in the upper quarter, wood and paper in the lowest."""
    for view in eyes:
        sky, table = view[:60, 230:380].mean(axis=(0, 1)), view[-60:].mean(axis=(0, 1))
        assert sky[2] > 1.2 * sky[0]
        assert table[0] > 1.2 * table[2]


@pytest.fixture(scope="module")
def small() -> Rig:
    """Few pixels over the whole field of view."""
    return load_rig(
        "bare",
        overrides=["panel.width_px=134", "panel.height_px=75", "panel.pixel_pitch_um=780.0"],
    )


def test_the_same_moment_is_the_same_bytes_and_another_is_not(device: Device, small: Rig) -> None:
    scene = Scene(device)
    try:
        first = seen_by(scene, device, small, "left", time_s=2.5)
        later = seen_by(scene, device, small, "left", time_s=3.0)
        again = seen_by(scene, device, small, "left", time_s=2.5)
    finally:
        scene.release()
    assert np.array_equal(first, again)
    assert np.any(first != later)
    # The wind moves leaves and clouds, not the table.
    assert np.array_equal(first[-5:, 25:], later[-5:, 25:])


def test_a_few_pixels_are_the_mean_of_many(device: Device, eyes: Any, small: Rig) -> None:
    """The same field at a tenth of the pixels: what antialiasing leaves of both is alike."""
    view = drawn(device, small, "left")
    fine = eyes[0][:, :660].reshape(75, 10, 66, 10, 3).mean(axis=(1, 3))
    # The rig's viewport is 67 columns of 0.78 mm, the fine one's 667 of 0.078: the left edges
    # differ by 0.15 mm, a fifth of a pixel. Detail and 9 samples a pixel leave some hundredths.
    assert np.mean(np.abs(view[:, :66] - fine)) < 0.05
    assert abs(view.mean() - eyes[0].mean()) < 0.01


def test_a_scene_gives_everything_back(device: Device, small: Rig) -> None:
    before = device.live_objects
    scene = Scene(device)
    seen_by(scene, device, small, "right")
    listed = " ".join(set(device.live_objects) - set(before))
    assert all(name in listed for name in ("scene/leaf", "scene/sky", "surfaces", "print", "depth"))
    scene.release()
    scene.release()
    assert device.live_objects == before


def test_the_canvas_follows_the_limits() -> None:
    rig = load_rig("matched-microlens")
    assert canvas_size(rig, 16384, 3) == (3, (2001, 2250))
    assert canvas_size(rig, 16384, 1) == (1, (667, 750))
    assert canvas_size(rig, 2000, 3) == (2, (1334, 1500))
    assert canvas_size(rig, 700, 3) == (1, (623, 700))
    wide = load_rig("matched-microlens", overrides=["panel.width_px=8000", "panel.height_px=6000"])
    samples, size_px = canvas_size(wide, 16384, 3)
    assert (samples, size_px) == (1, (4000, 6000))
    assert size_px[0] * size_px[1] * 4 > MOST_SAMPLES


def test_a_canvas_for_distortion_is_as_dense_in_the_middle() -> None:
    rig = load_rig("bare", overrides=BENT)
    plain = canvas_size(load_rig("bare", overrides=SKEW), 16384, 3)[1]
    bent = canvas_size(rig, 16384, 3)[1]
    assert bent[0] > 1.02 * plain[0]
    assert bent[1] > 1.02 * plain[1]


def test_a_target_beyond_the_gpu_is_refused(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(device, "info", replace(device.info, max_texture_px=3200))
    rig = load_rig("bare", overrides=["panel.width_px=8000", "panel.height_px=30"])
    with pytest.raises(InputError, match="target: found 8000x30 pixels, wanted at most 3200"):
        render_stereo(device, rig)


def test_another_rig_and_fewer_samples_from_frame_to_frame(device: Device, small: Rig) -> None:
    """An odd width too; the same scene draws what one made for the rig does."""
    odd = load_rig(
        "bare", overrides=["panel.width_px=97", "panel.height_px=50", "panel.pixel_pitch_um=780"]
    )
    scene = Scene(device)
    try:
        for rig in (small, odd, small):
            for side in ("left", "right"):
                np.testing.assert_array_equal(
                    seen_by(scene, device, rig, side), drawn(device, rig, side)
                )
        fine = seen_by(scene, device, odd, "right")
        scene.canvas.samples = 1
        coarse = seen_by(scene, device, odd, "right")
    finally:
        scene.release()
    assert 0.0 < np.mean(np.abs(fine - coarse)) < 0.1
