"""Alignment screens: the twin's light, true sizes, and what an eye sees of a misplaced array."""

from __future__ import annotations

from typing import Any

import numpy as np
import pass_rigs
import pytest
from numpy.typing import NDArray

from vrlf.app.preview.steps import altered, nudged
from vrlf.errors import InputError
from vrlf.gpu import Device, Texture
from vrlf.model import Rig, load_rig
from vrlf.optics.alignment import (
    ALIGNMENT_SCREENS,
    CARD_MM,
    AlignmentScreen,
    fringe_cells,
    middle_cell,
)
from vrlf.optics.lattice import lattice_of
from vrlf.optics.viewport import SIDES, viewport
from vrlf.passes.alignment import Alignment
from vrlf.reference import alignment as twin
from vrlf.renderer import GpuRenderer

# Odd, turned, moved, a moved pupil, axes off the viewports' middles.
SKEW = load_rig(
    "matched-full",
    overrides=[
        "panel.width_px=301",
        "panel.height_px=117",
        "array.rotation_deg=17",
        "array.offset_um=[103, -58]",
        "left.pupil_offset_mm=[0.7, -0.4]",
        "headset.lens_separation_mm=11",
        "headset.lens_height_mm=0.9",
    ],
)


def screen(device: Device, rig: Rig, which: AlignmentScreen) -> NDArray[np.float32]:
    """A screen's light."""
    made = Alignment(device)
    panel = Texture(device, (rig.panel.width_px, rig.panel.height_px), label="panel")
    panel.write(np.full((rig.panel.height_px, rig.panel.width_px, 4), 9.0, np.float32))
    try:
        made.run(rig, which, panel)
        return np.ascontiguousarray(panel.read()[..., :3], np.float32)
    finally:
        made.release()
        panel.release()


def by_twin(rig: Rig, which: AlignmentScreen) -> NDArray[Any]:
    if which == "pitch":
        return twin.pitch_screen(rig)
    if which == "separation":
        return twin.separation_screen(rig)
    return twin.fringes(rig, 0 if which == "fringes" else 1)


@pytest.mark.parametrize("which", ALIGNMENT_SCREENS)
def test_a_screen_is_the_twins(device: Device, which: AlignmentScreen) -> None:
    rigs = [SKEW, pass_rigs.SMALL["round-holes-moved"]]
    rigs.append(altered(SKEW, {"array": {"lattice": "hexagonal"}}))
    growing = {"rotation_deg": 0.0, "pitch_growth_per_cm2": [0.3, -0.05]}
    rigs.append(altered(SKEW, {"array": growing}))
    if which in ("pitch", "separation"):
        rigs.append(load_rig("bare", overrides=["panel.width_px=233", "panel.pixel_pitch_um=1500"]))
    for rig in rigs:
        # The phase's waves: 32 bits leave 1e-6 of a cell, 6e-6 of light at the steepest.
        np.testing.assert_allclose(screen(device, rig, which), by_twin(rig, which), atol=3e-5)


