"""What a wearer should know of a rig, in sentences."""

from __future__ import annotations

from math import atan, ceil, degrees

import numpy as np

from vrlf.model import Eye, Rig, focal_mm
from vrlf.optics import limits
from vrlf.optics.bench import Bench, bench_of
from vrlf.optics.distortion import coefficients_of, edge_radius, turning_radius
from vrlf.optics.eye import EyeOptics, amplitude_of_accommodation_d, eye_optics, viewer
from vrlf.optics.lattice import Lattice, lattice_of
from vrlf.optics.openings import FOCUSED_PX, served_pupil
from vrlf.optics.viewport import (
    SIDES,
    Side,
    axis_in_viewport_px,
    panel_points_mm,
    pitch_mm,
    viewport,
)
from vrlf.units import UM_PER_MM

# Blur below this is not worth an array.
_SHARP_PX = 1.5
_DIM = 0.25
# Rounding leaves 1e-16 where accommodation reaches its aim.
_UNREACHED = 1e-9
# Less of a pupil than this in focus is said.
_SERVED = 0.9
# A pupil wider than the eyebox by less than this sees next to nothing twice.
_COVERED = 0.98


def advice(rig: Rig) -> list[str]:
    """Warnings, most grave first for each eye, then those of the array alone."""
    sentences: list[str] = []
    for side in SIDES:
        sentences += [f"{side} eye: {text}" for text in _eye_advice(rig, side)]
    return _joined(sentences) + _headset_advice(rig) + _array_advice(rig)


def wavefront_advice(rig: Rig) -> list[str]:
    """What is odd in the eyes' wavefronts: said by every command that corrects with them."""
    said = []
    for side in SIDES:
        said += [f"{side} eye: {text}" for text in _wavefront_advice(viewer(rig, side))]
    return _joined(said)


def _joined(sentences: list[str]) -> list[str]:
    """The same sentence for both eyes said once."""
    left = [s.removeprefix("left eye: ") for s in sentences if s.startswith("left eye: ")]
    right = [s.removeprefix("right eye: ") for s in sentences if s.startswith("right eye: ")]
    both = [f"both eyes: {s}" for s in left if s in right]
    rest = [f"left eye: {s}" for s in left if s not in right]
    return both + rest + [f"right eye: {s}" for s in right if s not in left]


def _eye_advice(rig: Rig, side: Side) -> list[str]:
    bench, optics, lattice = bench_of(rig), eye_optics(rig, side), lattice_of(rig)
    sentences = _given_advice(rig, side, optics)
    if lattice is None:
        blur_mm = optics.pupil_mm * limits.worst_meridian(limits.blur_matrix(bench, optics))
        blur_px = blur_mm / pitch_mm(rig)
        if blur_px > _SHARP_PX:
            sentences.append(
                f"a point blurs over {blur_px:.1f} pixels, and without an array nothing corrects it"
            )
        return sentences
    return sentences + _correction_advice(rig, bench, lattice, optics)


def _wavefront_advice(eye: Eye) -> list[str]:
    """Whether the wavefront says twice what the prescription says, or too little."""
    sentences = []
    if eye.zernike is not None:
        second = any(n == 2 and value != 0.0 for (n, _), value in eye.zernike.terms)
        if second and (eye.sphere_d != 0.0 or eye.cylinder_d != 0.0):
            sentences.append(
                "the wavefront has second-order terms of its own and adds to the prescription; "
                "is the error counted twice?"
            )
        if eye.pupil_mm > eye.zernike.diameter_mm * (1.0 + 1e-9):
            sentences.append(
                f"the wavefront was measured over {eye.zernike.diameter_mm:g} mm and is continued "
                f"to the pupil's {eye.pupil_mm:g} mm"
            )
    return sentences


def _given_advice(rig: Rig, side: Side, optics: EyeOptics) -> list[str]:
    """What is odd in the eye's own table."""
    eye = viewer(rig, side)
    sentences = _wavefront_advice(eye)
    blur = limits.blur_matrix(bench_of(rig), optics)
    # What is left on the far-sighted side was beyond the eye's reach.
    if eye.accommodation == "best" and float(np.trace(blur)) > _UNREACHED:
        amplitude_d = amplitude_of_accommodation_d(eye.age_years)
        sentences.append(f"accommodation is at its limit of {amplitude_d:.2f} D")
    view = viewport(rig, side)
    column, row = axis_in_viewport_px(rig, view)
    if not (0.0 <= column <= view.width_px and 0.0 <= row <= view.height_px):
        sentences.append("its optical axis misses its half of the panel")
    return sentences


