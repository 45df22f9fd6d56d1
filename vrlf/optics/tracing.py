"""What perception ray by ray has in it beyond thin lenses and shadows, and the checks on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vrlf.errors import InputError
from vrlf.model import Rig
from vrlf.optics.beams import shadow_scale, upright_scale
from vrlf.optics.bench import bench_of
from vrlf.optics.exact_lenslet import GREEN, ExactLenslet, exact_lenslet
from vrlf.optics.eye import EyeOptics
from vrlf.optics.fresnel import Spread, spread_of
from vrlf.optics.lattice import Lattice, lattice_of
from vrlf.optics.lenslet.given import focal_mm_of_colour, medium_of
from vrlf.optics.polynomial import Float
from vrlf.units import NM_PER_MM


@dataclass(frozen=True)
class Tracing:
    """Options of perception; without any it is the fast one.

    Attributes
    ----------
    diffraction : bool
        Holes and lenslets spread each ray as ``vrlf/optics/fresnel.py`` derives.
    exact : bool
        Lenslets are plano-convex lenses (``vrlf/optics/exact_lenslet.py``).
    """

    diffraction: bool = False
    exact: bool = False

    def __bool__(self) -> bool:
        return self.diffraction or self.exact

    def check(self, rig: Rig) -> None:
        """Refuse what a rig has nothing for.

        Raises
        ------
        InputError
        """
        if not self:
            return
        kind = rig.array.kind
        if rig.headset.glass is not None:
            raise InputError(
                f'headset.glass: found "{rig.headset.glass}", wanted none: rays traced one by one '
                "take the headset's lens for the same in all colours"
            )
        if kind != "none" and rig.array.lattice != "square":
            raise InputError(
                f'array.lattice: found "{rig.array.lattice}", wanted "square" for rays traced one '
                "by one"
            )
        if rig.array.varies:
            growth = list(rig.array.pitch_growth_per_cm2)
            raise InputError(
                f"array.pitch_growth_per_cm2: found {growth}, wanted [0, 0] for rays traced one by "
                "one"
            )
        if self.exact and kind != "microlens":
            raise InputError(f'exact: found array.kind = "{kind}", wanted lenslets ("microlens")')
        if self.diffraction and kind == "none":
            raise InputError(
                'diffraction: found array.kind = "none", wanted an array ("pinhole", "microlens")'
            )
        if self.exact:
            lens_of(rig, self)


@dataclass(frozen=True)
class Diffraction:
    """How a rig's openings spread light.

    Attributes
    ----------
    spread : Spread
    half_cells : float
        Half an opening's width, in cells.
    unit_cells : ndarray (3,)
        lambda g / w of each colour, in cells.
    number : ndarray (3,)
        N for a shadow as large as the opening.
    """

    spread: Spread
    half_cells: float
    unit_cells: Float
    number: Float


def diffraction_of(rig: Rig, lattice: Lattice) -> Diffraction:
    """For a rig's array."""
    half_cells = min(lattice.half_aperture, 0.5)
    width_mm = 2.0 * half_cells * lattice.pitch_mm
    reach_mm2 = np.array(rig.panel.wavelengths_nm) / NM_PER_MM * bench_of(rig).reduced_gap_mm
    return Diffraction(
        spread=spread_of(lattice.round_holes),
        half_cells=half_cells,
        unit_cells=reach_mm2 / width_mm / lattice.pitch_mm,
        number=width_mm**2 / reach_mm2,
    )


def lens_of(rig: Rig, tracing: Tracing) -> ExactLenslet | None:
    """The lenslet as it is made, where that is asked for."""
    if not tracing.exact:
        return None
    lenslet = rig.array.lenslet
    if lenslet is None:
        return exact_lenslet(rig)
    if lenslet.radius_mm is None or lenslet.glass is None or lenslet.conic != 0.0:
        raise InputError(
            "exact: found an array.lenslet of several surfaces or a conic one, wanted a spherical "
            "plano-convex one (radius_mm, thickness_mm, glass)"
        )
    medium = medium_of(lenslet.glass)
    red, green, blue = (medium.index_at(nm) for nm in rig.panel.wavelengths_nm)
    return exact_lenslet(
        rig,
        index=(red, green, blue),
        focal_mm=focal_mm_of_colour(rig, GREEN),
        thickness_mm=lenslet.thickness_mm,
        curved=lenslet.facing,
    )


def spreading(rig: Rig, optics: EyeOptics, colour: int, v_mm: Float) -> Float:
    """M along the lattice's axes at pupil points from the pupil's centre; (n, 2)."""
    lattice = lattice_of(rig)
    assert lattice is not None
    scale = shadow_scale(optics.benches[colour], optics.aberration[colour], v_mm)
    return upright_scale(lattice, scale)
