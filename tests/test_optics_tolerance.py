"""The cases of a tolerance: evenly drawn, and each moved back to where the picture belongs."""

from __future__ import annotations

from typing import Any

import numpy as np
import optics_by_hand as by_hand
import pytest
from hypothesis import given
from hypothesis import strategies as st
from optics_by_hand import unhurried

from vrlf.errors import InputError
from vrlf.model import Rig, load_rig
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.tolerance import cases_of, moves_mm
from vrlf.optics.viewport import SIDES, Side

SPREAD = "tolerance={array_um=15, pupil_shift_mm=1, pupil_mm=[4, 6], focus_d=0.25, draws=40}"


def tolerant(*changes: str) -> Rig:
    return load_rig("two-eyes", overrides=[SPREAD, *changes])


def test_cases_fill_what_was_asked_for_evenly() -> None:
    rig = tolerant()
    cases = cases_of(rig)
    assert sum(case.weight for case in cases) == pytest.approx(1.0)
    off = np.array([case.rig.array.offset_um for case in cases]) - rig.array.offset_um
    assert np.abs(off).max() <= 15.0
    # 40 even draws: means within a few parts in a hundred of the range, nearly all of it reached.
    assert off.mean(axis=0) == pytest.approx([0.0, 0.0], abs=1.5)
    assert np.abs(off).max() > 13.0
    pupils = np.array([case.rig.left.pupil_mm for case in cases])
    assert 4.0 <= pupils.min() < 4.2 < 5.8 < pupils.max() <= 6.0
    for side in SIDES:
        before = np.array(getattr(rig, side).pupil_offset_mm)
        shift = np.array([getattr(case.rig, side).pupil_offset_mm for case in cases]) - before
        radius = np.hypot(*shift.T)
        assert radius.max() <= 1.0
        # Evenly over the disc: half of it lies beyond 0.71 of its radius.
        assert np.mean(radius > 0.5**0.5) == pytest.approx(0.5, abs=0.1)


def test_other_draws_are_others() -> None:
    rig = tolerant()
    first = {case.rig.array.offset_um for case in cases_of(rig)}
    assert not first & {case.rig.array.offset_um for case in cases_of(rig, first=1000)}
    assert [case.rig for case in cases_of(rig)] == [case.rig for case in cases_of(rig)]


def test_without_a_tolerance_the_rig_is_its_own_only_case() -> None:
    rig = load_rig("two-eyes")
    (case,) = cases_of(rig)
    assert case.rig is rig
    assert case.weight == 1.0


@pytest.mark.parametrize("accommodation", ["relaxed", "best"])
def test_focus_is_off_the_accommodated_eyes_by_what_was_asked(accommodation: str) -> None:
    rig = tolerant(f"left.accommodation={accommodation}", "left.sphere_d=2.0", "left.age_years=30")
    nominal = eye_optics(rig, "left").matrix_d
    steps = []
    for case in cases_of(rig):
        moved = eye_optics(case.rig, "left").matrix_d - nominal
        assert moved == pytest.approx(np.eye(2) * moved[0, 0], abs=1e-12)
        steps.append(moved[0, 0])
    assert -0.25 <= min(steps) < -0.23
    assert 0.23 < max(steps) <= 0.25


def test_places_are_served_with_their_weights() -> None:
    places = "[{weight=3.0}, {offset_mm=[1.0, -0.5], pupil_mm=4.0}]"
    rig = load_rig("two-eyes", overrides=[f"tolerance={{pupils={places}, draws=2}}"])
    first, second = cases_of(rig)
    assert (first.weight, second.weight) == (0.75, 0.25)
    assert first.rig.left.pupil_mm == rig.left.pupil_mm
    assert second.rig.right.pupil_mm == 4.0
    shift = np.array(second.rig.left.pupil_offset_mm) - rig.left.pupil_offset_mm
    assert shift == pytest.approx([1.0, -0.5])


EYES = {
    "left": {"sphere_d": -4.0, "cylinder_d": -1.5, "axis_deg": 30.0, "vertex_mm": 0.0},
    "right": {"sphere_d": 2.0, "cylinder_d": 0.75, "axis_deg": 100.0, "vertex_mm": 12.0},
}
ARRAY = {"kind": "microlens", "pitch_um": 400.0, "gap_mm": 3.5, "focal_mm": 2.4, "gap_index": 1.3}
_small = st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=2).map(np.array)


@unhurried
@given(_small, _small, _small, st.sampled_from(SIDES), st.floats(0.0, 20.0))
def test_what_is_off_moves_the_picture_as_the_inverse_map_does(
    x_mm: Any, array_mm: Any, pupil_mm: Any, side: Side, relief_mm: float
) -> None:
    rig = by_hand.rig(array=ARRAY, headset={"eye_relief_mm": relief_mm}, **EYES)
    centre = 0.9 * x_mm + 0.05

    def seen(c: Any, o: Any) -> Any:
        """The design's inverse: where a panel point through a lenslet's centre is perceived."""
        u, alpha = by_hand.inverse(rig, x_mm, c)
        eye = rig.left if side == "left" else rig.right
        return by_hand.slope_distance_mm(rig) * (alpha - by_hand.aberration(eye, u - o))

    moved = seen(centre + array_mm, pupil_mm) - seen(centre, np.zeros(2))
    found = moves_mm(bench_of(rig), eye_optics(rig, side).matrix_d, array_mm, pupil_mm)
    # All of it is linear: rounding of some millimetres.
    assert found == pytest.approx(moved, abs=1e-9)


def test_each_cases_prism_moves_its_picture_back() -> None:
    rig = tolerant()
    for case in cases_of(rig)[:5]:
        for side in SIDES:
            eye, before = getattr(case.rig, side), getattr(rig, side)
            array_mm = (np.array(case.rig.array.offset_um) - rig.array.offset_um) / 1000.0
            shift = np.array(eye.pupil_offset_mm) - before.pupil_offset_mm
            moved = moves_mm(bench_of(rig), eye_optics(rig, side).matrix_d, array_mm, shift)
            prism = (np.array(eye.prism_pd) - before.prism_pd) / 100.0
            assert bench_of(rig).panel_per_slope_mm * prism == pytest.approx(moved)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("tolerance.draws=1", "tolerance.draws: found 1, wanted a whole number from 2 to 64"),
        ("tolerance.pupil_mm=[6, 4]", "tolerance.pupil_mm: found [6, 4], wanted the smaller"),
        ("tolerance.array=15", 'tolerance.array: found an unknown key, wanted "array_um"'),
        ("tolerance={pupils=[]}", "tolerance.pupils: found 0 of them, wanted 1 to 64 places"),
        (
            "tolerance={pupils=[{weight=1}], pupil_shift_mm=1}",
            "tolerance.pupils: found them beside pupil_shift_mm or pupil_mm, wanted one of the",
        ),
        ("array.barriers=perpendicular", 'array.barriers: found "perpendicular", wanted barriers'),
    ],
)
def test_a_wrong_tolerance_is_one_line(change: str, said: str) -> None:
    start = [] if change.startswith("tolerance={") else [SPREAD]
    with pytest.raises(InputError) as error:
        load_rig("two-eyes", overrides=[*start, change])
    assert said in str(error.value)
    assert "\n" not in str(error.value)
