"""The lenslet of a rig: its surfaces as they are given, and its focal length of each colour."""

from __future__ import annotations

from vrlf.errors import InputError
from vrlf.model import Rig, focal_mm
from vrlf.model.lenslet import Lenslet, faces, glass_numbers, is_glass, wanted_glass
from vrlf.optics.lenslet.paraxial import power_per_mm
from vrlf.optics.lenslet.surfaces import AIR, Lens, Medium, Surface, curvature
from vrlf.units import UM_PER_MM


def medium_of(glass: str) -> Medium:
    """A glass as a rig names it: catalogued, or "1.52/55".

    Raises
    ------
    InputError
        If it is neither.
    """
    if not is_glass(glass):
        raise InputError(f"glass: found {glass[:40]!r}, wanted {wanted_glass()}")
    numbers = glass_numbers(glass)
    if numbers is None:
        return Medium(glass)
    return Medium(index=numbers.n_d, abbe=numbers.abbe)


def lens_from(lenslet: Lenslet, aperture_mm: float, behind: Medium = AIR) -> Lens:
    """The surfaces of a lenslet that fills a square cell."""
    surfaces = tuple(
        Surface(
            curvature(face.radius_mm),
            behind if face.glass is None else medium_of(face.glass),
            face.thickness_mm,
            face.conic,
        )
        for face in faces(lenslet)
    )
    return Lens(surfaces, aperture_mm)


def lens_of(rig: Rig) -> Lens | None:
    """The lenslet that a rig's ``[array.lenslet]`` describes; None without that table.

    What fills the gap has no dispersion.
    """
    array = rig.array
    if array.kind != "microlens" or array.lenslet is None:
        return None
    behind = Medium(index=array.gap_index)
    return lens_from(array.lenslet, array.pitch_um / UM_PER_MM, behind)


def focal_mm_of_colour(rig: Rig, colour: int) -> float:
    """Focal length of a rig's lenslets for one of the panel's colours.

    Without ``[array.lenslet]`` it is the same for all.
    """
    lens = lens_of(rig)
    if lens is None:
        return focal_mm(rig.array)
    return 1.0 / power_per_mm(lens, rig.panel.wavelengths_nm[colour])