def _correction_advice(rig: Rig, bench: Bench, lattice: Lattice, optics: EyeOptics) -> list[str]:
    """Whether the array can correct this eye."""
    sentences = []
    found = limits.array_limits(rig)
    assert found is not None
    focus_mm = limits.focus_distance_mm(bench, optics)
    if focus_mm is None:
        sentences.append("its plane of focus is not in front of the lens")
    elif abs(focus_mm - bench.lens_to_array_mm) > found.depth_of_field_mm:
        distance_mm = abs(focus_mm - bench.lens_to_array_mm)
        sentences.append(
            f"its plane of focus at {focus_mm:.1f} mm lies {distance_mm:.1f} mm from the array, "
            f"beyond its depth of field of {found.depth_of_field_mm:.1f} mm"
        )
    sentences += _focus_advice(rig, bench, lattice, optics)
    sentences += _higher_order_advice(rig, optics)
    if found.eyebox_mm < _COVERED * optics.pupil_mm:
        seen = ceil((optics.pupil_mm / found.eyebox_mm) ** 2 / lattice.row_pitches)
        sentences.append(
            f"its pupil of {optics.pupil_mm:g} mm is wider than the eyebox of "
            f"{found.eyebox_mm:.2f} mm: it sees a pixel through up to {seen} openings at once "
            "(crosstalk that the forward prefilter does not know of)"
        )
    if lattice.barriers == "perpendicular":
        sentences += _field_advice(rig, bench, lattice, optics)
    return sentences


def _focus_advice(rig: Rig, bench: Bench, lattice: Lattice, optics: EyeOptics) -> list[str]:
    """Whether the openings are sharp for this eye."""
    blur_px = limits.opening_blur_mm(bench, lattice, optics) / pitch_mm(rig)
    if blur_px <= FOCUSED_PX:
        return []
    if lattice.kind == "pinhole":
        return [
            f"one hole alone blurs a point over {blur_px:.1f} pixels: smaller holes are sharper"
        ]
    best_mm = limits.best_focal_mm(bench, limits.signed_focus_mm(bench, optics))
    remedy = (
        "no converging lenslet does"
        if best_mm is None
        else f"{best_mm:.2f} mm would for its mean error"
    )
    return [
        f"lenslets of {focal_mm(rig.array):.4g} mm do not image the panel onto its plane of focus "
        f"(one alone blurs a point over {blur_px:.1f} pixels); {remedy}"
    ]


def _higher_order_advice(rig: Rig, optics: EyeOptics) -> list[str]:
    """Where in the pupil no lenslet of this array helps, for an eye with higher orders."""
    served = served_pupil(rig, optics) if optics.has_higher_orders else None
    if served is None or served.share >= _SERVED:
        return []
    return [
        f"its higher orders let the array be in focus for {100.0 * served.share:.0f} % of the "
        f"pupil; elsewhere one opening alone blurs a point over {served.mean_px:.1f} pixels "
        f"({served.most_px:.1f} at worst), which forward cannot help and optimal only in part"
    ]


def _field_advice(rig: Rig, bench: Bench, lattice: Lattice, optics: EyeOptics) -> list[str]:
    """How much of the viewport perpendicular barriers leave."""
    half_mm = limits.barrier_field_mm(bench, lattice, optics) / bench.array_from_panel
    side: Side = "left"
    reach_mm = float(abs(panel_points_mm(rig, viewport(rig, side))).max())
    if half_mm >= reach_mm:
        return []
    field_deg = limits.barrier_field_deg(bench, lattice, optics)
    return [
        f"perpendicular barriers leave a field of {field_deg:.0f} degrees and black beyond; "
        "converging ones would not"
    ]


def _headset_advice(rig: Rig) -> list[str]:
    """Whether the lens's distortion shows some of the panel twice."""
    turn = turning_radius(coefficients_of(rig))
    edge = max(edge_radius(rig, side) for side in SIDES)
    if turn >= edge:
        return []
    return [
        f"headset: the distortion turns back at {degrees(atan(turn)):.0f} degrees of panel, of "
        f"{degrees(atan(edge)):.0f} in the farthest corner: what lies beyond shows again what "
        "lies within"
    ]


def _array_advice(rig: Rig) -> list[str]:
    """What is true whatever the eye."""
    lattice, found = lattice_of(rig), limits.array_limits(rig)
    if lattice is None or found is None:
        return []
    sentences = []
    if found.throughput < _DIM:
        sentences.append(f"array: only {100.0 * found.throughput:.1f} % of the light is left")
    if lattice.kind == "pinhole":
        side_um = 2.0 * lattice.half_aperture * lattice.pitch_mm * UM_PER_MM
        if side_um < 0.7 * found.best_pinhole_um:
            sentences.append(
                f"array: holes of {side_um:.0f} um are much smaller than the "
                f"{found.best_pinhole_um:.0f} um below which diffraction blurs more than it helps"
            )
    if found.views < 1.0:
        sentences.append("array: its pitch is smaller than a pixel")
    return sentences
