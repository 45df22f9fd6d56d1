"""Preparing the target: the pass against its float64 twin, and both against closed forms."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from pass_rigs import rig

from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.optics.fitting import Fit, FitMode, fit_picture
from vrlf.optics.viewport import SIDES, viewport
from vrlf.passes import EyePicture, Prepare
from vrlf.reference.prepare import prepare as twin

Light = NDArray[Any]
Prepared = Callable[..., Light]

# Sums of at most 33 x 33 float32 products of light below 1, at places good to 1e-5 px.
SAME_LIGHT = 2e-5


def fits_of(pictures: tuple[Light, Light], given: Rig, mode: FitMode, aspect: float) -> list[Fit]:
    """Where each eye's picture lies."""
    return [
        fit_picture(picture.shape[1::-1], aspect, viewport(given, side), mode)
        for picture, side in zip(pictures, SIDES, strict=True)
    ]


def by_twin(
    given: Rig,
    pictures: tuple[Light, Light],
    mode: FitMode = "contain",
    aspect: float = 1.0,
    *,
    encoded: bool = False,
) -> Light:
    """The target by the float64 twin."""
    left, right = fits_of(pictures, given, mode, aspect)
    return twin(pictures, (left, right), given, encoded=encoded)


def by_pass(
    device: Device,
    given: Rig,
    pictures: tuple[Light, Light],
    mode: FitMode = "contain",
    aspect: float = 1.0,
    *,
    encoded: bool = False,
) -> Light:
    """The target by the GPU."""
    owned: list[Any] = [Prepare(device)]
    try:
        eyes = []
        for picture, fit in zip(pictures, fits_of(pictures, given, mode, aspect), strict=True):
            pixels = np.ascontiguousarray(picture, np.float32)
            owned.append(texture := Texture.from_array(device, pixels, label="picture"))
            eyes.append(EyePicture(texture, fit))
        size = (given.panel.width_px, given.panel.height_px)
        owned.append(target := Texture(device, size, label="target"))
        # What a pixel keeps that nobody writes would show.
        target.write(np.full((size[1], size[0], 4), 7.0, np.float32))
        owned[0].run(given, (eyes[0], eyes[1]), target, encoded=encoded)
        return target.read()[..., :3]
    finally:
        for each in owned:
            each.release()


@pytest.fixture(params=["twin", "pass"])
def prepared(request: pytest.FixtureRequest, device: Device) -> Prepared:
    """Whoever prepares: closed forms hold for both."""
    if request.param == "twin":
        return by_twin
    return lambda *args, **options: by_pass(device, *args, **options)


def noise(width: int, height: int, seed: int) -> Light:
    """Random light, asymmetric in all ways."""
    return np.random.default_rng(seed).random((height, width, 3), dtype=np.float32)


def halves(target: Light) -> tuple[Light, Light]:
    """What each viewport shows."""
    half = target.shape[1] // 2
    return target[:, :half], target[:, target.shape[1] - half :]


# --- against the twin -------------------------------------------------------------------------

DISTORTED = {"distortion": [0.34, 0.55], "lens_height_mm": 0.4}


@pytest.mark.parametrize(
    ("size", "pictures", "mode", "aspect", "headset"),
    [
        ((44, 30), ((22, 30), (22, 30)), "contain", 1.0, {}),
        ((45, 31), ((31, 57), (63, 29)), "contain", 1.0, {}),
        ((45, 31), ((31, 57), (63, 29)), "cover", 1.0, {}),
        ((44, 30), ((7, 5), (3, 11)), "cover", 2.0, {}),
        ((45, 29), ((90, 131), (17, 13)), "contain", 0.5, DISTORTED),
        ((44, 31), ((160, 150), (41, 45)), "cover", 2.0, DISTORTED | {"eye_relief_mm": 11.0}),
    ],
)
@pytest.mark.parametrize("encoded", [False, True])
def test_prepare_matches_its_twin(
    device: Device,
    size: tuple[int, int],
    pictures: tuple[tuple[int, int], tuple[int, int]],
    mode: FitMode,
    aspect: float,
    headset: dict[str, Any],
    encoded: bool,
) -> None:
    given = rig(*size, headset=headset)
    both = (noise(*pictures[0], 1), noise(*pictures[1], 2))
    got = by_pass(device, given, both, mode, aspect, encoded=encoded)
    wanted = by_twin(given, both, mode, aspect, encoded=encoded)
    # A place within float32's rounding of the picture's edge may be in or out: none is here.
    assert np.abs(got - wanted).max() <= SAME_LIGHT


