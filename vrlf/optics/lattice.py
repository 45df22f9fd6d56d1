"""The array's lattice: cell coordinates, openings, and the areas that barriers leave.

Cell coordinates q count cells: cell (k, l) is centred at q = (k, l), and the place p in a cell is
q - (k, l). On a square lattice they are the lattice's own upright axes, in pitches. On a hexagonal
one the second axis stands 60 degrees to the first,

    upright = S q,  S = [[1, 1/2], [0, sqrt(3)/2]],

so that whatever is linear in q is as it is on a square one, and the determinant of S is a cell's
area in square pitches. A cell holds what is nearer to its centre than to any other (Voronoi): with
a_k the upright steps to its neighbours, |a_k| = 1, that is |a_k . S p| <= 1/2. The rows of a_k S
(``normals``) are (1, 0), (0, 1) on the square lattice, and (1, 1/2), (1/2, 1), (-1/2, 1/2) on the
hexagonal one, whose cells are hexagons (Conway & Sloane 1999, chapter 4.2, the lattice A2).

A square lattice's pitch may vary along its axes. There are two measures then: *even* places n, in
pitches of its middle, in which rays are as straight as everywhere, and cell coordinates q, with

    n = q (1 + G q^2 / 3),

each axis by itself (``growth``). Elsewhere n is q.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vrlf.model import LEAST_PITCH, MOST_PITCH, Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.polynomial import Float
from vrlf.units import MM2_PER_CM2, UM_PER_MM

# Rows of a hexagonal lattice lie closer than its cells in a row.
ROW_PITCHES: Final = sqrt(3.0) / 2.0
_HEXAGON: Final = np.array([[1.0, 0.5], [0.5, 1.0], [-0.5, 0.5]])


def _upright_from_cell(is_hexagonal: bool) -> Float:
    return np.array([[1.0, 0.5], [0.0, ROW_PITCHES]]) if is_hexagonal else np.eye(2)


@dataclass(frozen=True)
class Lattice:
    """One square or hexagonal lattice over the whole panel.

    Attributes
    ----------
    kind : "microlens" or "pinhole"
    is_hexagonal : bool
    pitch_mm : float
        From a cell's centre to those of its neighbours, in the lattice's middle.
    cell_from_panel : ndarray (2, 2)
        Cells per millimetre, panel frame to even places.
    growth : ndarray (2,)
        G of both axes, per square cell; 0 where the pitch is the same everywhere.
    density : float
        Cells over the panel, by how many there would be if the pitch were the middle one.
    origin_mm : ndarray (2,)
        Centre of cell (0, 0), panel frame.
    half_aperture : float
        Half a hole's side, or its radius, in pitches; infinite for lenslets, which fill their
        cells. Square holes are upright in the lattice.
    round_holes : bool
    barriers : "none", "perpendicular" or "converging"
    barrier_scale : float
        The cell that owns a panel point x is the one that holds ``barrier_scale * x``
        (relative to the axis).
    """

    kind: str
    is_hexagonal: bool
    pitch_mm: float
    cell_from_panel: Float
    origin_mm: Float
    half_aperture: float
    round_holes: bool
    barriers: str
    barrier_scale: float
    growth: Float
    density: float

    @property
    def is_varying(self) -> bool:
        """Whether its pitch varies."""
        return bool(np.any(self.growth != 0.0))

    @property
    def least_pitch(self) -> float:
        """No pitch is narrower, in pitches of the middle."""
        return LEAST_PITCH if self.is_varying else 1.0

    @property
    def widest_pitch(self) -> float:
        """No pitch is wider, in pitches of the middle."""
        return MOST_PITCH if self.is_varying else 1.0

    @property
    def panel_from_cell(self) -> Float:
        """Millimetres per even cell, shape (2, 2)."""
        return np.asarray(np.linalg.inv(self.cell_from_panel))

    @property
    def upright_from_cell(self) -> Float:
        """S: pitches along the lattice's upright axes, per cell; shape (2, 2)."""
        return _upright_from_cell(self.is_hexagonal)

    @property
    def row_pitches(self) -> float:
        """From a row of cells to the next, in pitches; a cell's area, in square ones, too."""
        return ROW_PITCHES if self.is_hexagonal else 1.0

    @property
    def normals(self) -> Float:
        """A place p is in its cell where |n . p| <= 1/2 for all these n; shape (k, 2)."""
        return _HEXAGON if self.is_hexagonal else np.eye(2)

    @property
    def corners(self) -> Float:
        """A cell's corners, in cells from its centre; shape (k, 2)."""
        if self.is_hexagonal:
            return np.array([[1, 1], [2, -1], [-1, 2], [-1, -1], [-2, 1], [1, -2]]) / 3.0
        return np.array([[0.5, 0.5], [0.5, -0.5], [-0.5, 0.5], [-0.5, -0.5]])

    @property
    def hole_reach(self) -> Float:
        """How far a hole reaches from its centre along each cell coordinate; shape (2,)."""
        rows = np.linalg.inv(self.upright_from_cell)
        reach = np.linalg.norm(rows, axis=1) if self.round_holes else np.abs(rows).sum(axis=1)
        return np.asarray(self.half_aperture * reach)

    @property
    def throughput(self) -> float:
        """The open fraction of the array before the panel."""
        return 1.0 if np.isinf(self.half_aperture) else self.opening * self.density

    @property
    def opening(self) -> float:
        """The open fraction of a cell in the lattice's middle."""
        if np.isinf(self.half_aperture):
            return 1.0
        side = 2.0 * self.half_aperture
        return side**2 * (np.pi / 4.0 if self.round_holes else 1.0) / self.row_pitches

    def mean_borders(self, moved: Float) -> Float:
        """Borders that straight ways of this many cells meet on the average; (..., 2) -> (...).

        A hexagon's borders stand on lines half a pitch apart and cover a third of them.
        """
        met = np.abs(moved @ self.normals.T).sum(axis=-1)
        return np.asarray(2.0 / 3.0 * met if self.is_hexagonal else met)

    def most_borders(self, moved: Float) -> Float:
        """The most that a straight way can meet, less those of its two ends; (..., 2) -> (...).

        Each border is a step to a neighbour; on a hexagonal lattice that leads at least half a
        pitch on along the neighbour's direction that the way is nearest to.
        """
        if self.is_hexagonal:
            return np.asarray(2.0 * np.abs(moved @ self.normals.T).max(axis=-1))
        return self.mean_borders(moved) / self.least_pitch


