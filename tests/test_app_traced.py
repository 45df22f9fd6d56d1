"""``vrlf perceive --diffraction`` and ``--exact``, and the Python interface to them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from command_runs import (
    BARE,
    DATA,
    LENSLETS,
    call,
    exr_file,
    left_in,
    light,
    require_done,
    require_one_line,
)

import vrlf
from vrlf.errors import InputError
from vrlf.images import read_picture

SMALL = ("--set", "panel.width_px=40", "--set", "panel.height_px=24")
HOLES = ("-r", str(DATA / "holes-round-prism.toml"))


@pytest.fixture
def panel(tmp_path: Path) -> Path:
    return exr_file(tmp_path / "panel.exr", light(size_px=(40, 24)))


@pytest.mark.parametrize(
    "options", [("--diffraction",), ("--exact",), ("--diffraction", "--exact")]
)
def test_traced_perception_by_gpu_reference_and_python(
    tmp_path: Path, panel: Path, options: tuple[str, ...]
) -> None:
    seen = {}
    for device in ("gpu", "reference"):
        out = tmp_path / f"{device}.exr"
        command = ("perceive", panel, *LENSLETS, *SMALL, "--rays", "8", "-o", out, *options)
        answer = require_done(call(*command, "--device", device, "--json")).json()
        for name in ("diffraction", "exact"):
            assert answer[name] == (f"--{name}" in options)
        seen[device] = read_picture(out)
    # The GPU sums two halves of the same rays.
    off = np.abs(seen["gpu"] - seen["reference"]).max(axis=-1)
    assert (off > 1e-4).mean() <= 5e-3
    rig = vrlf.load_rig(LENSLETS[1], overrides=(SMALL[1], SMALL[3]))
    keys = {option[2:]: True for option in options}
    same = vrlf.perceive(read_picture(panel), rig, rays=8, **keys)  # type: ignore[arg-type]
    assert np.abs(same - seen["gpu"]).max() <= 1e-6
    plain = vrlf.perceive(read_picture(panel), rig, rays=8)
    assert np.abs(plain - same).max() > 1e-3


def test_what_a_rig_has_nothing_for_is_one_line(tmp_path: Path, panel: Path) -> None:
    out = tmp_path / "out.exr"
    for rig, option, names in (
        (BARE, "--exact", ("exact", "none", "microlens")),
        (BARE, "--diffraction", ("diffraction", "none", "pinhole")),
        (HOLES, "--exact", ("exact", "pinhole", "microlens")),
    ):
        outcome = call("perceive", panel, *rig, *SMALL, option, "-o", out)
        require_one_line(outcome, 2, *names)
    strong = ("--set", "array.focal_mm=0.2")
    outcome = call("perceive", panel, *LENSLETS, *SMALL, *strong, "--exact", "-o", out)
    require_one_line(outcome, 2, "array.focal_mm", "0.2", "corner")
    assert left_in(tmp_path) == ["panel.exr"]
    rig = vrlf.load_rig(BARE[1])
    with pytest.raises(InputError, match="exact"):
        vrlf.perceive(np.zeros((rig.panel.height_px, rig.panel.width_px, 3)), rig, exact=True)
