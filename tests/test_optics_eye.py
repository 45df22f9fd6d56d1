"""Accommodation, colour, prism: what an eye adds to its prescription."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from optics_by_hand import (
    aberration,
    points_mm,
    rig,
    rigs,
    sides,
    unhurried,
)

from vrlf.model import Rig
from vrlf.optics.eye import (
    aberration_at,
    amplitude_of_accommodation_d,
    chromatic_difference_d,
    eye_optics,
)
from vrlf.optics.viewport import Side


def best(eye: dict[str, Any], **headset: float) -> float:
    rigged = rig(headset=headset, left={"accommodation": "best", "vertex_mm": 0.0} | eye)
    return eye_optics(rigged, "left").accommodation_d


@pytest.mark.parametrize(
    ("age_years", "amplitude_d"),
    [(None, 9.5), (30.0, 9.5), (0.0, 18.5), (45.0, 5.0), (61.0, 0.2), (62.0, 0.0), (90.0, 0.0)],
)
def test_hofstetter(age_years: float | None, amplitude_d: float) -> None:
    assert amplitude_of_accommodation_d(age_years) == pytest.approx(amplitude_d, abs=1e-12)


def test_relaxed_eyes_add_nothing() -> None:
    optics = eye_optics(rig(left={"sphere_d": 3.0, "accommodation": "relaxed"}), "left")
    assert optics.accommodation_d == 0.0


def test_hyperope_accommodates_to_the_bare_panel() -> None:
    """+2.5 D behind a panel at the lens's focus: 2.5 D of accommodation, no error left."""
    optics = eye_optics(
        rig(left={"sphere_d": 2.5, "vertex_mm": 0.0, "accommodation": "best"}), "left"
    )
    assert optics.accommodation_d == pytest.approx(2.5, abs=1e-12)
    assert optics.matrix_d == pytest.approx(np.zeros((2, 2)), abs=1e-12)


def test_accommodation_cannot_help_a_myope() -> None:
    assert best({"sphere_d": -5.0}) == 0.0


def test_accommodation_serves_the_mean_of_an_astigmatic_eye() -> None:
    # M = 3 - 1 = 2.
    assert best({"sphere_d": 3.0, "cylinder_d": -2.0, "axis_deg": 20.0}) == pytest.approx(2.0)


def test_age_limits_accommodation() -> None:
    # 18.5 - 0.3 * 55 = 2 D of the 6 D that are wanted.
    assert best({"sphere_d": 6.0, "age_years": 55.0}) == pytest.approx(2.0, abs=1e-12)
    assert best({"sphere_d": 6.0, "age_years": 70.0}) == 0.0


def test_panel_vergence_is_in_it() -> None:
    """Without a lens a panel at 400 mm asks 2.5 D of an emmetrope, 1 D of a -1.5 D myope."""
    bare = {"lens_to_panel_mm": 400.0, "lens_power_d": 0.0}
    assert best({}, **bare) == pytest.approx(2.5, abs=1e-12)
    assert best({"sphere_d": -1.5}, **bare) == pytest.approx(1.0, abs=1e-12)
    # 20 mm of relief: the panel is 420 mm from the pupil.
    assert best({}, **bare, eye_relief_mm=20.0) == pytest.approx(1000.0 / 420.0, abs=1e-12)


def test_lens_and_relief_in_the_vergence() -> None:
    """d = 40, F = 20 D, e = 15: the panel's image lies 1/(1/40 - 1/50) = 200 mm off the lens.

    That is 215 mm from the pupil: 4.651 D.
    """
    headset = {"lens_to_panel_mm": 40.0, "lens_power_d": 20.0, "eye_relief_mm": 15.0}
    assert best({}, **headset) == pytest.approx(1000.0 / 215.0, abs=1e-10)


def test_wavefront_defocus_is_in_it_once() -> None:
    """c20 = -0.5 um over 6 mm: M = 4 sqrt(3) 0.5 / 9 = 0.3849 D; c40 has no say."""
    wavefront = {"diameter_mm": 6.0, "coefficients_um": {"2,0": -0.5, "4,0": 0.4}}
    assert best({"sphere_d": 1.0, "zernike": wavefront}) == pytest.approx(
        1.0 + 2.0 * 3.0**0.5 / 9.0, abs=1e-12
    )