def test_same_input_gives_the_same_bytes(device: Device) -> None:
    given = rig(45, 31, headset=DISTORTED)
    both = (noise(31, 57, 1), noise(63, 29, 2))
    first = by_pass(device, given, both).tobytes()
    assert by_pass(device, given, both).tobytes() == first


# --- where the picture lies -------------------------------------------------------------------


@pytest.mark.parametrize("width", [44, 45])
def test_a_picture_of_the_viewports_size_comes_through_unchanged(
    prepared: Prepared, width: int
) -> None:
    left, right = noise(22, 31, 3), noise(22, 31, 4)
    target = prepared(rig(width, 31), (left, right))
    # At whole steps the cubic is exactly 1 and 0: not a bit changes.
    assert np.array_equal(halves(target)[0], left)
    assert np.array_equal(halves(target)[1], right)
    # The middle column of an odd width is nobody's; of an even one there is none.
    assert not target[:, 22 : width - 22].any()


def quarters() -> Light:
    """Red upper left, green upper right, blue lower left, black lower right; 4 x 6 pixels."""
    picture = np.zeros((6, 4, 3), np.float32)
    picture[:3, :2, 0] = picture[:3, 2:, 1] = picture[3:, :2, 2] = 1.0
    return picture


def test_pictures_stand_upright_unmirrored_each_before_its_own_eye(prepared: Prepared) -> None:
    left, right = quarters(), quarters()[..., [1, 2, 0]]
    shown = halves(prepared(rig(41, 30), (left, right)))
    for half, colours in zip(shown, ([0, 1, 2], [2, 0, 1]), strict=True):
        # Five times as large: the middle of each quarter is far from the others.
        corners = [half[7, 4], half[7, 15], half[22, 4], half[22, 15]]
        wanted = [*np.eye(3)[colours], np.zeros(3)]
        assert np.array(corners) == pytest.approx(np.array(wanted), abs=1e-6)


def disc(width: int, height: int, radius: float, aspect: float) -> Light:
    """A disc of ``radius`` seen pixels in the middle, drawn in pixels ``aspect`` wide; 8 x 8
    points a pixel, on grey ground lower than full light so that no overshoot is cut."""
    x = (np.arange(width * 8) + 0.5) / 8 - width / 2
    y = (np.arange(height * 8) + 0.5) / 8 - height / 2
    inside = (x[None, :] * aspect) ** 2 + y[:, None] ** 2 <= radius**2
    drawn = inside.reshape(height, 8, width, 8).mean(axis=(1, 3))
    return np.repeat((0.2 + 0.6 * drawn)[..., None], 3, axis=2)


@pytest.mark.parametrize(
    ("width", "height", "aspect"), [(80, 60, 1.0), (30, 60, 2.0), (90, 30, 0.5), (31, 64, 1.0)]
)
@pytest.mark.parametrize("mode", ["contain", "cover"])
def test_circles_stay_circles(
    prepared: Prepared, mode: FitMode, width: int, height: int, aspect: float
) -> None:
    """In every layout: a half layout's pixels are seen twice as wide, or half as wide."""
    given = rig(100, 40)
    picture = disc(width, height, 11.0, aspect)
    scales = (50 / (width * aspect), 40 / height)
    scale = min(scales) if mode == "contain" else max(scales)
    for half in halves(prepared(given, (picture, picture), mode, aspect)):
        light = half[..., 0] - 0.2
        # Only the disc's own surroundings: the bars are darker than the ground.
        reach = 11.0 * scale + 2.0
        assert reach < 20.0, "the whole disc is in the viewport"
        x, y = np.arange(50) + 0.5 - 25.0, np.arange(40) + 0.5 - 20.0
        near = (np.abs(x)[None, :] <= reach) & (np.abs(y)[:, None] <= reach)
        light = np.where(near, light, 0.0)
        # A disc's variance along any axis is a quarter of the squared radius; to it the
        # picture's pixels, over which it was drawn, add their own, and the kernel's is 0.
        pixel = np.array([aspect * scale, scale]) ** 2 / 12.0
        spread = [(light * x[None, :] ** 2).sum(), (light * y[:, None] ** 2).sum()]
        radii = 2.0 * np.sqrt(np.array(spread) / light.sum() - pixel)
        # Cutting at ``reach`` leaves some thousandths of the lobes' light out.
        assert radii == pytest.approx(np.full(2, 11.0 * scale), rel=0.006)


