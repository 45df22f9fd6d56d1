"""Pixels, viewports, cells and holes, against the design's frames."""

from __future__ import annotations

from math import cos, pi, radians, sin
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from optics_by_hand import (
    PITCH_MM,
    cell_centre_mm,
    points_mm,
    rig,
    rigs,
    sides,
    unhurried,
)

from vrlf.model import Rig
from vrlf.optics.lattice import cell_coordinates, is_open, lattice_of, nearest_cell
from vrlf.optics.raster import cell_raster, cells_per_pixel, pixels_per_cell
from vrlf.optics.viewport import (
    SIDES,
    Side,
    axis_in_viewport_px,
    column_centres_mm,
    panel_points_mm,
    row_centres_mm,
    viewport,
)


def sized(width: int, height: int, **tables: dict[str, Any]) -> Rig:
    return rig(panel={"width_px": width, "height_px": height}, **tables)


HOLES = {"kind": "pinhole", "pitch_um": 390.0, "gap_mm": 6.0, "aperture_um": 120.0}


def test_pixel_centres() -> None:
    """x = (i + 1/2 - W/2) pitch, y = (H/2 - j - 1/2) pitch: row 0 is the highest."""
    even, odd = sized(4, 3), sized(5, 2)
    assert column_centres_mm(even) == pytest.approx(np.array([-1.5, -0.5, 0.5, 1.5]) * PITCH_MM)
    assert row_centres_mm(even) == pytest.approx(np.array([1.0, 0.0, -1.0]) * PITCH_MM)
    assert column_centres_mm(odd) == pytest.approx(np.array([-2, -1, 0, 1, 2]) * PITCH_MM)
    assert row_centres_mm(odd) == pytest.approx(np.array([0.5, -0.5]) * PITCH_MM)


@pytest.mark.parametrize(
    ("width", "left", "right"),
    [(96, range(48), range(48, 96)), (97, range(48), range(49, 97)), (2, [0], [1]), (3, [0], [2])],
)
def test_viewports_share_the_columns(width: int, left: range, right: range) -> None:
    """The middle column of an odd width is nobody's."""
    seen = {side: list(range(width))[viewport(sized(width, 9), side).columns] for side in SIDES}
    assert seen == {"left": list(left), "right": list(right)}
    assert viewport(sized(width, 9), "right").height_px == 9


def test_panel_points_are_relative_to_the_axis() -> None:
    """Column 3 of 7 x 5 is nobody's; the right eye's first pixel is column 4, at x = 1 pitch."""
    panel = sized(7, 5, headset={"lens_separation_mm": 0.4, "lens_height_mm": 0.05})
    points = {side: panel_points_mm(panel, viewport(panel, side)) for side in SIDES}
    assert points["right"].shape == (5, 3, 2)
    assert points["right"][0, 0] == pytest.approx([PITCH_MM - 0.2, 2 * PITCH_MM - 0.05])
    assert points["left"][4, 2] == pytest.approx([-PITCH_MM + 0.2, -2 * PITCH_MM - 0.05])


@unhurried
@given(st.integers(2, 41), st.integers(2, 41), sides, st.floats(0.0, 9.0), st.floats(-3.0, 3.0))
def test_axis_in_the_viewports_own_raster(
    width: int, height: int, side: Side, separation_mm: float, height_mm: float
) -> None:
    """The pixel (i, j) has its centre at i + 1/2, j + 1/2: from there to X and back."""
    headset = {"lens_separation_mm": separation_mm, "lens_height_mm": height_mm}
    given_rig = sized(width, height, headset=headset)
    view = viewport(given_rig, side)
    raster = axis_in_viewport_px(given_rig, view) + panel_points_mm(given_rig, view) / PITCH_MM * [
        1.0,
        -1.0,
    ]
    rows, columns = np.mgrid[0 : view.height_px, 0 : view.width_px]
    assert raster[..., 0] == pytest.approx(columns + 0.5, abs=1e-9)
    assert raster[..., 1] == pytest.approx(rows + 0.5, abs=1e-9)


def test_a_cell_stands_in_the_middle() -> None:
    lattice = lattice_of(rig(array=HOLES | {"rotation_deg": 12.0}))
    assert lattice is not None
    assert cell_coordinates(lattice, np.zeros(2)) == pytest.approx([0.0, 0.0])


def test_lattice_turns_anticlockwise_then_moves() -> None:
    """Cell (1, 0) of a 0.39 mm lattice turned by 30 degrees and moved by (0.06, -0.11) mm."""
    turned = HOLES | {"rotation_deg": 30.0, "offset_um": [60.0, -110.0]}
    lattice = lattice_of(rig(array=turned))
    assert lattice is not None
    # Anticlockwise: the right neighbour rises.
    right = np.array([0.39 * cos(radians(30)) + 0.06, 0.39 * sin(radians(30)) - 0.11])
    assert cell_coordinates(lattice, right) == pytest.approx([1.0, 0.0], abs=1e-12)
    above = np.array([-0.39 * sin(radians(30)) + 0.06, 0.39 * cos(radians(30)) - 0.11])
    assert cell_coordinates(lattice, above) == pytest.approx([0.0, 1.0], abs=1e-12)
    assert lattice.panel_from_cell @ [1.0, 0.0] + lattice.origin_mm == pytest.approx(right)


