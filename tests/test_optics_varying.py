"""Lattices whose pitch varies: the law by hand, its rasters, what is refused, what is said."""

from __future__ import annotations

from typing import Any

import numpy as np
import optics_by_hand as by_hand
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from vrlf.errors import RigError
from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.inspect import inspect_rig
from vrlf.optics.lattice import (
    Lattice,
    cell_coordinates,
    cells_mm,
    grown,
    lattice_of,
    nearest_cell,
    pitches_over,
    ungrown,
)
from vrlf.optics.raster import varying_raster
from vrlf.optics.viewport import SIDES, panel_points_mm, viewport

Points = NDArray[np.float64]

# Growths of both signs, of two sizes, the middle off the panel: 60 x 30 pixels of 78 um.
ARRAY: dict[str, Any] = {
    "kind": "pinhole",
    "pitch_um": 390.0,
    "gap_mm": 6.0,
    "aperture_um": 120.0,
    "pitch_growth_per_cm2": [0.3, -0.08],
    "offset_um": [-8000.0, 7000.0],
}


def varying(**changes: Any) -> tuple[Rig, Lattice]:
    made = by_hand.rig(array=ARRAY | changes)
    lattice = lattice_of(made)
    assert lattice is not None
    return made, lattice


def centre_mm(column: float, growth_per_cm2: float) -> float:
    """The definition: t (1 + G t^2 / 3), t in cm, from the lattice's middle."""
    t_cm = column * 0.039
    return 10.0 * t_cm * (1.0 + growth_per_cm2 * t_cm**2 / 3.0)


def test_columns_and_rows_stand_where_the_definition_says() -> None:
    _, lattice = varying()
    for column, row in ((0, 0), (1, -1), (20, -17), (-31, 40)):
        x = centre_mm(column, 0.3) - 8.0
        y = centre_mm(row, -0.08) + 7.0
        assert cells_mm(lattice, np.array([column, row])) == pytest.approx([x, y], abs=1e-12)
        assert cell_coordinates(lattice, np.array([x, y])) == pytest.approx([column, row], abs=1e-9)


def test_a_cell_ends_half_way_to_the_next() -> None:
    _, lattice = varying()
    for column in (-20, 3, 25):
        border = centre_mm(column + 0.5, 0.3) - 8.0
        for side, wanted in ((-1e-6, column), (1e-6, column + 1)):
            q = cell_coordinates(lattice, np.array([border + side, 7.0]))
            assert nearest_cell(lattice, q).tolist() == [wanted, 0]


@by_hand.unhurried
@given(
    st.floats(-0.9, 0.9),
    st.floats(-60.0, 60.0),
)
def test_the_law_is_undone(strength: float, q: float) -> None:
    # Down to a tenth of the middle pitch, further than any rig may go.
    growth = np.array([strength / 60.0**2, 0.0])
    even = grown(growth, np.array([q, q]))
    assert ungrown(growth, even) == pytest.approx(np.array([q, q]), abs=1e-9)


def test_without_growth_the_lattice_is_the_old_one() -> None:
    _, plain = varying(pitch_growth_per_cm2=[0.0, 0.0])
    assert not plain.is_varying
    assert (plain.throughput, plain.least_pitch) == (plain.opening, 1.0)


@pytest.mark.parametrize("scale", [1.0, 40.0 / 46.0])
def test_a_pixels_law_is_exact(scale: float) -> None:
    """From every pixel's q on, up to five pitches on, moved for each eye by another shift."""
    made, lattice = varying()
    shift = {"left": np.array([0.11, -0.23]), "right": np.array([-0.07, 0.05])}
    raster = varying_raster(made, lattice, scale, shift)  # type: ignore[arg-type]
    c = lattice.growth / 3.0
    for number, side in enumerate(SIDES):
        view = viewport(made, side)
        columns, rows = raster.columns[view.columns], raster.rows[30 * number : 30 * number + 30]
        crossing = scale * panel_points_mm(made, view) + shift[side] + np.array(view.axis_mm)
        law = np.stack(np.broadcast_arrays(columns[None], rows[:, None]), axis=-1)
        rest, whole, a, b = np.moveaxis(law, 2, 0)
        assert np.abs(rest).max() <= 0.5
        assert rest + whole == pytest.approx(cell_coordinates(lattice, crossing), abs=1e-9)
        for d in (-5.0, -0.3, 2.0):
            even = d * (a + d * (b + d * c))
            there = cells_mm(lattice, rest + whole + d)
            assert there == pytest.approx(crossing + 0.39 * even, abs=1e-9)


def test_throughput_is_that_of_the_holes_before_the_panel() -> None:
    made, lattice = varying()
    found = inspect_rig(made)["array"]
    # Holes counted, a cut one by how much of its cell stands before the panel.
    ends = np.array([[-2.34, -1.17], [2.34, 1.17]])
    holes = np.prod(np.diff(cell_coordinates(lattice, ends), axis=0))
    assert lattice.throughput == pytest.approx(holes * 0.12**2 / (4.68 * 2.34), rel=1e-9)
    assert found["throughput"] == lattice.throughput
    assert lattice.opening == pytest.approx((0.12 / 0.39) ** 2)