def lattice_of(rig: Rig) -> Lattice | None:
    """The lattice of a rig, or None for a bare panel."""
    array = rig.array
    if array.kind == "none":
        return None
    bench = bench_of(rig)
    pitch_mm = array.pitch_um / UM_PER_MM
    turn = np.radians(array.rotation_deg)
    is_hexagonal = array.lattice == "hexagonal"
    # The inverse of an anticlockwise turn.
    upright = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    pinhole = array.kind == "pinhole"
    growth = np.array(array.pitch_growth_per_cm2) / MM2_PER_CM2 * pitch_mm**2
    return Lattice(
        kind=array.kind,
        is_hexagonal=is_hexagonal,
        pitch_mm=pitch_mm,
        cell_from_panel=np.linalg.inv(_upright_from_cell(is_hexagonal)) @ upright / pitch_mm,
        origin_mm=np.array(array.offset_um) / UM_PER_MM,
        half_aperture=array.aperture_um / array.pitch_um / 2.0 if pinhole else float("inf"),
        round_holes=pinhole and array.aperture_shape == "circle",
        barriers=array.barriers,
        barrier_scale=bench.array_from_panel if array.barriers == "converging" else 1.0,
        growth=growth,
        density=_density(rig, growth),
    )


def _density(rig: Rig, growth: Float) -> float:
    """Mean over the panel: how many cells there are along it, each way."""
    if not np.any(growth):
        return 1.0
    ends = _ends(rig)
    counts = np.diff(ungrown(growth, ends), axis=0) / np.diff(ends, axis=0)
    return float(np.prod(counts))


