"""HDR-VDP-2.2: its pieces by closed forms, the whole against the original's own output.

``tests/data/hdr-vdp/release-2.2.npz`` holds what release 2.2 gave for the pictures that are made
here: every third pixel of ``s_map`` and ``p_map`` and ``numbers`` (P_det, C_max, Q, Q_MOS) of a
blurred photograph, every second pixel of P of faint Gabor patches, at 10.3 and 30 pixels per
degree. It is stored as float32, so that some 1e-7 is its own.
"""

from __future__ import annotations

from math import exp, expm1, log, sqrt
from pathlib import Path

import numpy as np
import pytest
import skimage.data
from numpy.typing import NDArray
from scipy import ndimage

from vrlf.errors import InputError
from vrlf.evaluation.hdrvdp import HdrVdp, hdr_vdp, masking, pooling
from vrlf.evaluation.hdrvdp.csf import (
    LOG_LUMINANCES,
    LUMINANCES_CD_M2,
    PARAMETERS,
    neural_csf,
    sensitivity_map,
)
from vrlf.evaluation.hdrvdp.eye import (
    L_CONE,
    M_CONE,
    RESPONSE_SCALE,
    cone_sensitivity,
    joint_sensitivity,
    optical_mtf,
    response_tables,
    retinal_luminance,
    rod_sensitivity,
    see,
)
from vrlf.evaluation.hdrvdp.filtering import filter_padded, radial_frequency, resize
from vrlf.evaluation.hdrvdp.pyramid import (
    Pyramid,
    convolve,
    correlate,
    decompose,
    level_count,
    reconstruct,
)
from vrlf.evaluation.hdrvdp.taps import band_taps, halving_taps, high_taps, low_taps

Plane = NDArray[np.float64]

# Pixels per degree, and what the original says of the photograph beside itself: Q, Q_MOS.
IDENTICAL = {10.3: (-1.2473, 77.54), 30.0: (-3.6484, 99.993)}
KEY = {10.3: "10_3", 30.0: "30"}


@pytest.fixture(scope="module")
def original() -> dict[str, Plane]:
    """What release 2.2 gave."""
    with np.load(Path(__file__).parent / "data" / "hdr-vdp" / "release-2.2.npz") as stored:
        return {name: stored[name].astype(np.float64) for name in stored.files}


@pytest.fixture(scope="module")
def photograph() -> Plane:
    """The camera man, 256x256, on a panel of 0.1 to 100 cd/m2."""
    encoded = ndimage.gaussian_filter(skimage.data.camera() / 255.0, 0.5, mode="mirror")
    encoded = encoded.reshape(256, 2, 256, 2).mean(axis=(1, 3))
    light = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return (0.1 + 99.9 * light).astype(np.float32).astype(np.float64)


def blurred(picture: Plane, diameter: float) -> Plane:
    """``picture`` seen through a disk, whose rim is sampled 16x16 times a pixel."""
    side = 2 * int(np.ceil(diameter / 2.0)) + 1
    at = (np.arange(side * 16) - (side * 16 - 1) / 2.0) / 16.0
    disk = np.hypot(at[:, np.newaxis], at) <= diameter / 2.0
    weights = disk.reshape(side, 16, side, 16).mean(axis=(1, 3))
    made = ndimage.convolve(picture, weights / weights.sum(), mode="mirror")
    return np.asarray(made.astype(np.float32).astype(np.float64))


def gabor(pixels_per_degree: float, cpd: float) -> Plane:
    """A patch of 1 % contrast on 30 cd/m2, half a degree wide."""
    at = (np.arange(256) - 127.5) / pixels_per_degree
    envelope = np.exp(-(at[:, np.newaxis] ** 2 + at**2) / (2.0 * 0.5**2))
    patch = 30.0 * (1.0 + 0.01 * envelope * np.cos(2.0 * np.pi * cpd * at))
    return patch.astype(np.float32).astype(np.float64)


@pytest.fixture(scope="module", params=list(KEY), ids=lambda ppd: f"{ppd:g}-per-degree")
def blur_case(request: pytest.FixtureRequest, photograph: Plane) -> tuple[float, HdrVdp]:
    """The photograph behind a blur of 9 pixels, at a resolution."""
    return request.param, hdr_vdp(blurred(photograph, 9.0), photograph, request.param)


