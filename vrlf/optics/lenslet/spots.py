"""Where a lenslet's rays land on the panel: spots, and the gap at which they are least."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from vrlf.errors import InputError
from vrlf.optics.lenslet.surfaces import Lens
from vrlf.optics.lenslet.trace import Beam, Rays, aperture_points, landing, trace
from vrlf.optics.polynomial import Float

# Rays along each side of the aperture: 24 and 96 give the same radius to 0.2 %.
RAYS_A_SIDE = 24


@dataclass(frozen=True)
class Spot:
    """One beam's rays on a plane.

    Attributes
    ----------
    errors_mm : ndarray (n, 2)
        Transverse errors, right and up, from their own middle; open rays only.
    middle_mm : ndarray (2,)
        Their mean place.
    transmitted : float
        Share of the aperture's rays that were not blocked.
    """

    errors_mm: Float
    middle_mm: Float
    transmitted: float

    @property
    def rms_mm(self) -> float:
        """Root of the mean square distance from the middle."""
        return float(np.sqrt(np.mean(np.sum(self.errors_mm**2, axis=1))))


def through(lens: Lens, beam: Beam, side: int = RAYS_A_SIDE) -> tuple[Rays, float]:
    """A beam's open rays behind the lens, and which share of its rays they are.

    Raises
    ------
    InputError
        If none comes through.
    """
    rays = trace(lens, beam, aperture_points(lens, side))
    kept = rays.open
    if not kept.any():
        raise InputError(
            f"lenslet: found no ray that comes through at the slope {max(beam.slope):.3g}, wanted "
            "one; a lenslet less curved or less oblique light"
        )
    open_rays = Rays(rays.points_mm[kept], rays.directions[kept], rays.path_mm[kept], kept[kept])
    return open_rays, float(kept.mean())


def spot(lens: Lens, beam: Beam, distance_mm: float, side: int = RAYS_A_SIDE) -> Spot:
    """The spot on a plane ``distance_mm`` (physical) behind the last surface."""
    rays, transmitted = through(lens, beam, side)
    points = landing(rays, distance_mm, 1.0).points_mm[:, :2]
    middle = points.mean(axis=0)
    return Spot(points - middle, middle, transmitted)


def best_distance_mm(lens: Lens, beams: Iterable[Beam], side: int = RAYS_A_SIDE) -> float:
    """Behind the last surface, where the mean of the beams' squared spot radii is least.

    Rays move evenly with the distance, so that mean is a parabola: its vertex, exactly.
    """
    together, apart = 0.0, 0.0
    for beam in beams:
        rays, _ = through(lens, beam, side)
        start = landing(rays, 0.0, 1.0).points_mm[:, :2]
        slopes = rays.directions[:, :2] / rays.directions[:, 2:]
        start, slopes = start - start.mean(axis=0), slopes - slopes.mean(axis=0)
        together += float(np.mean(np.sum(start * slopes, axis=1)))
        apart += float(np.mean(np.sum(slopes**2, axis=1)))
    if apart == 0.0:
        raise InputError("lenslet: found surfaces that focus nothing, wanted a lens")
    return -together / apart
