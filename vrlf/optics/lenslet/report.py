"""How well a lenslet focuses a rig's panel for an eye: what ``vrlf lenslet`` says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan, degrees, hypot, inf

import numpy as np

from vrlf.errors import InputError
from vrlf.optics.glass import C_LINE_NM, D_LINE_NM, F_LINE_NM
from vrlf.optics.lenslet.diffraction import transfer, wavefront
from vrlf.optics.lenslet.focus import Foci, chromatic_focus_mm, foci
from vrlf.optics.lenslet.paraxial import Cardinal, cardinal
from vrlf.optics.lenslet.setting import Setting
from vrlf.optics.lenslet.spots import best_distance_mm, spot
from vrlf.units import NM_PER_MM, UM_PER_MM


@dataclass(frozen=True)
class FieldNumbers:
    """One place of the field.

    Attributes
    ----------
    angle_deg : float
        Of the light before the lenslet.
    rms_um, mtf : tuple of float, or None
        For each colour: the spot's RMS radius, and the contrast that is left of lines one pixel
        wide, the worse of both directions; None where no light comes through.
    transmitted : float
        Share of green light that is not blocked.
    sagittal_mm, tangential_mm : float or None
        Where green light's foci lie from the paraxial one, toward the panel.
    """

    angle_deg: float
    rms_um: tuple[float, ...] | None
    mtf: tuple[float, ...] | None
    transmitted: float
    sagittal_mm: float | None
    tangential_mm: float | None


@dataclass(frozen=True)
class LensletReport:
    """All numbers of a lenslet before its panel.

    Attributes
    ----------
    focal_mm, back_focus_mm : tuple of float
        For each colour; from the last surface to the image of what the eye focuses on.
    panel_mm : float
        From the last surface to the panel.
    pixel_um, diffraction_um : float
        The panel's pitch, and from the middle of green light's diffraction to its first dark.
    chromatic_um, chromatic_fc_um : float
        How far red's image lies behind blue's; C's behind F's.
    depth_of_focus_um : float
        Either way, a quarter of a green wave: 2 lambda N^2 (Born & Wolf 1999, 8.8).
    best_gap_mm : float or None
        At which the spots of all colours on the axis and at the edge are least together; None
        where no panel can stand so, the light not meeting behind the lenslet.
    fields : dict of FieldNumbers
    """

    focal_mm: tuple[float, ...]
    back_focus_mm: tuple[float, ...]
    object_mm: float | None
    panel_mm: float
    pixel_um: float
    diffraction_um: float
    chromatic_um: float
    chromatic_fc_um: float
    depth_of_focus_um: float
    best_gap_mm: float | None
    fields: dict[str, FieldNumbers]


def lenslet_report(setting: Setting) -> LensletReport:
    """The numbers of a setting."""
    found = [cardinal(setting.lens, nm) for nm in setting.wavelengths_nm]
    images = setting.gap_index * np.array([each.image_mm(setting.object_mm) for each in found])
    if not np.all(np.isfinite(images)):
        raise InputError(
            "lenslet: found that what the eye focuses on lies in its focus, wanted an image of it"
        )
    f_c = chromatic_focus_mm(setting.lens, (F_LINE_NM, C_LINE_NM), setting.object_mm)
    green_mm = setting.wavelengths_nm[1] / NM_PER_MM
    # Reduced: in a medium waves are shorter and cones narrower, both by its index.
    number = _image_mm(setting, found[1]) / setting.lens.aperture_mm
    dark = 1.0 if setting.lens.square else 1.22
    return LensletReport(
        focal_mm=tuple(each.focal_mm for each in found),
        back_focus_mm=tuple(float(each) for each in images),
        object_mm=None if setting.object_mm == inf else setting.object_mm,
        panel_mm=setting.distance_mm,
        pixel_um=UM_PER_MM * setting.pixel_mm,
        diffraction_um=UM_PER_MM * dark * green_mm * abs(number),
        chromatic_um=UM_PER_MM * float(images[0] - images[2]),
        chromatic_fc_um=UM_PER_MM * setting.gap_index * float(f_c[1] - f_c[0]),
        depth_of_focus_um=UM_PER_MM * 2.0 * green_mm * number**2 * setting.gap_index,
        best_gap_mm=best_gap_mm(setting),
        fields={name: field_numbers(setting, name) for name in setting.fields},
    )


def _image_mm(setting: Setting, found: Cardinal) -> float:
    """From the second principal plane to the panel, reduced."""
    return setting.distance_mm / setting.gap_index - found.back_principal_mm


def best_gap_mm(setting: Setting, fields: Sequence[str] = ("axis", "edge")) -> float | None:
    """The rig's gap at which spots are least, or None; see ``spots.best_distance_mm``."""
    beams = [setting.beam(colour, field) for colour in range(3) for field in fields]
    back_mm = cardinal(setting.lens, D_LINE_NM).back_principal_mm
    distance_mm = best_distance_mm(setting.lens, beams)
    return distance_mm - setting.gap_index * back_mm if distance_mm > 0.0 else None


def field_numbers(setting: Setting, field: str) -> FieldNumbers:
    """The numbers at one place of the field."""
    angle_deg = degrees(atan(hypot(*setting.fields[field])))
    lens, colours = setting.lens, range(3)
    try:
        spots = [spot(lens, setting.beam(c, field), setting.distance_mm) for c in colours]
        mtf = tuple(pixel_contrast(setting, c, field) for c in colours)
        ends = foci_from_axis(setting, 1, field)
    except InputError:
        return FieldNumbers(angle_deg, None, None, 0.0, None, None)
    return FieldNumbers(
        angle_deg,
        tuple(UM_PER_MM * each.rms_mm for each in spots),
        mtf,
        spots[1].transmitted,
        ends.sagittal_mm,
        ends.tangential_mm,
    )


def pixel_contrast(setting: Setting, colour: int, field: str) -> float:
    """What is left of the contrast of lines as wide as a pixel."""
    beam = setting.beam(colour, field)
    front = wavefront(setting.lens, beam, setting.distance_mm)
    per_mm = np.array([1.0 / (2.0 * setting.pixel_mm)])
    return float(transfer(front, beam.wavelength_nm).at(per_mm).min())


def foci_from_axis(setting: Setting, colour: int, field: str) -> Foci:
    """Coddington's foci from the panel, positive behind it.

    Moved by what the paraxial focus of this colour lies off: field curvature alone is left.
    """
    found = foci(setting.lens, setting.beam(colour, field))
    middle = foci(setting.lens, setting.beam(colour, "axis")).sagittal_mm
    return Foci(found.sagittal_mm - middle, found.tangential_mm - middle)