def test_chromatic_difference() -> None:
    """D = 1.7312 - 0.63346 / (lambda - 0.21410), by hand: less 0.04152 D at 589 nm."""
    assert chromatic_difference_d(589.0) == 0.0
    assert chromatic_difference_d(610.0) == pytest.approx(0.08963, abs=2e-5)
    assert chromatic_difference_d(545.0) == pytest.approx(-0.22468, abs=2e-5)
    assert chromatic_difference_d(465.0) == pytest.approx(-0.83507, abs=2e-5)


def test_chromatic_eye_errs_more_in_blue() -> None:
    eye = {"sphere_d": -1.0, "vertex_mm": 0.0, "chromatic": True}
    optics = eye_optics(rig(left=eye), "left")
    assert optics.is_chromatic
    u = np.array([2.0, 0.0])
    seen_d = [aberration_at(colour, u)[0] / 2.0 * 1000.0 for colour in optics.aberration]
    # Red, green, blue; the tolerance is that of the rounded hand-made numbers.
    assert seen_d == pytest.approx([-0.91037, -1.22468, -1.83507], abs=2e-5)
    # The matrix is that at 589 nm.
    assert optics.matrix_d == pytest.approx(-np.eye(2), abs=1e-12)


def test_colours_accommodate_together() -> None:
    eye = {"sphere_d": 2.0, "vertex_mm": 0.0, "chromatic": True, "accommodation": "best"}
    optics = eye_optics(rig(left=eye), "left")
    assert optics.accommodation_d == pytest.approx(2.0, abs=1e-12)
    blue = aberration_at(optics.aberration[2], np.array([0.0, 1.0]))
    assert blue == pytest.approx([0.0, -0.83507e-3], abs=2e-8)


def test_plain_eye_takes_one_path_for_all_colours() -> None:
    assert not eye_optics(rig(left={"sphere_d": -4.0}), "left").is_chromatic


def test_prism_is_a_slope_of_p_per_cent() -> None:
    optics = eye_optics(rig(right={"prism_pd": [1.5, -0.5]}), "right")
    assert aberration_at(optics.aberration[1], np.array([1.0, 2.0])) == pytest.approx(
        [0.015, -0.005], abs=1e-15
    )


def test_each_side_has_its_own_eye() -> None:
    both = rig(left={"pupil_mm": 3.0}, right={"pupil_mm": 5.0, "pupil_offset_mm": [0.4, -0.2]})
    assert eye_optics(both, "left").pupil_mm == 3.0
    assert eye_optics(both, "right").pupil_mm == 5.0
    assert eye_optics(both, "right").pupil_offset_mm == (0.4, -0.2)


@unhurried
@given(rigs(), sides, points_mm(3.0))
def test_aberration_by_hand(given_rig: Rig, side: Side, u: np.ndarray) -> None:
    optics = eye_optics(given_rig, side)
    eye = given_rig.left if side == "left" else given_rig.right
    # The hand-made gradient is a central difference, good to 1e-9 of a slope.
    assert aberration_at(optics.aberration[0], u) == pytest.approx(aberration(eye, u), abs=1e-8)


@unhurried
@given(st.floats(0.0, 5.0), st.floats(0.0, 5.0))
def test_best_leaves_the_least_mean_error(sphere_d: float, cylinder_d: float) -> None:
    """Within the amplitude nothing is left; beyond it what the amplitude lacks."""
    age = 50.0  # 3.5 D
    eye = {
        "sphere_d": sphere_d,
        "cylinder_d": cylinder_d,
        "axis_deg": 33.0,
        "vertex_mm": 0.0,
        "accommodation": "best",
        "age_years": age,
    }
    left_d = np.trace(eye_optics(rig(left=eye), "left").matrix_d) / 2.0
    assert left_d == pytest.approx(max(0.0, sphere_d + cylinder_d / 2.0 - 3.5), abs=1e-12)
