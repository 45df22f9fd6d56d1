"""The real window on a virtual screen, driven by real keys, held to what the commands write."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest
from command_runs import call
from numpy.typing import NDArray
from virtual_screen import Screen

from vrlf.app.preview.layout import placed
from vrlf.app.preview.session import Session
from vrlf.images import write_encoded
from vrlf.model import Rig, load_rig, rig_from_tables
from vrlf.optics.tile import BACKGROUND_CODE, LINE_CODE

# Two different eyes, an odd width.
RIG = """extends = "two-eyes"  # a comment that stays
[panel]
width_px = 97
height_px = 60
[headset]
lens_separation_mm = 3.8
"""
PATIENCE_S = 60.0  # for a loaded machine; each wait ends as soon as what is awaited is there


class Window:
    """A window of ours in a process of its own."""

    def __init__(self, screen: Screen, folder: Path, *arguments: str, **environment: str) -> None:
        self.screen, self.folder = screen, folder
        errors = (folder / "errors.txt").open("w")
        kept = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "vrlf", "preview", "--folder", str(folder), *arguments],
            env={
                **kept,
                "DISPLAY": screen.display,
                "VRLF_CONFIG_DIR": str(folder / "configuration"),
                **environment,
            },
            cwd=environment.get("PYTHONPATH"),
            stderr=errors,
            stdout=subprocess.PIPE,
        )
        errors.close()
        self.eventually(lambda: screen.pixels().any(), "a picture")

    def eventually(self, is_so: Callable[[], Any], what: str) -> None:
        """Wait until something is so."""
        deadline = time.monotonic() + PATIENCE_S
        while not is_so():
            assert self.process.poll() is None, f"the window ended: {self.said()}"
            assert time.monotonic() < deadline, f"waited in vain for {what}; it said: {self.said()}"
            time.sleep(0.05)

    def shot(self, chord: str = "F12") -> NDArray[np.uint8]:
        """A screenshot's codes."""
        return read_codes(self.shot_file(chord))

    def shot_file(self, chord: str = "F12") -> Path:
        """Press the key and wait for the file."""
        before = set(self.folder.glob("vrlf-*.png"))
        self.screen.keys(chord)
        self.eventually(lambda: set(self.folder.glob("vrlf-*.png")) - before, "a screenshot")
        return next(iter(set(self.folder.glob("vrlf-*.png")) - before))

    def shows(self, expected: NDArray[Any], what: str) -> None:
        """Wait for a screenshot that is, code by code, what is expected."""
        self.eventually(lambda: np.array_equal(self.shot(), expected), what)

    def pause(self) -> None:
        """Give the window time to draw what a key opened: the field takes keys from then on."""
        time.sleep(0.7)

    def said(self) -> str:
        """Standard error so far."""
        return (self.folder / "errors.txt").read_text()

    def leave(self) -> int:
        """Press Escape; the exit status."""
        if self.process.poll() is None:
            self.screen.keys("Escape")
        try:
            return self.process.wait(PATIENCE_S)
        finally:
            self.close()

    def close(self) -> None:
        """End it in any case."""
        self.process.kill()
        self.process.wait()
        assert self.process.stdout is not None
        self.process.stdout.close()


def read_codes(path: Path) -> NDArray[np.uint8]:
    """A PNG's own codes."""
    return np.asarray(OpenImageIO.ImageBuf(str(path)).get_pixels("uint8"))[..., :3]


def expected_codes(rig: Rig, codes: NDArray[Any], window_px: tuple[int, int]) -> NDArray[Any]:
    """A picture one to one in the middle of the window."""
    tile = placed(replace(Session(rig=rig, loaded=rig), zoom=1.0), window_px)[0].tile
    window = np.full((window_px[1], window_px[0], 3), BACKGROUND_CODE, np.uint8)
    x, y = (round(-start) for start in tile.start_px)
    window[y : y + codes.shape[0], x : x + codes.shape[1]] = codes
    return window


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """With a rig and a picture in it."""
    (tmp_path / "rig.toml").write_text(RIG)
    light = np.random.default_rng(4).integers(0, 256, (60, 97, 3), np.uint8)
    light[:, 48] = 0
    write_encoded(tmp_path / "target.png", light)
    return tmp_path


