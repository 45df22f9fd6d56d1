"""A lenslet as a row of surfaces: spheres, conics and planes, and what is between them.

Light is followed from the eye toward the panel, along z. A radius is positive where the surface's
centre lies on the panel's side, 0 for a plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from vrlf.errors import InputError
from vrlf.optics.glass import cauchy_index, index_at

Facing = Literal["eye", "panel"]


@dataclass(frozen=True)
class Medium:
    """What light goes through: a glass of assets/glasses.toml, or an index and an Abbe number."""

    glass: str | None = None
    index: float = 1.0
    abbe: float | None = None

    def index_at(self, wavelength_nm: float) -> float:
        """Refractive index."""
        if self.glass is not None:
            return index_at(self.glass, wavelength_nm)
        return cauchy_index(self.index, self.abbe, wavelength_nm)

    @property
    def name(self) -> str:
        """As people write it."""
        if self.glass is not None:
            return self.glass
        return f"{self.index:g}" if self.abbe is None else f"{self.index:g}/{self.abbe:g}"


AIR = Medium()


@dataclass(frozen=True)
class Surface:
    """One refracting surface and what follows it.

    Attributes
    ----------
    curvature_per_mm : float
        1 / radius; 0 for a plane.
    medium : Medium
        Behind it, toward the panel.
    thickness_mm : float
        Along the axis to the next surface; of the last one it means nothing.
    conic : float
        0 for a sphere, -1 a parabola: sag = c r^2 / (1 + sqrt(1 - (1 + k) c^2 r^2)).
    """

    curvature_per_mm: float
    medium: Medium
    thickness_mm: float = 0.0
    conic: float = 0.0

    def sag_mm(self, radius_mm: float) -> float:
        """Height over the vertex's plane, toward the panel, at a distance from the axis.

        Raises
        ------
        InputError
            If the surface ends before that.
        """
        root = 1.0 - (1.0 + self.conic) * (self.curvature_per_mm * radius_mm) ** 2
        if root <= 0.0:
            raise InputError(
                f"lenslet: found a surface of radius {1.0 / self.curvature_per_mm:g} mm, wanted "
                f"one that reaches {radius_mm:g} mm from its axis"
            )
        return float(self.curvature_per_mm * radius_mm**2 / (1.0 + root**0.5))


@dataclass(frozen=True)
class Lens:
    """A lenslet.

    Attributes
    ----------
    surfaces : tuple of Surface
        From the eye's side to the panel's; air is before them.
    aperture_mm : float
        Side of its cell, or diameter. Curved surfaces end there; flat ones are the plate's and
        go on.
    square : bool
        Whether it fills a square cell.
    """

    surfaces: tuple[Surface, ...]
    aperture_mm: float
    square: bool = True

    @property
    def stop(self) -> int:
        """The surface that bounds the light: the first curved one."""
        curved = [i for i, each in enumerate(self.surfaces) if each.curvature_per_mm != 0.0]
        return curved[0] if curved else 0

    @property
    def reach_mm(self) -> float:
        """From the axis to the farthest point of the aperture."""
        return self.aperture_mm / 2.0 * (2.0**0.5 if self.square else 1.0)

    def check(self) -> None:
        """Make sure that it can be made.

        Raises
        ------
        InputError
            If a surface ends within the aperture, or two cross.
        """
        sags = [each.sag_mm(self.reach_mm) for each in self.surfaces]
        for i, each in enumerate(self.surfaces[:-1]):
            rim_mm = each.thickness_mm + sags[i + 1] - sags[i]
            if each.thickness_mm <= 0.0 or rim_mm < 0.0:
                raise InputError(
                    f"lenslet: found {each.thickness_mm:g} mm of {each.medium.name} and "
                    f"{rim_mm:.3g} mm of it at the rim, wanted it thick enough for its surfaces"
                )


def curvature(radius_mm: float) -> float:
    """1 / radius, 0 for the radius 0 that stands for a plane."""
    return 1.0 / radius_mm if radius_mm != 0.0 else 0.0


def plano_convex(
    radius_mm: float,
    thickness_mm: float,
    glass: Medium,
    aperture_mm: float,
    *,
    facing: Facing = "eye",
    conic: float = 0.0,
    behind: Medium = AIR,
    square: bool = True,
) -> Lens:
    """A lens with one flat face; ``facing`` says where the convex one looks.

    ``radius_mm`` is positive for a convex lens either way.
    """
    bent = curvature(radius_mm)
    if facing == "eye":
        faces = (Surface(bent, glass, thickness_mm, conic), Surface(0.0, behind))
    else:
        faces = (Surface(0.0, glass, thickness_mm), Surface(-bent, behind, 0.0, conic))
    return Lens(faces, aperture_mm, square)


def cemented(
    radii_mm: Sequence[float],
    thicknesses_mm: Sequence[float],
    glasses: Sequence[Medium],
    aperture_mm: float,
    *,
    behind: Medium = AIR,
    square: bool = True,
) -> Lens:
    """Lenses cemented to one another: one radius more than glasses; a doublet has three."""
    if not len(radii_mm) - 1 == len(thicknesses_mm) == len(glasses) >= 1:
        raise InputError(
            f"lenslet: found {len(radii_mm)} radii, {len(thicknesses_mm)} thicknesses and "
            f"{len(glasses)} glasses, wanted one radius more than glasses and as many thicknesses"
        )
    faces = [
        Surface(curvature(radius), glass, thickness)
        for radius, glass, thickness in zip(radii_mm[:-1], glasses, thicknesses_mm, strict=True)
    ]
    return Lens((*faces, Surface(curvature(radii_mm[-1]), behind)), aperture_mm, square)
