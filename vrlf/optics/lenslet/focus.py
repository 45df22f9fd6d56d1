"""Where a lenslet's foci lie over the field: sagittal and tangential, by Coddington's equations.

Along the chief ray, with the angles of incidence I and I' and the surface's two radii there,

    sagittal    n' / s' = n / s + (n' cos I' - n cos I) / R_s
    tangential  n' cos^2 I' / t' = n cos^2 I / t + (n' cos I' - n cos I) / R_t

(Coddington 1829; Welford 1986, sec. 9.6). A conic has R_s = sqrt(R^2 - k r^2) and
R_t = R_s^3 / R^2 at the distance r from its axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from vrlf.errors import InputError
from vrlf.optics.lenslet.paraxial import cardinal
from vrlf.optics.lenslet.surfaces import Lens, Surface
from vrlf.optics.lenslet.trace import Beam, Passage, passages, vergence_per_mm
from vrlf.optics.polynomial import Float


@dataclass(frozen=True)
class Foci:
    """Foci of a beam's narrow pencil behind the last surface, along the axis; physical mm.

    Sagittal: of rays beside the chief ray's meridian; tangential: of those within it.
    """

    sagittal_mm: float
    tangential_mm: float


def foci(lens: Lens, beam: Beam) -> Foci:
    """Coddington's foci of the ray through the middle of the stop.

    Raises
    ------
    InputError
        If that ray does not come through.
    """
    sagittal = tangential = -vergence_per_mm(lens, beam)
    first = True
    for passage in passages(lens, beam, np.zeros((1, 2))):
        coming, leaving = passage.coming, passage.leaving
        if not leaving.open[0]:
            raise InputError("lenslet: found its middle ray blocked, wanted less oblique light")
        direction = coming.directions[0]
        if first:  # from the height to the way along the ray
            sagittal, tangential = sagittal * direction[2], tangential * direction[2]
            first = False
        way = float((leaving.points_mm[0] - coming.points_mm[0]) @ direction) / passage.before
        sagittal = _bent(passage, sagittal / (1.0 - sagittal * way), along=False)
        tangential = _bent(passage, tangential / (1.0 - tangential * way), along=True)
    height, forward = float(leaving.points_mm[0, 2]), float(leaving.directions[0, 2])
    ends = [
        float(height + passage.behind / each * forward) if each != 0.0 else inf
        for each in (sagittal, tangential)
    ]
    return Foci(*ends)


def _bent(passage: Passage, vergence: float, *, along: bool) -> float:
    """A pencil's vergence (index over distance) behind a surface, along its meridian or across."""
    point = passage.leaving.points_mm[0]
    across, within = _curvatures(passage.surface, float(np.hypot(point[0], point[1])))
    normal = _normal(passage.surface, point)
    cos_in = float(passage.coming.directions[0] @ normal)
    cos_out = float(passage.leaving.directions[0] @ normal)
    power = passage.behind * cos_out - passage.before * cos_in
    if not along:
        return vergence + power * across
    return (vergence * cos_in**2 + power * within) / cos_out**2


def _curvatures(surface: Surface, radius_mm: float) -> tuple[float, float]:
    """1 / R_s and 1 / R_t of a conic at a distance from its axis."""
    c = surface.curvature_per_mm
    root = float(np.sqrt(1.0 - surface.conic * (c * radius_mm) ** 2))
    return c / root, c / root**3


def _normal(surface: Surface, point: Float) -> Float:
    c = surface.curvature_per_mm
    normal = np.array([-c * point[0], -c * point[1], 1.0 - c * (1.0 + surface.conic) * point[2]])
    return np.asarray(normal / np.linalg.norm(normal))


def field_curves(
    lens: Lens, wavelength_nm: float, slopes: Sequence[float], object_mm: float = inf
) -> list[Foci]:
    """The foci over a field, for slopes upward."""
    return [foci(lens, Beam(wavelength_nm, (0.0, slope), object_mm)) for slope in slopes]


def chromatic_focus_mm(
    lens: Lens, wavelengths_nm: Sequence[float], object_mm: float = inf
) -> Float:
    """The paraxial image's distance behind the last surface for each wavelength, reduced."""
    return np.array([cardinal(lens, nm).image_mm(object_mm) for nm in wavelengths_nm])
