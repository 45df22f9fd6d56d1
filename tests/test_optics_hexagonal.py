"""Hexagonal lattices: cells by brute force, borders, corners, holes; the shaders' own cells."""

from __future__ import annotations

from math import cos, pi, radians, sin, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import optics_by_hand as by_hand
import pass_rigs
import pytest
from numpy.typing import NDArray

from vrlf.gpu import Block, Buffer, ComputePass, Device, Field, compute
from vrlf.model import Rig
from vrlf.optics.inspect import inspect_rig
from vrlf.optics.lattice import Lattice, cell_coordinates, is_open, lattice_of, nearest_cell
from vrlf.passes.fields import LATTICE_FIELDS, VIEWPORT_FIELDS, lattice_values, viewport_values
from vrlf.renderer import GpuRenderer, bare_rig
from vrlf.resources import shaders_dir

Points = NDArray[np.float64]

HOLES = {
    "kind": "pinhole",
    "lattice": "hexagonal",
    "pitch_um": 390.0,
    "gap_mm": 6.0,
    "aperture_um": 120.0,
    "rotation_deg": 13.0,
    "offset_um": [60.0, -110.0],
}


def hexagonal(**changes: Any) -> tuple[Rig, Lattice]:
    given = by_hand.rig(array=HOLES | changes)
    lattice = lattice_of(given)
    assert lattice is not None
    return given, lattice


def test_neighbours_stand_60_degrees_apart() -> None:
    """Anticlockwise from the turned first axis, each a pitch off."""
    _, lattice = hexagonal()
    steps = [(1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)]
    for number, cell in enumerate(steps):
        angle = radians(13.0 + 60.0 * number)
        centre = np.array([0.06, -0.11]) + 0.39 * np.array([cos(angle), sin(angle)])
        assert cell_coordinates(lattice, centre) == pytest.approx(cell, abs=1e-12)
        assert lattice.panel_from_cell @ cell + lattice.origin_mm == pytest.approx(centre)


def test_a_cell_holds_what_is_nearest_to_its_centre() -> None:
    given, lattice = hexagonal()
    y = 40.0 * np.random.default_rng(3).random((20_000, 2)) - 20.0
    axis = by_hand.axis_mm(given, "left")
    cell = nearest_cell(lattice, cell_coordinates(lattice, y + axis))
    centre = cell @ lattice.panel_from_cell.T + lattice.origin_mm - axis
    assert centre == pytest.approx(by_hand.cell_centre_mm(given, "left", y), abs=1e-9)
    # Within all three pairs of borders, and no corner nearer to the centre than another.
    p = cell_coordinates(lattice, y + axis) - cell
    assert np.abs(p @ lattice.normals.T).max() <= 0.5 + 1e-12
    corners = lattice.corners @ lattice.upright_from_cell.T
    assert np.hypot(*corners.T) == pytest.approx(np.full(6, 1.0 / sqrt(3.0)))


# Sixteenths of a cell: floats hold them exactly, so that borders and corners of squares are met,
# and of hexagons all borders.
TIES = np.stack(np.meshgrid(np.arange(-40, 41), np.arange(-40, 41)), -1).reshape(-1, 2) / 16.0


def test_a_border_belongs_to_one_cell_wherever_it_stands() -> None:
    _, lattice = hexagonal()
    cell = nearest_cell(lattice, TIES)
    p = TIES - cell
    on_border = np.abs(p @ lattice.normals.T).max(axis=1) == 0.5
    assert on_border.sum() > 300
    assert np.abs(p @ lattice.normals.T).max() == 0.5
    # Moved by whole cells, the same place of the same cell.
    for moved in ([1.0, 0.0], [0.0, -3.0], [7.0, 5.0]):
        assert np.array_equal(nearest_cell(lattice, TIES + moved), cell + moved)
    # Of the first two pairs the border belongs to the cell beyond, of the third to the upper one,
    # as far as its middle; beyond that to the one at the right.
    right = np.array([[0.5, 0.0], [0.0, 0.5], [-0.5, 0.0], [0.0, -0.5]])
    assert nearest_cell(lattice, right).tolist() == [[1, 0], [0, 1], [0, 0], [0, 0]]
    assert nearest_cell(lattice, np.array([[-0.4, 0.6], [-0.6, 0.4]])).tolist() == [[-1, 1], [0, 0]]


PROBE = Block("Probe", (*VIEWPORT_FIELDS, *LATTICE_FIELDS, Field("int", "count", "places")))
SHADER = """#include "block/Probe"
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Places { vec4 places[]; };
#include "include/lattice.glsl"
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(count)) return;
    vec2 cell = nearest_cell(places[i].xy);
    places[i].zw = vec2(cell.x + 100.0 * cell.y, is_open(places[i].xy - cell) ? 1.0 : 0.0);
}
"""


