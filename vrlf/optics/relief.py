"""What taking the eye to be at the lens costs this wearer (the single-lens approximation, T 8.2).

A picture for the panel made with e = 0 is looked at by an eye e behind the lens. Both benches
have the same lens, panel and array; the ray through the pupil's centre o from a panel point x
crosses the array where the approximation puts it, at c, and is the same ray beyond the lens:

    beta = (x - c) / g,  h = c - s_a beta = o,  alpha = beta + F h.

It meets the true pupil's plane at o - e alpha, not at o: beside the pupil's centre, where the
eye's aberration T is another. What was drawn for the direction alpha - T(0) is therefore seen at
alpha - T(-e alpha), as long as it meets the pupil at all. Without an array all of the pupil sees x,
at x / m, where x / m_0 was meant.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import atan, degrees

import numpy as np

from vrlf.model import Rig
from vrlf.optics import limits
from vrlf.optics.bench import Bench, bench_of
from vrlf.optics.eye import EyeOptics, eye_optics
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import Side, pitch_mm, viewport
from vrlf.units import MM_PER_M

# Where no relief is given: 12 mm from the lens to the cornea, as spectacles are worn, and 3 mm
# from there to the entrance pupil.
TYPICAL_RELIEF_MM = 15.0


@dataclass(frozen=True)
class ReliefCost:
    """An eye behind the lens against the same eye at it.

    Attributes
    ----------
    error_d : float
        How much the residual error differs, true less approximated; the same on every meridian.
    focus_shift_mm : float or None
        How much farther from the lens its plane of focus lies; None where one is not in front.
    magnification : float
        How much larger the bare panel is seen: m_0 / m.
    pupil_shift_mm : float
        In the farthest corner of the viewport, how far beside the pupil's centre the light passes
        that was meant for it; 0 without an array.
    shift_px : float
        In that corner, how far from where it was meant a thing is seen, in pixels of the panel.
        With an array, if that light still meets the pupil.
    field_deg : float or None
        The field within which what was meant for the pupil's centre meets the pupil at all, from
        border to border; None without an array.
    """

    error_d: float
    focus_shift_mm: float | None
    magnification: float
    pupil_shift_mm: float
    shift_px: float
    field_deg: float | None


def compared_relief_mm(rig: Rig) -> float:
    """The rig's eye relief, or a typical one where it is approximated away."""
    return rig.headset.eye_relief_mm or TYPICAL_RELIEF_MM


def relief_cost(rig: Rig, side: Side) -> ReliefCost | None:
    """The cost for one eye; None where an eye so far behind the lens has no upright image."""
    true = replace(bench_of(rig), relief_mm=compared_relief_mm(rig))
    plain = replace(true, relief_mm=0.0)
    if true.panel_per_slope_mm <= 0.0:
        return None
    # Accommodated as the rig has it: the difference alone is asked for.
    optics = eye_optics(rig, side)
    corners = [_at_corner(rig, plain, true, optics, x_mm) for x_mm in _corners_mm(rig, side)]
    vergence = MM_PER_M * true.defocus_factor
    return ReliefCost(
        error_d=vergence * (1.0 / true.panel_per_slope_mm - 1.0 / plain.panel_per_slope_mm),
        focus_shift_mm=_focus_shift_mm(plain, true, optics),
        magnification=plain.panel_per_slope_mm / true.panel_per_slope_mm,
        pupil_shift_mm=max(beside for beside, _ in corners),
        shift_px=max(shift for _, shift in corners),
        field_deg=_field_deg(true, optics),
    )


def _field_deg(true: Bench, optics: EyeOptics) -> float | None:
    """Both ways as far as e alpha is the pupil's radius."""
    if not true.has_array:
        return None
    return degrees(2.0 * atan(optics.pupil_mm / 2.0 / true.relief_mm))


def _corners_mm(rig: Rig, side: Side) -> list[Float]:
    """The viewport's corners, relative to its axis."""
    view, pitch = viewport(rig, side), pitch_mm(rig)
    left_mm = (view.first_column - rig.panel.width_px / 2.0) * pitch - view.axis_mm[0]
    top_mm = rig.panel.height_px / 2.0 * pitch - view.axis_mm[1]
    return [
        np.array([x_mm, y_mm])
        for x_mm in (left_mm, left_mm + view.width_px * pitch)
        for y_mm in (top_mm, top_mm - view.height_px * pitch)
    ]


def _focus_shift_mm(plain: Bench, true: Bench, optics: EyeOptics) -> float | None:
    meant_mm, found_mm = (limits.focus_distance_mm(bench, optics) for bench in (plain, true))
    return None if meant_mm is None or found_mm is None else found_mm - meant_mm


def _at_corner(
    rig: Rig, plain: Bench, true: Bench, optics: EyeOptics, x_mm: Float
) -> tuple[float, float]:
    """How far beside the pupil's centre the light passes, mm, and its shift, px."""
    if not true.has_array:
        slope = x_mm / true.panel_per_slope_mm - x_mm / plain.panel_per_slope_mm
        return 0.0, float(np.hypot(*slope)) * true.panel_per_slope_mm / pitch_mm(rig)
    offset = np.array(optics.pupil_offset_mm)
    # alpha, from the approximated lens's middle o through it to x.
    alpha = (x_mm - offset * plain.defocus_factor) / plain.panel_per_slope_mm
    beside_mm = -true.relief_mm * alpha
    # To second order: wavefronts are not known beyond the pupil.
    shift = optics.matrix_d @ beside_mm / MM_PER_M
    in_px = true.panel_per_slope_mm / pitch_mm(rig)
    return float(np.hypot(*beside_mm)), float(np.hypot(*shift)) * in_px