@pytest.fixture
def opened(screen: Screen, folder: Path) -> Iterator[Callable[..., Window]]:
    """Opens windows of 640 x 480 and closes them."""
    if shutil.which("xdotool") is None:
        pytest.skip("xdotool is not installed (make test installs it)")
    windows: list[Window] = []

    def open_window(*arguments: str, **environment: str) -> Window:
        given = arguments or (str(folder / "target.png"),)
        rig = () if "-r" in given else ("-r", str(folder / "rig.toml"))
        size = '{"version": 1, "window_px": [0, 0, 640, 480], "has_panels": false}'
        (folder / "configuration").mkdir(exist_ok=True)
        (folder / "configuration" / "preview.json").write_text(size)
        windows.append(Window(screen, folder, *given, *rig, **environment))
        return windows[-1]

    yield open_window
    for window in windows:
        window.close()


def perceived(folder: Path, *changes: str) -> NDArray[np.uint8]:
    """What the commands write for the rig with some keys changed."""
    rig = ["-r", str(folder / "rig.toml"), *(word for c in changes for word in ("--set", c))]
    panel, seen = str(folder / "panel.exr"), str(folder / "seen.png")
    assert call("prefilter", str(folder / "target.png"), *rig, "-o", panel).status == 0
    assert call("perceive", panel, *rig, "-o", seen).status == 0
    return read_codes(folder / "seen.png")


def test_eight_steps_of_the_left_sphere(opened: Any, folder: Path, screen: Screen) -> None:
    rig = load_rig(folder / "rig.toml")
    window = opened()
    screen.keys("z")
    before = perceived(folder)
    window.shows(expected_codes(rig, before, (640, 480)), "the view before")
    screen.keys("1", *["Down"] * 8)
    after = perceived(folder, f"left.sphere_d={rig.left.sphere_d - 2.0}")
    wanted = expected_codes(rig, after, (640, 480))
    window.shows(wanted, "the view after eight steps")
    assert (after[:, :48] != before[:, :48]).mean() > 0.5
    np.testing.assert_array_equal(after[:, 49:], before[:, 49:])
    # The screen itself shows what the file holds.
    screen.mouse("mousemove", "3", "3")
    window.eventually(
        lambda: np.array_equal(screen.pixels()[100:400], wanted[100:400]), "the screen"
    )
    # Undo, all of it, and back.
    screen.keys(*["ctrl+z"] * 8)
    window.shows(expected_codes(rig, before, (640, 480)), "the view after undo")
    screen.keys(*["ctrl+y"] * 8)
    window.shows(wanted, "the view done again")
    assert window.leave() == 0
    assert window.said().count("\n") == window.said().count("wrote") + 1, window.said()


def test_a_typed_prescription_is_saved_with_the_files_comments(
    opened: Any, folder: Path, screen: Screen
) -> None:
    window = opened()
    screen.keys("2", "Return")
    window.pause()
    screen.type("nonsense")
    screen.keys("Return")
    window.pause()
    screen.keys("ctrl+a")
    screen.type("-2,25 / -0.75 x 65")
    screen.keys("Return")
    window.pause()
    screen.keys("ctrl+s")
    path = folder / "rig.toml"
    window.eventually(lambda: path.read_text() != RIG, "the rig to be saved")
    rig = load_rig(path)
    assert (rig.right.sphere_d, rig.right.cylinder_d, rig.right.axis_deg) == (-2.25, -0.75, 65.0)
    assert path.read_text().startswith(RIG)
    assert rig.left == load_rig("two-eyes").left
    seen = perceived(folder)
    screen.keys("z")
    window.shows(expected_codes(rig, seen, (640, 480)), "what the saved rig sees")
    # Another program's work is not overwritten, and is said.
    path.write_text(path.read_text() + "# theirs\n")
    screen.keys("1", "Down", "ctrl+s")
    window.eventually(lambda: "changed by another program" in window.said(), "a message")
    assert path.read_text().endswith("# theirs\n")
    screen.keys("ctrl+r")
    window.eventually(lambda: "read" in window.said().splitlines()[-1], "the rig to be read")
    window.shows(expected_codes(rig, seen, (640, 480)), "the rig as it was read again")
    path.write_text("[left]\nsphere = 1\n")
    screen.keys("ctrl+r")
    window.eventually(lambda: "sphere" in window.said(), "the fault's line")
    window.shows(expected_codes(rig, seen, (640, 480)), "the rig as it was before")
    assert window.leave() == 0