def _ends(rig: Rig) -> Float:
    """The panel's ends as even places: left and lower, right and upper; (2, 2)."""
    sizes = np.array([rig.panel.width_px, rig.panel.height_px]) * rig.panel.pixel_pitch_um
    from_middle_um = np.array([[-0.5], [0.5]]) * sizes - np.array(rig.array.offset_um)
    return np.asarray(from_middle_um / rig.array.pitch_um)


def pitches_over(rig: Rig, lattice: Lattice) -> tuple[float, float]:
    """The least and the widest pitch over the panel, in those of the lattice's middle."""
    if not lattice.is_varying:
        return 1.0, 1.0
    q = ungrown(lattice.growth, _ends(rig))
    nearest = np.clip(0.0, q[0], q[1])
    pitches = 1.0 + lattice.growth * np.stack([q[0], nearest, q[1]]) ** 2
    return float(pitches.min()), float(pitches.max())


def grown(growth: Float, q: Float) -> Float:
    """Even places n of cell coordinates q; (..., 2) each."""
    return np.asarray(q * (1.0 + growth * q**2 / 3.0))


def ungrown(growth: Float, n: Float) -> Float:
    """Cell coordinates of even places, by Newton's steps, that never pass the root.

    Where a pitch would be less than a tenth (far beside any panel), whatever they come to.
    """
    q = n
    for _ in range(12):
        q = q - (grown(growth, q) - n) / np.maximum(1.0 + growth * q**2, 0.1)
    return np.asarray(q)


def cell_coordinates(lattice: Lattice, panel_frame_mm: Float) -> Float:
    """q of points in the panel's frame; shape (..., 2) in and out."""
    even = np.asarray((panel_frame_mm - lattice.origin_mm) @ lattice.cell_from_panel.T)
    return ungrown(lattice.growth, even) if lattice.is_varying else even


def cells_mm(lattice: Lattice, q: Float) -> Float:
    """The reverse: points in the panel's frame of cell coordinates."""
    even = grown(lattice.growth, q) if lattice.is_varying else q
    return np.asarray(even @ lattice.panel_from_cell.T + lattice.origin_mm)


def nearest_cell(lattice: Lattice, q: Float) -> Float:
    """The cell that holds q; a point on a border belongs to the cell above it.

    On a hexagonal lattice the nearest whole numbers are that cell or a neighbour, across the
    border of the coordinate that is farther off: where p = q - floor(q + 1/2) has coordinates of
    unlike signs no n . p passes 1/2, and where they are alike the larger one's is the larger.
    Borders belong to one cell each, the same wherever it stands.
    """
    square = np.floor(q + 0.5)
    if not lattice.is_hexagonal:
        return square
    p = q - square
    first = (np.abs(p[..., 0]) >= np.abs(p[..., 1]))[..., None]
    axis = np.where(first, [1.0, 0.0], [0.0, 1.0])
    across = np.sum(axis * (p @ _HEXAGON[:2].T), axis=-1, keepdims=True)
    return np.asarray(square + axis * np.floor(across + 0.5))


def is_open(lattice: Lattice, in_cell: Float) -> NDArray[np.bool_]:
    """Whether the array passes light at an even place from its cell's centre; (..., 2) -> (...)."""
    upright = in_cell @ lattice.upright_from_cell.T
    if lattice.round_holes:
        return np.asarray(np.sum(upright**2, axis=-1) <= lattice.half_aperture**2)
    return np.asarray(np.max(np.abs(upright), axis=-1) <= lattice.half_aperture)
