"""The headset as an optical bench: the distances and powers of design equations.

Symbols follow the field's papers: e eye relief, F lens power, s_a lens to array, g reduced
gap, d reduced distance lens to panel, m the distance that turns slopes into panel
millimetres.
"""

from __future__ import annotations

from dataclasses import dataclass

from vrlf.model import Rig, lens_power_d
from vrlf.units import MM_PER_M


@dataclass(frozen=True)
class Bench:
    """Paraxial distances of a rig; millimetres and 1/mm."""

    relief_mm: float
    lens_power_per_mm: float
    lens_to_array_mm: float
    reduced_gap_mm: float
    has_array: bool

    @property
    def lens_to_panel_mm(self) -> float:
        """d, reduced: what a solid spacer brings nearer is brought nearer here."""
        return self.lens_to_array_mm + self.reduced_gap_mm

    @property
    def relief_factor(self) -> float:
        """1 - e F."""
        return 1.0 - self.relief_mm * self.lens_power_per_mm

    @property
    def panel_per_slope_mm(self) -> float:
        """m = e + d - d e F: the panel height of a unit slope through an error-free eye."""
        return self.relief_mm + self.lens_to_panel_mm * self.relief_factor

    @property
    def array_per_slope_mm(self) -> float:
        """e + s_a (1 - e F): the array height of a unit slope through the pupil's centre."""
        return self.relief_mm + self.lens_to_array_mm * self.relief_factor

    @property
    def array_from_panel(self) -> float:
        """Height at the array of the chief ray, per height on the panel (pupil at u = 0)."""
        return self.array_per_slope_mm / self.panel_per_slope_mm

    @property
    def defocus_factor(self) -> float:
        """1 - d F: panel height per pupil height of a ray that left the eye parallel."""
        return 1.0 - self.lens_to_panel_mm * self.lens_power_per_mm

    @property
    def array_defocus_factor(self) -> float:
        """1 - s_a F: the same at the array."""
        return 1.0 - self.lens_to_array_mm * self.lens_power_per_mm


def bench_of(rig: Rig) -> Bench:
    """The bench that a rig describes; without an array it stands at the panel with no gap."""
    headset, array = rig.headset, rig.array
    has_array = array.kind != "none"
    gap_mm = array.gap_mm if has_array else 0.0
    return Bench(
        relief_mm=headset.eye_relief_mm,
        lens_power_per_mm=lens_power_d(headset) / MM_PER_M,
        lens_to_array_mm=headset.lens_to_panel_mm - gap_mm,
        reduced_gap_mm=gap_mm / array.gap_index if has_array else 0.0,
        has_array=has_array,
    )
