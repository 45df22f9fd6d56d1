"""How far the eye may turn, and what the single-lens approximation costs, by hand."""

from __future__ import annotations

from dataclasses import replace
from math import asin, atan, degrees, pi, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pass_rigs import HOLES, LENSLETS, rig

from vrlf.model import Rig, load_rig
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.gaze import PUPIL_FROM_CENTRE_MM, pupil_move_mm, shared_mm2
from vrlf.optics.inspect import inspect_rig
from vrlf.optics.lattice import lattice_of
from vrlf.optics.relief import relief_cost
from vrlf.optics.viewport import viewport
from vrlf.reference.perceive import trace

# 1000 slices of a disc that a square cuts.
SLICED = 1e-5


# --- gaze -------------------------------------------------------------------------------------


def test_areas_by_hand() -> None:
    """A disc within, a quarter at the corner, half at an edge, the square within, none."""
    places = np.array([[0.0, 0.0], [5.0, 5.0], [5.0, 0.0], [0.0, -5.0], [9.0, 1.0]])
    disc = pi * 1.5**2
    wanted = [disc, disc / 4, disc / 2, disc / 2, 0.0]
    assert shared_mm2(places, 3.0, 10.0) == pytest.approx(wanted, abs=SLICED * disc)
    assert shared_mm2(np.zeros((1, 2)), 9.0, 2.0) == pytest.approx([4.0], rel=SLICED)
    # A square that reaches beyond a disc by four caps: radius 1, edges 0.8 away.
    cap = np.arccos(0.8) - 0.8 * sqrt(1 - 0.8**2)
    assert shared_mm2(np.zeros((1, 2)), 2.0, 1.6) == pytest.approx([pi - 4 * cap], rel=SLICED)


@settings(max_examples=60, deadline=None)
@given(pupil_mm=st.floats(1.0, 8.0), wider=st.floats(1.25, 4.0))
def test_a_pupil_within_the_eyebox_fails_at_its_edge(pupil_mm: float, wider: float) -> None:
    """Half of the disc is out where its centre is on the edge; along the diagonal later."""
    eyebox_mm = wider * pupil_mm
    assert pupil_move_mm(pupil_mm, eyebox_mm) == pytest.approx(eyebox_mm / 2.0, rel=2 * SLICED)


def test_a_pupil_much_wider_than_the_eyebox_fails_by_its_radius() -> None:
    """Half of a small square is out where the disc's edge, as good as straight, halves it."""
    assert pupil_move_mm(8.0, 0.08) == pytest.approx(4.0, rel=1e-2)
    assert pupil_move_mm(8.0, 0.08) > pupil_move_mm(7.0, 0.08)


@settings(max_examples=20, deadline=None)
@given(pupil_mm=st.floats(1.0, 8.0), eyebox_mm=st.floats(0.5, 12.0), turn=st.floats(0.0, 2 * pi))
def test_by_counted_rays(pupil_mm: float, eyebox_mm: float, turn: float) -> None:
    """At the found move at least half of what was shared is left, in any direction."""
    y, x = np.mgrid[-0.5:0.5:401j, -0.5:0.5:401j] * eyebox_mm

    def counted(centre: tuple[float, float]) -> int:
        return int(np.sum((x - centre[0]) ** 2 + (y - centre[1]) ** 2 <= pupil_mm**2 / 4))

    move = pupil_move_mm(pupil_mm, eyebox_mm)
    left = counted((move * np.cos(turn), move * np.sin(turn))) / counted((0.0, 0.0))
    assert left > 0.5 - 0.02
    along = counted((1.02 * move, 0.0)), counted((1.02 * move / sqrt(2), 1.02 * move / sqrt(2)))
    assert min(along) / counted((0.0, 0.0)) < 0.5 + 0.02


def test_the_default_rig() -> None:
    """Its eyebox is 0.635 * 46 / 3.6 mm, wider than the pupil of 6 mm."""
    found = inspect_rig(load_rig("matched-microlens"))["left"]["gaze_limit_deg"]
    edge_mm = 0.635 * 46.0 / 3.6 / 2.0
    assert found == pytest.approx(degrees(asin(edge_mm / PUPIL_FROM_CENTRE_MM)), rel=3 * SLICED)
    assert inspect_rig(load_rig("bare"))["left"]["gaze_limit_deg"] is None


