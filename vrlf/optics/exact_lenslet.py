"""A lenslet as it is made: a plano-convex lens of glass, its rays refracted exactly.

A ray comes as the paraxial trace has it, a place y on the array's plane and a slope; that
plane is the lens's first principal plane. From there on everything is exact: Snell's law at a
sphere and a plane in unit vectors, the sphere's sagitta, straight ways between. The second
principal plane stands where the thin lens did too (what is between the two planes is not
counted), a reduced gap g before the panel: small angles and heights land where the paraxial ray
does. Principal planes of a plano-convex lens of thickness t and index n: one touches the
curved side's vertex, the other lies t / n inside the plane side (Hecht 2017, 6.1). A ray stays in
the cell where it crosses the array's plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, sqrt
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vrlf.errors import InputError
from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.polynomial import Float
from vrlf.units import UM_PER_MM

CurvedSide = Literal["eye", "panel"]
# Acrylic, design.md's spacer.
LENSLET_INDEX = 1.49
# That of a triplet of colours that all are alike, or the reference of three.
GREEN = 1


@dataclass(frozen=True)
class ExactLenslet:
    """A plano-convex lens and the gap behind it; made by ``exact_lenslet``.

    Attributes
    ----------
    radius_mm, thickness_mm : float
        Of the curved side, and on the axis.
    index : (float, float, float)
        Of red, green and blue.
    curved : "eye" or "panel"
    gap_index : float
        Of what is between it and the panel.
    to_plane_mm : float
        From the array's plane back to the first surface's vertex, along the axis; 0 with the
        curved side to the eye.
    to_panel_mm : float
        From the last surface's vertex to the panel.
    """

    radius_mm: float
    thickness_mm: float
    index: tuple[float, float, float]
    curved: CurvedSide
    gap_index: float
    to_plane_mm: float
    to_panel_mm: float


def exact_lenslet(
    rig: Rig,
    *,
    index: tuple[float, float, float] = (LENSLET_INDEX,) * 3,
    focal_mm: float | None = None,
    thickness_mm: float | None = None,
    curved: CurvedSide = "eye",
) -> ExactLenslet:
    """The plano-convex lens whose focal length in green is the rig's.

    Parameters
    ----------
    rig : Rig
        With lenslets.
    index : (float, float, float)
    focal_mm : float, optional
        In green; by default the rig's ``array.focal_mm``.
    thickness_mm : float, optional
        By default the sagitta at its cell's corner: the lens ends in an edge there.
    curved : "eye" or "panel"
        Toward the eye a lens has less spherical aberration, and a solid spacer may touch it.

    Raises
    ------
    InputError
        If no sphere makes such a lens.
    """
    array, gap_mm = rig.array, bench_of(rig).reduced_gap_mm
    focal = array.focal_mm if focal_mm is None else focal_mm
    n = index[GREEN]
    beyond = array.gap_index if curved == "panel" else 1.0
    if not n > beyond:
        raise InputError(
            f"lenslets: found an index of {n:g} in a medium of {beyond:g}, wanted a higher one"
        )
    # R / (n - n') is the focal length of the curved side; the plane side adds no power.
    radius_mm = (n - beyond) * focal
    corner_mm = hypot(1.0, 1.0) * array.pitch_um / UM_PER_MM / 2.0
    if not radius_mm > corner_mm:
        raise InputError(
            f"array.focal_mm: found {focal:g}, for which a plano-convex lens of index "
            f"{n:g} has a radius of {radius_mm:.3g} mm, wanted more than {corner_mm:.3g} mm, its "
            f"cell's corner (a focal length above {corner_mm / (n - beyond):.3g})"
        )
    sagitta_mm = radius_mm - sqrt(radius_mm**2 - corner_mm**2)
    thick_mm = sagitta_mm if thickness_mm is None else thickness_mm
    inside_mm = thick_mm / n
    behind_mm = gap_mm if curved == "panel" else gap_mm - inside_mm
    if behind_mm <= 0.0:
        raise InputError(
            f"array.gap_mm: found {array.gap_mm:g}, wanted more than "
            f"{inside_mm * array.gap_index:.3g}, as much as a lenslet {thick_mm:.3g} mm thick takes"
        )
    return ExactLenslet(
        radius_mm=radius_mm,
        thickness_mm=thick_mm,
        index=index,
        curved=curved,
        gap_index=array.gap_index,
        to_plane_mm=inside_mm if curved == "panel" else 0.0,
        to_panel_mm=array.gap_index * behind_mm,
    )


def landing_mm(
    lens: ExactLenslet, place_mm: Float, slope: Float, colour: int
) -> tuple[Float, NDArray[np.bool_]]:
    """Where rays land on the panel from the lenslet's centre, and which come through.

    Parameters
    ----------
    place_mm, slope : ndarray (..., 2)
        On the array's plane from the lenslet's centre, any upright frame; direction before it.
    colour : int

    Returns
    -------
    (ndarray (..., 2), ndarray (...) of bool)
        A ray that misses the sphere, or is reflected totally, does not come through; its place
        is then without meaning.
    """
    n = lens.index[colour]
    at = place_mm - lens.to_plane_mm * slope
    direction = _unit(np.concatenate([slope, np.ones_like(slope[..., :1])], axis=-1))
    curved_first = lens.curved == "eye"
    if curved_first:
        at, z, direction, passes = _through_sphere(at, direction, lens.radius_mm, 1.0 / n)
        at = at + (lens.thickness_mm - z)[..., None] * _slope(direction)
        direction, onward = _through_plane(direction, n / lens.gap_index)
        z = np.zeros_like(z)
    else:
        direction, passes = _through_plane(direction, 1.0 / n)
        at = at + lens.thickness_mm * _slope(direction)
        at, z, direction, onward = _through_sphere(
            at, direction, -lens.radius_mm, n / lens.gap_index
        )
    return at + (lens.to_panel_mm - z)[..., None] * _slope(direction), passes & onward


def _unit(v: Float) -> Float:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def _slope(direction: Float) -> Float:
    return np.asarray(direction[..., :2] / direction[..., 2:])


def _through_plane(direction: Float, ratio: float) -> tuple[Float, NDArray[np.bool_]]:
    """Directions behind a plane across the axis; ``ratio`` is the index before over behind."""
    across = ratio * direction[..., :2]
    along = 1.0 - np.sum(across**2, axis=-1, keepdims=True)
    passes = along[..., 0] > 0.0
    along = np.sqrt(np.maximum(along, 1e-12))
    return np.concatenate([across, along], axis=-1), passes


def _through_sphere(
    at_mm: Float, direction: Float, radius_mm: float, ratio: float
) -> tuple[Float, Float, Float, NDArray[np.bool_]]:
    """Rays from the plane through a sphere's vertex: where they meet it, and go from there.

    Parameters
    ----------
    at_mm : ndarray (..., 2)
        On that plane.
    radius_mm : float
        Positive if the sphere's centre lies behind it, as the light goes.
    ratio : float
        Index before over behind.

    Returns
    -------
    (ndarray (..., 2), ndarray (...), ndarray (..., 3), ndarray (...) of bool)
        Place, depth behind the vertex, direction, and whether there is one.
    """
    squared = np.sum(at_mm**2, axis=-1)
    # Way to the point nearest the centre, and half the chord; the root that is near the vertex.
    nearest = radius_mm * direction[..., 2] - np.sum(at_mm * direction[..., :2], axis=-1)
    chord = nearest**2 - squared
    passes = chord > 0.0
    root = np.copysign(np.sqrt(np.maximum(chord, 0.0)), radius_mm)
    way = squared / np.where(passes, nearest + root, 1.0)
    met = at_mm + way[..., None] * direction[..., :2]
    z = way * direction[..., 2]
    # The normal along the light: toward the centre, or away from it.
    normal = np.concatenate([-met, (radius_mm - z)[..., None]], axis=-1) / radius_mm
    cosine = np.sum(normal * direction, axis=-1)
    beyond = 1.0 - ratio**2 * (1.0 - cosine**2)
    passes &= beyond > 0.0
    turned = np.sqrt(np.maximum(beyond, 0.0)) - ratio * cosine
    return met, z, ratio * direction + turned[..., None] * normal, passes
