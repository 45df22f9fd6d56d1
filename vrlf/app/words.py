"""What ``vrlf inspect`` says: the numbers of a rig in words that a wearer can use."""

from __future__ import annotations

from math import sqrt
from typing import Any

from vrlf.model import Rig, prescription_text
from vrlf.units import UM_PER_MM

Numbers = dict[str, Any]
# Reading needs about this; below it letters of a headline size are lost.
_FINE_PX = 1.5


def inspection(rig: Rig, numbers: Numbers) -> str:
    """All of it, a paragraph for each part."""
    parts = [
        _display(rig, numbers),
        _eye(rig, "Left eye", numbers["left"], numbers["display"]),
        _eye(rig, "Right eye", numbers["right"], numbers["display"]),
        _array(numbers),
    ]
    if numbers["warnings"]:
        parts.append("\n".join(["Take note", *(f"  - {text}" for text in numbers["warnings"])]))
    return "\n\n".join(parts)


def _display(rig: Rig, numbers: Numbers) -> str:
    panel, display = rig.panel, numbers["display"]
    image, height = display["virtual_image_mm"], display["axis_height_px"]
    where = "at infinity" if image is None else _distance(image)
    lines = [
        "Headset",
        f"  panel           {panel.width_px} x {panel.height_px} pixels of "
        f"{panel.pixel_pitch_um:g} um, {panel.subpixels}, {panel.peak_nit:g} cd/m2, "
        f"{panel.bits} bits",
        f"  sharpness       {display['pixels_per_degree']:.1f} pixels per degree on the axis",
        f"  the lens shows the bare panel {where}",
    ]
    if height != 0.0:
        way = "above" if height > 0.0 else "below"
        lines.append(f"  axes            {abs(height):.1f} pixels {way} the panel's middle")
    headset = numbers["headset"]
    if rig.headset.glass is not None:
        lines.append(
            f"  colours         {rig.headset.glass} takes them {headset['longitudinal_d']:.2f} D "
            f"and in the farthest corner {headset['lateral_px']:.1f} pixels apart"
        )
    return "\n".join([*lines, *_approximation(headset)])


def _approximation(headset: Numbers) -> list[str]:
    """What taking the eye to be at the lens costs, the worse of both eyes."""
    costs = [headset[side] for side in ("left", "right") if headset[side] is not None]
    if not costs:
        return [f"  an eye {headset['relief_mm']:g} mm behind such a lens has no upright image"]
    error, beside, shift = (
        max(abs(cost[key]) for cost in costs) for key in ("error_d", "pupil_shift_mm", "shift_px")
    )
    size = 100.0 * abs(costs[0]["magnification"] - 1.0)
    relief = f"{headset['relief_mm']:g} mm"
    if headset["approximated"]:
        said = f"taken as 0; an eye {relief} behind the lens pays for that"
    else:
        said = f"{relief}; taken as 0 it would cost"
    lines = [
        f"  eye relief      {said} {error:.2f} D, {size:.1f} % of size,",
        f"                  and sees the farthest corner {shift:.1f} pixels off",
    ]
    if beside > 0.0:
        field = min(cost["field_deg"] for cost in costs)
        lines += [
            f"                  (its light passes {beside:.1f} mm beside the pupil's centre; what "
            "meets",
            f"                  the pupil lies within a field of {field:.0f} degrees)",
        ]
    return lines


def _distance(mm: float) -> str:
    if mm < 0.0:
        return f"{-mm:.0f} mm behind the eye (converging light: a relaxed good eye sees a blur)"
    return (
        f"{mm / 1000.0:.2f} m before the lens" if mm >= 1000.0 else f"{mm:.0f} mm before the lens"
    )