def test_the_map_before_pooling_is_the_originals(
    blur_case: tuple[float, HdrVdp], original: dict[str, Plane]
) -> None:
    ppd, found = blur_case
    wanted = original[f"s_map_{KEY[ppd]}"]
    s_map = found.s_map[::3, ::3]
    assert np.corrcoef(np.log(s_map).ravel(), np.log(wanted).ravel())[0, 1] > 0.99999
    # The constants are known to six digits, and the map holds their power of 3.5. Where large
    # differences of several bands cancel, more is lost.
    off = np.abs(s_map / wanted - 1.0)
    assert np.percentile(off, [50, 90, 99]) == pytest.approx([0.0, 0.0, 0.0], abs=2e-4)
    assert np.median(off) < 3e-6
    assert np.abs(s_map - wanted).max() < 1e-5 * wanted.max()


def test_probability_and_numbers_are_the_originals(
    blur_case: tuple[float, HdrVdp], original: dict[str, Plane]
) -> None:
    ppd, found = blur_case
    assert found.p_map[::3, ::3] == pytest.approx(original[f"p_map_{KEY[ppd]}"], abs=1e-3)
    p_det, c_max, q, q_mos = original[f"numbers_{KEY[ppd]}"]
    assert found.p_det == pytest.approx(p_det, abs=1e-12)
    assert found.c_max == pytest.approx(c_max, rel=1e-5)
    assert found.q == pytest.approx(q, abs=1e-6)
    assert found.q_mos == pytest.approx(q_mos, abs=1e-4)


@pytest.mark.parametrize("ppd", list(KEY))
@pytest.mark.parametrize("cpd", [1, 4])
def test_a_faint_patch_is_seen_as_often_as_the_original_says(
    ppd: float, cpd: int, original: dict[str, Plane]
) -> None:
    found = hdr_vdp(gabor(ppd, cpd), np.full((256, 256), 30.0), ppd, surround_l=30.0)
    wanted = original[f"gabor_{KEY[ppd]}_{cpd}"]
    # The input's own float32 is 1e-7 of it, 1e-5 of its contrast.
    assert found.p_map[::2, ::2] == pytest.approx(wanted, abs=1e-5)
    assert wanted.max() > 0.02  # the patch is there to be missed


@pytest.mark.parametrize("ppd", list(IDENTICAL))
def test_equal_pictures_do_not_differ(ppd: float, photograph: Plane) -> None:
    found = hdr_vdp(photograph, photograph, ppd)
    assert not found.p_map.any()
    assert not found.s_map.any()
    assert (found.p_det, found.c_max) == (0.0, 0.0)
    q, q_mos = IDENTICAL[ppd]
    assert found.q == pytest.approx(q, abs=5e-5)
    assert found.q_mos == pytest.approx(q_mos, abs=5e-3)


def test_more_distortion_is_seen_more_and_spoils_more(photograph: Plane) -> None:
    part = photograph[40:141, 90:201]
    noise = np.random.default_rng(4).normal(size=part.shape)
    blocks = np.kron(part[:96, :104].reshape(12, 8, 13, 8).mean(axis=(1, 3)), np.ones((8, 8)))
    coarse = part.copy()
    coarse[:96, :104] = blocks
    rows = (
        [ndimage.gaussian_filter(part, sigma) for sigma in (0.3, 1.0, 3.0)],
        [part + share * (coarse - part) for share in (0.1, 0.4, 1.0)],
        [np.maximum(part + cd_m2 * noise, 0.0) for cd_m2 in (0.1, 1.0, 10.0)],
    )
    for row in rows:
        found = [hdr_vdp(picture, part, 30.0) for picture in row]
        assert found[0].c_max < found[1].c_max < found[2].c_max
        assert found[0].q < found[1].q < found[2].q
        assert found[0].q_mos > found[1].q_mos > found[2].q_mos


def test_the_surround_veils() -> None:
    patch, plain = gabor(10.3, 4)[64:192, 64:192], np.full((128, 128), 30.0)
    dark = hdr_vdp(patch, plain, 10.3)
    light = hdr_vdp(patch, plain, 10.3, surround_l=3000.0)
    assert light.c_max < 0.9 * dark.c_max


