"""Screens that show how array, panel and lenses stand to each other, while looking through them.

*Fringes.* Light on the panel in waves that are a little shorter than the array's cells in one half
of an eye's view and a little longer in the other half: each cell shows another phase of them, and
both halves show bright and dark fringes, N cells apart. Where the lattice lies as it is thought to
lie, the fringes of both halves meet. Moved by delta, they part: by N delta to one side and N delta
to the other. A lattice that is turned tilts them against each other, one of another pitch has them
lie at different distances. The principle is that of moire verniers (Oster & Nishijima 1963; in
lithography King & Berry 1972).

*Pitch*: an outline as large as a bank card (ISO/IEC 7810, ID-1) and a ruler, to be held against.

*Separation*: a frame for both eyes, the upper line for the left eye, the lower one for the right;
where the lenses' axes stand as they are thought to, both lines fuse into one.
"""

from __future__ import annotations

from typing import Final, Literal

import numpy as np

from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.lattice import Lattice, cell_coordinates, nearest_cell
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import SIDES, Side, pitch_mm, viewport

AlignmentScreen = Literal["fringes", "fringes up", "pitch", "separation"]
ALIGNMENT_SCREENS: Final[tuple[AlignmentScreen, ...]] = (
    "fringes", "fringes up", "pitch", "separation",
)  # fmt: skip

# From fringe to fringe on the panel: a few in a viewport. Cells of 0.39 mm that are 10 um off part
# the halves' fringes by 0.8 mm.
FRINGE_MM: Final = 16.0
CARD_MM: Final = (85.60, 53.98)
CARD_LINE_MM: Final = 0.4
# Ruler: width of a tick; its length at each millimetre, at each fifth and each tenth.
TICK_MM: Final = 0.2
TICKS_MM: Final = (2.0, 3.5, 5.0)
# Separation: side of the frame and of its lines, the nonius lines' width, their ends off the axis.
FRAME_MM: Final = (14.0, 0.8)
NONIUS_MM: Final = (0.5, 1.0, 5.0)


def pupil_shift_mm(rig: Rig) -> dict[Side, Float]:
    """What a moved pupil adds to where chief rays cross the array: g o / m."""
    bench = bench_of(rig)
    scale = bench.reduced_gap_mm / bench.panel_per_slope_mm
    return {side: scale * np.asarray(getattr(rig, side).pupil_offset_mm) for side in SIDES}


def fringe_cells(rig: Rig, lattice: Lattice) -> float:
    """N, the rows of cells from fringe to fringe."""
    row_mm = lattice.pitch_mm * lattice.row_pitches
    return FRINGE_MM * bench_of(rig).array_from_panel / row_mm


def middle_cell(rig: Rig, lattice: Lattice, side: Side) -> Float:
    """The cell that the chief ray from the middle of an eye's viewport crosses; (2,)."""
    view, bench = viewport(rig, side), bench_of(rig)
    axis = np.asarray(view.axis_mm)
    columns = view.first_column + view.width_px / 2.0 - rig.panel.width_px / 2.0
    place = np.array([columns * pitch_mm(rig), 0.0])
    crossing = axis + bench.array_from_panel * (place - axis) + pupil_shift_mm(rig)[side]
    return nearest_cell(lattice, cell_coordinates(lattice, crossing))
