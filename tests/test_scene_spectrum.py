"""The spectrum's slope: on noise that was made with a known one."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from vrlf.scene import luminance, spectrum_slope
from vrlf.scene.spectrum import radial_amplitude


def noise_with_slope(slope: float, shape: tuple[int, int], seed: int) -> NDArray[np.float64]:
    """Gaussian noise whose amplitude is f to the power of ``slope``."""
    rng = np.random.default_rng(seed)
    spectrum = np.fft.rfft2(rng.standard_normal(shape))
    frequency = np.hypot(np.fft.fftfreq(shape[0])[:, None], np.fft.rfftfreq(shape[1])[None, :])
    frequency[0, 0] = 1.0
    spectrum *= frequency**slope
    spectrum[0, 0] = 0.0
    return np.fft.irfft2(spectrum, s=shape)


@pytest.mark.parametrize("slope", [-2.0, -1.3, -1.0, -0.7, 0.0])
@pytest.mark.parametrize("shape", [(256, 256), (301, 214)])
def test_a_known_slope_is_found(slope: float, shape: tuple[int, int]) -> None:
    # The lowest rings hold some ten waves, each of a Rayleigh spread of a half, so one
    # picture's slope spreads by about 0.05; the mean of twelve by 0.015.
    found = [spectrum_slope(noise_with_slope(slope, shape, seed)) for seed in range(12)]
    assert np.mean(found) == pytest.approx(slope, abs=0.045)
    assert np.std(found) < 0.1


def test_mean_and_gain_do_not_matter() -> None:
    noise = noise_with_slope(-1.0, (160, 120), seed=3)
    assert spectrum_slope(50.0 + 0.01 * noise) == pytest.approx(spectrum_slope(noise), abs=1e-6)


def test_a_wave_stands_at_its_frequency() -> None:
    """20 cycles along a picture of 200 columns are 0.1 cycles a pixel, whatever the height."""
    wave = np.sin(2.0 * np.pi * 20.0 * np.arange(200) / 200.0) * np.ones((150, 1))
    frequencies, amplitudes = radial_amplitude(wave)
    # Half a ring's width: 24 rings from 4/150 to 0.35.
    half = (0.35 * 150 / 4) ** (0.5 / 24)
    assert 0.1 / half <= frequencies[np.argmax(amplitudes)] <= 0.1 * half
    assert frequencies[0] > 4.0 / 150.0
    assert frequencies[-1] < 0.35


def test_luminance_weighs_the_colours() -> None:
    assert luminance([[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]]).tolist() == [
        [0.2126, 0.7152, 0.0722]
    ]