@unhurried
@given(rigs(), sides, points_mm(20.0))
def test_cells_by_hand(given_rig: Rig, side: Side, y: np.ndarray) -> None:
    lattice = lattice_of(given_rig)
    assert lattice is not None
    axis = np.array(viewport(given_rig, side).axis_mm)
    q = cell_coordinates(lattice, y + axis)
    in_cell = q - nearest_cell(lattice, q)
    # A point within rounding of a border may fall to either side.
    if np.abs(lattice.normals @ in_cell).max() < 0.5 - 1e-9:
        centre = nearest_cell(lattice, q) @ lattice.panel_from_cell.T + lattice.origin_mm - axis
        assert centre == pytest.approx(cell_centre_mm(given_rig, side, y), abs=1e-9)


def test_square_holes_turn_with_the_lattice() -> None:
    """A square of 0.12 mm: its corner at 45 degrees is farther off than its side."""
    lattice = lattice_of(rig(array=HOLES | {"rotation_deg": 45.0}))
    assert lattice is not None
    # In the turned square the panel's x axis runs along the diagonal: 0.06 sqrt(2) = 0.0849.
    points = np.array([[0.084, 0.0], [0.086, 0.0], [0.0424, 0.0424], [0.0426, 0.0426]])
    assert is_open(lattice, cell_coordinates(lattice, points)).tolist() == [
        True,
        False,
        True,
        False,
    ]


def test_round_holes_have_their_diameter() -> None:
    lattice = lattice_of(rig(array=HOLES | {"aperture_shape": "circle"}))
    assert lattice is not None
    points = np.array([[0.0599, 0.0], [0.0601, 0.0], [0.0, -0.0599], [0.045, 0.045]])
    assert is_open(lattice, cell_coordinates(lattice, points)).tolist() == [
        True,
        False,
        True,
        False,
    ]


def test_throughput() -> None:
    """(120/390)^2, pi/4 of it for circles, 1 for lenslets."""
    square = lattice_of(rig(array=HOLES))
    circle = lattice_of(rig(array=HOLES | {"aperture_shape": "circle"}))
    lenses = lattice_of(rig(array=HOLES | {"kind": "microlens", "focal_mm": 6.0}))
    assert square is not None
    assert circle is not None
    assert lenses is not None
    assert square.throughput == pytest.approx(0.0946746, abs=1e-7)
    assert circle.throughput == pytest.approx(0.0946746 * pi / 4.0, abs=1e-7)
    assert lenses.throughput == 1.0
    assert is_open(lenses, np.array([[0.5, -0.5], [0.0, 0.3]])).all()
    assert lattice_of(rig()) is None


@unhurried
@given(
    rigs(),
    st.integers(2, 33),
    st.integers(2, 33),
    st.floats(0.5, 1.5),
    points_mm(1.0),
    points_mm(1.0),
)
def test_raster_of_cells(
    given_rig: Rig,
    width: int,
    height: int,
    scale: float,
    left_mm: np.ndarray,
    right_mm: np.ndarray,
) -> None:
    """Column and row contributions add up to the cell coordinates of scale X + shift."""
    panel = given_rig.panel.model_copy(update={"width_px": width, "height_px": height})
    sized_rig = given_rig.model_copy(update={"panel": panel})
    lattice = lattice_of(sized_rig)
    assert lattice is not None
    shift: dict[Side, np.ndarray] = {"left": left_mm, "right": right_mm}
    raster = cell_raster(sized_rig, lattice, scale, shift)
    assert raster.columns.shape == (width, 4)
    assert raster.rows.shape == (height, 4)
    # What the 32-bit sums rely on: whole numbers, and rests of at most half a cell.
    for table in (raster.columns, raster.rows):
        assert np.abs(table[:, :2]).max() <= 0.5
        assert (table[:, 2:] == np.round(table[:, 2:])).all()
    q = (raster.columns[None] + raster.rows[:, None])[..., :2]
    q = q + (raster.columns[None] + raster.rows[:, None])[..., 2:]
    for side in SIDES:
        view = viewport(sized_rig, side)
        points = scale * panel_points_mm(sized_rig, view) + shift[side] + np.array(view.axis_mm)
        wanted = cell_coordinates(lattice, points)
        # A few hundred cells in float64.
        assert q[:, view.columns] == pytest.approx(wanted, abs=1e-10)


def test_a_raster_without_a_shift() -> None:
    odd = sized(7, 5, array=HOLES, headset={"lens_separation_mm": 0.3, "lens_height_mm": 0.1})
    lattice, view = lattice_of(odd), viewport(odd, "right")
    assert lattice is not None
    raster = cell_raster(odd, lattice, 1.0)
    # With scale 1 the axis drops out: pixel (6, 0) lies at (3, 2) pitches, 0.2 cells each.
    q = raster.columns[6] + raster.rows[0]
    assert q[:2] + q[2:] == pytest.approx([0.6, 0.4], abs=1e-12)
    assert view.first_column == 4


def test_steps_between_pixels_and_cells() -> None:
    """78 um pixels before a 390 um lattice turned by 90 degrees: right is minus the cell's y."""
    turned = rig(array=HOLES | {"rotation_deg": 90.0})
    lattice = lattice_of(turned)
    assert lattice is not None
    step = cells_per_pixel(turned, lattice)
    # Its columns are a pixel to the right and a pixel down, in cells.
    assert step[:, 0] == pytest.approx([0.0, -0.2], abs=1e-12)
    assert step[:, 1] == pytest.approx([-0.2, 0.0], abs=1e-12)
    assert pixels_per_cell(turned, lattice) @ step == pytest.approx(np.eye(2), abs=1e-12)
