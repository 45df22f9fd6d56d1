"""The forward prefilter's pass against its twin, the known results and an independent tracer."""

from __future__ import annotations

from typing import Any

import independent_tracer
import numpy as np
import pass_rigs
import pytest
from numpy.typing import NDArray

from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.passes.forward import Forward, ForwardTables
from vrlf.reference.forward import forward as twin

Light = NDArray[Any]

# The pass maps a sample by one float32 polynomial of its place in a cell, the twin traces it:
# a few 1e-6 px apart. A sample that near a border of cell or pupil may be counted otherwise.
SAME_LIGHT = 1e-4
EDGE_SHARE = 1e-3

WITH_ARRAY = tuple(name for name in pass_rigs.CASES if pass_rigs.case(name)[0].array.kind != "none")


def prefiltered(device: Device, rig: Rig, target: Light) -> Light:
    """What the pass shows for a target, (H, W, 3)."""
    owned: list[Any] = [Forward(device)]
    try:
        owned.append(tables := ForwardTables(device, rig))
        owned.append(wanted := Texture.from_array(device, target, label="target"))
        owned.append(shown := Texture(device, wanted.size_px, label="shown"))
        owned[0].run(tables, wanted, shown)
        return shown.read()[..., :3]
    finally:
        for each in owned:
            each.release()


def hold_same(got: Light, wanted: Light, what: str) -> None:
    """All pixels equal, but for the few of which a sample lies on an edge."""
    error = np.abs(got - wanted).max(axis=-1)
    apart = int((error > SAME_LIGHT).sum())
    print(f"{what}: {apart} of {error.size} pixels apart, greatest error {error.max():.1e}")
    assert apart <= EDGE_SHARE * error.size


@pytest.mark.parametrize("name", WITH_ARRAY)
def test_forward_matches_its_twin(device: Device, name: str) -> None:
    rig, target = pass_rigs.case(name)
    hold_same(prefiltered(device, rig, target), twin(target, rig), name)


@pytest.mark.parametrize("grid", [1, 2, 5])
@pytest.mark.parametrize("name", ["coma-lenslets", "round-holes-moved", "full-leaning-walls"])
def test_forward_matches_its_twin_on_any_grid(device: Device, name: str, grid: int) -> None:
    rig, target = pass_rigs.case(name)
    rig = rig.model_copy(
        update={"prefilter": rig.prefilter.model_copy(update={"subpixel_grid": grid})}
    )
    hold_same(prefiltered(device, rig, target), twin(target, rig), f"{name}, {grid} x {grid}")


# The twin of all of a 4K panel takes too long: its widest rows and its highest columns.
@pytest.mark.parametrize(("width", "height"), [(1334, 750), (3840, 130), (90, 2160)])
def test_forward_matches_its_twin_as_far_out_as_panels_reach(
    device: Device, width: int, height: int
) -> None:
    rig = pass_rigs.rig(
        width,
        height,
        panel={"subpixels": "full", "pixel_pitch_um": 31.5},
        headset={"lens_separation_mm": 61.0, "lens_height_mm": 1.7, "eye_relief_mm": 11.0},
        array=pass_rigs.LENSLETS | {"rotation_deg": 17.3, "offset_um": [83.0, -141.0]},
        left={"pupil_offset_mm": [-1.3, 0.8], "cylinder_d": -2.0, "axis_deg": 33.0},
        prefilter={"subpixel_grid": 1},
    )
    target = pass_rigs.picture(rig)
    hold_same(prefiltered(device, rig, target), twin(target, rig), f"{width}x{height}")


@pytest.mark.parametrize("name", [n for n in pass_rigs.KNOWN if n in WITH_ARRAY])
def test_forward_matches_known_results(device: Device, name: str) -> None:
    known = pass_rigs.known_results(name)
    shown = prefiltered(device, pass_rigs.known_rig(name), known["panel"])
    error = float(np.sqrt(np.mean((shown - known["forward"]) ** 2, dtype=np.float64)))
    # The known results carry float32's rounding; the pass that of a polynomial in float32.
    print(f"{name}: {error:.1e} RMS")
    assert error <= 1e-5


@pytest.mark.parametrize(
    "name", [n for n, rig in pass_rigs.APART.items() if rig.array.kind != "none"]
)
def test_forward_matches_an_independent_tracer(device: Device, name: str) -> None:
    rig = pass_rigs.APART[name]
    target = pass_rigs.picture(rig, seed=13)
    shown, wanted = prefiltered(device, rig, target), independent_tracer.forward(target, rig)
    error = float(np.sqrt(np.mean((shown - wanted) ** 2)))
    print(f"{name}: {error:.1e} RMS")
    # The same rays on both sides; only one of them on an edge may differ, and few do.
    assert error <= 0.003


def test_same_input_gives_the_same_bytes(device: Device) -> None:
    rig, target = pass_rigs.case("coma-lenslets")
    first = prefiltered(device, rig, target).tobytes()
    assert prefiltered(device, rig, target).tobytes() == first
    with Device.headless() as other:
        assert prefiltered(other, rig, target).tobytes() == first


def test_the_middle_column_of_an_odd_width_is_dark(device: Device) -> None:
    rig, target = pass_rigs.case("bgr-walls")
    assert np.all(prefiltered(device, rig, target)[:, 22] == 0.0)


def test_a_bare_panel_has_no_tables(device: Device) -> None:
    with pytest.raises(ValueError, match="bare panel"):
        ForwardTables(device, pass_rigs.SMALL["own-lens-bare"])
