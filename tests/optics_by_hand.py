"""The design's optics once more, written from its page and not from the code under test.

No helper is shared with ``vrlf.optics``: what agrees with this agrees with the equations. Points
are (..., 2). Rigs come from keyword tables.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, factorial, pi, radians, sin, sqrt
from typing import Any

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from vrlf.model import Eye, Rig, rig_from_tables
from vrlf.optics.viewport import Side

Points = NDArray[np.float64]

PITCH_MM = 0.078

# A busy machine is no reason for a property to fail.
unhurried = settings(deadline=None)


def rig(**tables: dict[str, Any]) -> Rig:
    """A rig of 60 x 30 pixels, axes in the middle of the viewports, two perfect eyes."""
    base: dict[str, dict[str, Any]] = {
        "panel": {"width_px": 60, "height_px": 30, "pixel_pitch_um": 78.0, "subpixels": "full"},
        "headset": {"lens_to_panel_mm": 46.0, "lens_separation_mm": 30 * PITCH_MM},
        "array": {"kind": "none"},
        "left": {"vertex_mm": 0.0},
        "right": {"vertex_mm": 0.0},
    }
    for name, change in tables.items():
        base[name] = base.get(name, {}) | change
    return rig_from_tables(base)


@dataclass(frozen=True)
class Ray:
    """A backward ray: from the optical axis, in mm; ``alpha`` is a slope."""

    alpha: Points
    array_mm: Points
    centre_mm: Points
    panel_mm: Points


def lengths_mm(given: Rig) -> tuple[float, float, float, float]:
    """e, F (1/mm), s_a, g as the rig file's page defines them."""
    headset, array = given.headset, given.array
    power_d = headset.lens_power_d
    power = 1.0 / headset.lens_to_panel_mm if power_d is None else power_d / 1000.0
    if array.kind == "none":
        return headset.eye_relief_mm, power, headset.lens_to_panel_mm, 0.0
    return (
        headset.eye_relief_mm,
        power,
        headset.lens_to_panel_mm - array.gap_mm,
        array.gap_mm / array.gap_index,
    )


def slope_distance_mm(given: Rig) -> float:
    """m = e + d - d e F."""
    e, power, s_a, g = lengths_mm(given)
    return e + (s_a + g) - (s_a + g) * e * power


