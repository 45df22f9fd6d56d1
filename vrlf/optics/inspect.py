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
from vrlf.optics.eye import EyeOptics, eye_optics
from vrlf.optics.gaze import gaze_limit_deg
from vrlf.optics.lateral import lateral_px, longitudinal_d
from vrlf.optics.lattice import lattice_of
from vrlf.optics.refraction import sphero_cylinder
from vrlf.optics.relief import compared_relief_mm, relief_cost
from vrlf.optics.viewport import SIDES, Side, pitch_mm
from vrlf.units import MM_PER_M

# Vergences nearer than this to nothing count as nothing: an image beyond 1000 km.
_FLAT_PER_MM = 1e-9
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
        ``barrier_field_deg``; ``array``; ``display``; ``headset``; ``warnings``.
        Null (None) stands where a thing is not there.
    """
    found = array_numbers(rig)
    return {
        **{side: eye_numbers(rig, side) for side in SIDES},
        "array": {"kind": rig.array.kind, **found},
        "display": display_numbers(rig),
        "headset": headset_numbers(rig),
        "warnings": advice(rig),
    }


def residual_matrix_d(bench: Bench, optics: EyeOptics) -> Any:
    """Residual error at the pupil, 1000 ((1 - d F) I + m R / 1000) / m, shape (2, 2)."""
    return MM_PER_M * limits.blur_matrix(bench, optics) / bench.panel_per_slope_mm


def eye_numbers(rig: Rig, side: Side) -> dict[str, float | None]:
    """What one eye has left to be corrected."""
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
