"""The wheel: it carries the shaders and assets, and serves without the checkout."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest


def run(arguments: list[str], folder: Path, **environment: str) -> str:
    """Run this Python with ``arguments`` in ``folder``; the output of what must succeed."""
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(repo_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel of this checkout, built with the build tools at hand, without a network."""
    folder = tmp_path_factory.mktemp("wheel")
    run(["-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder)], repo_root)
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def site(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder outside the checkout with only vrlf installed in it."""
    folder = tmp_path_factory.mktemp("site")
    run(
        ["-m", "pip", "install", "--no-deps", "--no-index", "--target", str(folder), str(wheel)],
        folder,
    )
    return folder


def run_installed(code: str, site: Path, elsewhere: Path) -> list[str]:
    """Lines that ``code`` prints when the vrlf in ``site`` is the one imported.

    PYTHONPATH stands before site-packages, where an editable install would
    bring the checkout in; the first line tells whether that held.
    """
    code = "import vrlf\nprint(vrlf.__file__)\n" + code
    origin, *lines = run(["-c", code], elsewhere, PYTHONPATH=str(site)).splitlines()
    assert Path(origin) == site / "vrlf" / "__init__.py"
    return lines


@pytest.mark.parametrize("folder", ["shaders", "assets"])
def test_wheel_carries_every_file_of(folder: str, wheel: Path, repo_root: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        shipped = {n for n in archive.namelist() if n.startswith(f"vrlf/_{folder}/")}
    there = [path for path in (repo_root / folder).rglob("*") if path.is_file()]
    wanted = {f"vrlf/_{folder}/{path.relative_to(repo_root / folder).as_posix()}" for path in there}
    assert wanted
    assert shipped == wanted


def test_wheel_carries_types_and_no_tests(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    assert "vrlf/py.typed" in names
    assert {name.split("/")[0] for name in names} == {
        "vrlf",
        wheel.name.rsplit("-", 3)[0] + ".dist-info",
    }


def test_installed_package_finds_its_own_shaders(site: Path, tmp_path: Path) -> None:
    code = """
from vrlf.resources import assets_dir, shaders_dir
print(shaders_dir())
print(assets_dir())
"""
    lines = run_installed(code, site, tmp_path)
    assert lines == [str(site / "vrlf" / "_shaders"), str(site / "vrlf" / "_assets")]


def test_installed_package_renders(site: Path, tmp_path: Path) -> None:
    """A small panel image; the lens separation puts both axes on the 96 px panel."""
    code = """
import numpy
rig = vrlf.load_rig("matched-microlens", overrides=[
    "panel.width_px=96", "panel.height_px=64", "headset.lens_separation_mm=3.744"])
panel = vrlf.prefilter(numpy.full((64, 96, 3), 0.5, numpy.float32), rig)
print(panel.shape, bool(panel.max() > 0), bool(numpy.isfinite(panel).all()))
"""
    assert run_installed(code, site, tmp_path) == ["(64, 96, 3) True True"]


def test_installed_command_runs(site: Path, tmp_path: Path) -> None:
    output = run([str(site / "bin" / "vrlf"), "--help"], tmp_path, PYTHONPATH=str(site))
    assert "prefilter" in output