def _eye(rig: Rig, name: str, eye: Numbers, display: Numbers) -> str:
    blur_deg = _width_px(eye) / display["pixels_per_degree"]
    blur_mm = _width_px(eye) * rig.panel.pixel_pitch_um / UM_PER_MM
    lines = [
        name,
        f"  error left      {prescription(eye)}  (mean {eye['mean_error_d']:+.2f} D; "
        f"accommodates {eye['accommodation_d']:.2f} D)",
        f"  sharp at        {_focus(eye['focus_distance_mm'])}",
        f"  a point blurs   {_width_px(eye):.1f} pixels wide ({blur_mm:.2f} mm on the "
        f"panel, {blur_deg:.1f} degrees)",
    ]
    if eye["higher_order_rms_um"] > 0.0:
        lines.append(
            f"  higher orders   {eye['higher_order_rms_um']:.2f} um RMS over its pupil; in the "
            f"middle of it the error is {prescription(_paraxial(eye))}"
        )
    if eye["clear_zone"] is not None:
        lines.append(f"  by itself       {_zone(eye['clear_zone'])}")
    corrected = eye["corrected_blur_px"]
    if corrected is not None:
        lines.append(
            f"  with the array  {corrected:.1f} pixels: {_verdict(_width_px(eye), corrected)}"
        )
        lines.append(f"  may look        {_gaze(eye['gaze_limit_deg'])}")
    if eye["barrier_field_deg"] is not None:
        lines.append(f"  barriers leave  a field of {eye['barrier_field_deg']:.0f} degrees")
    return "\n".join(lines)


def _gaze(limit_deg: float | None) -> str:
    if limit_deg is None:
        return "anywhere"
    return f"{limit_deg:.0f} degrees aside before other lenslets' light is half of what it sees"


def _width_px(eye: Numbers) -> float:
    """How wide a point's image is: along the worst meridian, or as an even disc of its spread."""
    blur_px: float = eye["blur_px"]
    if eye["higher_order_rms_um"] == 0.0:
        return blur_px
    even_px: float = 2.0 * sqrt(2.0) * eye["spot_rms_px"]
    return max(blur_px, even_px)


def _paraxial(eye: Numbers) -> Numbers:
    return {name: eye[f"paraxial_{name}"] for name in ("sphere_d", "cylinder_d", "axis_deg")}


def _zone(zone: Numbers) -> str:
    near, far = zone["near_mm"], zone["far_mm"]
    if near is None:
        return "it sees sharp at infinity alone"
    where = "on" if far is None else f"to {far:.0f} mm"
    if far is not None and far - near < 0.5:
        return f"it sees sharp at {far:.0f} mm alone"
    return f"it sees sharp from {near:.0f} mm {where}"


def prescription(eye: Numbers) -> str:
    """As it is written on paper."""
    return prescription_text(eye["sphere_d"], eye["cylinder_d"], eye["axis_deg"])


def _focus(mm: float | None) -> str:
    return "no distance in front" if mm is None else f"{mm:.1f} mm before the headset lens"


def _verdict(blur_px: float, corrected_px: float) -> str:
    if blur_px <= _FINE_PX:
        return "this eye needs no correction"
    if corrected_px >= 0.8 * blur_px:
        return "this array does not help this eye"
    if corrected_px <= 2.0 * _FINE_PX:
        return "this array can correct this eye"
    return "this array helps, but leaves a blur"


def _pitch(array: Numbers) -> str:
    least, widest = array["least_pitch_um"], array["widest_pitch_um"]
    return f"{least:g}" if least == widest else f"{least:.4g} to {widest:.4g}"


def _array(numbers: Numbers) -> str:
    array = numbers["array"]
    if array["kind"] == "none":
        return "Array\n  none: the bare panel"
    kind = "holes" if array["kind"] == "pinhole" else "lenslets"
    lattice = " in hexagons" if array["lattice"] == "hexagonal" else ""
    return "\n".join(
        [
            "Array",
            f"  {kind:<15} every {_pitch(array)} um{lattice}, {array['views']:.1f} pixels, "
            f"{array['lens_to_array_mm']:.1f} mm behind the lens",
            f"  light left      {100.0 * array['throughput']:.1f} %",
            f"  eyebox          {array['eyebox_mm']:.2f} mm (pupils: "
            f"{numbers['left']['pupil_mm']:.3g} and {numbers['right']['pupil_mm']:.3g} mm)",
            f"  depth of field  {array['depth_of_field_mm']:.1f} mm about the array",
            f"  field           {array['field_of_view_deg']:.1f} degrees behind one opening",
            f"  best hole       {array['best_pinhole_um']:.0f} um for green light",
        ]
    )
