"""Metrics of how an eye sees: contrast by frequency, an edge's MTF, the smallest letters."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import fourier_gaussian, gaussian_filter
from scipy.special import erf

from vrlf.errors import InputError
from vrlf.evaluation.measure import border_px
from vrlf.evaluation.metrics.contrast import contrast_kept
from vrlf.evaluation.metrics.edge import edge_mtf, slanted_edge
from vrlf.evaluation.metrics.letters import NOISE_DEG2, share_read, smallest_line
from vrlf.model import load_rig
from vrlf.optics.viewport import viewport
from vrlf.renderer import GpuRenderer, bare_rig
from vrlf.studies.quality import cropped

Float = NDArray[np.float64]


def blurred(picture: NDArray[np.floating], sigma_px: float) -> Float:
    """By a true Gaussian, in the frequencies; it wraps around."""
    planes = [np.fft.fft2(picture[..., c].astype(np.float64)) for c in range(3)]
    return np.stack([np.fft.ifft2(fourier_gaussian(each, sigma_px)).real for each in planes], -1)


def gaussian_mtf(cycles_per_px: Float, sigma_px: float) -> Float:
    return np.asarray(np.exp(-2.0 * (np.pi * sigma_px * cycles_per_px) ** 2))


# Contrast at each spatial frequency.


def noise(height: int, width: int) -> Float:
    return 0.5 + 0.1 * np.random.default_rng(4).standard_normal((height, width, 3))


def test_a_blur_keeps_its_mtf_of_contrast() -> None:
    picture = noise(150, 200)
    found = contrast_kept(picture, 0.4 * blurred(picture, 1.2), 10.0)
    assert found is not None
    wanted = gaussian_mtf(found.cycles_per_degree / 10.0, 1.2)
    # A ring is a seventh of an octave wide or so, and its few waves have amplitudes of chance.
    assert found.kept == pytest.approx(wanted, abs=0.05)
    assert found.cycles_per_degree[0] == pytest.approx(10 * 4 / 150, rel=0.15)


def test_a_shift_keeps_all_contrast() -> None:
    picture = np.tile(noise(64, 64), (1, 2, 1))
    found = contrast_kept(picture[:, :64], picture[:, 9:73], 10.0)
    assert found is not None
    assert found.kept == pytest.approx(1.0, abs=0.25)  # the window cuts out other waves
    assert float(np.mean(found.kept)) == pytest.approx(1.0, abs=0.03)


def test_no_contrast_to_compare() -> None:
    even = np.full((40, 40, 3), 0.5)
    assert contrast_kept(even, even, 10.0) is None
    assert contrast_kept(noise(40, 40), 0.0 * even, 10.0) is None
    assert contrast_kept(noise(11, 40), noise(11, 40), 10.0) is None


# The edge.


def soft_edge(width: int, height: int, slant_deg: float, sigma_px: float) -> Float:
    """Point samples of an edge blurred by a Gaussian, by the error function."""
    angle = np.radians(slant_deg)
    x = np.arange(width) + 0.5 - width / 2.0
    up = height / 2.0 - np.arange(height) - 0.5
    away = x[None, :] * np.cos(angle) - up[:, None] * np.sin(angle)
    light = 0.5 + 0.3 * erf(away / (sigma_px * np.sqrt(2.0)))
    return np.repeat(light[..., None], 3, axis=2)


@pytest.mark.parametrize("sigma_px", [0.7, 1.5, 2.5])
@pytest.mark.parametrize("slant_deg", [5.0, -7.3, 14.0])
def test_a_known_blur_is_recovered(slant_deg: float, sigma_px: float) -> None:
    found = edge_mtf(soft_edge(160, 110, slant_deg, sigma_px), 12.0)
    cycles = found.cycles_per_degree / 12.0
    wanted = gaussian_mtf(cycles, sigma_px)
    # The Hamming window makes a wide line narrower: 0.002 at these widths. Beyond the raster's
    # limit, where bins fill unevenly, there is nothing to compare.
    below = cycles <= 0.5
    assert found.mtf[below] == pytest.approx(wanted[below], abs=0.004)
    assert found.slant_deg == pytest.approx(slant_deg, abs=0.05)


def test_a_drawn_edge_has_the_pixels_own_mtf() -> None:
    """A square pixel's area: sinc along both of its sides, at the edge's angle."""
    found = edge_mtf(slanted_edge(80, 100), 10.0)
    cycles = found.cycles_per_degree / 10.0
    angle = np.radians(5.0)
    wanted = np.sinc(cycles * np.cos(angle)) * np.sinc(cycles * np.sin(angle))
    # Half a hundredth up to the raster's limit; beyond it only the oversampling knows.
    below = cycles <= 0.5
    assert found.mtf[below] == pytest.approx(wanted[below], abs=0.005)


def test_an_edge_the_other_way_round_is_the_same() -> None:
    edge = soft_edge(60, 70, 5.0, 1.0)
    assert edge_mtf(edge[:, ::-1], 9.0).mtf == pytest.approx(edge_mtf(edge, 9.0).mtf, abs=1e-9)
    assert edge_mtf(edge[:, ::-1], 9.0).slant_deg == pytest.approx(-5.0, abs=0.05)


@pytest.mark.parametrize(
    ("picture", "said"),
    [
        (np.full((40, 40, 3), 0.5), "found none"),
        (slanted_edge(40, 40, slant_deg=0.0), "0.00 degrees off"),
        (slanted_edge(12, 40), "12x40 pixels"),
        (np.zeros((40, 40, 3)), "found none"),
    ],
)
def test_no_edge_to_measure(picture: Float, said: str) -> None:
    with pytest.raises(InputError, match=said):
        edge_mtf(picture, 10.0)


# Letters.


def see_sharp(page: NDArray[np.float32]) -> NDArray[np.float32]:
    return page


def acuity(see: object, ppd: float, side: int = 130, **more: float) -> float | None:
    return smallest_line(
        see,  # type: ignore[arg-type]
        width_px=side,
        height_px=side,
        pixels_per_degree=ppd,
        **more,  # type: ignore[arg-type]
    ).logmar


def test_sharp_letters_on_a_fine_raster_are_read_to_one() -> None:
    """What the noise was chosen for."""
    for ppd in (120.0, 240.0):
        found = smallest_line(see_sharp, width_px=260, height_px=200, pixels_per_degree=ppd)
        assert found.logmar == pytest.approx(0.0)
        assert found.decimal_acuity == pytest.approx(1.0)
        assert found.lines[-1].share < 0.6


def test_a_headsets_raster_limits_acuity_by_itself() -> None:
    """At 10.3 pixels per degree a stroke of a pixel is 5.8 minutes: logMAR 0.77; letters of
    less than three pixels, 0.54 below, hold too little to tell ten apart."""
    found = acuity(see_sharp, 10.3)
    assert found is not None
    assert 0.4 <= found <= 0.8


def test_twice_the_blur_and_the_raster_is_twice_the_letter() -> None:
    """Letters, blur and pixels scale together; 0.3 logMAR is a factor of two."""
    few = acuity(lambda p: gaussian_filter(p, (3, 3, 0)), 10.0, noise_deg2=NOISE_DEG2)
    many = acuity(lambda p: gaussian_filter(p, (3, 3, 0)), 20.0, noise_deg2=NOISE_DEG2 / 4)
    assert few is not None
    assert many == pytest.approx(few - 0.3)


def test_more_blur_needs_larger_letters() -> None:
    found = [acuity(lambda p, s=s: gaussian_filter(p, (s, s, 0)), 20.0) for s in (0, 1, 2, 4)]
    assert None not in found
    assert found == sorted(set(found))  # type: ignore[type-var]


def test_neither_gain_nor_a_pixels_shift_counts_but_lost_contrast_does() -> None:
    def hazy(page: NDArray[np.float32]) -> NDArray[np.float32]:
        return 0.1 * page + 0.9

    plain = acuity(see_sharp, 20.0)
    assert acuity(lambda p: 0.05 * p, 20.0) == plain
    assert acuity(lambda p: np.roll(p, (1, -2), (0, 1)), 20.0) == plain
    assert acuity(hazy, 20.0) > plain  # type: ignore[operator]


def test_an_eye_that_sees_nothing_reads_nothing() -> None:
    found = smallest_line(
        lambda p: np.zeros_like(p), width_px=90, height_px=60, pixels_per_degree=10.0
    )
    assert (found.logmar, found.decimal_acuity) == (None, None)
    assert found.lines[0].share == pytest.approx(0.1)


def test_chance_is_one_in_ten_and_certainty_one() -> None:
    letters = np.random.default_rng(2).random((10, 6, 6))
    assert share_read(letters, letters, 1e-6) == 1.0
    # 40,960 draws leave 0.0015.
    assert share_read(letters, letters, 1e3) == pytest.approx(0.1, abs=0.01)
    # The next letter's look is taken for the next letter.
    assert share_read(letters, np.roll(letters, 1, axis=0), 1e-6) == 0.0


def test_two_letters_are_told_apart_as_the_normal_distribution_says() -> None:
    """Templates at right angles: right where their scores' difference, 1, outdoes sqrt(2) s."""
    letters = np.zeros((2, 2, 2))
    letters[0, 0] = (1, -1)
    letters[1, 1] = (1, -1)
    wanted = 0.5 * (1.0 + erf(np.sqrt(2.0) / (np.sqrt(2.0) * 1.3) / np.sqrt(2.0)))
    assert share_read(letters, letters, 1.3) == pytest.approx(wanted, abs=0.015)


