"""What sharpens a target: point spreads against closed forms and the twins, kernels by hand."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pass_rigs
import pytest
import scipy.ndimage
import scipy.special
from numpy.typing import NDArray

from vrlf.gpu import Device
from vrlf.model import Rig
from vrlf.passes import Forward, Perceive
from vrlf.reference.forward import forward
from vrlf.reference.quadrature import perceive_well
from vrlf.reference.sharpen import sharpen
from vrlf.renderer import GpuRenderer
from vrlf.solve.spread import (
    SPREAD_RAYS,
    PointSpread,
    point_spread,
    spots_of,
    spread_of,
    spread_pieces,
)
from vrlf.solve.wiener import kernel_of, sharpen_pieces

Light = NDArray[Any]

# Pixels four times as large as a phone's: the blur, and all that is measured, is four times
# smaller, and fits the twins' patience. Two lenslets in three pixels.
COARSE: dict[str, Any] = {"pixel_pitch_um": 320.0}
LENSLETS = pass_rigs.LENSLETS | {"pitch_um": 480.0, "offset_um": [70.0, -40.0]}
OBLIQUE: dict[str, Any] = {"sphere_d": -3.0, "cylinder_d": -2.0, "pupil_mm": 5.0}
LEANING = pass_rigs.rig(
    44,
    30,
    panel=COARSE | {"subpixels": "full"},
    left=OBLIQUE | {"axis_deg": 30.0},
    right=OBLIQUE | {"axis_deg": 110.0, "pupil_mm": 4.0},
)


@pytest.fixture
def gpu(device: Device) -> Iterator[GpuRenderer]:
    """A renderer on the file's device, which it leaves empty."""
    with GpuRenderer(device) as made:
        yield made


def twins(target: Light, rig: Rig) -> Light:
    """What is perceived of a target, by the float64 twins."""
    seen = perceive_well(forward(target.astype(np.float64), rig), rig, SPREAD_RAYS)
    return seen.astype(np.float32)


def measured(device: Device, rig: Rig) -> PointSpread:
    """A rig's point spread by the passes."""
    forward_pass, perceive_pass = Forward(device), Perceive(device)
    pieces = spread_pieces(device, rig, forward_pass, perceive_pass)
    try:
        while True:
            next(pieces)
    except StopIteration as done:
        spread: PointSpread = done.value
        return spread
    finally:
        forward_pass.release()
        perceive_pass.release()


