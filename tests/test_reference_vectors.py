"""The twins against small rigs with results from two other implementations of the design."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from vrlf.model import Rig, load_rig
from vrlf.reference.forward import forward
from vrlf.reference.perceive import perceive

DATA = Path(__file__).parent / "data"

# Rays a pixel, and the RMS error that the twin had with them, measured against `perceived`.
# Each fell with the number of rays all the way to 1024 or more, toward `noise_rms`: it is the
# sampling's alone. Holes cost 1 / throughput more. Stripes behind lenslets near focus are the
# hardest to sample: single sub-pixels, with black between.
SAMPLING_RMS = {
    "bare-sphere": (128, 0.00388),
    "bare-stripe-astigmatic-relief": (128, 0.00262),
    "bare-wavefront": (128, 0.00061),
    "holes-round-prism": (64, 0.00321),
    "holes-square-perpendicular": (64, 0.00195),
    "lenslets-stripe-acrylic-converging": (128, 0.03862),
    "lenslets-turned": (128, 0.00791),
}
NAMES = sorted(SAMPLING_RMS)


@dataclass(frozen=True)
class Known:
    rig: Rig
    panel: NDArray[np.float64]
    perceived: NDArray[np.float64]
    forward: NDArray[np.float64]
    noise_rms: float


def known(name: str) -> Known:
    with np.load(DATA / f"{name}.npz") as stored:
        return Known(
            load_rig(DATA / f"{name}.toml"),
            stored["panel"].astype(np.float64),
            stored["perceived"].astype(np.float64),
            stored["forward"].astype(np.float64),
            float(stored["noise_rms"]),
        )


def test_every_stored_rig_is_tested() -> None:
    assert sorted(path.stem for path in DATA.glob("*.npz")) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_forward(name: str) -> None:
    case = known(name)
    # Stored as float32: half a unit in its last place below 1 is 3e-8.
    assert np.abs(forward(case.panel, case.rig) - case.forward).max() < 1e-6


@pytest.mark.parametrize("name", NAMES)
def test_perceive(name: str) -> None:
    case = known(name)
    rays, sampling_rms = SAMPLING_RMS[name]
    off = perceive(case.panel, case.rig, rays) - case.perceived
    # Nearly a third more than was measured, for other processors' rounding at cells' borders.
    assert np.sqrt(np.mean(off**2)) < 1.3 * sampling_rms + case.noise_rms
    # Sampling errors go both ways: light that is lost or made everywhere shows in the mean.
    assert abs(off.mean()) < 0.1 * sampling_rms + case.noise_rms
