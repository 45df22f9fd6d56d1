"""Where a head goes between the poses of a file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vrlf.errors import InputError
from vrlf.scene import HeadPose
from vrlf.scene.path import HeadPath, head_at, load_path

KEYS = [
    {"time_s": 1, "yaw_deg": 10.0, "position_m": [0.1, 0.2, 0.3]},
    {"time_s": 2, "pitch_deg": -20},
    {"time_s": 4.5, "yaw_deg": 370.0, "roll_deg": 5.0},
]


def written(tmp_path: Path, value: Any) -> str:
    path = tmp_path / "path.json"
    path.write_text(value if isinstance(value, str) else json.dumps(value))
    return str(path)


def test_keys_are_met_and_what_they_leave_out_stays(tmp_path: Path) -> None:
    path = load_path(written(tmp_path, {"keys": KEYS}))
    assert head_at(path, 0.0) == head_at(path, 1.0) == HeadPose(10.0, 0.0, 0.0, (0.1, 0.2, 0.3))
    assert head_at(path, 2.0) == HeadPose(10.0, -20.0, 0.0, (0.1, 0.2, 0.3))
    end = HeadPose(370.0, -20.0, 5.0, (0.1, 0.2, 0.3))
    assert head_at(path, 4.5) == head_at(path, 99.0) == end
    # Angles run as they are given: past 180 on the way from 10 to 370.
    assert head_at(path, 3.3).yaw_deg == pytest.approx(180.0, abs=40.0)


@given(slope=st.floats(-30, 30), times=st.lists(st.floats(0.1, 5), min_size=2, max_size=5))
def test_an_even_turn_stays_even(slope: float, times: list[float]) -> None:
    """However far apart the keys are: a cubic with secant slopes reproduces a line."""
    ends = [sum(times[: k + 1]) for k in range(len(times))]
    path = HeadPath(tuple(ends), tuple(HeadPose(yaw_deg=slope * t) for t in ends))
    for part in (0.1, 0.5, 0.77):
        at = ends[0] + part * (ends[-1] - ends[0])
        assert head_at(path, at).yaw_deg == pytest.approx(slope * at, abs=1e-6)


def test_no_jerk_at_a_key(tmp_path: Path) -> None:
    path = load_path(written(tmp_path, {"keys": KEYS}))
    step = 1e-5
    before = (head_at(path, 2.0).pitch_deg - head_at(path, 2.0 - step).pitch_deg) / step
    after = (head_at(path, 2.0 + step).pitch_deg - head_at(path, 2.0).pitch_deg) / step
    assert before == pytest.approx(after, abs=0.01)


def test_the_shipped_path_comes_back_to_where_it_began() -> None:
    path = load_path("orbit")
    assert path.poses[0] == path.poses[-1] == HeadPose()
    assert head_at(path, 2.0).yaw_deg == 12.0


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("", "no JSON"),
        ("[" * 100_000, "no JSON"),
        ([], "wanted an object"),
        ({}, '"keys" alone'),
        ({"keys": [], "fps": 3}, '"keys" alone'),
        ({"keys": []}, "no keys"),
        ({"keys": [3]}, "keys[0]: found int"),
        ({"keys": [{"yaw_deg": 1}]}, "keys[0]: found no time_s"),
        ({"keys": [{"time_s": 0, "yaw": 1}]}, "found the key 'yaw'"),
        ({"keys": [{"time_s": "0"}]}, "keys[0].time_s: found '0'"),
        ('{"keys": [{"time_s": NaN}]}', "keys[0].time_s: found nan"),
        ({"keys": [{"time_s": 10**400}]}, "found a number of 401 digits"),
        ({"keys": [{"time_s": 0, "yaw_deg": -1e300}]}, "found -1e+300, wanted at most 1e+06"),
        ({"keys": [{"time_s": True}]}, "keys[0].time_s: found True"),
        ({"keys": [{"time_s": 0, "position_m": [1, 2]}]}, "keys[0].position_m"),
        ({"keys": [{"time_s": 0, "position_m": [1, 2, "3"]}]}, "keys[0].position_m: found '3'"),
        ({"keys": [{"time_s": 1}, {"time_s": 1}]}, "keys[1].time_s: found 1, wanted more than 1"),
    ],
)
def test_a_wrong_file_is_one_line(tmp_path: Path, value: Any, said: str) -> None:
    with pytest.raises(InputError) as caught:
        load_path(written(tmp_path, value))
    assert said in str(caught.value)
    assert "path.json" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_path_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="one of orbit"):
        load_path("nowhere")
    with pytest.raises(InputError, match="one of orbit"):
        load_path("n" * 400)
    with pytest.raises(InputError, match="No such file"):
        load_path(str(tmp_path / "no.json"))
