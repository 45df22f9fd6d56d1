"""Fixtures that every room's tests share."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from virtual_screen import SERVER, Screen

from vrlf.gpu import Device

# What the runner and a library change by themselves: pytest names the running
# test; importing imgui_bundle names its own GLFW.
_CHANGED_BY_OTHERS = frozenset({"PYTEST_CURRENT_TEST", "PYTEST_VERSION", "PYGLFW_LIBRARY"})


@pytest.fixture(scope="session")
def repo_root() -> Path:
    """Top folder of the checkout that these tests lie in."""
    return Path(__file__).resolve().parent.parent


def _environment() -> dict[str, str]:
    return {name: os.environ[name] for name in os.environ if name not in _CHANGED_BY_OTHERS}


@pytest.fixture(scope="session", autouse=True)
def _environment_guard() -> Iterator[None]:
    """Hold that no test leaves another working folder or environment behind; set nothing."""
    folder, variables = Path.cwd(), _environment()
    yield
    assert Path.cwd() == folder, f"a test left the working folder at {Path.cwd()}"
    changed = {name for name, _ in variables.items() ^ _environment().items()}
    assert not changed, f"a test left these environment variables changed: {sorted(changed)}"


@pytest.fixture(scope="module")
def device() -> Iterator[Device]:
    """A GPU context without a window, one for each file of tests."""
    with Device.headless() as made:
        yield made


@pytest.fixture(autouse=True)
def _gpu_litter_guard(request: pytest.FixtureRequest) -> Iterator[None]:
    """Hold that each test with a ``device`` gives back all that it put there.

    A test that makes a device of its own leaves that one current; the file's is taken up again.
    """
    if "device" not in request.fixturenames:
        yield
        return
    device: Device = request.getfixturevalue("device")
    device.make_current()
    before = device.live_objects
    yield
    device.make_current()
    assert device.live_objects == before, "the test left these on the GPU"
    device.check("ending a test")


@pytest.fixture(scope="module")
def screen(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Screen]:
    """A virtual screen of our own."""
    if shutil.which("Xvfb") is None:
        pytest.skip("Xvfb is not installed (make test installs it)")
    folder = tmp_path_factory.mktemp("screen")
    read_end, write_end = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write_end), *SERVER, "-fbdir", str(folder)],
        pass_fds=[write_end],
        stderr=subprocess.DEVNULL,
    )
    os.close(write_end)
    with os.fdopen(read_end) as number:
        name = number.readline().strip()
    assert name, "Xvfb said no display number"
    yield Screen(f":{name}", folder / "Xvfb_screen0", server)
    server.terminate()
    server.wait(10)


@pytest.fixture(scope="module")
def display(screen: Screen) -> str:
    """Its name."""
    return screen.display
