"""Where a pupil point's rays cross the array and meet the panel, as affine as they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vrlf.model import Rig
from vrlf.optics.bench import Bench
from vrlf.optics.eye import EyeOptics, aberration_at
from vrlf.optics.lattice import Lattice
from vrlf.optics.polynomial import Float
from vrlf.optics.raster import cells_per_pixel
from vrlf.optics.viewport import RASTER_FLIP, pitch_mm


@dataclass(frozen=True)
class RayMaps:
    """phi in cells and psi in pixels of pupil points, of one eye and colour."""

    rig: Rig
    bench: Bench
    lattice: Lattice
    optics: EyeOptics
    colour: int

    def __call__(self, even_mm: Float) -> tuple[Float, Float]:
        """phi and psi of points that are spread evenly over the pupil, from its centre."""
        from_centre_mm = self.optics.weighed(even_mm)
        u_mm = from_centre_mm + np.array(self.optics.pupil_offset_mm)
        slope = aberration_at(self.optics.aberration[self.colour], from_centre_mm)
        phi_mm = self.bench.array_defocus_factor * u_mm + self.bench.array_per_slope_mm * slope
        psi_mm = self.bench.defocus_factor * u_mm + self.bench.panel_per_slope_mm * slope
        cells = phi_mm @ self.lattice.cell_from_panel.T
        return cells, psi_mm @ (RASTER_FLIP / pitch_mm(self.rig)).T

    def crossed_by_px(self, within_px: Float) -> Float:
        """Cells by which places in the retinal pixel (pixels right, down) move the crossing."""
        per_px = self.bench.array_from_retina * cells_per_pixel(self.rig, self.lattice)
        return np.asarray(within_px @ per_px.T)

    def landed_by_px(self, within_px: Float) -> Float:
        """Pixels by which they move the landing, not bent."""
        return np.asarray(self.bench.panel_from_retina * within_px)

    def linear(self) -> tuple[Float, Float]:
        """Matrices (2, 2) by which phi and psi move from the pupil's centre to its edge."""
        radius_mm = self.optics.pupil_mm / 2.0
        # Central differences: exact for a sphero-cylinder, the mean slope of anything else.
        phi, psi = self(radius_mm * np.concatenate([np.eye(2), -np.eye(2)]))
        return (phi[:2] - phi[2:]).T / 2.0, (psi[:2] - psi[2:]).T / 2.0

    @property
    def is_affine(self) -> bool:
        """Whether the eye is a sphero-cylinder with a prism at most, weighed evenly."""
        if self.optics.stiles_crawford_per_mm2 != 0.0:
            return False
        polynomials = self.optics.aberration[self.colour]
        return all(
            abs(value) == 0.0 or i + j <= 1
            for each in polynomials
            for (i, j), value in np.ndenumerate(each)
        )


def ray_maps(rig: Rig, lattice: Lattice, optics: EyeOptics, colour: int) -> RayMaps:
    return RayMaps(rig, optics.benches[colour], lattice, optics, colour)