def test_the_card_is_as_large_as_a_card(device: Device) -> None:
    rig = load_rig("bare", overrides=["panel.pixel_pitch_um=78.4"])
    light = screen(device, rig, "pitch")[..., 0]
    column = light[rig.panel.height_px // 2 + 200]
    row = light[:, 3 + rig.panel.width_px // 2]
    for line, wanted_mm in ((column, CARD_MM[0]), (row[:250], None)):
        lit = np.nonzero(line > 0)[0]
        if wanted_mm is not None:
            width_px = lit[-1] - lit[0] - 1 + line[lit[0]] + line[lit[-1]]
            assert width_px * 0.0784 == pytest.approx(wanted_mm, abs=1e-3)
    top = np.nonzero(row > 0)[0][0]
    above_px = rig.panel.height_px / 2 - top - 1 + row[top]
    assert above_px * 0.0784 == pytest.approx(CARD_MM[1] / 2, abs=1e-3)
    # Ticks a millimetre apart: ten longer ones in ten centimetres are a centimetre apart.
    beside = int(40.5 / 0.0784)
    ruler = light[int(rig.panel.height_px / 2 + 4.5 / 0.0784)][667 - beside : 667 + beside]
    middles = np.nonzero((ruler[1:-1] >= ruler[:-2]) & (ruler[1:-1] > ruler[2:]))[0] + 1.5
    np.testing.assert_allclose(np.diff(middles) * 0.0784, 10.0, atol=0.08)


def test_the_lines_of_both_eyes_stand_on_their_axes(device: Device) -> None:
    rig = load_rig("bare", overrides=["headset.lens_separation_mm=61", "headset.lens_height_mm=2"])
    light = screen(device, rig, "separation")[..., 1]
    pitch_mm, middle = 0.078, np.array([rig.panel.width_px, rig.panel.height_px]) / 2
    for side, sign, up in (("left", -1, 1), ("right", 1, -1)):
        axis = middle + np.array([sign * 30.5, -2.0]) / pitch_mm
        box = light[
            int(axis[1] - 6 / pitch_mm) : int(axis[1] + 6 / pitch_mm),
            int(axis[0] - 5 / pitch_mm) : int(axis[0] + 5 / pitch_mm),
        ]
        rows, columns = np.nonzero(box > 0.5)
        assert columns.mean() + 0.5 + int(axis[0] - 5 / pitch_mm) == pytest.approx(axis[0], abs=0.6)
        above = axis[1] - (rows.mean() + 0.5 + int(axis[1] - 6 / pitch_mm))
        assert above * pitch_mm == pytest.approx(3.0 * up, abs=0.05), side


def fringe_phases_um(assumed: Rig, seen: NDArray[Any], side: Any, axis: int) -> tuple[float, float]:
    """Where both halves' fringes lie, as the array's displacement that either tells."""
    lattice = lattice_of(assumed)
    assert lattice is not None
    view = viewport(assumed, side)
    q = twin.crossings(assumed, lattice, side)[..., axis]
    from_middle = q - middle_cell(assumed, lattice, side)[axis]
    light = seen[:, view.columns, 1].astype(np.float64)
    half = (view.height_px if axis == 0 else view.width_px) // 2
    ends = []
    for sign, part in ((1.0, slice(0, half)), (-1.0, slice(-half, None))):
        piece = np.s_[part, :] if axis == 0 else np.s_[:, part]
        here, where = light[piece], from_middle[piece]
        window = np.outer(np.hanning(here.shape[0]), np.hanning(here.shape[1]))
        mean = (window * here).sum() / window.sum()
        wave = np.exp(-2j * np.pi * sign * where / fringe_cells(assumed, lattice))
        ends.append(float(np.angle((window * (here - mean) * wave).sum()) / (2.0 * np.pi)))
    return ends[0] * assumed.array.pitch_um, ends[1] * assumed.array.pitch_um


@pytest.fixture(scope="module")
def renderer() -> Any:
    with GpuRenderer() as made:
        yield made


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize(
    ("moved_um", "cells"), [(0.0, "square"), (2.0, "square"), (-10.0, "square"), (7.0, "hexagonal")]
)
def test_a_displaced_array_parts_the_fringes(
    renderer: GpuRenderer, axis: int, moved_um: float, cells: str
) -> None:
    """The screen is drawn for the array as it is thought to be, and seen through the true one.

    Both halves tell the displacement, but with fringes that run opposite ways: that they meet at
    no other place than the true one.
    """
    assumed = load_rig("matched-microlens", overrides=[f"array.lattice={cells}"])
    # The second axis of hexagons stands 60 degrees to the first.
    turn = np.radians(assumed.array.rotation_deg + axis * (90.0 if cells == "square" else 60.0))
    along = np.array([np.cos(turn), np.sin(turn)])
    offset = np.asarray(assumed.array.offset_um) + moved_um * np.asarray(along)
    true = altered(assumed, {"array": {"offset_um": offset.tolist()}})
    renderer.device.make_current()
    shown = screen(renderer.device, assumed, "fringes" if axis == 0 else "fringes up")
    seen = renderer.perceive(shown, true, rays=64)
    for side in SIDES:
        for told_um in fringe_phases_um(assumed, seen, side, axis):
            # A tenth of a pixel of 78 um is 8 um: the verniers tell far less than that.
            assert told_um == pytest.approx(moved_um, abs=0.6)


def test_a_turned_array_tilts_the_fringes(renderer: GpuRenderer) -> None:
    """Turned by 0.05 degrees: fringes that met over the whole height part at its ends."""
    assumed = load_rig("matched-microlens")
    true = nudged(assumed, "align_turn", 5.0, fine=True)
    renderer.device.make_current()
    shown = screen(renderer.device, assumed, "fringes")
    parted = []
    for rig in (assumed, true):
        seen = renderer.perceive(shown, rig, rays=64)
        upper, lower = fringe_phases_um(assumed, seen, "left", 0)
        parted.append(upper - lower)
    # The halves' middles are some 15 mm above and below the panel's: 0.05 degrees of 29 mm.
    assert abs(parted[1] - parted[0]) > 15.0
    assert abs(parted[0]) < 1.0


def test_without_an_array_there_are_no_fringes(device: Device) -> None:
    with pytest.raises(InputError, match="found no array"):
        screen(device, load_rig("bare"), "fringes")
    assert screen(device, load_rig("bare"), "separation").any()