def wavefront_um(terms: dict[tuple[int, int], float], diameter_mm: float, u: Points) -> Points:
    """OSA/ANSI wavefront at points of the wearer's pupil, by radius and angle."""
    # The examiner looks at the patient: what is right to the wearer is left to them.
    x, y = -u[..., 0], u[..., 1]
    rho, theta = np.hypot(x, y) / (diameter_mm / 2.0), np.arctan2(y, x)
    total = np.zeros_like(rho)
    for (n, m), value in terms.items():
        k = abs(m)
        radial = sum(
            (-1) ** s
            * factorial(n - s)
            / (factorial(s) * factorial((n + k) // 2 - s) * factorial((n - k) // 2 - s))
            * rho ** (n - 2 * s)
            for s in range((n - k) // 2 + 1)
        )
        norm = sqrt(n + 1) if m == 0 else sqrt(2 * (n + 1))
        total += value * norm * radial * (np.cos(k * theta) if m >= 0 else np.sin(k * theta))
    return total


def matrix_d(eye: Eye) -> Points:
    """Prescription at the pupil in the wearer's frame, meridian by meridian."""
    angle = radians(eye.axis_deg)
    # TABO as the examiner sees it; the wearer sees x mirrored.
    along, across = np.array([-cos(angle), sin(angle)]), np.array([sin(angle), cos(angle)])

    def at_pupil(power_d: float) -> float:
        return power_d / (1.0 - eye.vertex_mm / 1000.0 * power_d)

    return np.asarray(
        at_pupil(eye.sphere_d) * np.outer(along, along)
        + at_pupil(eye.sphere_d + eye.cylinder_d) * np.outer(across, across)
    )


def aberration(eye: Eye, from_centre_mm: Points) -> Points:
    """T of a relaxed eye at 589 nm, at points from the pupil's centre."""
    # The matrix is symmetric: on which side of the points it stands makes no difference.
    slope = from_centre_mm @ matrix_d(eye) / 1000.0 + np.array(eye.prism_pd) / 100.0
    if eye.zernike is not None:
        terms, diameter = dict(eye.zernike.terms), eye.zernike.diameter_mm
        # Central differences: their own error is a millionth of the slopes used here.
        for axis, step in enumerate(np.eye(2) * 1e-4):
            rise = wavefront_um(terms, diameter, from_centre_mm + step)
            rise -= wavefront_um(terms, diameter, from_centre_mm - step)
            slope[..., axis] -= rise / 2e-4 / 1000.0
    return np.asarray(slope)


def axis_mm(given: Rig, side: Side) -> Points:
    half = given.headset.lens_separation_mm / 2.0
    return np.array([-half if side == "left" else half, given.headset.lens_height_mm])


def cell_centre_mm(given: Rig, side: Side, y: Points) -> Points:
    """Centre of the lattice cell that holds ``y``; both relative to the eye's axis."""
    array = given.array
    turn = radians(array.rotation_deg)
    if array.lattice == "hexagonal":
        return _hexagonal_centre_mm(given, side, y)
    across = np.array([cos(turn), sin(turn)]) * array.pitch_um / 1000.0
    upward = np.array([-sin(turn), cos(turn)]) * array.pitch_um / 1000.0
    offset = np.array(array.offset_um) / 1000.0
    from_origin = y + axis_mm(given, side) - offset
    pitch_squared = across @ across
    k = np.floor(from_origin @ across / pitch_squared + 0.5)
    row = np.floor(from_origin @ upward / pitch_squared + 0.5)
    centre = np.multiply.outer(k, across) + np.multiply.outer(row, upward)
    return np.asarray(centre + offset - axis_mm(given, side))


def _hexagonal_centre_mm(given: Rig, side: Side, y: Points) -> Points:
    """The nearest of all centres about, each tried by itself."""
    array = given.array
    pitch, turn = array.pitch_um / 1000.0, radians(array.rotation_deg)
    steps = pitch * np.array([[cos(turn + each), sin(turn + each)] for each in (0.0, pi / 3.0)])
    offset = np.array(array.offset_um) / 1000.0 - axis_mm(given, side)
    # A cell near the point: its rows are pitch sin 60 deg apart.
    near = np.rint((y - offset) @ np.linalg.inv(steps))
    tried = [near + np.array([i, j]) for i in range(-2, 3) for j in range(-2, 3)]
    centres = np.array([each @ steps + offset for each in tried])
    apart = np.linalg.norm(centres - y, axis=-1)
    best = apart.argmin(axis=0)
    return np.asarray(np.take_along_axis(centres, best[None, ..., None], axis=0)[0])


def backward(given: Rig, side: Side, X: Points, u: Points, slope: Points, bent: bool = True) -> Ray:
    """The design's backward ray, line by line; ``slope`` is T there."""
    e, power, s_a, g = lengths_mm(given)
    alpha = X / slope_distance_mm(given) + slope
    h = u + e * alpha
    beta = alpha - power * h
    y = h + s_a * beta
    if given.array.kind == "none":
        return Ray(alpha, y, y, y + g * beta)
    c = cell_centre_mm(given, side, y)
    x = y + g * beta
    if bent and given.array.kind == "microlens":
        x = x - g * (y - c) / given.array.focal_mm
    return Ray(alpha, y, c, x)


def chief(given: Rig, side: Side, x: Points, o: Points) -> Ray:
    """The unbent ray from the panel point ``x`` to the pupil point ``o``, by trial and rule."""
    zero = np.zeros(2)
    m = slope_distance_mm(given)
    start = backward(given, side, zero, o, zero, bent=False).panel_mm
    unit = backward(given, side, np.ones(2) * m, o, zero, bent=False).panel_mm - start
    return backward(given, side, (x - start) / unit * m, o, zero, bent=False)


def inverse(given: Rig, x: Points, c: Points) -> tuple[Points, Points]:
    """The design's inverse: the ray from x through the centre c; (u, alpha)."""
    e, power, s_a, g = lengths_mm(given)
    beta = (x - c) / g
    h = c - s_a * beta
    alpha = beta + power * h
    return h - e * alpha, alpha


def _numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_infinity=False)


def _pairs(limit: float) -> st.SearchStrategy[list[float]]:
    return st.lists(_numbers(-limit, limit), min_size=2, max_size=2)


_EYES = st.fixed_dictionaries(
    {
        "sphere_d": _numbers(-9, 6),
        "cylinder_d": _numbers(-4, 4),
        "axis_deg": _numbers(0, 180),
        "vertex_mm": _numbers(0, 15),
        "pupil_mm": _numbers(2, 7),
        "pupil_offset_mm": _pairs(1.5),
        "prism_pd": _pairs(0.8),
    },
    optional={
        "zernike": st.fixed_dictionaries(
            {
                "diameter_mm": _numbers(4, 7),
                "extrapolate": st.just(True),
                "coefficients_um": st.dictionaries(
                    st.sampled_from(["1,-1", "2,0", "2,-2", "3,-1", "3,1", "3,3", "4,0", "5,-3"]),
                    _numbers(-0.4, 0.4),
                ),
            }
        )
    },
)


@st.composite
def rigs(draw: st.DrawFn, kinds: tuple[str, ...] = ("microlens", "pinhole")) -> Rig:
    """Rigs with everything that moves a ray: relief, lens power, spacer, lattice, eyes."""
    headset = {
        "lens_to_panel_mm": draw(_numbers(30, 80)),
        "lens_separation_mm": draw(_numbers(0, 60)),
        "lens_height_mm": draw(_numbers(-2, 2)),
        "eye_relief_mm": draw(st.one_of(st.just(0.0), _numbers(0, 20))),
    }
    power_d = draw(st.one_of(st.none(), _numbers(0, 25)))
    if power_d is not None:
        headset["lens_power_d"] = power_d
    array = {
        "kind": draw(st.sampled_from(kinds)),
        "pitch_um": draw(_numbers(200, 500)),
        "gap_mm": draw(_numbers(1, 8)),
        "gap_index": draw(_numbers(1, 1.6)),
        "focal_mm": draw(_numbers(1, 10)),
        "aperture_um": draw(_numbers(50, 200)),
        "offset_um": draw(_pairs(300)),
        "rotation_deg": draw(_numbers(-60, 60)),
        "lattice": draw(st.sampled_from(("square", "hexagonal"))),
    }
    if array["lattice"] == "hexagonal":  # no larger square stands in a hexagon
        array["aperture_um"] = min(array["aperture_um"], 0.73 * array["pitch_um"])
    return rig(headset=headset, array=array, left=draw(_EYES), right=draw(_EYES))


sides: st.SearchStrategy[Side] = st.sampled_from(("left", "right"))


def points_mm(limit: float) -> st.SearchStrategy[Points]:
    return _pairs(limit).map(np.array)
