"""The headset as an optical bench: the distances and powers of design equations.

Symbols follow the field's papers: e eye relief, F lens power, s_a lens to array, g reduced
gap, d reduced distance lens to panel, m the distance that turns slopes into panel
millimetres.

A lens of glass has another power F for each colour, and so has the bench. The retinal image is
named by panel points of 589 nm for all colours: X stands for the direction X / m_0, m_0 that
wavelength's. A colour's chief ray from X then meets the panel at (m / m_0) X and crosses the
array at (e + s_a (1 - e F)) X / m_0: with e > 0 the colours are magnified differently.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from vrlf.errors import InputError
from vrlf.model import Rig, focal_mm, lens_power_d
from vrlf.optics.glass import relative_power
from vrlf.optics.lenslet.given import focal_mm_of_colour
from vrlf.units import MM_PER_M


@dataclass(frozen=True)
class Bench:
    """Paraxial distances of a rig; millimetres and 1/mm.

    ``lens_power_per_mm`` is that of the bench's own colour, ``naming_power_per_mm`` that of
    589 nm; only with ``headset.glass`` are they two. ``bend`` is g / f of the lenslets: how far
    one moves a panel point, per millimetre off its centre; 0 for holes.
    """

    relief_mm: float
    lens_power_per_mm: float
    naming_power_per_mm: float
    lens_to_array_mm: float
    reduced_gap_mm: float
    has_array: bool
    bend: float = 0.0

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
    def retina_per_slope_mm(self) -> float:
        """m_0, at 589 nm: the retinal image's millimetres of a unit slope, whatever the colour."""
        factor = 1.0 - self.relief_mm * self.naming_power_per_mm
        return self.relief_mm + self.lens_to_panel_mm * factor

    @property
    def panel_from_retina(self) -> float:
        """m / m_0: where a colour's chief ray from X meets the panel, over X; 1 for 589 nm."""
        return self.panel_per_slope_mm / self.retina_per_slope_mm

    @property
    def array_from_retina(self) -> float:
        """Height at the array of the chief ray from X, over X (pupil at u = 0)."""
        return self.array_per_slope_mm / self.retina_per_slope_mm

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
    """The bench that a rig describes, at 589 nm; without an array it stands at the panel."""
    headset, array = rig.headset, rig.array
    has_array = array.kind != "none"
    gap_mm = array.gap_mm if has_array else 0.0
    power_per_mm = lens_power_d(headset) / MM_PER_M
    return Bench(
        relief_mm=headset.eye_relief_mm,
        lens_power_per_mm=power_per_mm,
        naming_power_per_mm=power_per_mm,
        lens_to_array_mm=headset.lens_to_panel_mm - gap_mm,
        reduced_gap_mm=gap_mm / array.gap_index if has_array else 0.0,
        has_array=has_array,
        bend=_bend(rig, focal_mm(array)),
    )


def _bend(rig: Rig, focal_mm: float) -> float:
    array = rig.array
    return array.gap_mm / array.gap_index / focal_mm if array.kind == "microlens" else 0.0


def colour_benches(rig: Rig) -> tuple[Bench, Bench, Bench]:
    """The bench of each of the panel's colours; all are ``bench_of`` without dispersion.

    ``headset.glass`` and ``[array.lenslet]`` bring it.

    Raises
    ------
    InputError
        If the eye stands so far behind a strong lens that a colour has no upright image.
    """
    bench, glass = bench_of(rig), rig.headset.glass

    def of(colour: int) -> Bench:
        nm, made = rig.panel.wavelengths_nm[colour], bench
        if rig.array.kind == "microlens" and rig.array.lenslet is not None:
            made = replace(made, bend=_bend(rig, focal_mm_of_colour(rig, colour)))
        if glass is None:
            return made
        power_per_mm = bench.lens_power_per_mm * relative_power(glass, nm)
        made = replace(made, lens_power_per_mm=power_per_mm)
        if made.panel_per_slope_mm <= 0.0:
            raise InputError(
                f"headset.eye_relief_mm: found {bench.relief_mm:g}, where lenses of {glass} show "
                f"light of {nm:g} nm in no upright image, wanted less"
            )
        return made

    return of(0), of(1), of(2)


def widest_bend(rig: Rig) -> float:
    """The largest g / f of the panel's colours."""
    return max(bench.bend for bench in colour_benches(rig))


def bends_apart(rig: Rig) -> bool:
    """Whether the lenslets bend the colours differently."""
    first, *others = colour_benches(rig)
    return any(bench.bend != first.bend for bench in others)


def is_lateral(rig: Rig) -> bool:
    """Whether the headset magnifies the panel's colours differently: lateral colour."""
    naming = bench_of(rig)
    return any(
        bench.panel_from_retina != 1.0 or bench.array_from_retina != naming.array_from_retina
        for bench in colour_benches(rig)
    )