def test_inspect_says_between_what_the_pitch_lies() -> None:
    made, lattice = varying()
    found = inspect_rig(made)["array"]
    # Columns from 5.66 to 10.34 mm of the middle, rows from 5.83 to 8.17 mm of it: the least
    # pitch is a row's, the widest a column's.
    ends = [cell_coordinates(lattice, np.array([x, 0.0]))[0] * 0.039 for x in (-2.34, 2.34)]
    widest = 1.0 + 0.3 * max(ends) ** 2
    row = cell_coordinates(lattice, np.array([0.0, -1.17]))[1] * 0.039
    least = 1.0 - 0.08 * row**2
    assert pitches_over(made, lattice) == pytest.approx((least, widest), rel=1e-9)
    assert found["least_pitch_um"] == pytest.approx(390.0 * least)
    assert found["widest_pitch_um"] == pytest.approx(390.0 * widest)
    even = inspect_rig(by_hand.rig(array=ARRAY | {"pitch_growth_per_cm2": [0.0, 0.0]}))["array"]
    assert (even["least_pitch_um"], even["widest_pitch_um"]) == pytest.approx((390.0, 390.0))
    assert even["eyebox_mm"] == found["eyebox_mm"]


def test_neighbouring_holes_are_a_local_pitch_apart() -> None:
    """Where light passes along a row of the array: as often as columns stand there."""
    made, lattice = varying()
    bench = bench_of(made)
    assert bench.reduced_gap_mm == 6.0
    columns = np.arange(18, 24)
    centres = np.array([cells_mm(lattice, np.array([c, 0.0]))[0] for c in columns])
    local = 1.0 + 0.3 * (columns[:-1] * 0.039 + 0.0195) ** 2
    # The mean pitch between two columns is the one half-way, to a part in a thousand of growth.
    assert np.diff(centres) == pytest.approx(0.39 * local, rel=1e-4)


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            {"rotation_deg": 3.0},
            "array.pitch_growth_per_cm2: found [0.3, -0.08], wanted [0, 0] unless the lattice is "
            "square and rotation_deg 0",
        ),
        (
            {"lattice": "hexagonal"},
            "array.pitch_growth_per_cm2: found [0.3, -0.08], wanted [0, 0] unless the lattice is "
            "square and rotation_deg 0",
        ),
        (
            {"pitch_growth_per_cm2": [-0.5, 0.0]},
            "array.pitch_growth_per_cm2: found [-0.5, 0.0], with pitches from 0 to",
        ),
        (
            {"pitch_growth_per_cm2": [0.0, 2.5]},
            "array.pitch_growth_per_cm2: found [0.0, 2.5], with pitches from 1 to",
        ),
        (
            {"aperture_um": 389.0},
            "array.aperture_um: found 389.0, wanted at most the least pitch of",
        ),
        (
            {"pitch_growth_per_cm2": [0.1]},
            "array.pitch_growth_per_cm2",
        ),
        (
            {"pitch_growth_per_cm2": [0.1, 11.0]},
            "array.pitch_growth_per_cm2",
        ),
    ],
)
def test_what_cannot_be_is_one_line(changes: dict[str, Any], line: str) -> None:
    with pytest.raises(RigError) as caught:
        varying(**changes)
    (problem,) = caught.value.problems
    print(problem)
    assert problem.startswith(line)


@pytest.mark.parametrize(
    ("tables", "line"),
    [
        (
            {"headset": {"glass": "pmma", "eye_relief_mm": 12.0}},
            "array.pitch_growth_per_cm2: found [0.3, -0.08], wanted [0, 0] beside headset.glass "
            "with an eye relief",
        ),
        (
            {"tolerance": {"array_um": 15.0}},
            "array.pitch_growth_per_cm2: found [0.3, -0.08], wanted [0, 0] beside [tolerance]",
        ),
    ],
)
def test_what_it_cannot_stand_beside_is_one_line(tables: dict[str, Any], line: str) -> None:
    with pytest.raises(RigError) as caught:
        by_hand.rig(array=ARRAY, **tables)
    (problem,) = caught.value.problems
    assert problem == line
    even = ARRAY | {"pitch_growth_per_cm2": [0.0, 0.0]}
    assert by_hand.rig(array=even, **tables).array.varies is False


def test_beside_glass_at_the_eye_it_stands() -> None:
    made = by_hand.rig(array=ARRAY, headset={"glass": "pmma"})
    assert made.array.varies


def test_without_an_array_its_growth_means_nothing() -> None:
    made = by_hand.rig(array={"kind": "none", "pitch_growth_per_cm2": [9.0, 9.0]})
    assert lattice_of(made) is None