def test_an_eye_that_cannot_turn_that_far() -> None:
    wide = {"pitch_um": 4000.0, "gap_mm": 5.0, "focal_mm": 4.0, "kind": "microlens"}
    assert inspect_rig(rig(40, 30, array=wide))["left"]["gaze_limit_deg"] is None


def test_light_of_a_turned_eye_is_what_the_tracer_finds() -> None:
    """Rays of a moved pupil: as many as said cross the lenslet that was meant for them.

    With the moved pupil's rays traced backward, the right lenslet is the one that the forward
    prefilter takes: the cell of the ray from the panel point to the old pupil's centre.
    """
    given_rig = rig(60, 60, array=LENSLETS | {"rotation_deg": 17.0}, left={"sphere_d": 0.0})
    bench, lattice = bench_of(given_rig), lattice_of(given_rig)
    view = viewport(given_rig, "left")
    assert lattice is not None
    eyebox_mm = 0.39 * 46.0 / 3.0
    random = np.random.default_rng(4)
    angle, moved_mm = np.radians(17.0), 4.0
    to_lattice = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    way = to_lattice.T @ np.array([moved_mm, 0.0])
    u = 2.5 * np.sqrt(random.random(40_000))[:, None] * _unit(random, 40_000) + way
    x_mm = (random.random((40_000, 2)) - 0.5) * 40.0
    landing = trace(bench, lattice, view, x_mm, u, np.zeros(2))
    chief = landing.panel_mm * bench.array_from_panel + np.array(view.axis_mm) - lattice.origin_mm
    right = np.all(np.floor(chief @ lattice.cell_from_panel.T + 0.5) == landing.cell, axis=-1)
    wanted = shared_mm2(np.array([[moved_mm, 0.0]]), 5.0, eyebox_mm)[0] / (pi * 2.5**2)
    # 40,000 rays: a share of 0.3 is good to 0.0023, four times that is never met by chance.
    assert 0.05 < wanted < 0.95
    assert right.mean() == pytest.approx(wanted, abs=0.01)


def _unit(random: np.random.Generator, count: int) -> np.ndarray[Any, Any]:
    angle = random.random(count) * 2.0 * pi
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


# --- eye relief -------------------------------------------------------------------------------


def cost(given_rig: Rig, **expected: float | None) -> None:
    found = relief_cost(given_rig, "left")
    assert found is not None
    for key, value in expected.items():
        assert getattr(found, key) == (value if value is None else pytest.approx(value)), key


def test_a_bare_panel_at_the_focus_costs_nothing_but_the_plane_of_focus() -> None:
    """m = e + d - e = d; 1 / (F - R / (1 + e R)) with R = -5 D and e = 15 mm is -5 / 0.925."""
    shift = 1000.0 / (1000.0 / 46.0 + 5.0 / 0.925) - 1000.0 / (1000.0 / 46.0 + 5.0)
    cost(
        rig(44, 31),
        error_d=0.0,
        magnification=1.0,
        shift_px=0.0,
        pupil_shift_mm=0.0,
        focus_shift_mm=shift,
        field_deg=None,
    )


def test_a_bare_panel_within_the_focus() -> None:
    """40 mm and 20 D: 1 - d F = 0.2, m = 40 + 12 * 0.2 = 42.4 where 40 was taken."""
    headset = {"lens_to_panel_mm": 40.0, "lens_power_d": 20.0, "eye_relief_mm": 12.0}
    given_rig = rig(44, 31, headset=headset)
    half_mm = np.array([22 * 0.078 / 2, 31 * 0.078 / 2])
    shift_mm = np.hypot(*half_mm) * (1.0 - 42.4 / 40.0)
    cost(
        given_rig,
        error_d=1000 * 0.2 * (1 / 42.4 - 1 / 40),
        magnification=40 / 42.4,
        shift_px=abs(shift_mm) / 0.078,
    )
    # Without relief the same lens is held against an eye 15 mm behind it.
    cost(rig(44, 31, headset=headset | {"eye_relief_mm": 0.0}), magnification=40 / 43.0)


