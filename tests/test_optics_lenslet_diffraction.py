"""Wavefront and MTF against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vrlf.errors import InputError
from vrlf.optics.lenslet.diffraction import cutoff_per_mm, transfer, wavefront
from vrlf.optics.lenslet.paraxial import cardinal
from vrlf.optics.lenslet.spots import spot
from vrlf.optics.lenslet.surfaces import Medium, plano_convex
from vrlf.optics.lenslet.trace import Beam

NM = 550.0
# Stigmatic, f 8, so that all that is left is diffraction; 0.4 mm wide, F / 20.
PERFECT = plano_convex(4.0, 0.3, Medium(index=1.5), 0.4, facing="panel", conic=-(1.5**2))
F_MM = 8.0


def test_the_diffraction_limit_of_a_square() -> None:
    """1 - nu lambda N, the same along both axes (Goodman 2005, 6.4.2)."""
    front = wavefront(PERFECT, Beam(NM), F_MM)
    assert front.rms_mm < 1e-12
    found = transfer(front, NM)
    # Sines for tangents: (0.2 / 8)^2 / 6.
    limit = 0.4 / F_MM / (NM * 1e-6)
    assert cutoff_per_mm(front, NM) == pytest.approx([limit, limit], rel=1e-3)
    assert found.contrast == pytest.approx(
        np.maximum(0.0, 1.0 - found.per_mm / cutoff_per_mm(front, NM)[:, None]), abs=1e-12
    )
    assert found.at(np.array([0.0, 2.0 * limit])) == pytest.approx(np.array([[1.0, 0.0]] * 2))


def test_the_diffraction_limit_of_a_disc() -> None:
    """2 / pi (acos x - x sqrt(1 - x^2))."""
    front = wavefront(replace(PERFECT, square=False), Beam(NM), F_MM)
    found = transfer(front, NM)
    x = found.per_mm / cutoff_per_mm(front, NM)[:, None]
    wanted = 2.0 / np.pi * (np.arccos(np.minimum(x, 1.0)) - x * np.sqrt(np.maximum(0, 1 - x**2)))
    # A disc of 64 squares across.
    assert found.contrast == pytest.approx(wanted, abs=5e-3)


@pytest.mark.parametrize("defocus_mm", [0.2, -0.5, 1.2])
def test_defocus_of_a_square(defocus_mm: float) -> None:
    """(1 - x) sinc(8 (W / lambda) x (1 - x)), W at the middle of an edge (Goodman 2005, 6-42)."""
    front = wavefront(PERFECT, Beam(NM), F_MM + defocus_mm)
    found = transfer(front, NM)
    x = found.per_mm[0] / cutoff_per_mm(front, NM)[0]
    waves = defocus_mm * (0.2 / F_MM) ** 2 / 2.0 / (NM * 1e-6)
    wanted = np.abs((1.0 - x) * np.sinc(8.0 * waves * x * (1.0 - x)))
    # 64 samples for the integral, and cosines to a part in a thousand.
    assert found.contrast[0] == pytest.approx(wanted, abs=5e-3)
    assert found.contrast[1] == pytest.approx(found.contrast[0], abs=1e-9)


def test_wavefront_and_spot_tell_the_same() -> None:
    """Transverse error = the slope of W over the direction cosine; oblique, defocused."""
    lens = plano_convex(2.0, 0.5, Medium("polycarbonate"), 0.3)
    beam = Beam(NM, (0.05, -0.11), 30.0)
    distance_mm = cardinal(lens, NM).image_mm(30.0) + 0.5
    front = wavefront(lens, beam, distance_mm)
    found = spot(lens, beam, distance_mm, side=64)
    slope = np.diff(front.path_mm, axis=1) / front.step[0]
    errors = found.errors_mm[:, 0].reshape(64, 64)
    middle = (errors[:, 1:] + errors[:, :-1]) / 2.0
    # Rays from the right go to the left. Cosines do not go quite evenly: F / 11, oblique.
    assert slope == pytest.approx(middle, abs=0.05 * np.abs(errors).max())


def test_perfect_is_the_limit_of_an_aberrated_lens() -> None:
    lens = plano_convex(0.6, 0.4, Medium("pmma"), 0.4)
    front = wavefront(lens, Beam(NM), cardinal(lens, NM).back_focus_mm)
    real, best = transfer(front, NM), transfer(front, NM, perfect=True)
    assert np.all(real.contrast <= best.contrast + 1e-12)
    assert real.contrast[0, 16] < 0.8 * best.contrast[0, 16]


def test_a_spacer_raises_the_cutoff() -> None:
    """In a medium of n the same cone is n times finer: cosines times index."""
    for n in (1.0, 1.3):
        lens = plano_convex(4.0, 0.3, Medium(index=1.5), 0.4, behind=Medium(index=n))
        found = cardinal(lens, NM)
        front = wavefront(lens, Beam(NM), n * found.back_focus_mm)
        assert cutoff_per_mm(front, NM)[0] == pytest.approx(
            0.4 / found.focal_mm / (NM * 1e-6), rel=2e-3
        )


def test_no_rays_no_wavefront() -> None:
    with pytest.raises(InputError, match="found its rays blocked"):
        wavefront(PERFECT, Beam(NM, (0.0, 60.0)), F_MM)
