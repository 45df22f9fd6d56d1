"""Keys and what they make of a session: no window in it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pass_rigs
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vrlf.app.preview.keys import (
    ALIGNMENT,
    EVERY_GROUP,
    GROUPS,
    Key,
    Press,
    help_lines,
    markdown,
    press_of,
)
from vrlf.app.preview.session import (
    ARRAYS,
    COMPARISONS,
    METHODS,
    SESSION_ACTIONS,
    VIEWS,
    WINDOW_ACTIONS,
    Session,
    act,
    changed,
    looked,
    strolled,
    typed,
)
from vrlf.app.preview.steps import STEPS, altered, prescribed, written
from vrlf.model import Rig, load_rig

RIG = load_rig("two-eyes")
BARE = pass_rigs.rig(24, 16)


def fresh(rig: Rig = RIG) -> Session:
    return Session(rig=rig, loaded=rig)


def pressed(session: Session, *chords: str) -> Session:
    """The session after some keys."""
    for chord in chords:
        press = press_of(chord, aligning=session.is_aligning is not None)
        assert press is not None, chord
        session = act(session, press)
    return session


def test_every_key_does_something_and_no_chord_does_two_things() -> None:
    for groups in (GROUPS, (ALIGNMENT,)):
        chords = [
            chord
            for group in groups
            for key in group.keys
            for chord in (key.chord, *([f"shift+{key.chord}"] if key.finer else []))
        ]
        assert len(chords) == len(set(chords))
    actions = {key.action for group in EVERY_GROUP for key in group.keys}
    assert actions == SESSION_ACTIONS | WINDOW_ACTIONS
    assert not SESSION_ACTIONS & WINDOW_ACTIONS


def test_a_line_of_help_names_both_keys_of_a_pair() -> None:
    lines = [line for group in EVERY_GROUP for line in help_lines(group)]
    assert ("Down Up", "sphere by 0.25 D (0.05 D)") in lines
    assert ("Ctrl+Y Ctrl+Shift+Z", "redo") in lines
    named = " ".join(chord for chord, _ in lines).split()
    assert len(named) == sum(len(group.keys) for group in EVERY_GROUP)


def test_eight_steps_of_the_left_sphere_leave_the_right_eye_alone() -> None:
    after = pressed(fresh(), "1", *["down"] * 8)
    assert after.rig.left.sphere_d == RIG.left.sphere_d - 2.0
    assert after.rig.right == RIG.right
    assert after.rig.left == RIG.left.model_copy(update={"sphere_d": RIG.left.sphere_d - 2.0})


@pytest.mark.parametrize(
    ("chord", "key", "coarse", "fine"),
    [
        ("up", "sphere_d", 0.25, 0.05),
        ("right", "cylinder_d", 0.25, 0.05),
        ("]", "axis_deg", 5.0, 1.0),
        (".", "pupil_mm", 0.5, 0.1),
    ],
)
def test_the_clinics_steps(chord: str, key: str, coarse: float, fine: float) -> None:
    for side, number in (("left", "1"), ("right", "2")):
        before = getattr(getattr(RIG, side), key)
        for keys, step in ((chord, coarse), (f"shift+{chord}", fine)):
            after = pressed(fresh(), number, keys)
            assert getattr(getattr(after.rig, side), key) == pytest.approx(before + step, abs=1e-12)


def test_prism_moves_right_and_up() -> None:
    after = pressed(fresh(), "2", "l", "l", "i", "shift+k")
    x, y = RIG.right.prism_pd
    assert after.rig.right.prism_pd == pytest.approx((x + 1.0, y + 0.4))
    assert after.rig.left == RIG.left


def test_the_axis_goes_round() -> None:
    start = fresh(altered(RIG, {"left": {"axis_deg": 178.0}, "right": {"axis_deg": 2.0}}))
    assert pressed(start, "1", "]").rig.left.axis_deg == 3.0
    assert pressed(start, "2", "[").rig.right.axis_deg == 177.0


def test_limits_are_where_steps_end() -> None:
    assert pressed(fresh(), "3", *["down"] * 400).rig.left.sphere_d == -40.0
    assert pressed(fresh(), "3", *[","] * 40).rig.right.pupil_mm == 0.5


def test_a_step_that_makes_no_rig_says_so_and_changes_nothing() -> None:
    """A plus lens whose focus would lie inside the eye at its vertex distance."""
    rig = altered(RIG, {"left": {"sphere_d": 9.75, "cylinder_d": 0.0, "vertex_mm": 100.0}})
    after = pressed(fresh(rig), "1", "up")
    assert after.rig == rig
    assert "vertex_mm" in after.message
    assert "\n" not in after.message
    assert not after.past


def test_undo_and_redo() -> None:
    after = pressed(fresh(), "1", "down", "down", "ctrl+z")
    assert after.rig.left.sphere_d == RIG.left.sphere_d - 0.25
    assert pressed(after, "ctrl+y").rig.left.sphere_d == RIG.left.sphere_d - 0.5
    assert pressed(after, "ctrl+shift+z") == pressed(after, "ctrl+y")
    assert pressed(after, "up", "ctrl+y").message == "nothing to redo"
    assert pressed(fresh(), "ctrl+z").message == "nothing to undo"


def test_a_dragged_slider_is_one_step_for_undo() -> None:
    session = fresh()
    for sphere_d in (-4.1, -4.2, -4.3):
        rig = altered(session.rig, {"left": {"sphere_d": sphere_d}})
        session = changed(session, rig, holding="left sphere")
    assert pressed(session, "ctrl+z").rig == RIG
    other = changed(session, altered(session.rig, {"left": {"pupil_mm": 3.0}}), holding="pupil")
    assert pressed(other, "ctrl+z").rig == session.rig


def test_copy_and_reset() -> None:
    after = pressed(fresh(), "2", "c")
    assert after.rig.left == RIG.right
    assert after.rig.right == RIG.right
    both = pressed(fresh(), "3", "c")
    assert both.rig.right == RIG.left
    assert pressed(after, "3", "up", "backspace").rig == RIG
    assert pressed(after, "2", "backspace").rig.left == RIG.right


def test_a_typed_prescription() -> None:
    session = pressed(fresh(), "2", "enter")
    assert session.is_typing
    wrong = typed(session, "-5,00 / -1.25")
    assert wrong.is_typing
    assert wrong.rig == RIG
    assert "axis" in wrong.message
    right = typed(session, "-5.00 / -1.25 x 170")
    assert not right.is_typing
    assert (right.rig.right.sphere_d, right.rig.right.cylinder_d) == (-5.0, -1.25)
    assert right.rig.right.axis_deg == 170.0
    assert right.rig.left == RIG.left
    assert right.message == "right: -5.00 / -1.25 x 170"


@given(
    sphere=st.integers(-160, 160),
    cylinder=st.integers(-80, 80),
    axis=st.integers(0, 180),
    fine=st.floats(-0.2, 0.2),
)
def test_what_is_written_reads_the_same(sphere: int, cylinder: int, axis: int, fine: float) -> None:
    values = {"sphere_d": max(-40.0, min(round(sphere / 4 + fine, 6), 40.0)), "vertex_mm": 0.0}
    values |= {"cylinder_d": cylinder / 4, "axis_deg": float(axis) if cylinder else 0.0}
    rig = altered(RIG, {"left": values})
    assert prescribed(rig, ("left",), written(rig.left)) == rig


def test_method_array_and_barriers_go_round() -> None:
    session, methods = fresh(), []
    for _ in METHODS:
        session = pressed(session, "m")
        methods.append(session.rig.prefilter.method)
    assert sorted(methods) == sorted(METHODS)
    assert session.rig == RIG
    session = pressed(session, "n")
    assert session.rig.array.kind in ARRAYS
    assert session.rig.array.kind != RIG.array.kind
    assert pressed(fresh(), "b").rig.array.barriers == "perpendicular"


def test_an_array_that_the_rig_cannot_be_is_said_not_taken() -> None:
    """A bare rig knows no pitch and no gap."""
    after = pressed(fresh(BARE), "n")
    assert after.rig == BARE
    assert "array" in after.message


def test_brightness_stays_above_black() -> None:
    rig = altered(RIG, {"prefilter": {"black_level": 0.93, "method": "optimal"}})
    assert pressed(fresh(rig), "-").rig.prefilter.brightness == 0.95
    assert pressed(fresh(rig), "-", "-").rig.prefilter.brightness == 0.95
    assert pressed(fresh(rig), "=").rig.prefilter.brightness == 1.0


def test_views_and_comparisons() -> None:
    for number, view in zip("4567890", VIEWS, strict=True):
        assert pressed(fresh(), number).view == view
    assert pressed(fresh(), "9", "9").comparison == 1
    assert pressed(fresh(), *["9"] * (len(COMPARISONS) + 1)).comparison == 0
    assert pressed(fresh(), "g", "4").is_aligning == "fringes"


def test_zoom() -> None:
    assert pressed(fresh(), "z").zoom == 1.0
    assert pressed(fresh(), "z", "z").zoom is None
    assert pressed(fresh(), "ctrl+=", "ctrl+=").zoom == 3.0
    assert pressed(fresh(), *["ctrl+-"] * 9).zoom == 0.25


def test_looking_ends_straight_up_and_goes_round() -> None:
    session = looked(fresh(), 350.0, 100.0)
    assert session.head.pitch_deg == 90.0
    assert session.head.yaw_deg == pytest.approx(-10.0)
    assert pressed(session, "h").head == fresh().head


def test_while_aligning_the_arrows_are_the_arrays() -> None:
    session = pressed(fresh(), "g", "right", "shift+left", "up", "]", "shift+[", ".", "i", "l", "=")
    rig = session.rig
    x, y = RIG.array.offset_um
    assert rig.array.offset_um == pytest.approx((x + 9.0, y + 10.0))
    assert rig.array.rotation_deg == pytest.approx(RIG.array.rotation_deg + 0.09)
    assert rig.array.pitch_um == pytest.approx(RIG.array.pitch_um + 0.1)
    assert rig.panel.pixel_pitch_um == pytest.approx(RIG.panel.pixel_pitch_um + 0.1)
    assert rig.headset.lens_separation_mm == RIG.headset.lens_separation_mm + 0.5
    assert rig.headset.lens_height_mm == RIG.headset.lens_height_mm + 0.5
    assert rig.left == RIG.left
    assert "9" in session.message
    assert press_of("1", aligning=True) == press_of("1", aligning=False)
    assert pressed(session, "g", "g", "g", "g").is_aligning is None
    assert pressed(session, *["ctrl+z"] * 9).rig == RIG


_CHORDS = [
    chord
    for group in GROUPS
    for key in group.keys
    for chord in (key.chord, *([f"shift+{key.chord}"] if key.finer else []))
]


@settings(max_examples=60, deadline=None)
@given(chords=st.lists(st.sampled_from(_CHORDS), max_size=40))
def test_whatever_is_pressed_the_rig_is_one_and_undo_leads_back(chords: list[str]) -> None:
    session = fresh()
    for chord in chords:
        session = pressed(session, chord)
        assert "\n" not in session.message
    # Valid through and through: a model that is made anew from its tables is equal.
    assert altered(session.rig, {}) == session.rig
    ends: list[Rig] = [session.rig]
    while session.past:
        session = pressed(session, "ctrl+z")
        ends.append(session.rig)
    assert session.rig == RIG
    for rig in reversed(ends[:-1]):
        session = pressed(session, "ctrl+y")
        assert session.rig == rig


def test_every_step_is_known() -> None:
    given: dict[str, Any] = {key.action: key for group in GROUPS for key in group.keys}
    for name in STEPS:
        assert isinstance(given[name], Key)
        assert Press(given[name], fine=True).key.finer
    assert replace(fresh(), message="x").message == "x"


def test_the_readme_has_the_table_of_keys(repo_root: Path) -> None:
    assert markdown() in (repo_root / "README.md").read_text()


def test_walking_goes_where_the_head_looks_and_stays_level() -> None:
    session = looked(fresh(), 90.0, 30.0)
    ahead = strolled(session, ["walk_ahead"], 0.05).head.position_m
    assert ahead == pytest.approx((0.06, 0.0, 0.0), abs=1e-9)
    right = strolled(session, ["walk_right"], 0.05).head.position_m
    assert right == pytest.approx((0.0, 0.0, 0.06), abs=1e-9)
    both = strolled(fresh(), ["walk_back", "walk_left"], 9.0).head.position_m
    assert both == pytest.approx((-0.12, 0.0, 0.12)), "a long frame is no leap"
    assert strolled(session, ["walk_ahead", "walk_back"], 0.05).head == session.head
