"""What a mask's drawing shows, in millimetres of the panel's frame: x right, y up, as worn.

One lattice stands over the whole panel, so both eyes' holes come out of one rule: cell (k, l) is
centred at ``cells_mm`` of the rig's lattice. Cells count whose opening lies within the panel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vrlf.errors import InputError
from vrlf.model import Rig
from vrlf.optics.lattice import Lattice, cell_coordinates, cells_mm, lattice_of
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import SIDES, viewport
from vrlf.units import UM_PER_MM

RULER_MM: Final = 100.0
CROSS_MM: Final = 5.0
_MARGIN_MM: Final = 15.0
_BELOW_MM: Final = 32.0
# Below the panel: the ruler, and the notes under it.
RULER_BELOW_MM: Final = 12.0
# More cells than any maker's program opens.
_MOST_CELLS: Final = 2_000_000
_ROUNDING: Final = 1e-9

Line = tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True)
class Plan:
    """A drawing.

    Attributes
    ----------
    panel_mm : (width, height)
        Its middle is the origin.
    centres_mm : ndarray (n, 2)
        Of holes or lenslets, row by row.
    cells : ndarray (n, 2)
        Their whole cell coordinates.
    diameter_mm : float or None
        Of round holes.
    outline_mm : ndarray (k, 2) or None
        Corners of a hole or lenslet from its centre, where it is not round.
    is_mask : bool
        Holes in the dark; otherwise lenslets.
    crosses : tuple of lines
        Two through each of the panel's corners.
    axes : tuple of lines
        Above and below the panel, where each eye's axis meets it.
    ruler : tuple of lines
        The first is the ruler's own, ``RULER_MM`` long; the others its marks.
    notes : tuple of str
    page_mm : (left, lower, right, upper)
    """

    panel_mm: tuple[float, float]
    centres_mm: Float
    cells: NDArray[np.int64]
    diameter_mm: float | None
    outline_mm: Float | None
    is_mask: bool
    crosses: tuple[Line, ...]
    axes: tuple[Line, ...]
    ruler: tuple[Line, ...]
    notes: tuple[str, ...]
    page_mm: tuple[float, float, float, float]


def plan_of(rig: Rig, name: str) -> Plan:
    """The drawing of a rig's array.

    Raises
    ------
    InputError
        If the rig has none, or one of too many cells.
    """
    lattice = lattice_of(rig)
    if lattice is None:
        raise InputError(f'{name}: found array.kind "none", wanted a pinhole or microlens array')
    pitch_mm = rig.panel.pixel_pitch_um / UM_PER_MM
    panel = (rig.panel.width_px * pitch_mm, rig.panel.height_px * pitch_mm)
    is_mask = lattice.kind == "pinhole"
    outline = None if lattice.round_holes else _outline(lattice)
    diameter = 2.0 * lattice.half_aperture * lattice.pitch_mm if lattice.round_holes else None
    cells, centres = _cells(lattice, panel, outline, diameter)
    half_width, half_height = panel[0] / 2.0, panel[1] / 2.0
    across = max(half_width, RULER_MM / 2.0) + _MARGIN_MM
    return Plan(
        panel_mm=panel,
        centres_mm=centres,
        cells=cells,
        diameter_mm=diameter,
        outline_mm=outline,
        is_mask=is_mask,
        crosses=_crosses(half_width, half_height),
        axes=_axes(rig, half_width, half_height),
        ruler=_ruler(-half_height - RULER_BELOW_MM),
        notes=_notes(rig, name, len(centres)),
        page_mm=(-across, -half_height - _BELOW_MM, across, half_height + _MARGIN_MM),
    )


def _outline(lattice: Lattice) -> Float:
    """Corners of a square hole or of a lenslet's cell, anticlockwise from its centre."""
    if lattice.kind == "pinhole":
        square = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
        upright = lattice.half_aperture * square
        corners = upright @ np.linalg.inv(lattice.upright_from_cell).T
    else:
        corners = lattice.corners
    mm = corners @ lattice.panel_from_cell.T
    return np.asarray(mm[np.argsort(np.arctan2(mm[:, 1], mm[:, 0]))])