def test_bars_are_black_and_the_picture_full_to_its_edge(prepared: Prepared) -> None:
    """Left 40 x 20 in 30 x 41: 30 x 15 with 13 rows of black; right 10 x 41, 10 columns."""
    white = (np.ones((20, 40, 3), np.float32), np.ones((41, 10, 3), np.float32))
    left, right = halves(prepared(rig(61, 41), white))
    # Weights are divided by their own sum, so that an edge is not darkened: to rounding.
    assert left[13:28] == pytest.approx(np.ones((15, 30, 3)), abs=1e-6)
    assert not left[:13].any()
    assert not left[28:].any()
    assert right[:, 10:20] == pytest.approx(np.ones((41, 10, 3)), abs=1e-6)
    assert not right[:, :10].any()
    assert not right[:, 20:].any()


def test_cover_leaves_no_bar_and_cuts_in_the_middle(prepared: Prepared) -> None:
    """40 x 20 over 30 x 41: 82 x 41, of which the columns 26 to 56 are shown."""
    ramp = np.repeat(np.arange(40)[None, :, None] / 40.0, 20, axis=0).repeat(3, axis=2) + 0.01
    left, right = halves(prepared(rig(61, 41), (ramp, ramp), "cover"))
    # The cubic keeps straight lines: half a target pixel is 20/41/2 of a source pixel.
    place = (np.arange(30) + 0.5 + 26.0) * 20 / 41 - 0.5
    wanted = np.broadcast_to((place / 40.0 + 0.01)[None, :, None], (41, 30, 3))
    assert left == pytest.approx(wanted, abs=1e-6)
    assert right == pytest.approx(wanted, abs=1e-6)


# --- how it is filtered -----------------------------------------------------------------------


def test_enlarging_keeps_straight_ramps(prepared: Prepared) -> None:
    """Keys's cubic reproduces lines, away from the edge pixels, in both directions at once."""
    x, y = np.arange(12)[None, :, None], np.arange(16)[:, None, None]
    ramp = 0.1 + 0.03 * x + 0.02 * y + np.zeros(3)
    left, _ = halves(prepared(rig(60, 40), (ramp, ramp)))
    at_x, at_y = (np.arange(30) + 0.5) / 2.5 - 0.5, (np.arange(40) + 0.5) / 2.5 - 0.5
    wanted = 0.1 + 0.03 * at_x[None, :, None] + 0.02 * at_y[:, None, None] + np.zeros(3)
    # Four target pixels are the 1.6 source pixels in which the kernel misses a neighbour.
    assert left[4:-4, 4:-4] == pytest.approx(wanted[4:-4, 4:-4], abs=1e-6)


def test_overshoot_is_no_light(prepared: Prepared) -> None:
    """A step enlarged 5 times: the cubic's lobes would leave [0, 1] by 1/16 and more."""
    step = np.zeros((8, 6, 3))
    step[:, 3:] = 1.0
    left, _ = halves(prepared(rig(60, 40), (step, step)))
    assert left.min() == 0.0
    assert left.max() == 1.0
    assert (left[20, :, 0] > 0.5).tolist() == [False] * 15 + [True] * 15


@pytest.mark.parametrize("ratio", [4, 7])
@pytest.mark.parametrize("encoded", [False, True])
def test_a_fine_checkerboard_becomes_grey(prepared: Prepared, ratio: int, encoded: bool) -> None:
    """Half the light, also of encoded pictures: what is averaged is light, not codes."""
    rows, columns = np.indices((30 * ratio, 22 * ratio))
    board = np.repeat(((rows + columns) % 2)[..., None], 3, axis=2).astype(np.float64)
    for half in halves(prepared(rig(44, 30), (board, board), encoded=encoded)):
        # A kernel of 4 target pixels over alternate squares: the odd one out weighs 1/ratio^2
        # at the corners, where only a quarter of the kernel lies on the picture.
        assert half == pytest.approx(np.full_like(half, 0.5), abs=0.5 / ratio**2)
        assert half[2:-2, 2:-2] == pytest.approx(np.full_like(half[2:-2, 2:-2], 0.5), abs=1e-3)


def test_minification_at_any_ratio_passes_no_pattern(prepared: Prepared) -> None:
    """Sampling every 3.37th pixel would give moire of full contrast."""
    rows, columns = np.indices((101, 74))
    board = np.repeat(((rows + columns) % 2)[..., None], 3, axis=2).astype(np.float64)
    left, _ = halves(prepared(rig(44, 30), (board, board)))
    # The cubic's spectrum at the board's frequency, 1.7 cycles a target pixel on each axis,
    # is below 3 %; both axes multiply.
    assert np.abs(left[2:-2, 2:-2] - 0.5).max() < 2e-3


