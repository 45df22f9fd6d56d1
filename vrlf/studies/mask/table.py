"""Lenslets as a maker's table: the surfaces in lines that begin with #, then the centres.

A rig that gives a focal length alone is made as plano-convex lenslets of acrylic, curved to the
eye: R = f (n - 1), whatever stands behind their plane backs.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Final

import numpy as np

from vrlf.errors import InputError
from vrlf.model import Rig, focal_mm
from vrlf.model.lenslet import design_index, faces
from vrlf.optics.lattice import Lattice, lattice_of
from vrlf.studies.mask.plan import Plan

_GLASS: Final = "pmma"
_LEAST_EDGE_MM: Final = 0.5


@dataclass(frozen=True)
class MadeSurface:
    """One face of a lenslet.

    Attributes
    ----------
    radius_mm : float
        Positive where its centre lies on the panel's side; 0 is plane.
    sag_mm : float
        From the middle to the cell's corner.
    thickness_mm : float or None
        To the next face.
    glass : str
        Behind it.
    index : float or None
        At the d line.
    """

    radius_mm: float
    conic: float
    sag_mm: float
    thickness_mm: float | None
    glass: str
    index: float | None


def surfaces_of(rig: Rig) -> list[MadeSurface]:
    """The faces of a rig's lenslets from the eye's side on.

    Raises
    ------
    InputError
        If a face is too strongly curved to reach the cell's corner.
    """
    lattice = lattice_of(rig)
    assert lattice is not None
    corner_mm = corner_radius_mm(lattice)
    if rig.array.lenslet is None:
        index = design_index(_GLASS)
        radius = focal_mm(rig.array) * (index - 1.0)
        sag = _sag_mm(radius, 0.0, corner_mm)
        front = MadeSurface(radius, 0.0, sag, sag + _LEAST_EDGE_MM, _GLASS, index)
        return [front, MadeSurface(0.0, 0.0, 0.0, None, "spacer", rig.array.gap_index)]
    made = []
    for face in faces(rig.array.lenslet):
        is_last = face.glass is None
        made.append(
            MadeSurface(
                face.radius_mm,
                face.conic,
                _sag_mm(face.radius_mm, face.conic, corner_mm),
                None if is_last else face.thickness_mm,
                face.glass or "spacer",
                rig.array.gap_index if face.glass is None else design_index(face.glass),
            )
        )
    return made


def corner_radius_mm(lattice: Lattice) -> float:
    """From a cell's centre to its farthest corner."""
    upright = lattice.corners @ lattice.upright_from_cell.T * lattice.pitch_mm
    return float(np.linalg.norm(upright, axis=1).max() * lattice.widest_pitch)


def _sag_mm(radius_mm: float, conic: float, height_mm: float) -> float:
    """c r^2 / (1 + sqrt(1 - (1 + k) c^2 r^2)); 0 of a plane."""
    if radius_mm == 0.0:
        return 0.0
    curvature = 1.0 / radius_mm
    under = 1.0 - (1.0 + conic) * (curvature * height_mm) ** 2
    if under < 0.0:
        raise InputError(
            f"array: found a face of {abs(radius_mm):.4g} mm radius, which ends before the cell's "
            f"corner at {height_mm:.4g} mm, wanted a longer focal length or a smaller pitch"
        )
    return curvature * height_mm**2 / (1.0 + sqrt(under))


def table_text(rig: Rig, plan: Plan) -> str:
    """The whole table as CSV."""
    array, lattice = rig.array, lattice_of(rig)
    assert lattice is not None
    lines = [f"# {note}" for note in plan.notes]
    lines.append(
        f"# focal length {focal_mm(array):.4f} mm (d line), pitch {array.pitch_um:g} um, lenslets "
        f"fill their {'hexagons' if lattice.is_hexagonal else 'squares'}: diameter "
        f"{2.0 * corner_radius_mm(lattice):.4f} mm from corner to corner"
    )
    for number, each in enumerate(surfaces_of(rig), 1):
        shape = "plane" if each.radius_mm == 0.0 else f"radius {each.radius_mm:.4f} mm"
        conic = f", conic {each.conic:g}" if each.conic else ""
        thick = "" if each.thickness_mm is None else f", then {each.thickness_mm:.4f} mm"
        index = "" if each.index is None else f" (n = {each.index:.4f})"
        lines.append(
            f"# surface {number} from the eye: {shape}{conic}, sag {each.sag_mm:.4f} mm at the "
            f"corner{thick} of {each.glass}{index}"
        )
    lines.append("column,row,x_mm,y_mm")
    rows = zip(plan.cells, plan.centres_mm, strict=True)
    lines += [f"{k},{row},{x:.5f},{y:.5f}" for (k, row), (x, y) in rows]
    return "\n".join(lines) + "\n"