@pytest.mark.parametrize(
    "shape", [(1, 1), (1, 40), (5, 8), (16, 40), (17, 18), (33, 35), (131, 50)]
)
def test_any_size_is_taken(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(5)
    reference = 50.0 * rng.random(shape)
    found = hdr_vdp(reference * rng.uniform(0.9, 1.1, shape), reference, 30.0)
    assert found.p_map.shape == found.s_map.shape == shape
    assert np.isfinite(found.s_map).all()
    assert np.isfinite([found.q, found.q_mos]).all()
    assert (found.p_map >= 0.0).all()
    assert (found.p_map <= 1.0).all()


@pytest.mark.parametrize("ppd", [0.1, 1.0, 1e4])
@pytest.mark.parametrize("cd_m2", [0.0, 1e-3, 1e8])
def test_darkness_glare_and_odd_resolutions_give_numbers(ppd: float, cd_m2: float) -> None:
    reference = np.zeros((40, 52))
    test = reference.copy()
    test[10:17, 20:40] = cd_m2
    found = hdr_vdp(test, reference, ppd)
    values = [found.p_det, found.c_max, found.q, found.q_mos]
    assert np.isfinite(found.p_map).all()
    assert np.isfinite(values).all()
    if not cd_m2:
        assert not found.p_map.any()


def test_whole_numbers_and_lists_are_pictures_too() -> None:
    whole = np.arange(20 * 24).reshape(20, 24)
    found = hdr_vdp(whole.tolist(), whole + 1, 30)
    assert found.q == hdr_vdp(whole.astype(float), whole + 1.0, 30.0).q


GOOD = np.ones((20, 30))
SPOILT = np.where((np.arange(600) == 95).reshape(20, 30), np.nan, GOOD)


@pytest.mark.parametrize(
    ("test", "reference", "ppd", "surround", "complaint"),
    [
        (SPOILT, GOOD, 30.0, 0.0, "test picture: found nan in row 3, column 5"),
        (GOOD, SPOILT, 30.0, 0.0, "reference picture: found nan in row 3, column 5"),
        (GOOD, GOOD * np.inf, 30.0, 0.0, "reference picture: found inf"),
        (GOOD, -GOOD, 30.0, 0.0, "reference picture: found -1.0"),
        (GOOD, GOOD[:, :29], 30.0, 0.0, "found 30x20 pixels, wanted 29x20"),
        (np.ones((20, 30, 3)), GOOD, 30.0, 0.0, r"found an array of shape \(20, 30, 3\)"),
        (np.ones((0, 30)), GOOD, 30.0, 0.0, r"found an array of shape \(0, 30\)"),
        (GOOD, GOOD, 0.0, 0.0, "pixels per degree: found 0.0, wanted 0.1 to 10000"),
        (GOOD, GOOD, float("nan"), 0.0, "pixels per degree: found nan"),
        (GOOD, GOOD, float("inf"), 0.0, "pixels per degree: found inf"),
        (GOOD, GOOD, 30.0, -1.0, "surround: found -1.0 cd/m2"),
        (GOOD, GOOD, 30.0, float("nan"), "surround: found nan cd/m2"),
    ],
)
def test_what_is_wrong_is_said(
    test: Plane, reference: Plane, ppd: float, surround: float, complaint: str
) -> None:
    with pytest.raises(InputError, match=complaint):
        hdr_vdp(test, reference, ppd, surround_l=surround)


def test_radial_frequency_is_where_a_wave_lies() -> None:
    # 3 waves down 24 pixels and 5 across 40, at 8 pixels per degree: 1 and 1 cycle per degree.
    down, across = np.mgrid[:24, :40]
    wave = np.cos(2.0 * np.pi * (3.0 * down / 24.0 + 5.0 * across / 40.0))
    peak = np.unravel_index(np.abs(np.fft.rfft2(wave)).argmax(), (24, 21))
    assert radial_frequency((24, 40), 8.0)[peak] == pytest.approx(sqrt(2.0))


def test_a_filter_is_a_gain_over_frequency() -> None:
    rng = np.random.default_rng(6)
    picture = rng.random((7, 10))
    rho = radial_frequency((14, 20), 1.0)
    assert filter_padded(picture, np.ones_like(rho), 3.0) == pytest.approx(picture)
    only_mean = np.where(rho == 0.0, 1.0, 0.0)
    mean = (picture.sum() + 3.0 * (14 * 20 - 70)) / (14 * 20)
    assert filter_padded(picture, only_mean, 3.0) == pytest.approx(np.full((7, 10), mean))


def test_resizing_is_keyss() -> None:
    # Keys's kernel of twice the width, at 1/4, 3/4, 5/4 and 7/4, halved.
    halves = [-0.01171875, -0.03515625, 0.11328125, 0.43359375]
    impulse = np.zeros((1, 32))
    impulse[0, 15] = 1.0
    assert resize(impulse, (1, 16))[0, 5:10] == pytest.approx(
        [0.0, halves[1], halves[3], halves[2], halves[0]]
    )
    # Enlarging, it goes through any parabola.
    at = np.arange(20.0)[:, np.newaxis]
    to = (np.arange(50.0)[:, np.newaxis] + 0.5) * 0.4 - 0.5
    found = resize(at**2 - 3.0 * at, (50, 1))
    assert found[6:-6] == pytest.approx((to**2 - 3.0 * to)[6:-6])


def test_resizing_keeps_an_even_picture_and_takes_each_axis_alone() -> None:
    assert resize(np.full((31, 40), 2.5), (16, 87)) == pytest.approx(np.full((16, 87), 2.5))
    rng = np.random.default_rng(7)
    rows, columns = rng.random((31, 1)), rng.random((1, 40))
    found = resize(rows * columns, (16, 87))
    assert found == pytest.approx(resize(rows, (16, 1)) * resize(columns, (1, 87)))


def test_the_optics_pass_an_even_field_and_lose_detail() -> None:
    mtf = optical_mtf(np.array([0.0, 0.5, 4.0, 30.0]))
    assert mtf[0] == pytest.approx(1.0, abs=1e-7)
    assert (np.diff(mtf) < 0.0).all()
    assert mtf[2] == pytest.approx(0.4248386 * exp(-0.112) + 0.5724351 * exp(-1.48), rel=1e-9)
    field = retinal_luminance(np.full((9, 14), 30.0), 30.0, 30.0)
    assert field == pytest.approx(np.full((9, 14), 30.0), rel=1e-7)


def test_darkness_is_never_quite_dark() -> None:
    assert (retinal_luminance(np.zeros((9, 14)), 30.0, 0.0) == 1e-5).all()


def test_sensitivities_peak_where_they_should() -> None:
    log_l = np.linspace(-5.0, 5.0, 2001)
    rods = rod_sensitivity(10.0**log_l)
    assert 10.0 ** log_l[rods.argmax()] == pytest.approx(1.1732, rel=0.01)
    assert rod_sensitivity(np.array([1.1732])) == pytest.approx([10.0**1.1414])
    assert joint_sensitivity(np.array([4.0627]))[0] == pytest.approx(30.162 * 2.0**-0.2712)
    # Far in daylight cones are left alone, and each kind has half.
    cones = cone_sensitivity(10.0**log_l)
    assert cones[-1] == pytest.approx(30.162 / 2.0, rel=1e-3)
    both = np.array([2.0])
    half = (joint_sensitivity(both) - rod_sensitivity(both)) / 2.0
    assert cones[1000] == pytest.approx(half[0], rel=1e-5)


def test_one_step_of_the_response_is_one_just_noticeable_difference() -> None:
    log_l, cones, rods = response_tables()
    assert len(log_l) == 2048
    assert (log_l[0], log_l[-1]) == (-5.0, 5.0)
    for table, sensitivity in ((cones, cone_sensitivity), (rods, rod_sensitivity)):
        assert table[0] == 0.0
        assert (np.diff(table) >= 0.0).all()
        assert (np.diff(table)[log_l[1:] < 2.0] > 0.0).all()  # rods are blind by day
        slope = np.diff(table) / np.diff(log_l) / np.log(10.0) / RESPONSE_SCALE
        middle = sensitivity(10.0 ** ((log_l[1:] + log_l[:-1]) / 2.0))
        # Trapezes cut the kink at the rods' peak.
        assert np.median(np.abs(slope / middle - 1.0)) < 1e-5
        assert slope == pytest.approx(middle, rel=1e-3, abs=5e-3)


def test_a_response_has_no_mean_and_adaptation_is_what_the_cones_take() -> None:
    picture = np.random.default_rng(8).uniform(1.0, 90.0, (21, 34))
    seen = see(picture, 20.0, 10.0)
    assert seen.response.mean() == pytest.approx(0.0, abs=1e-9)
    retina = retinal_luminance(picture, 20.0, 10.0)
    assert seen.adaptation == pytest.approx((L_CONE + M_CONE) * retina)


def by_hand(rho: float, p1: float, p2: float, p3: float, p4: float) -> float:
    """The neural CSF for given parameters."""
    return p4 * sqrt((-expm1(-((rho / 7.0) ** 2))) ** p3 / (1.0 + (p1 * rho) ** p2))


def test_the_csf_goes_through_its_fits_and_lines_between() -> None:
    for cd_m2, parameters in zip(LUMINANCES_CD_M2, PARAMETERS, strict=True):
        assert neural_csf(3.5, cd_m2) == pytest.approx(by_hand(3.5, *parameters))
    between = [(a + b) / 2.0 for a, b in zip(PARAMETERS[3], PARAMETERS[4], strict=True)]
    assert neural_csf(9.0, sqrt(2.0 * 20.0)) == pytest.approx(by_hand(9.0, *between))
    assert neural_csf(2.0, 1e4) == neural_csf(2.0, 150.0)
    assert neural_csf(2.0, 1e-5) == neural_csf(2.0, 0.002)
    assert neural_csf(0.0, 30.0) == 0.0


def test_a_sensitivity_map_is_the_csf_pixel_by_pixel() -> None:
    at = np.array([[LOG_LUMINANCES[100], LOG_LUMINANCES[200]], [0.7, 1.234]])
    wanted = neural_csf(5.0, 10.0**at)
    assert sensitivity_map(5.0, at)[0] == pytest.approx(wanted[0])
    # A chord of 0.04 in log luminance.
    assert sensitivity_map(5.0, at)[1] == pytest.approx(wanted[1], rel=1e-4)


def test_the_taps_tile_the_plane_of_frequencies() -> None:
    def power(kernel: Plane) -> Plane:
        return np.abs(np.fft.fft2(kernel, (64, 64))) ** 2

    bands = sum(power(kernel) for kernel in band_taps())
    whole = power(high_taps()) + power(low_taps()) * (bands + power(halving_taps()) / 4.0)
    # Short filters tile to a few hundredths only (Karasaridis & Simoncelli 1996).
    assert np.abs(whole - 1.0).max() < 0.03
    assert np.sqrt(np.mean((whole - 1.0) ** 2)) < 0.006
    sums = [kernel.sum() for kernel in (high_taps(), low_taps(), halving_taps(), *band_taps())]
    assert sums == pytest.approx([0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 0.0], abs=1e-6)


@pytest.mark.parametrize("shape", [(40, 23), (9, 30), (4, 11)])
def test_correlation_is_scipys_mirrored_about_the_edge_pixel(shape: tuple[int, int]) -> None:
    picture = np.random.default_rng(9).normal(size=shape)
    for kernel in (high_taps(), *band_taps()):
        kernel = kernel + np.arange(kernel.size).reshape(kernel.shape) * 1e-3
        wanted = ndimage.correlate(picture, kernel, mode="mirror")
        assert correlate(picture, [kernel])[0] == pytest.approx(wanted, abs=1e-12)
        wanted = ndimage.convolve(picture, kernel, mode="mirror")
        assert convolve(picture, kernel) == pytest.approx(wanted, abs=1e-12)


def test_the_pyramid_has_the_toolboxs_levels() -> None:
    assert [level_count((side, 300)) for side in (16, 17, 33, 34, 256)] == [0, 1, 1, 2, 4]
    shapes = [planes[0].shape for planes in decompose(np.zeros((256, 256))).bands]
    assert shapes == [(side, side) for side in (256, 256, 128, 64, 32, 16)]
    odd = decompose(np.zeros((35, 71)))
    assert [planes[0].shape for planes in odd.bands] == [(35, 71), (35, 71), (18, 36), (9, 18)]
    assert [len(planes) for planes in odd.bands] == [1, 4, 4, 1]
    assert odd.frequencies == (1.0, 0.5, 0.25, 0.125)


def test_an_even_picture_is_all_base() -> None:
    bands = decompose(np.full((70, 90), 3.0)).bands
    # Two levels of 70 rows and 35, and one of 17.5, each of which doubles.
    assert bands[-1][0] == pytest.approx(np.full(bands[-1][0].shape, 3.0 * 2.0**3), rel=1e-5)
    for planes in bands[:-1]:
        assert max(np.abs(plane).max() for plane in planes) < 1e-5


@pytest.mark.parametrize("shape", [(128, 96), (101, 131)])
def test_a_picture_comes_back_from_its_bands(shape: tuple[int, int]) -> None:
    picture = np.random.default_rng(10).normal(size=shape)
    inside = (slice(24, -24), slice(24, -24))
    off = (reconstruct(decompose(picture)) - picture)[inside]
    # As far as the filters tile; at the edges the mirror does not suit the odd ones.
    assert np.abs(off).max() < 0.06
    assert off.std() < 0.012 * picture.std()


def test_each_orientation_answers_to_its_own_stripes() -> None:
    down, across = np.mgrid[:64, :64]
    inside = (slice(16, -16), slice(16, -16))
    for orientation, way in enumerate((across, down - across, down, down + across)):
        spacing = 8.0 if orientation % 2 == 0 else 8.0 * sqrt(2.0) / 2.0
        bands = decompose(np.cos(2.0 * np.pi * way / spacing)).bands[1]
        answers = [np.square(plane[inside]).mean() for plane in bands]
        assert int(np.argmax(answers)) == orientation, answers


# A luminance that the table of sensitivities holds, so that nothing is read between two.
AT_A_POINT = LOG_LUMINANCES[160]


def one_band(plane: Plane) -> Pyramid:
    """A pyramid of a high residual and an empty base."""
    return Pyramid(((plane,), (np.zeros_like(plane),)))


def test_a_difference_at_its_threshold_is_one() -> None:
    log_adaptation = np.full((6, 9), AT_A_POINT)
    threshold = 1.0 / neural_csf(10.0, 10.0**AT_A_POINT)
    empty, delta = one_band(np.zeros((6, 9))), np.zeros((6, 9))
    delta[2, 3], delta[4, 4] = threshold, -2.0 * threshold
    found = masking.visible_difference(one_band(delta), empty, log_adaptation, 20.0).bands[0][0]
    assert found[2, 3] == pytest.approx(1.0)
    assert found[4, 4] == pytest.approx(-(2.0**3.5))
    assert np.count_nonzero(found) == 2


def test_what_both_pictures_hold_masks() -> None:
    texture = np.full((6, 9), 4.0)
    log_adaptation = np.full((6, 9), AT_A_POINT)
    seen = masking.visible_difference(
        one_band(texture + 1.0), one_band(texture), log_adaptation, 20.0
    ).bands[0][0]
    threshold = 1.0 / neural_csf(10.0, 10.0**AT_A_POINT)
    # Outside the picture nothing masks: a corner's mean of nine holds four.
    for pixel, texture_there in (((3, 4), 4.0), ((0, 0), 4.0 * 4.0 / 9.0)):
        mask = masking.K_SELF * (texture_there / threshold) ** masking.Q
        assert seen[pixel] == pytest.approx(1.0 / sqrt(threshold**7.0 + mask**2))


def test_nine_pixels_mean_zero_outside() -> None:
    plane = np.random.default_rng(11).random((4, 7))
    wanted = ndimage.uniform_filter(plane, 3, mode="constant")
    assert masking.mean_of_nine(plane) == pytest.approx(wanted)


def test_neighbouring_bands_mask_but_the_base_does_not() -> None:
    high, base = np.full((32, 40), 1.0), np.full((16, 20), 1000.0)
    level = tuple(np.full((32, 40), 10.0 * (number + 1)) for number in range(4))
    shared = Pyramid(((high,), level, (base,)))
    assert masking.neighbours(shared, 0, 0) == pytest.approx(np.full((32, 40), 10.0 / 2.0))
    assert masking.neighbours(shared, 1, 2) == pytest.approx(np.full((32, 40), 1.0 / 1.0))
    assert masking.neighbours(shared, 2, 0) == pytest.approx(np.full((16, 20), 10.0 / 2.0))


def test_pooling_and_probability_by_hand() -> None:
    s_map = np.array([[0.0, 0.5], [0.25, 0.25]])
    assert pooling.pooled(s_map) == pytest.approx(s_map * 2.0)
    assert pooling.probability(np.array([0.0, 1.0, 2.0])) == pytest.approx([0.0, 0.5, 0.75])
    assert not pooling.pooled(np.zeros((3, 4))).any()
    test, reference = np.array([1.002, 1.0005, 0.0, 0.1]), np.array([1.0, 1.0, 0.0, 0.0])
    assert pooling.differing(test, reference).tolist() == [1.0, 0.0, 0.0, 1.0]


def test_quality_by_hand() -> None:
    fine, coarse = np.full((4, 5), 3.0), np.full((4, 5), 0.5)
    bands = Pyramid(((fine,), (coarse,)))
    found = pooling.quality(bands, np.ones((4, 5)), 15.0)
    terms = [0.2142 * log(3.0 / sqrt(20.0)), 0.2690 * log(0.5 / sqrt(20.0))]
    assert found == pytest.approx(sum(terms) / 2.0)
    assert pooling.opinion_score(-0.8886) == 50.0
