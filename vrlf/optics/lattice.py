"""The array's lattice: cell coordinates, openings, and the areas that barriers leave.

Cell coordinates q count cells: cell (k, l) is centred at q = (k, l), and the place in a
cell is q - round(q). They are turned with the lattice, so holes are upright in them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.polynomial import Float
from vrlf.units import UM_PER_MM


@dataclass(frozen=True)
class Lattice:
    """One square lattice over the whole panel.

    Attributes
    ----------
    kind : "microlens" or "pinhole"
    cell_from_panel : ndarray (2, 2)
        Cells per millimetre, panel frame to lattice frame.
    origin_mm : ndarray (2,)
        Centre of cell (0, 0), panel frame.
    half_aperture : float
        Half a hole's side, or its radius, in cells; infinite for lenslets, which fill theirs.
    round_holes : bool
    barriers : "none", "perpendicular" or "converging"
    barrier_scale : float
        The cell that owns a panel point x is the one that holds ``barrier_scale * x``
        (relative to the axis).
    """

    kind: str
    pitch_mm: float
    cell_from_panel: Float
    origin_mm: Float
    half_aperture: float
    round_holes: bool
    barriers: str
    barrier_scale: float

    @property
    def panel_from_cell(self) -> Float:
        """Millimetres per cell, shape (2, 2)."""
        return np.asarray(np.linalg.inv(self.cell_from_panel))

    @property
    def throughput(self) -> float:
        """The open fraction of the array."""
        if np.isinf(self.half_aperture):
            return 1.0
        side = 2.0 * self.half_aperture
        return side**2 * (np.pi / 4.0 if self.round_holes else 1.0)


def lattice_of(rig: Rig) -> Lattice | None:
    """The lattice of a rig, or None for a bare panel."""
    array = rig.array
    if array.kind == "none":
        return None
    bench = bench_of(rig)
    pitch_mm = array.pitch_um / UM_PER_MM
    turn = np.radians(array.rotation_deg)
    # The inverse of an anticlockwise turn.
    upright = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    pinhole = array.kind == "pinhole"
    return Lattice(
        kind=array.kind,
        pitch_mm=pitch_mm,
        cell_from_panel=upright / pitch_mm,
        origin_mm=np.array(array.offset_um) / UM_PER_MM,
        half_aperture=array.aperture_um / array.pitch_um / 2.0 if pinhole else float("inf"),
        round_holes=pinhole and array.aperture_shape == "circle",
        barriers=array.barriers,
        barrier_scale=bench.array_from_panel if array.barriers == "converging" else 1.0,
    )


def cell_coordinates(lattice: Lattice, panel_frame_mm: Float) -> Float:
    """q of points in the panel's frame; shape (..., 2) in and out."""
    return np.asarray((panel_frame_mm - lattice.origin_mm) @ lattice.cell_from_panel.T)


def nearest_cell(q: Float) -> Float:
    """The cell that holds q; a point on a border belongs to the cell above it."""
    return np.floor(q + 0.5)


def is_open(lattice: Lattice, in_cell: Float) -> NDArray[np.bool_]:
    """Whether the array passes light at a place in its cell, q - round(q); (..., 2) -> (...)."""
    if lattice.round_holes:
        return np.asarray(np.sum(in_cell**2, axis=-1) <= lattice.half_aperture**2)
    return np.asarray(np.max(np.abs(in_cell), axis=-1) <= lattice.half_aperture)
