"""Float64 twin of ``shaders/alignment.comp``: screens for aligning array, panel and lenses."""

from __future__ import annotations

from math import ceil, floor

import numpy as np

from vrlf.model import Rig
from vrlf.optics.alignment import (
    CARD_LINE_MM,
    CARD_MM,
    FRAME_MM,
    NONIUS_MM,
    TICK_MM,
    TICKS_MM,
    fringe_cells,
    middle_cell,
    pupil_shift_mm,
)
from vrlf.optics.bench import bench_of
from vrlf.optics.lattice import Lattice, cell_coordinates, lattice_of
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import (
    SIDES,
    Side,
    column_centres_mm,
    pitch_mm,
    row_centres_mm,
    viewport,
)


def crossings(rig: Rig, lattice: Lattice, side: Side) -> Float:
    """Cell coordinates at which an eye's chief rays cross the array, (H, w, 2)."""
    view = viewport(rig, side)
    x, y = column_centres_mm(rig)[view.columns], row_centres_mm(rig)
    place = np.stack(np.meshgrid(x, y), axis=-1)
    axis = np.asarray(view.axis_mm)
    crossing = axis + bench_of(rig).array_from_panel * (place - axis) + pupil_shift_mm(rig)[side]
    return cell_coordinates(lattice, crossing)


def fringes(rig: Rig, axis: int) -> Float:
    """Fringes along the lattice's first (0) or second (1) axis; (H, W, 3), green alone."""
    lattice = lattice_of(rig)
    assert lattice is not None
    panel = np.zeros((rig.panel.height_px, rig.panel.width_px, 3))
    for side in SIDES:
        view = viewport(rig, side)
        q = crossings(rig, lattice, side)[..., axis]
        first = np.zeros(q.shape, np.bool_)
        if axis == 0:
            first[: view.height_px // 2] = True
        else:
            first[:, : view.width_px // 2] = True
        from_middle = q - middle_cell(rig, lattice, side)[axis]
        phase = q + np.where(first, 1.0, -1.0) * from_middle / fringe_cells(rig, lattice)
        panel[:, view.columns, 1] = 0.5 + 0.5 * np.cos(2.0 * np.pi * phase)
    return panel


def pitch_screen(rig: Rig) -> Float:
    """A bank card's outline and a ruler about the panel's middle; (H, W, 3)."""
    columns, rows = _edges(rig, (0.0, 0.0))
    card = _outline(columns, rows, CARD_MM, CARD_LINE_MM)
    light = card + _ruler(columns, rows)
    return np.repeat(np.clip(light, 0.0, 1.0)[..., None], 3, axis=2)


def separation_screen(rig: Rig) -> Float:
    """A frame for both eyes, the upper line for the left one, the lower for the right."""
    panel = np.zeros((rig.panel.height_px, rig.panel.width_px, 3))
    width, low, high = NONIUS_MM
    for side in SIDES:
        view = viewport(rig, side)
        columns, rows = _edges(rig, view.axis_mm)
        frame = _outline(columns, rows, (FRAME_MM[0], FRAME_MM[0]), FRAME_MM[1])
        span = (low, high) if side == "left" else (-high, -low)
        line = np.outer(_share(rows, *span), _share(columns, -width / 2, width / 2))
        panel[:, view.columns] = (frame + line)[:, view.columns, None]
    return panel


def _edges(rig: Rig, origin_mm: tuple[float, float]) -> tuple[Float, Float]:
    """Lower ends and upper ends of the pixels' intervals, right and up; (W, 2) and (H, 2)."""
    half = pitch_mm(rig) / 2.0
    x, y = column_centres_mm(rig) - origin_mm[0], row_centres_mm(rig) - origin_mm[1]
    return np.stack([x - half, x + half], -1), np.stack([y - half, y + half], -1)


def _share(edges: Float, low: float, high: float) -> Float:
    overlap = np.minimum(edges[:, 1], high) - np.maximum(edges[:, 0], low)
    return np.asarray(np.maximum(overlap, 0.0) / (edges[:, 1] - edges[:, 0]))


def _box(columns: Float, rows: Float, side: tuple[float, float]) -> Float:
    return np.outer(
        _share(rows, -side[1] / 2, side[1] / 2), _share(columns, -side[0] / 2, side[0] / 2)
    )


def _outline(columns: Float, rows: Float, side: tuple[float, float], line: float) -> Float:
    inner = (side[0] - 2 * line, side[1] - 2 * line)
    return _box(columns, rows, side) - _box(columns, rows, inner)


def _ruler(columns: Float, rows: Float) -> Float:
    total = np.zeros((len(rows), len(columns)))
    for k in range(floor(columns.min()) - 1, ceil(columns.max()) + 2):
        length = TICKS_MM[2] if k % 10 == 0 else TICKS_MM[1] if k % 5 == 0 else TICKS_MM[0]
        tick = _share(columns, k - TICK_MM / 2, k + TICK_MM / 2)
        total += np.outer(_share(rows, -length, 0.0), tick)
    return total