@pytest.mark.parametrize("array", [LENSLETS, HOLES | {"gap_index": 1.49}])
def test_behind_an_array_by_traced_rays(array: dict[str, Any]) -> None:
    """The ray that the approximation sends to the pupil's centre, followed to the true pupil."""
    given_rig = rig(
        60,
        44,
        headset={"eye_relief_mm": 11.0, "lens_power_d": 19.0, "lens_height_mm": 0.6},
        array=array,
        left={"cylinder_d": -2.0, "axis_deg": 25.0, "pupil_offset_mm": [0.4, -0.7]},
    )
    # Unbent, as the ray to the pupil's centre is.
    true, optics = replace(bench_of(given_rig), bend=0.0), eye_optics(given_rig, "left")
    plain = replace(true, relief_mm=0.0)
    view = viewport(given_rig, "left")
    o = np.array([0.4, -0.7])
    worst_mm, worst_px = 0.0, 0.0
    for x in (-30 * 0.039, 30 * 0.039):
        for y in (-44 * 0.039 - 0.6, 44 * 0.039 - 0.6):
            # What the approximation sees there through the middle of its pupil.
            meant = np.linalg.solve(np.eye(2), np.array([x, y]) - o * plain.defocus_factor)
            landing = trace(plain, lattice_of(given_rig), view, meant, o, np.zeros(2))
            assert landing.panel_mm == pytest.approx(np.array([x, y]))
            slope = meant / plain.panel_per_slope_mm
            # The true eye sees the same ray from the lens's point o: u = o - e slope.
            u = o - 11.0 * slope
            same = trace(
                true, lattice_of(given_rig), view, slope * true.panel_per_slope_mm, u, np.zeros(2)
            )
            assert same.panel_mm == pytest.approx(np.array([x, y]))
            assert same.array_mm == pytest.approx(landing.array_mm)
            worst_mm = max(worst_mm, float(np.hypot(*(u - o))))
            seen_off = optics.matrix_d @ (u - o) / 1000.0 * true.panel_per_slope_mm / 0.078
            worst_px = max(worst_px, float(np.hypot(*seen_off)))
    cost(given_rig, pupil_shift_mm=worst_mm, shift_px=worst_px)
    cost(given_rig, field_deg=degrees(2 * atan(2.5 / 11.0)))


def test_an_eye_too_far_behind_a_strong_lens() -> None:
    """60 D and 40 mm: m = 15 + 40 - 36 is good, at 120 D there is no upright image."""
    headset = {"lens_to_panel_mm": 40.0, "lens_power_d": 60.0}
    assert relief_cost(rig(44, 31, headset=headset), "left") is not None
    strong = rig(44, 31, headset=headset | {"lens_power_d": 120.0})
    assert relief_cost(strong, "left") is None
    assert inspect_rig(strong)["headset"]["left"] is None


# --- the panel --------------------------------------------------------------------------------


def test_height_of_the_axis_and_the_field_that_barriers_leave() -> None:
    walls = LENSLETS | {"barriers": "perpendicular"}
    given_rig = rig(44, 30, headset={"lens_height_mm": -0.39, "eye_relief_mm": 6.0}, array=walls)
    found = inspect_rig(given_rig)
    assert found["display"]["axis_height_px"] == pytest.approx(-5.0)
    # |c (1 - e F)| <= a/2 + D A / 2g, A = 6 + 43 (1 - 6/46); seen from the pupil at c / A.
    reach = 6.0 + 43.0 * (1.0 - 6.0 / 46.0)
    half_mm = (2.5 + 0.39 * reach / 6.0) / (1.0 - 6.0 / 46.0)
    wanted = degrees(2.0 * atan(half_mm / reach))
    assert found["left"]["barrier_field_deg"] == pytest.approx(wanted)
    assert inspect_rig(rig(44, 30, array=LENSLETS))["left"]["barrier_field_deg"] is None