@pytest.mark.parametrize("shape", ["square", "circle"])
@pytest.mark.parametrize("cells", ["square", "hexagonal"])
def test_the_shaders_find_the_same_cells(
    device: Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cells: str, shape: str
) -> None:
    """Borders too: there both must decide alike, or a pixel would be its neighbour's."""
    (tmp_path / "include").symlink_to(shaders_dir() / "include")
    (tmp_path / "probe.comp").write_text(SHADER, encoding="utf-8")
    monkeypatch.setattr(compute, "shaders_dir", lambda: tmp_path)
    given, lattice = hexagonal(lattice=cells, aperture_shape=shape)
    anywhere = np.random.default_rng(8).random((4000, 2)).astype(np.float32) * 9.0 - 4.0
    places = np.concatenate([TIES, anywhere]).astype(np.float32)
    probe = ComputePass(
        device, "probe.comp", PROBE, defines={"HEXAGONAL": int(cells == "hexagonal")}
    )
    buffer = Buffer(device, np.pad(places, ((0, 0), (0, 2))), label="places")
    try:
        values = {**viewport_values(given), **lattice_values(given, lattice)}
        probe.set(values | {"count": len(places)})
        buffer.bind(0)
        probe.run_linear(len(places), 64)
        got = buffer.read(np.float32).reshape(-1, 4)
    finally:
        buffer.release()
        probe.release()
    exact = places.astype(np.float64)
    cell = nearest_cell(lattice, exact)
    assert np.array_equal(got[:, 2], cell[:, 0] + 100.0 * cell[:, 1])
    assert np.array_equal(got[:, 3] == 1.0, is_open(lattice, exact - cell))


@pytest.mark.parametrize("shape", ["square", "circle"])
def test_holes_are_upright_and_reach_as_far_as_they_say(shape: str) -> None:
    """A tenth of a millimetre off along the turned axes, and all the way to their corners."""
    given, lattice = hexagonal(aperture_shape=shape)
    turn = radians(13.0)
    axes = np.array([[cos(turn), sin(turn)], [-sin(turn), cos(turn)]])
    upright = 0.3 * np.random.default_rng(5).random((40_000, 2)) - 0.15
    q = cell_coordinates(lattice, upright @ axes + lattice.origin_mm)
    wide = np.hypot(*upright.T) if shape == "circle" else np.abs(upright).max(axis=1)
    assert np.array_equal(is_open(lattice, q), wide <= 0.06)
    reach = np.abs(q[wide <= 0.06]).max(axis=0)
    assert np.all(reach <= lattice.hole_reach)
    # 40,000 points come within a hundredth of a hole's corner.
    assert reach == pytest.approx(lattice.hole_reach, rel=0.02)
    cell_mm2 = 0.39**2 * sqrt(3.0) / 2.0
    area_mm2 = pi * 0.06**2 if shape == "circle" else 0.12**2
    assert lattice.throughput == pytest.approx(area_mm2 / cell_mm2, rel=1e-12)
    assert inspect_rig(given)["array"]["throughput"] == lattice.throughput


def test_inspect_says_what_hexagons_change() -> None:
    """Rows root 3 / 2 of a pitch apart: Petersen & Middleton 1962; all else counts in pitches."""
    numbers = [
        inspect_rig(by_hand.rig(array=HOLES | {"lattice": each}))["array"]
        for each in ("square", "hexagonal")
    ]
    square, hexagons = numbers
    assert (square["lattice"], hexagons["lattice"]) == ("square", "hexagonal")
    assert hexagons["spatial_nyquist_per_mm"] == pytest.approx(1.0 / (sqrt(3.0) * 0.39))
    assert hexagons["throughput"] == pytest.approx(square["throughput"] * 2.0 / sqrt(3.0))
    changed = {"lattice", "throughput", "spatial_nyquist_per_mm"}
    assert {key for key in square if square[key] != hexagons[key]} == changed
    assert inspect_rig(by_hand.rig())["array"]["lattice"] is None


def test_a_pupil_sees_more_hexagons_at_once() -> None:
    """Of 4 mm before an eyebox of 2.99 mm: two neighbours of a square lattice, three of this one.

    Three hexagons about a corner stand 2.99 / root 3 = 1.73 mm from it; four squares 2.11 mm.
    """
    for cells, count in (("square", 2), ("hexagonal", 3)):
        eye = {"vertex_mm": 0.0, "pupil_mm": 4.0}
        given = by_hand.rig(array=HOLES | {"lattice": cells}, left=eye, right=eye)
        said = [each for each in inspect_rig(given)["warnings"] if "openings at once" in each]
        assert len(said) == 1
        assert f"through up to {count} openings at once" in said[0]


@pytest.mark.parametrize("cells", ["square", "hexagonal"])
def test_what_forward_shows_is_perceived(cells: str) -> None:
    """Bars before eyes of -5 D, whose pupil of 5 mm is narrower than the eyebox of 5.98 mm."""
    eye = {"vertex_mm": 0.0, "sphere_d": -5.0, "pupil_mm": 5.0}
    array = pass_rigs.LENSLETS | {"lattice": cells, "rotation_deg": 23.0}
    given = pass_rigs.rig(160, 80, array=array, left=eye, right=eye, panel={"subpixels": "full"})
    target = np.zeros((80, 160, 3), np.float32)
    target[:] = 0.5 + 0.4 * np.sin(np.arange(160) * 2.0 * pi / 12.0)[None, :, None]
    inner = np.s_[20:-20, 20:60]
    errors = {}
    with GpuRenderer() as renderer:
        for method, rig in (("none", bare_rig(given)), ("forward", given)):
            shown = renderer.prefilter(target, rig)
            seen = renderer.perceive(shown, rig, rays=256)[inner]
            gain = float(np.sum(seen * target[inner]) / np.sum(seen**2))
            errors[method] = float(np.sqrt(np.mean((gain * seen - target[inner]) ** 2)))
    print(cells, errors)
    # Measured 0.289 bare, where bars 12 pixels apart blur over 15, 0.084 through squares, 0.068
    # through hexagons.
    assert errors["none"] > 0.25
    assert errors["forward"] < errors["none"] / 3.0
