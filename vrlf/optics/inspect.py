"""Everything that follows from a rig: the numbers that scripts rely on, and plain words."""

from __future__ import annotations

from dataclasses import asdict
from math import pi
from typing import Any

import numpy as np

from vrlf.model import Rig
from vrlf.optics import limits
from vrlf.optics.advice import advice
from vrlf.optics.bench import Bench, bench_of
from vrlf.optics.eye import (
    EyeOptics,
    aberration_at,
    amplitude_of_accommodation_d,
    clear_zone_mm,
    eye_optics,
    higher_order_rms_um,
    viewer,
)
from vrlf.optics.gaze import gaze_limit_deg
from vrlf.optics.lateral import lateral_px, longitudinal_d
from vrlf.optics.lattice import lattice_of
from vrlf.optics.openings import served_pupil
from vrlf.optics.refraction import sphero_cylinder
from vrlf.optics.relief import compared_relief_mm, relief_cost
from vrlf.optics.samples import pupil_points
from vrlf.optics.viewport import SIDES, Side, pitch_mm
from vrlf.units import MM_PER_M

# Vergences nearer than this to nothing count as nothing: an image beyond 1000 km.
_FLAT_PER_MM = 1e-9
# Rays of a spot: its radius is then known to a part in a thousand.
_SPOT_RAYS = 1024
_ARRAY_KEYS = tuple(limits.ArrayLimits.__dataclass_fields__)


def inspect_rig(rig: Rig) -> dict[str, Any]:
    """All numbers that follow from a rig.

    Returns
    -------
    dict
        ``left``, ``right``: ``sphere_d``, ``cylinder_d``, ``axis_deg`` (residual error at the
        pupil, panel vergence and accommodation in it), ``mean_error_d``,
        ``focus_distance_mm``, ``blur_mm``, ``blur_px``, ``accommodation_d``, and with an
        array ``corrected_blur_px``, ``best_focal_mm``, ``gaze_limit_deg`` and
        ``barrier_field_deg``. These are of the second order alone;
        ``paraxial_sphere_d``, ``paraxial_cylinder_d``, ``paraxial_axis_deg``,
        ``paraxial_mean_error_d`` have the higher orders in, at the pupil's centre. Of the eye by
        itself ``pupil_mm``, ``amplitude_d``, ``clear_zone`` (null for infinity),
        ``higher_order_rms_um`` over its pupil; ``spot_rms_px``, the radius of a point's image,
        root mean square, all orders in; ``served_pupil``, the share of the pupil for
        which the array is in focus. Then ``array``; ``display``; ``headset``; ``warnings``.
        Null (None) stands where a thing is not there.
    """
    found = array_numbers(rig)
    return {
        **{side: eye_numbers(rig, side) for side in SIDES},
        "array": {"kind": rig.array.kind, "lattice": _lattice_name(rig), **found},
        "display": display_numbers(rig),
        "headset": headset_numbers(rig),
        "warnings": advice(rig),
    }


def residual_matrix_d(bench: Bench, optics: EyeOptics) -> Any:
    """Residual error at the pupil, 1000 ((1 - d F) I + m R / 1000) / m, shape (2, 2)."""
    return MM_PER_M * limits.blur_matrix(bench, optics) / bench.panel_per_slope_mm


def eye_numbers(rig: Rig, side: Side) -> dict[str, Any]:
    """What one eye has left to be corrected, and what it is by itself."""
    return {**_residual_numbers(rig, side), **_own_numbers(rig, side)}


def _own_numbers(rig: Rig, side: Side) -> dict[str, Any]:
    """The eye by itself: pupil, reach, and its wavefront with all orders in."""
    bench, optics, eye = bench_of(rig), eye_optics(rig, side), viewer(rig, side)
    paraxial = MM_PER_M * limits.paraxial_blur_matrix(bench, optics) / bench.panel_per_slope_mm
    rx = sphero_cylinder(paraxial)
    zone, served = clear_zone_mm(eye), served_pupil(rig, optics)
    is_camera = (rig.left if side == "left" else rig.right).camera is not None
    return {
        "pupil_mm": optics.pupil_mm,
        "amplitude_d": 0.0 if is_camera else amplitude_of_accommodation_d(eye.age_years),
        "clear_zone": None if zone is None or is_camera else _zone(zone),
        "paraxial_sphere_d": rx.sphere_d,
        "paraxial_cylinder_d": rx.cylinder_d,
        "paraxial_axis_deg": rx.axis_deg,
        "paraxial_mean_error_d": float(np.trace(paraxial)) / 2.0,
        "higher_order_rms_um": higher_order_rms_um(eye),
        "spot_rms_px": spot_rms_px(rig, optics),
        "served_pupil": None if served is None else served.share,
    }