def test_minification_keeps_the_mean(prepared: Prepared) -> None:
    """The cubic is a partition of unity at whole ratios; grey margins keep the edges out."""
    ratio, margin = 3, 12
    picture = np.full((30 * ratio, 22 * ratio, 3), 0.5)
    inner = picture[margin:-margin, margin:-margin]
    inner += np.random.default_rng(6).random(inner.shape) * 0.4 - 0.3
    left, right = halves(prepared(rig(44, 30), (picture, picture[::-1])))
    # float32 sums of 1e3 pixels near 0.5.
    assert left.mean(axis=(0, 1)) == pytest.approx(picture.mean(axis=(0, 1)), abs=2e-6)
    assert right.mean(axis=(0, 1)) == pytest.approx(picture.mean(axis=(0, 1)), abs=2e-6)


def test_encoded_pictures_are_decoded(prepared: Prepared) -> None:
    """IEC 61966-2-1, on both of its branches; 0.5 is 0.21404 of light."""
    codes = np.linspace(0.0, 1.0, 22 * 30 * 3).reshape(30, 22, 3)
    light = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    left, right = halves(prepared(rig(44, 30), (codes, codes[::-1]), encoded=True))
    # GLSL's pow is good to some 1e-6 of its result on what is tested; hardware to 1e-5.
    assert left == pytest.approx(light, abs=SAME_LIGHT)
    assert right == pytest.approx(light[::-1], abs=SAME_LIGHT)


# --- the lens's distortion --------------------------------------------------------------------

# Ten times a phone's, so that a small panel reaches slopes of 0.6.
PITCH_MM = 0.78


@pytest.mark.parametrize(
    ("headset", "array", "m_mm"),
    [
        ({}, {}, 46.0),
        # m = e + d - d e F = 12 + 46 - 46 * 12 * 0.018.
        ({"lens_power_d": 18.0, "eye_relief_mm": 12.0}, {}, 48.064),
        # d = 40 + 6 / 1.5 = 44 behind a solid spacer, at no relief m = d.
        (
            {},
            {
                "kind": "microlens",
                "pitch_um": 3900.0,
                "gap_mm": 6.0,
                "gap_index": 1.5,
                "focal_mm": 6.0,
            },
            44.0,
        ),
    ],
)
@pytest.mark.parametrize("k", [(0.34, 0.55), (-0.4, 0.3), (0.4, 0.0), (0.0, -0.9)])
def test_a_target_is_drawn_for_the_slope_that_is_seen(
    prepared: Prepared,
    headset: dict[str, Any],
    array: dict[str, Any],
    m_mm: float,
    k: tuple[float, float],
) -> None:
    """A panel point of slope r = |X| / m holds the content of slope r (1 + k1 r^2 + k2 r^4).

    The content is a straight ramp over the viewport, which the filter leaves straight: every
    pixel then tells from where its content came. Axes are off the viewports' middles.
    """
    given = rig(
        91,
        60,
        panel={"pixel_pitch_um": 1000.0 * PITCH_MM},
        headset={
            "distortion": list(k),
            "lens_separation_mm": 41.0,
            "lens_height_mm": 3.5,
            **headset,
        },
        array=array,
    )
    x, y = np.arange(45)[None, :] + 0.5, np.arange(60)[:, None] + 0.5
    ramp = np.stack([x / 50 + 0 * y, y / 70 + 0 * x, (x + 2 * y) / 200], axis=-1)
    for half, axis_mm, first in zip(
        halves(prepared(given, (ramp, ramp))), (-20.5, 20.5), (0, 46), strict=True
    ):
        axis_x = axis_mm / PITCH_MM + 91 / 2 - first
        axis_y = 60 / 2 - 3.5 / PITCH_MM
        r2 = ((x - axis_x) ** 2 + (y - axis_y) ** 2) * (PITCH_MM / m_mm) ** 2
        stretch = 1 + k[0] * r2 + k[1] * r2**2
        from_x, from_y = axis_x + (x - axis_x) * stretch, axis_y + (y - axis_y) * stretch
        wanted = np.stack([from_x / 50, from_y / 70, (from_x + 2 * from_y) / 200], axis=-1)
        # The kernel misses neighbours within two pixels of the picture's edge.
        depth = np.minimum(np.minimum(from_x, 45 - from_x), np.minimum(from_y, 60 - from_y))
        assert (depth > 2).sum() > 1000
        # A float32 place of 60 px is good to 4e-6, and the ramp is less than 1/50 a pixel.
        assert half[depth > 2] == pytest.approx(wanted[depth > 2], abs=1e-5)
        assert not half[depth < -1e-3].any()
        assert half[(depth > 1e-3) & (from_x > 1)].any(axis=-1).all()
        # And it is a long way: what an undistorted target would show is elsewhere.
        assert np.abs(half[..., 0] - ramp[..., 0]).max() > 0.05
