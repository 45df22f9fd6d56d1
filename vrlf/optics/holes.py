"""Points of a mask's holes; see ``vrlf/optics/quadrature.py``."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np

from vrlf.model import Rig
from vrlf.optics import sequence
from vrlf.optics.eye import EyeOptics
from vrlf.optics.lattice import Lattice, lattice_of
from vrlf.optics.maps import RayMaps, ray_maps
from vrlf.optics.polynomial import Float
from vrlf.optics.samples import MAX_POINTS
from vrlf.optics.sequence import Half, half_of

# Fewer points under each hole show their pattern; a smaller share of hits is no gain.
_FEWEST_POINTS, _LEAST_HITS = 16, 0.2


@dataclass(frozen=True)
class HoleTable:
    """Points of a hole's open area and of the retinal pixel, of one eye and colour.

    A hole whose centre lies s cells from where the pixel's ray through the pupil's centre
    crosses shows the point i from the pupil at ``pupil_from_cells @ s + in_pupil[i]``, in radii,
    and on the panel at ``centre_px + px_from_cells @ s + landing_px[i]``.

    Attributes
    ----------
    in_pupil, landing_px : ndarray (n, 2)
    centre_cells, centre_px : ndarray (2,)
        phi and psi of the pupil's centre.
    pupil_from_cells, px_from_cells : ndarray (2, 2)
    reach_cells : ndarray (2,)
        How far right and up of that crossing a hole can be seen at all.
    share : float
        Of each hit, times n: the sum over the hits over n is the light.
    """

    in_pupil: Float
    landing_px: Float
    centre_cells: Float
    centre_px: Float
    pupil_from_cells: Float
    px_from_cells: Float
    reach_cells: Float
    share: float


def hole_points(rig: Rig, lattice: Lattice, optics: EyeOptics, rays: int, half: Half) -> Float:
    """Points of a hole, in cells from its centre, and of the pixel, in pixels right and down.

    As many as let about ``rays`` rays through to a retinal pixel.

    Returns
    -------
    ndarray (n, 4)
    """
    seen = min(image_cells(rig, lattice, optics, colour) for colour in range(3))
    count = min(MAX_POINTS, ceil(rays / seen))
    square = half_of(sequence.points(count + count % 2), half)
    plain = square[:, :2]
    in_hole = sequence.to_disc(plain) if lattice.round_holes else 2.0 * plain - 1.0
    in_hole = lattice.half_aperture * in_hole @ np.linalg.inv(lattice.upright_from_cell).T
    return np.concatenate([in_hole, square[:, 2:] - 0.5], axis=1)


def image_cells(rig: Rig, lattice: Lattice, optics: EyeOptics, colour: int) -> float:
    """Area of the pupil's image at the array, in cells."""
    phi, _ = ray_maps(rig, lattice, optics, colour).linear()
    return float(np.pi * abs(np.linalg.det(phi)))


def suits_holes(rig: Rig, lattice: Lattice, optics: EyeOptics, colour: int, rays: int) -> bool:
    maps = ray_maps(rig, lattice, optics, colour)
    if not maps.is_affine:
        return False
    seen = image_cells(rig, lattice, optics, colour)
    searched = float(np.pi * np.prod(_reach_cells(maps, maps.linear()[0])))
    return seen >= _LEAST_HITS * searched and rays >= _FEWEST_POINTS * seen


def _reach_cells(maps: RayMaps, phi: Float) -> Float:
    """Half of the pupil's image, a hole's half and what half a pixel moves the crossing."""
    image = np.sqrt(np.sum(phi**2, axis=1))
    half_px = np.abs(maps.crossed_by_px(np.eye(2) / 2.0)).sum(axis=0)
    return np.asarray(image + maps.lattice.hole_reach + half_px)


def hole_table(rig: Rig, optics: EyeOptics, colour: int, points: Float) -> HoleTable:
    """The points of ``hole_points`` seen by one eye and colour."""
    lattice = lattice_of(rig)
    assert lattice is not None
    maps = ray_maps(rig, lattice, optics, colour)
    phi, psi = maps.linear()
    centre_cells, centre_px = maps(np.zeros(2))
    in_hole, within_px = points[:, :2], points[:, 2:]
    pupil_from_cells = np.asarray(np.linalg.inv(phi))
    in_pupil = (in_hole - maps.crossed_by_px(within_px)) @ pupil_from_cells.T
    return HoleTable(
        in_pupil=in_pupil,
        landing_px=in_pupil @ psi.T + maps.landed_by_px(within_px),
        centre_cells=centre_cells,
        centre_px=centre_px,
        pupil_from_cells=pupil_from_cells,
        px_from_cells=psi @ pupil_from_cells,
        reach_cells=_reach_cells(maps, phi),
        share=lattice.opening / image_cells(rig, lattice, optics, colour),
    )