def spot_rms_px(rig: Rig, optics: EyeOptics) -> float:
    """Root mean square radius of a point's image on the bare panel, all orders and colours in.

    An even disc of that much is 2 sqrt 2 times as wide.
    """
    at = pupil_points(rig, optics, _SPOT_RAYS)
    landings = [
        bench.defocus_factor * at.u_mm
        + bench.panel_per_slope_mm * aberration_at(colour, at.from_centre_mm)
        for colour, bench in zip(optics.aberration, optics.benches, strict=True)
    ]
    spread = np.mean([np.sum(np.var(each, axis=0)) for each in landings])
    return float(np.sqrt(spread)) / pitch_mm(rig)


def _zone(zone: tuple[float | None, float | None]) -> dict[str, float | None]:
    return {"near_mm": zone[0], "far_mm": zone[1]}


def _residual_numbers(rig: Rig, side: Side) -> dict[str, float | None]:
    bench, optics, lattice = bench_of(rig), eye_optics(rig, side), lattice_of(rig)
    residual = residual_matrix_d(bench, optics)
    rx = sphero_cylinder(residual)
    blur_mm = optics.pupil_mm * limits.worst_meridian(limits.blur_matrix(bench, optics))
    numbers: dict[str, float | None] = {
        "sphere_d": rx.sphere_d,
        "cylinder_d": rx.cylinder_d,
        "axis_deg": rx.axis_deg,
        "mean_error_d": float(np.trace(residual)) / 2.0,
        "focus_distance_mm": limits.focus_distance_mm(bench, optics),
        "blur_mm": blur_mm,
        "blur_px": blur_mm / pitch_mm(rig),
        "accommodation_d": optics.accommodation_d,
        "corrected_blur_px": None,
        "best_focal_mm": None,
        "gaze_limit_deg": None,
        "barrier_field_deg": None,
    }
    if lattice is not None:
        spread_px = limits.opening_blur_mm(bench, lattice, optics) / pitch_mm(rig)
        numbers["corrected_blur_px"] = spread_px + limits.seen_pixel_px(bench, optics)
        focus_mm = limits.signed_focus_mm(bench, optics)
        numbers["best_focal_mm"] = limits.best_focal_mm(bench, focus_mm)
        numbers["gaze_limit_deg"] = gaze_limit_deg(bench, lattice, optics)
        if lattice.barriers == "perpendicular":
            numbers["barrier_field_deg"] = limits.barrier_field_deg(bench, lattice, optics)
    return numbers


def _lattice_name(rig: Rig) -> str | None:
    return None if rig.array.kind == "none" else rig.array.lattice


def array_numbers(rig: Rig) -> dict[str, float | None]:
    """The array's limits; without one all light passes and nothing else is defined."""
    found = limits.array_limits(rig)
    if found is None:
        return {**dict.fromkeys(_ARRAY_KEYS), "throughput": 1.0}
    return asdict(found)


def display_numbers(rig: Rig) -> dict[str, float | None]:
    """Pixels per degree, where the lens alone shows the panel, the axes' height on it."""
    bench = bench_of(rig)
    vergence_per_mm = 1.0 / bench.lens_to_panel_mm - bench.lens_power_per_mm
    flat = abs(vergence_per_mm) < _FLAT_PER_MM
    return {
        "pixels_per_degree": bench.panel_per_slope_mm * pi / 180.0 / pitch_mm(rig),
        "virtual_image_mm": None if flat else 1.0 / vergence_per_mm,
        "axis_height_px": rig.headset.lens_height_mm / pitch_mm(rig),
    }


def headset_numbers(rig: Rig) -> dict[str, Any]:
    """How far the lens takes the colours apart, and what the single-lens approximation costs."""
    costs = {side: relief_cost(rig, side) for side in SIDES}
    return {
        "approximated": rig.headset.eye_relief_mm == 0.0,
        "relief_mm": compared_relief_mm(rig),
        "longitudinal_d": longitudinal_d(rig),
        "lateral_px": max(lateral_px(rig, side) for side in SIDES),
        **{side: None if cost is None else asdict(cost) for side, cost in costs.items()},
    }
