"""What a window remembers: whole, checked, and never a reason to fail."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vrlf.app.preview.state import State, load_state, save_state, state_folder

GIVEN = State(
    rig="mine.toml",
    source="a b.png",
    window_px=(-20, 30, 800, 600),
    view="compare",
    eyes="left",
    has_panels=False,
    monitor=1,
)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("VRLF_CONFIG_DIR", str(tmp_path / "configuration"))
    return tmp_path / "configuration"


def test_it_comes_back(folder: Path) -> None:
    assert load_state() == (State(), None)
    assert save_state(GIVEN) is None
    assert load_state() == (GIVEN, None)
    assert [path.name for path in folder.iterdir()] == ["preview.json"]


@pytest.mark.parametrize(
    "change",
    [
        {"version": 2},
        {"version": None},
        {"window_px": [0, 0, 800]},
        {"window_px": [0, 0, 800, 1]},
        {"window_px": [0, 0, 800, 6e5]},
        {"window_px": [10**9, 0, 800, 600]},
        {"view": "nothing"},
        {"eyes": 3},
        {"rig": None},
        {"has_panels": 1},
        {"monitor": -1},
        {"unknown": 1},
    ],
)
def test_a_wrong_value_sets_the_file_aside(folder: Path, change: dict[str, object]) -> None:
    save_state(GIVEN)
    path = folder / "preview.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), **change}))
    broken = path.read_text()
    state, message = load_state()
    assert state == State()
    assert message is not None
    assert "\n" not in message
    assert not path.exists()
    assert (folder / "preview.broken.json").read_text() == broken
    assert load_state() == (State(), None)


@pytest.mark.parametrize("text", ["", "{", "[1]", "nul", "[" * 100_000, b"\xff\xfe{"])
def test_a_broken_file_is_set_aside(folder: Path, text: str | bytes) -> None:
    folder.mkdir()
    raw = text if isinstance(text, bytes) else text.encode()
    (folder / "preview.json").write_bytes(raw)
    state, message = load_state()
    assert state == State()
    assert message is not None
    assert (folder / "preview.broken.json").read_bytes() == raw


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(raw=st.binary(max_size=60))
def test_no_bytes_are_a_crash(raw: bytes) -> None:
    state_folder().mkdir(exist_ok=True)
    (state_folder() / "preview.json").write_bytes(raw)
    assert isinstance(load_state()[0], State)


def test_a_folder_that_cannot_be_made_is_a_message(folder: Path) -> None:
    folder.write_text("a file in the way")
    message = save_state(GIVEN)
    assert message is not None
    assert "wanted a folder" in message
    state, message = load_state()
    assert state == State()
    assert message is not None


def test_it_lies_in_the_users_folder_by_default(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("VRLF_CONFIG_DIR")
    monkeypatch.setenv("XDG_CONFIG_HOME", os.sep + "somewhere")
    assert state_folder().name == "vrlf"
