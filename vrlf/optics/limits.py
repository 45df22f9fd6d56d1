"""What an array can and cannot do (T 4.3, 7.1), and how sharp an eye can see through it.

p is the panel's pixel pitch, D the array's, g the reduced gap, m the distance that turns
slopes into panel millimetres.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan, atan2, degrees, inf, sqrt

import numpy as np

from vrlf.model import Rig
from vrlf.optics.bench import Bench, bench_of
from vrlf.optics.eye import EyeOptics
from vrlf.optics.lattice import Lattice, lattice_of, pitches_over
from vrlf.optics.polynomial import Float
from vrlf.optics.samples import footprint_scale
from vrlf.optics.viewport import pitch_mm
from vrlf.units import MM_PER_M, NM_PER_MM, UM_PER_MM


@dataclass(frozen=True)
class ArrayLimits:
    """Limits of a rig's array, whatever the eye; in the lattice's middle where its pitch varies."""

    throughput: float
    field_of_view_deg: float
    views: float
    spatial_nyquist_per_mm: float
    depth_of_field_mm: float
    eyebox_mm: float
    best_pinhole_um: float
    lens_to_array_mm: float
    reduced_gap_mm: float
    least_pitch_um: float
    widest_pitch_um: float


def array_limits(rig: Rig) -> ArrayLimits | None:
    """The limits, or None without an array."""
    lattice, bench = lattice_of(rig), bench_of(rig)
    if lattice is None:
        return None
    gap_mm, cell_mm = bench.reduced_gap_mm, lattice.pitch_mm
    least, widest = pitches_over(rig, lattice)
    green_mm = rig.panel.wavelengths_nm[1] / NM_PER_MM
    return ArrayLimits(
        throughput=lattice.throughput,
        field_of_view_deg=degrees(2.0 * atan(cell_mm / (2.0 * gap_mm))),  # T 4.1
        views=cell_mm / pitch_mm(rig),
        spatial_nyquist_per_mm=1.0 / (2.0 * cell_mm * lattice.row_pitches),
        depth_of_field_mm=cell_mm * gap_mm / pitch_mm(rig),
        eyebox_mm=cell_mm * bench.panel_per_slope_mm / gap_mm,
        best_pinhole_um=sqrt(2.0 * green_mm * gap_mm) * UM_PER_MM,  # T 7.1
        lens_to_array_mm=bench.lens_to_array_mm,
        reduced_gap_mm=gap_mm,
        least_pitch_um=least * cell_mm * UM_PER_MM,
        widest_pitch_um=widest * cell_mm * UM_PER_MM,
    )


def blur_matrix(bench: Bench, optics: EyeOptics) -> Float:
    """Panel height per pupil height, (1 - d F) I + m R / 1000, shape (2, 2)."""
    spread = bench.panel_per_slope_mm * optics.matrix_d / MM_PER_M
    return np.asarray(bench.defocus_factor * np.eye(2) + spread)


def paraxial_blur_matrix(bench: Bench, optics: EyeOptics) -> Float:
    """The same about the pupil's centre, with all orders of the wavefront in."""
    spread = bench.panel_per_slope_mm * optics.paraxial_matrix_d / MM_PER_M
    return np.asarray(bench.defocus_factor * np.eye(2) + spread)


def worst_meridian(matrix: Float) -> float:
    """Largest absolute eigenvalue of a symmetric matrix."""
    return float(np.abs(np.linalg.eigvalsh(matrix)).max())


def signed_focus_mm(bench: Bench, optics: EyeOptics) -> float:
    """Plane of focus of the mean error, d_f: negative behind the lens, infinite at infinity.

    1 / (F - R / (1 + e R)), R in 1/mm. T 8.4 for e = 0 and F = 1/d.
    """
    mean_per_mm = float(np.trace(optics.matrix_d)) / 2.0 / MM_PER_M
    at_lens = 1.0 + bench.relief_mm * mean_per_mm
    difference = bench.lens_power_per_mm * at_lens - mean_per_mm
    return at_lens / difference if difference != 0.0 else inf


def focus_distance_mm(bench: Bench, optics: EyeOptics) -> float | None:
    """``signed_focus_mm`` where it is in front of the headset lens, else None."""
    focus_mm = signed_focus_mm(bench, optics)
    # A plane of focus a thousand kilometres off is none.
    return focus_mm if 0.0 < focus_mm < 1e9 else None


def best_focal_mm(bench: Bench, focus_mm: float) -> float | None:
    """Focal length of lenslets that image the panel onto the plane of focus.

    1/f = 1/g + 1/(s_a - d_f), signs kept (``signed_focus_mm``); None where no converging
    array serves.
    """
    distance_mm = bench.lens_to_array_mm - focus_mm
    if distance_mm == 0.0:
        return None  # the eye focuses on the array itself: no lenslet images anything there
    power = 1.0 / bench.reduced_gap_mm + 1.0 / distance_mm
    return 1.0 / power if power > 0.0 else None


def seen_pixel_px(bench: Bench, optics: EyeOptics) -> float:
    """Size at which one panel pixel is seen through one opening, in retinal pixels.

    The eigenvalues of dX/dx = I + a (m / g) B, with a = (e + s_a (1 - e F)) / m and B the
    blur matrix: the derivative of the inverse map within a cell.
    """
    reach = bench.panel_per_slope_mm / bench.reduced_gap_mm
    return worst_meridian(np.eye(2) + bench.array_from_panel * reach * blur_matrix(bench, optics))


def opening_blur_mm(bench: Bench, lattice: Lattice, optics: EyeOptics) -> float:
    """How far one panel point spreads on the retina through one opening.

    For a fixed panel point, moving by dy in the opening moves the retinal point by
    -(m / g) (B - (g / f) Phi) dy, where Phi = (1 - s_a F) I + (e + s_a (1 - e F)) R / 1000:
    zero where the lenslets image the panel onto the plane of focus.
    """
    reach = bench.panel_per_slope_mm / bench.reduced_gap_mm
    at_array = bench.array_per_slope_mm * optics.matrix_d / MM_PER_M
    phi = bench.array_defocus_factor * np.eye(2) + at_array
    unfocused = worst_meridian(blur_matrix(bench, optics) - bench.bend * phi)
    opening_mm = 2.0 * min(lattice.half_aperture, 0.5) * lattice.pitch_mm
    # An opening's rays spread over the pupil by (m / g) (1 - (g / f) a): it may be smaller.
    kappa = abs(footprint_scale(bench, lattice))
    through_mm = reach * opening_mm
    if through_mm * kappa > optics.pupil_mm:
        through_mm = optics.pupil_mm / kappa
    return through_mm * unfocused


def barrier_field_mm(bench: Bench, lattice: Lattice, optics: EyeOptics) -> float:
    """Half the field in which perpendicular barriers leave cells that show anything.

    On the array, from the axis: |c (1 - e F) - o| <= a/2 + D (e + s_a (1 - e F)) / 2g.
    """
    half = optics.pupil_mm / 2.0
    half += lattice.pitch_mm * bench.array_per_slope_mm / (2.0 * bench.reduced_gap_mm)
    return half / abs(bench.relief_factor) if bench.relief_factor != 0.0 else inf


def barrier_field_deg(bench: Bench, lattice: Lattice, optics: EyeOptics) -> float:
    """That field as an angle, from border to border, at the pupil."""
    reach_mm = abs(bench.array_per_slope_mm)
    return degrees(2.0 * atan2(barrier_field_mm(bench, lattice, optics), reach_mm))