def test_no_room_for_letters() -> None:
    with pytest.raises(InputError, match="letters: found room for 0 pixels"):
        acuity(see_sharp, 10.0, side=20, border_px=15)


# An eye.


def test_a_corrected_eye_reads_smaller_letters_and_keeps_more_of_an_edge() -> None:
    """-5 D, 46 mm, 6 mm pupil: a blur of 18 pixels, all but undone by the matched array."""
    rig = cropped(load_rig("matched-full"), (240, 120))
    view, ppd = viewport(rig, "left"), 10.3
    border = border_px(rig, "left")

    def sees(method: str) -> tuple[float | None, float]:
        worn = rig if method == "forward" else bare_rig(rig)

        def see(page: NDArray[np.floating]) -> NDArray[np.float32]:
            target = np.zeros((120, 240, 3), np.float32)
            target[:, view.columns] = page
            panel = renderer.prefilter(target, rig) if method == "forward" else target
            return np.asarray(renderer.perceive(panel, worn, rays=16)[:, view.columns])

        letters = smallest_line(
            see, width_px=120, height_px=120, pixels_per_degree=ppd, border_px=border
        )
        edge = edge_mtf(see(slanted_edge(120, 120))[border:-border, border:-border], ppd)
        return letters.logmar, float(np.interp(1.0, edge.cycles_per_degree, edge.mtf))

    with GpuRenderer() as renderer:
        (corrected, sharp), (without, dull) = sees("forward"), sees("none")
    assert corrected is not None
    assert without is None or without >= corrected + 0.3
    # A disc of 18 pixels has 2 J1(x) / x = 0.1 there, x = pi 18 / 10.3.
    assert sharp > 0.6 > 0.2 > dull
