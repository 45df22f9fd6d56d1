"""A lenslet before its panel: where it stands, what it images, and the field that it shows.

It stands where the ray equations' thin one does: its second principal plane is the rig's gap before
the panel. Light is followed from the plane that the eye focuses on (or from infinity) to the panel.
The field is what a lenslet shows of the panel when it faces the eye: up to its cell's edge,
atan(pitch / 2 g), and corner; and, apart from that, the slope at which the viewport's farthest
lenslets are looked through, which is far more.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Literal

import numpy as np

from vrlf.errors import InputError
from vrlf.model import Rig, focal_mm
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.glass import D_LINE_NM
from vrlf.optics.lenslet.achromat import achromat
from vrlf.optics.lenslet.given import lens_of, medium_of
from vrlf.optics.lenslet.paraxial import cardinal
from vrlf.optics.lenslet.surfaces import Lens, Medium, plano_convex
from vrlf.optics.lenslet.trace import Beam
from vrlf.optics.limits import signed_focus_mm
from vrlf.optics.viewport import SIDES, axis_in_viewport_px, pitch_mm, viewport
from vrlf.units import UM_PER_MM

FocusOn = Literal["left", "right", "infinity"]

# What an array without surfaces is taken to be: a moulded sheet.
USUAL_GLASS, USUAL_THICKNESS_MM = "pmma", 0.5
# An eye that focuses nearer to the array than this focuses on it.
_ON_THE_ARRAY_MM = 1e-3


@dataclass(frozen=True)
class Setting:
    """A lenslet before its panel.

    Attributes
    ----------
    lens : Lens
    wavelengths_nm : tuple of float
        The panel's colours.
    object_mm : float
        From the first principal plane to what it is to image on the panel; negative behind it.
    distance_mm : float
        From the last surface to the panel, physical.
    gap_index : float
    pixel_mm : float
    fields : dict
        Slopes (right, up) by name: "axis", "edge", "corner", "viewport".
    """

    lens: Lens
    wavelengths_nm: tuple[float, float, float]
    object_mm: float
    distance_mm: float
    gap_index: float
    pixel_mm: float
    fields: dict[str, tuple[float, float]]

    @property
    def gap_mm(self) -> float:
        """From the second principal plane to the panel, physical: the rig's gap."""
        back_mm = cardinal(self.lens, D_LINE_NM).back_principal_mm
        return self.distance_mm - self.gap_index * back_mm

    def beam(self, colour: int, field: str) -> Beam:
        return Beam(self.wavelengths_nm[colour], self.fields[field], self.object_mm)


def usual_lens(rig: Rig) -> Lens:
    """A plano-convex lens of PMMA, the curved face to the eye, of the rig's focal length."""
    glass = Medium(USUAL_GLASS)
    radius_mm = focal_mm(rig.array) * (glass.index_at(D_LINE_NM) - 1.0)
    behind = Medium(index=rig.array.gap_index)
    pitch = rig.array.pitch_um / UM_PER_MM
    return plano_convex(radius_mm, USUAL_THICKNESS_MM, glass, pitch, behind=behind)


def achromat_of(rig: Rig, crown: str, flint: str) -> Lens:
    """An achromat of the rig's focal length and pitch, of two glasses as a rig names them."""
    return achromat(
        focal_mm(rig.array),
        medium_of(crown),
        medium_of(flint),
        rig.array.pitch_um / UM_PER_MM,
        agreeing="focus",
        behind=Medium(index=rig.array.gap_index),
    )


def object_mm_of(rig: Rig, focus: FocusOn) -> float:
    """From the array to the plane that an eye focuses on, toward the eye; or infinity.

    Raises
    ------
    InputError
        If that is the array itself.
    """
    if focus == "infinity":
        return inf
    bench, optics = bench_of(rig), eye_optics(rig, focus)
    distance_mm = bench.lens_to_array_mm - signed_focus_mm(bench, optics)
    if abs(distance_mm) < _ON_THE_ARRAY_MM:
        raise InputError(
            f"--focus: found that the {focus} eye focuses on the array, wanted another"
        )
    # A focus at infinity behind the lens or before it is one.
    return inf if abs(distance_mm) == inf else distance_mm


def setting_of(rig: Rig, lens: Lens | None, focus: FocusOn) -> Setting:
    """A rig's lenslet before its panel; ``lens`` stands in for the rig's own.

    Raises
    ------
    InputError
        If the rig has no lenslets, or the panel would stand within this one.
    """
    array = rig.array
    if array.kind != "microlens":
        raise InputError(f'array.kind: found "{array.kind}", wanted "microlens"')
    made = lens or lens_of(rig) or usual_lens(rig)
    made.check()
    back_mm = cardinal(made, D_LINE_NM).back_principal_mm
    distance_mm = array.gap_mm + array.gap_index * back_mm
    if distance_mm <= 0.0:
        raise InputError(
            f"array.gap_mm: found {array.gap_mm:g}, wanted more than the "
            f"{-array.gap_index * back_mm:.3g} mm from the lenslet's principal plane to its last "
            "surface"
        )
    edge = array.pitch_um / UM_PER_MM / 2.0 / bench_of(rig).reduced_gap_mm
    fields = {
        "axis": (0.0, 0.0),
        "edge": (0.0, edge),
        "corner": (edge, edge),
        "viewport": (0.0, _viewport_slope(rig)),
    }
    return Setting(
        lens=made,
        wavelengths_nm=rig.panel.wavelengths_nm,
        object_mm=object_mm_of(rig, focus),
        distance_mm=distance_mm,
        gap_index=array.gap_index,
        pixel_mm=pitch_mm(rig),
        fields=fields,
    )


def _viewport_slope(rig: Rig) -> float:
    """At which the chief ray from the farthest panel corner passes the array.

    From X it leaves the eye at alpha = X / m and the headset's lens at beta = alpha (1 - e F).
    """
    bench = bench_of(rig)
    farthest_mm = 0.0
    for side in SIDES:
        view = viewport(rig, side)
        axis = axis_in_viewport_px(rig, view)
        far_px = np.maximum(np.abs(axis), np.abs(np.array([view.width_px, view.height_px]) - axis))
        farthest_mm = max(farthest_mm, float(np.hypot(*far_px)) * pitch_mm(rig))
    return abs(bench.relief_factor) / bench.panel_per_slope_mm * farthest_mm