def single(*values: tuple[int, int, float], side: int = 9) -> PointSpread:
    """The same spread for all eyes and colours: (right, down, share) of the light."""
    mean = np.zeros((2, 3, side, side))
    for right, down, share in values:
        mean[..., side // 2 + down, side // 2 + right] += share
    return PointSpread(mean, np.zeros((2, 3)), np.zeros((2, 2), int))


# --- point spreads ----------------------------------------------------------------------------


@pytest.mark.parametrize("array", [None, LENSLETS], ids=["bare", "lenslets"])
def test_the_passes_measure_what_the_twins_do(device: Device, array: dict[str, Any] | None) -> None:
    rig = pass_rigs.rig(
        44,
        30,
        panel=COARSE,
        array={} if array is None else array,
        left={"sphere_d": -4.0, "cylinder_d": -1.5, "axis_deg": 25.0},
        right={"sphere_d": -3.0, "pupil_mm": 3.0, "prism_pd": [0.9, -0.4]},
    )
    got, wanted = measured(device, rig), point_spread(rig, twins)
    # One ray in 64 on an edge of a lenslet moves 1 / 64 of one spot in 64's light.
    assert got.mean == pytest.approx(wanted.mean, abs=3e-4)
    assert got.scatter == pytest.approx(wanted.scatter, abs=3e-4)
    assert np.array_equal(got.shift_px, wanted.shift_px)


def exact_spectrum(side: int, rig: Rig, eye: int) -> Light:
    """Of a uniform ellipse of blur, averaged over two pixels, sampled at pixels; (side, side).

    psi = d R u, R in the raster's frame: right and down turn its mixed term's sign twice, once
    for the wearer's view of the axis and once for the rows.
    """
    given = (rig.left, rig.right)[eye]
    mean, half = given.sphere_d + given.cylinder_d / 2.0, -given.cylinder_d / 2.0
    twice = np.radians(2.0 * given.axis_deg)
    j0, j45 = half * np.cos(twice), half * np.sin(twice)
    refraction = np.array([[mean + j0, j45], [j45, mean - j0]]) / 1000.0
    blur_px = rig.headset.lens_to_panel_mm / (rig.panel.pixel_pitch_um / 1000.0) * refraction
    total = np.zeros((side, side))
    # Beyond three times the sampling rate sinc^2 leaves less than 1e-3.
    for down, right in np.ndindex(7, 7):
        fy, fx = np.meshgrid(
            np.fft.fftfreq(side) + down - 3, np.fft.fftfreq(side) + right - 3, indexing="ij"
        )
        radius = np.linalg.norm(np.stack([fx, fy], axis=-1) @ blur_px, axis=-1)
        z = np.pi * given.pupil_mm * np.maximum(radius, 1e-12)
        pixels = np.sinc(fx) ** 2 * np.sinc(fy) ** 2
        total += 2.0 * scipy.special.j1(z) / z * pixels
    return total


@pytest.mark.parametrize("eye", [0, 1])
def test_a_bare_panels_spread_is_the_blur(gpu: GpuRenderer, eye: int) -> None:
    """Two oblique ellipses of blur, which lean each its own way: their spectrum is the jinc."""

    def seen(target: Light, rig: Rig) -> Light:
        return gpu.perceive(target, rig, rays=16384)

    spread = point_spread(LEANING, seen)
    side = spread.mean.shape[-1]
    assert spread.mean.sum(axis=(-1, -2)) == pytest.approx(1.0, abs=1e-9)
    assert not np.any(spread.scatter > 1e-9)
    centred = np.fft.ifftshift(spread.mean[eye, 1])
    wanted = exact_spectrum(side, LEANING, eye)
    # What the window cuts off, and 16384 points for the integral over the pupil.
    assert np.fft.fft2(centred) == pytest.approx(wanted, abs=2e-3)
    # The other way about it would not be the same: the test sees which way the ellipse leans.
    assert np.abs(np.fft.fft2(centred[:, ::-1]) - wanted).max() > 0.1


@pytest.mark.parametrize("name", ["bgr-walls", "coma-lenslets", "round-holes-moved"])
def test_spots_keep_their_distance(name: str) -> None:
    """All within the small panel's viewports, and no light of one among another's."""
    spots = spots_of(pass_rigs.SMALL[name])
    side, reach = spots.rig.panel.height_px, spots.reach_px
    assert spots.rig.panel.width_px == 2 * side
    assert spots.places.min() >= reach
    assert spots.places.max() < side - reach
    for shot in spots.places:
        between = np.abs(shot[:, None] - shot).max(axis=-1)[~np.eye(len(shot), dtype=bool)]
        assert np.all(between > 2 * reach)


def test_spots_meet_a_cell_everywhere() -> None:
    """64 of them in a cell of 6 x 6 pixels: in every column and row of it, and most of both."""
    rig = pass_rigs.rig(44, 30, array=pass_rigs.LENSLETS | {"pitch_um": 468.0})
    at = spots_of(rig).places.reshape(-1, 2) % 6
    assert len(at) >= 64
    assert set(at[:, 0]) == set(at[:, 1]) == set(range(6))
    # Of 64 random places 36 (1 - e^(-64 / 36)) = 30 differ.
    assert len({tuple(place) for place in at}) >= 25


def test_spots_on_a_bare_panel_meet_every_place_of_a_layout() -> None:
    """One spot where all pixels are alike; the four kinds of a PenTile panel alike often."""
    assert len(spots_of(pass_rigs.rig(44, 30)).places.reshape(-1, 2)) == 1
    rig = pass_rigs.rig(44, 30, panel={"subpixels": "pentile-rgbg"})
    spots = spots_of(rig)
    at = spots.places.reshape(-1, 2) % 2
    counts = np.bincount(2 * at[:, 1] + at[:, 0], minlength=4)
    # Well-spread places: each kind within a third of its quarter.
    assert counts.min() > 0.66 * len(at) / 4


def test_walls_leave_the_spots_they_show() -> None:
    walls = pass_rigs.LENSLETS | {"barriers": "perpendicular"}
    rig = pass_rigs.rig(44, 30, array=walls, left={"pupil_mm": 3.0}, right={"pupil_mm": 3.0})
    spots = spots_of(rig)
    middle = spots.rig.panel.height_px / 2.0
    # Half the pupil and half an eyebox of 5.98 mm, seen from the panel: 4.49 mm.
    off_mm = np.abs(spots.places + 0.5 - middle).max() * pass_rigs.PITCH_UM / 1000.0
    assert 0.0 < off_mm <= 4.49 / (43.0 / 46.0) + 1e-9
    assert np.all(spots.places == spots.places.astype(int))


def test_an_eye_that_sees_nothing_is_shown_the_target() -> None:
    spots = spots_of(LEANING)
    side = 2 * spots.reach_px + 1
    spread = spread_of(spots, np.zeros((2, 2, 3, side, side), np.float32))
    assert not np.any(spread.scatter)
    taps = kernel_of(spread, 1e-6).taps
    middle = taps.shape[-1] // 2
    # All but the share of the noise.
    assert taps[..., middle, middle] == pytest.approx(1.0, abs=2e-6)
    assert np.abs(taps).sum(axis=(-1, -2)) == pytest.approx(1.0, abs=4e-6)


def test_scatter_is_what_spreads_differ_by() -> None:
    """Two spots, each wholly seen at another place: energy 1 each, 1/2 of it in the mean."""
    spots = spots_of(LEANING)
    side, middle = 2 * spots.reach_px + 1, spots.reach_px
    each = np.zeros((2, 2, 3, side, side), np.float32)
    each[0, ..., middle, middle] = each[1, ..., middle, middle + 1] = 3.0
    spread = spread_of(spots, each)
    assert spread.mean[0, 0, middle, middle : middle + 2] == pytest.approx(0.5)
    # From two samples, the mean's own error taken into account: twice 1/2.
    assert spread.scatter == pytest.approx(1.0)


# --- kernels ----------------------------------------------------------------------------------


def test_a_sharp_eye_needs_no_sharpening() -> None:
    taps = kernel_of(single((0, 0, 1.0)), 0.02).taps
    assert taps.shape == (2, 3, 5, 5)
    wanted = np.zeros((5, 5))
    wanted[2, 2] = 1.0
    # 1 / (1 + noise) of it is left where it is, the rest evens the noise out.
    assert taps[1, 2] == pytest.approx(wanted, abs=0.02)


@pytest.mark.parametrize("noise", [0.01, 0.05])
@pytest.mark.parametrize(
    "spread",
    [
        single((0, 0, 0.5), (1, 0, 0.25), (-1, 0, 0.25)),
        single((0, 0, 0.6), (1, 0, 0.25), (-1, 1, 0.15)),
    ],
    ids=["symmetric", "leaning"],
)
def test_kernels_are_wieners(spread: PointSpread, noise: float) -> None:
    """Their response is that of the filter without end, where pictures have their detail."""
    taps = kernel_of(spread, noise).taps[0, 0]
    assert taps.sum() == pytest.approx(1.0, abs=1e-12)

    def spectrum(kernel: Light) -> Light:
        padded = np.pad(kernel, (64 - len(kernel)) // 2 + np.array([[1, 0], [1, 0]]))
        return np.fft.fft2(np.fft.ifftshift(padded))

    h = spectrum(spread.mean[0, 0])
    wiener = np.conj(h) / (np.abs(h) ** 2 + noise)
    f = np.hypot(*np.meshgrid(np.fft.fftfreq(64), np.fft.fftfreq(64)))
    # A correlation's taps turn the convolution's kernel about.
    response = spectrum(taps[::-1, ::-1])
    # The mean is kept at 1, of which the filter without end would lose the noise's share.
    detail = (f > 0.05) & (f < 0.25)
    off = np.abs(response - wiener)[detail].max()
    print(f"{len(taps)} pixels: {off:.1e}")
    # 1 % of the expected error is what a small kernel may lose, 10 % of amplitude.
    assert off < 0.1
    if spread.mean[0, 0, 5, 3] > 0.0:
        assert np.abs(spectrum(taps) - wiener)[detail].max() > 0.3


def test_more_noise_sharpens_less() -> None:
    spread = single((0, 0, 0.4), (1, 0, 0.3), (-1, 0, 0.3))
    heights = [kernel_of(spread, n).taps[0, 0].max() for n in (0.001, 0.01, 0.1, 1.0)]
    assert heights == sorted(heights, reverse=True)


def test_scatter_counts_like_noise() -> None:
    spread = single((0, 0, 0.4), (1, 0, 0.3), (-1, 0, 0.3))
    scattered = PointSpread(spread.mean, np.full((2, 3), 0.05), spread.shift_px)
    assert kernel_of(scattered, 0.02).taps == pytest.approx(kernel_of(spread, 0.07).taps)


def test_sharpened_is_nearer_when_perceived(device: Device) -> None:
    """By scipy's convolution with each eye's blur; with the other eye's kernel it is farther."""
    spread = measured(device, LEANING)
    kernel = kernel_of(spread, 0.01)
    rng = np.random.default_rng(11)
    target = scipy.ndimage.gaussian_filter(rng.random((30, 44, 3)), (1.5, 1.5, 0))
    own = sharpen(target, LEANING, kernel.taps, kernel.shift_px)
    others = sharpen(target, LEANING, kernel.taps[::-1], kernel.shift_px)

    def error(shown: Light, eye: int) -> float:
        half = shown[:, eye * 22 : eye * 22 + 22, 1]
        seen = scipy.ndimage.convolve(half, spread.mean[eye, 1], mode="nearest")
        return float(np.sqrt(np.mean((seen - target[:, eye * 22 : eye * 22 + 22, 1]) ** 2)))

    for eye in (0, 1):
        errors = [error(shown, eye) for shown in (own, others, target)]
        print(errors)
        assert errors[0] < 0.8 * errors[2]
        assert errors[0] < 0.9 * errors[1]


# --- pieces -----------------------------------------------------------------------------------


def test_measuring_may_be_given_up(device: Device) -> None:
    before = device.live_objects
    forward_pass, perceive_pass = Forward(device), Perceive(device)
    rig = pass_rigs.SMALL["bgr-walls"]
    pieces = sharpen_pieces(device, rig, forward_pass, perceive_pass)
    next(pieces)
    assert device.live_objects != before
    pieces.close()
    forward_pass.release()
    perceive_pass.release()
    assert device.live_objects == before
