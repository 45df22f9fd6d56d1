"""A lenslet's first order: its matrix, focal length, back focus and principal planes.

Matrices act on (height, index times slope), so that their determinant is 1 (Gerrard & Burch 1975,
ch. II): a surface is [[1, 0], [-P, 1]] with P = c (n' - n), a way of t is [[1, t / n], [0, 1]].
Distances behind the lens are *reduced*, divided by the index there, as the ray equations' gap is.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from vrlf.errors import InputError
from vrlf.optics.lenslet.surfaces import AIR, Lens
from vrlf.optics.polynomial import Float

# A lens whose focus lies beyond a kilometre has none.
_LEAST_POWER_PER_MM = 1e-6


def system_matrix(lens: Lens, wavelength_nm: float, upto: int | None = None) -> Float:
    """From before the first surface to behind the last, or to just before surface ``upto``."""
    matrix, before = np.eye(2), AIR.index_at(wavelength_nm)
    last = len(lens.surfaces) - 1
    for number, surface in enumerate(lens.surfaces[:upto]):
        behind = surface.medium.index_at(wavelength_nm)
        power = surface.curvature_per_mm * (behind - before)
        matrix = np.array([[1.0, 0.0], [-power, 1.0]]) @ matrix
        if number < last:
            matrix = np.array([[1.0, surface.thickness_mm / behind], [0.0, 1.0]]) @ matrix
        before = behind
    return matrix


@dataclass(frozen=True)
class Cardinal:
    """The first order of one wavelength; millimetres.

    Attributes
    ----------
    focal_mm : float
        Effective focal length: 1 / power.
    back_focus_mm : float
        From the last surface to the focus of light from infinity, reduced.
    front_principal_mm : float
        From the first surface to the first principal plane, toward the panel.
    back_principal_mm : float
        From the last surface to the second, toward the panel, reduced.
    """

    focal_mm: float
    back_focus_mm: float
    front_principal_mm: float
    back_principal_mm: float

    def image_mm(self, object_mm: float) -> float:
        """From the last surface to the image, reduced, of an object before the first plane.

        ``object_mm`` is infinite for light from infinity, negative for light that converges to
        a point behind the lens.
        """
        vergence = 1.0 / self.focal_mm - (0.0 if object_mm == inf else 1.0 / object_mm)
        return self.back_principal_mm + (1.0 / vergence if vergence != 0.0 else inf)


def power_per_mm(lens: Lens, wavelength_nm: float) -> float:
    """1 / focal length."""
    return -float(system_matrix(lens, wavelength_nm)[1, 0])


def cardinal(lens: Lens, wavelength_nm: float) -> Cardinal:
    """Focal lengths and principal planes at one wavelength.

    Raises
    ------
    InputError
        If the lens has no focus.
    """
    (a, _), (c, d) = system_matrix(lens, wavelength_nm)
    if abs(c) < _LEAST_POWER_PER_MM:
        raise InputError("lenslet: found surfaces that focus nothing, wanted a lens")
    return Cardinal(
        focal_mm=float(-1.0 / c),
        back_focus_mm=float(-a / c),
        front_principal_mm=float((d - 1.0) / c),
        back_principal_mm=float((1.0 - a) / c),
    )