def test_a_screenshot_holds_the_rig(opened: Any, folder: Path, screen: Screen) -> None:
    window = opened(str(folder / "target.png"), "-r", str(folder / "rig.toml"), "--view", "panel")
    screen.keys("1", "period", "Tab")
    path = window.shot_file()
    attributes = OpenImageIO.ImageBuf(str(path)).spec().extra_attribs
    found = {each.name: each.value for each in attributes}
    rig = rig_from_tables(tomllib.loads(found["vrlf:rig"]))
    pupil_mm = load_rig(folder / "rig.toml").left.pupil_mm
    assert rig.left.pupil_mm == pupil_mm + 0.5
    assert found["vrlf:view"] == "panel"
    with_panels, without = window.shot("shift+F12"), read_codes(path)
    assert with_panels.shape == without.shape == (480, 640, 3)
    np.testing.assert_array_equal(with_panels[:400, 400:], without[:400, 400:])
    assert (with_panels[:200, 20:200] != without[:200, 20:200]).mean() > 0.3
    assert window.leave() == 0


def test_a_broken_shader_changes_nothing(
    opened: Any, folder: Path, screen: Screen, repo_root: Path
) -> None:
    copy = folder / "checkout"
    for part in ("vrlf", "shaders", "assets"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(repo_root / part, copy / part, ignore=ignored)
    (copy / "pyproject.toml").touch()
    rig, path = load_rig(folder / "rig.toml"), copy / "shaders" / "perceive.comp"
    window = opened(PYTHONPATH=str(copy))
    screen.keys("z")
    before = expected_codes(rig, perceived(folder), (640, 480))
    window.shows(before, "the view")
    good = path.read_text()
    path.write_text(good.replace("void main() {", "void main() { broken"))
    screen.keys("F5")
    window.eventually(lambda: "perceive.comp" in window.said(), "the compiler's message")
    assert "broken" in window.said()
    screen.keys("1", "Down", "Up")
    window.shows(before, "the last good program")
    path.write_text(good.replace("light * scale", "light * scale * vec3(1.0, 0.0, 0.0)"))
    screen.keys("F5")
    red = before.copy()
    tile = red[210:270, 271:368]
    tile[..., 1:] = 0
    window.shows(red, "the new program")
    assert window.leave() == 0


def test_fullscreen_and_another_size(opened: Any, folder: Path, screen: Screen) -> None:
    rig = load_rig(folder / "rig.toml")
    window = opened()
    screen.keys("z")
    seen = perceived(folder)
    window.shows(expected_codes(rig, seen, (640, 480)), "the view")
    screen.mouse("search", "--name", "vrlf", "windowsize", "501", "303")
    window.shows(expected_codes(rig, seen, (501, 303)), "the view in a smaller window")
    screen.keys("F11")
    window.shows(expected_codes(rig, seen, (640, 480)), "the view fullscreen")
    screen.keys("F11")
    window.shows(expected_codes(rig, seen, (501, 303)), "the window as it was")
    assert window.leave() == 0
    state = json.loads((folder / "configuration" / "preview.json").read_text())
    assert state["window_px"][2:] == [501, 303]
    assert state["source"] == str(folder / "target.png")


def test_what_cannot_be_written_is_said_and_the_window_goes_on(
    opened: Any, folder: Path, screen: Screen
) -> None:
    shots = folder / "shots"
    shots.mkdir()
    window = opened(
        str(folder / "target.png"), "-r", str(folder / "rig.toml"), "--folder", str(shots)
    )
    shots.rmdir()
    screen.keys("F12")
    window.eventually(lambda: "found no folder" in window.said(), "a message")
    shots.mkdir()
    screen.keys("F12")
    window.eventually(lambda: list(shots.glob("*.png")), "a screenshot")
    assert window.leave() == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["no-such.png"], "no-such.png"),
        (["chart:nothing"], "nothing"),
        (["--monitor", "0"], "--monitor"),
        (["-r", "no-such-rig"], "no-such-rig"),
        (["--folder", "/no/such/folder"], "folder"),
        (["--view", "sideways"], "--view"),
    ],
)
def test_wrong_input_is_one_line_before_there_is_a_window(
    folder: Path, arguments: list[str], said: str, screen: Screen
) -> None:
    result = subprocess.run(
        [sys.executable, "-m", "vrlf", "preview", *arguments],
        env={**os.environ, "DISPLAY": screen.display, "VRLF_CONFIG_DIR": str(folder / "c")},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert result.returncode == 2, result.stderr
    assert len(result.stderr.splitlines()) == 1, result.stderr
    assert said in result.stderr


def test_without_a_display_one_line_says_so(folder: Path) -> None:
    kept = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    result = subprocess.run(
        [sys.executable, "-m", "vrlf", "preview", "scene"],
        env={**kept, "VRLF_CONFIG_DIR": str(folder / "c")},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert result.returncode == 1
    assert len(result.stderr.splitlines()) == 1, result.stderr
    assert "no display" in result.stderr


def test_the_mouse_divides_zooms_moves_and_looks(opened: Any, folder: Path, screen: Screen) -> None:
    rig = load_rig(folder / "rig.toml")
    window = opened(str(folder / "target.png"), "-r", str(folder / "rig.toml"), "--view", "compare")
    lines = lambda: np.nonzero((window.shot()[240] == LINE_CODE).all(axis=1))[0].tolist()  # noqa: E731
    window.eventually(lambda: lines() == [319, 320, 321], "the divider in the middle")
    _drag(screen, "1", (321, 100), (161, 100))
    window.eventually(lambda: lines() == [160, 161, 162], "the divider where it was dragged")
    screen.keys("7", "z")
    target = read_codes(folder / "target.png")
    window.shows(expected_codes(rig, target, (640, 480)), "the target one to one")
    screen.mouse("mousemove", "330", "236", "click", "--repeat", "6", "--delay", "120", "4")

    def pixel_widths() -> set[int]:
        row = window.shot()[241].astype(int)
        return set(np.diff(np.nonzero((np.diff(row, axis=0) != 0).any(axis=1))[0]).tolist())

    window.eventually(lambda: pixel_widths() == {12}, "twelve times the size")
    large = window.shot()
    _drag(screen, "1", (300, 300), (260, 290))
    window.eventually(
        lambda: np.array_equal(window.shot()[20:400, 20:400], large[30:410, 60:440]), "a move"
    )
    assert window.leave() == 0


def _drag(screen: Screen, button: str, start: tuple[int, int], end: tuple[int, int]) -> None:
    """In steps, as a hand does."""
    x, y = start
    screen.mouse("mousemove", str(x), str(y))
    time.sleep(0.3)
    screen.mouse("mousedown", button)
    time.sleep(0.3)
    for part in (0.25, 0.5, 0.75, 1.0):
        at = (round(x + part * (end[0] - x)), round(y + part * (end[1] - y)))
        screen.mouse("mousemove", str(at[0]), str(at[1]))
        time.sleep(0.2)
    screen.mouse("mouseup", button)
    time.sleep(0.2)


def test_a_phone_shows_the_windows_panel_image_and_its_keys_are_the_windows(
    opened: Any, folder: Path, screen: Screen
) -> None:
    """The QR code on the screen is the address, module by module; frames are the panel image."""
    import asyncio
    import json

    import segno
    from test_serve_faults import dial, unpacked

    window = opened(str(folder / "target.png"), "--phone")
    window.eventually(lambda: "http://" in window.said(), "the address")
    address = next(word for word in window.said().split() if word.startswith("http://"))
    matrix = np.array(segno.make(address, micro=False).matrix, bool)

    def has_code() -> bool:
        dark = screen.pixels().max(axis=2) < 40
        side = 5 * len(matrix)
        big = np.kron(matrix, np.ones((5, 5), bool))
        # It stands in the lower right corner, its place a matter of the window's frame.
        for top in range(dark.shape[0] - side - 80, dark.shape[0] - side + 1):
            for left in range(dark.shape[1] - side - 60, dark.shape[1] - side + 1):
                if np.array_equal(dark[top : top + side : 29, left : left + side : 31],
                                  big[::29, ::31]) and np.array_equal(
                    dark[top : top + side, left : left + side], big
                ):  # fmt: skip
                    return True
        return False

    window.eventually(has_code, "the QR code")
    screen.keys("p")

    async def talk() -> tuple[np.ndarray, str]:
        async with dial(address) as phone:
            hello = {"t": "hello", "width": 97, "height": 60, "ratio": 1}
            await phone.send(json.dumps(hello))
            for chord in ("1", "down", "down"):
                await phone.send(json.dumps({"t": "key", "chord": chord}))
            frame, words = b"", ""
            while True:
                try:
                    data = await asyncio.wait_for(phone.recv(), 4.0 if frame else 30.0)
                except TimeoutError:
                    return np.frombuffer(frame, np.uint8).reshape(60, 97, 3), words
                if isinstance(data, str):
                    words = json.loads(data).get("left", words)
                    continue
                number, frame = unpacked(data)
                await phone.send(json.dumps({"t": "shown", "number": number, "photon": None}))

    shown, _ = asyncio.run(talk())
    window.shot()
    rig = ["-r", str(folder / "rig.toml"), "--set", "left.sphere_d=-5.0"]
    panel = str(folder / "panel.png")
    assert call("prefilter", str(folder / "target.png"), *rig, "-o", panel).status == 0
    assert np.array_equal(shown, read_codes(folder / "panel.png"))