def _cells(
    lattice: Lattice, panel_mm: tuple[float, float], outline: Float | None, diameter: float | None
) -> tuple[NDArray[np.int64], Float]:
    """Cells whose opening (whose centre, of lenslets) lies within the panel."""
    half = np.array(panel_mm) / 2.0
    ends = half * [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]
    q = cell_coordinates(lattice, ends)
    low, high = np.floor(q.min(axis=0)) - 1.0, np.ceil(q.max(axis=0)) + 1.0
    count = float(np.prod(high - low + 1.0))
    if count > _MOST_CELLS:
        raise InputError(
            f"array.pitch_um: found {count:.3g} cells over the panel, wanted at most "
            f"{_MOST_CELLS:.0e} in a drawing; a wider pitch or a smaller panel has fewer"
        )
    rows, columns = np.meshgrid(
        np.arange(low[1], high[1] + 1.0), np.arange(low[0], high[0] + 1.0), indexing="ij"
    )
    cells = np.stack([columns, rows], axis=-1).reshape(-1, 2)
    centres = cells_mm(lattice, cells)
    reach = np.zeros(2)
    if diameter is not None:
        reach = np.full(2, diameter / 2.0)
    elif outline is not None and lattice.kind == "pinhole":
        reach = np.abs(outline).max(axis=0)
    inside = np.all(np.abs(centres) <= half - reach + _ROUNDING, axis=1)
    return cells[inside].astype(np.int64), centres[inside]


def _crosses(half_width: float, half_height: float) -> tuple[Line, ...]:
    lines: list[Line] = []
    for x in (-half_width, half_width):
        for y in (-half_height, half_height):
            lines.append(((x - CROSS_MM, y), (x + CROSS_MM, y)))
            lines.append(((x, y - CROSS_MM), (x, y + CROSS_MM)))
    return tuple(lines)


def _axes(rig: Rig, half_width: float, half_height: float) -> tuple[Line, ...]:
    lines: list[Line] = []
    for side in SIDES:
        x, y = viewport(rig, side).axis_mm
        if abs(x) <= half_width:
            lines.append(((x, half_height + 1.0), (x, half_height + CROSS_MM)))
            lines.append(((x, -half_height - 1.0), (x, -half_height - CROSS_MM)))
        if abs(y) <= half_height:
            end = -half_width if side == "left" else half_width
            way = -1.0 if side == "left" else 1.0
            lines.append(((end + way, y), (end + way * CROSS_MM, y)))
    return tuple(lines)


def _ruler(y: float) -> tuple[Line, ...]:
    lines: list[Line] = [((-RULER_MM / 2.0, y), (RULER_MM / 2.0, y))]
    for mm in range(int(RULER_MM) + 1):
        length = 4.0 if mm % 10 == 0 else 2.5 if mm % 5 == 0 else 1.5
        x = mm - RULER_MM / 2.0
        lines.append(((x, y), (x, y - length)))
    return tuple(lines)


def _notes(rig: Rig, name: str, count: int) -> tuple[str, ...]:
    array = rig.array
    size = ""
    if array.kind == "pinhole":
        shape = "round" if array.aperture_shape == "circle" else "square"
        size = f" of {array.aperture_um:g} um, {shape}"
    kind = "holes" if array.kind == "pinhole" else "lenslets"
    return (
        "Print at 100 %, not fitted to the page. The ruler must measure 100.00 mm: check it.",
        f"{name}: {count} {kind}{size}; {array.gap_mm:g} mm (index {array.gap_index:g}) "
        "before the panel",
        f"pitch {array.pitch_um:g} um, {array.lattice}, turned {array.rotation_deg:g} degrees",
        "Seen from the eyes. The crosses lie on the corners of the panel's lit area.",
    )
