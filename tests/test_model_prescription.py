"""Prescriptions as they are written on paper."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vrlf.errors import InputError
from vrlf.model import parse_prescription


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("-5.00 / -1.25 x 170", (-5.0, -1.25, 170.0)),
        ("-5.00 -1.25x170", (-5.0, -1.25, 170.0)),
        ("-5.00-1.25X170", (-5.0, -1.25, 170.0)),
        ("-5", (-5.0, 0.0, 0.0)),
        ("+2.50 DS", (2.5, 0.0, 0.0)),
        ("-5.00 / DS", (-5.0, 0.0, 0.0)),
        ("plano", (0.0, 0.0, 0.0)),
        ("pl / -0.75 x 90", (0.0, -0.75, 90.0)),
        ("Plano +1.50 x 7", (0.0, 1.5, 7.0)),
        (
            "\N{MINUS SIGN}5,25 / \N{MINUS SIGN}1,25 \N{MULTIPLICATION SIGN} 170",
            (-5.25, -1.25, 170),
        ),
        ("-5.25, -1.25 x 170", (-5.25, -1.25, 170.0)),
        ("  -.5 / + 1. x 5° ", (-0.5, 1.0, 5.0)),
        ("-3.00 DS / -1.00 DC axis 12.5", (-3.0, -1.0, 12.5)),
        ("-3.00 / 0.00", (-3.0, 0.0, 0.0)),
        # Without a cylinder an axis means nothing.
        ("-3.00 / -0.00 x 45", (-3.0, 0.0, 0.0)),
    ],
)
def test_paper_forms(text: str, expected: tuple[float, float, float]) -> None:
    assert parse_prescription(text) == expected


def test_zero_has_no_sign() -> None:
    assert [str(value) for value in parse_prescription("-0.00 / -0.00 x 3")] == ["0.0"] * 3


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "sphere / cylinder x axis"),
        ("five", "sphere / cylinder x axis"),
        ("-5.00 / -1.25", "cylinder without its axis"),
        ("-5.00 x 170", "sphere / cylinder x axis"),
        ("-5.00 / -1.25 x 181", "0 to 180 degrees"),
        ("-5.00 / -1.25 x -1", "0 to 180 degrees"),
        ("-41", "at most 40 D"),
        ("-5 / 20.5 x 3", "at most 20 D"),
        ("nan", "sphere / cylinder x axis"),
        ("1e3", "sphere / cylinder x axis"),
        ("-5.00.25", "sphere / cylinder x axis"),
        ("\N{ARABIC-INDIC DIGIT FIVE}", "sphere / cylinder x axis"),
        ("9" * 90, "at most 40 D"),
        ("-5" + " " * 5000, "sphere / cylinder x axis"),
    ],
)
def test_refusals_say_found_and_wanted(text: str, reason: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_prescription(text)
    message = str(caught.value)
    assert reason in message
    assert "found" in message
    assert "wanted" in message
    # The quoted text is clipped to 60 characters; the rest is ours.
    assert len(message) < 200


_quarters = st.integers(-80, 80).map(lambda steps: steps / 4)


@given(sphere=_quarters, cylinder=_quarters.filter(bool), axis=st.integers(0, 180))
def test_what_is_written_is_read(sphere: float, cylinder: float, axis: int) -> None:
    text = f"{sphere:+.2f} / {cylinder:+.2f} x {axis}"
    assert parse_prescription(text) == (sphere, cylinder, axis)
    assert parse_prescription(text.replace(".", ",")) == (sphere, cylinder, axis)


def _read_or_refused(text: str) -> tuple[float, float, float] | InputError:
    try:
        return parse_prescription(text)
    except InputError as error:
        return error


@given(st.text(max_size=120))
def test_any_text_is_read_or_refused_in_one_line(text: str) -> None:
    outcome = _read_or_refused(text)
    assert isinstance(outcome, tuple) or str(outcome).isprintable()
