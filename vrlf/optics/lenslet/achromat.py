"""Cemented doublets that bring two colours to one focus, and the thesis's Table 7.1.

Two thin lenses in contact of powers p1 and p2 and Abbe numbers V1 and V2 have the same power for
the F and C lines if p1 / V1 + p2 / V2 = 0; so of the power p,

    p1 = p V1 / (V1 - V2),  p2 = -p V2 / (V1 - V2)             (Kingslake 1978, ch. 5)

The crown, of the higher V, is the convex one. From there the second and third curvature are solved
for the focal length wanted at d and for F and C to agree, thicknesses and all, whatever the first
curvature is. They agree in their focal lengths, so that the ray equations' bends are one, or in
their foci behind the lens; only thin lenses do both. The first curvature, the bending, is taken
where the spots on the axis and at the field's edge are least, at the gap that is best for both:
spherical aberration against coma, for field curvature and astigmatism hardly depend on it.

Table 7.1 of the thesis says: concave lens, radius 1.4805 mm, index 1.52, Abbe number 55; convex
lens, radius 2.961 mm, 1.65, 45. As a cemented doublet that is a convex lens of radii 2.961 and
1.4805 mm with a plano-concave lens of 1.4805 mm behind it. So made it has a focal length of some
3.3 mm and more colour than one lens alone: the flint is the convex lens. With the glasses exchanged
p1 / V1 = 0.0096 and p2 / V2 = -0.0098: an achromat, but of some 11 mm, nearly twice the gap of
6 mm that it is to focus. (Another reading, two plano lenses, has no positive power either way.)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf, sqrt
from typing import Final, Literal

import numpy as np

from vrlf.errors import InputError
from vrlf.optics.glass import C_LINE_NM, D_LINE_NM, F_LINE_NM
from vrlf.optics.lenslet.paraxial import cardinal, power_per_mm
from vrlf.optics.lenslet.spots import best_distance_mm, spot
from vrlf.optics.lenslet.surfaces import AIR, Lens, Medium, cemented
from vrlf.optics.lenslet.trace import Beam
from vrlf.optics.polynomial import Float

# Newton's steps double the right digits; from thin lenses these are more than enough.
_STEPS = 30
_EXACT = 1e-12
# Of the curvatures, in 1/mm, for their slopes.
_STEP = 1e-5
_NUDGES = _STEP * np.eye(3)[1:]
# Bendings tried first, as the first surface's share of the crown's curvature, and then golden
# sections: the optimum is flat, 30 of them place it to 1e-6.
_SHARES = np.linspace(-0.5, 1.5, 21)
_SECTIONS = 30
_GOLDEN = (sqrt(5.0) - 1.0) / 2.0

Agreeing = Literal["focal length", "focus"]

TABLE_7_1: Final = {
    "concave": (1.4805, Medium(index=1.52, abbe=55.0)),
    "convex": (2.961, Medium(index=1.65, abbe=45.0)),
}


def abbe_of(medium: Medium) -> float:
    """(n_d - 1) / (n_F - n_C); infinite without dispersion."""
    n_d, n_f, n_c = (medium.index_at(nm) for nm in (D_LINE_NM, F_LINE_NM, C_LINE_NM))
    return (n_d - 1.0) / (n_f - n_c) if n_f != n_c else inf


def thin_powers(focal_mm: float, crown: Medium, flint: Medium) -> tuple[float, float]:
    """Powers of the two thin lenses, 1/mm.

    Raises
    ------
    InputError
        If the glasses disperse alike, or the flint less.
    """
    v1, v2 = abbe_of(crown), abbe_of(flint)
    if not v1 > v2 + 1.0 or v1 == inf:
        raise InputError(
            f"achromat: found a crown of Abbe number {v1:.3g} and a flint of {v2:.3g}, wanted the "
            "crown's higher by more than 1"
        )
    return v1 / (v1 - v2) / focal_mm, -v2 / (v1 - v2) / focal_mm


def colour_difference(lens: Lens, agreeing: Agreeing) -> float:
    """Of F less C: the focal length's share, or the back focus's of the focal length at d."""
    if agreeing == "focal length":
        f, c = (power_per_mm(lens, nm) for nm in (F_LINE_NM, C_LINE_NM))
        return (c - f) / power_per_mm(lens, D_LINE_NM)
    f, c = (cardinal(lens, nm).back_focus_mm for nm in (F_LINE_NM, C_LINE_NM))
    return (f - c) * power_per_mm(lens, D_LINE_NM)


def achromat(
    focal_mm: float,
    crown: Medium,
    flint: Medium,
    aperture_mm: float,
    *,
    thicknesses_mm: tuple[float, float] = (0.35, 0.2),
    agreeing: Agreeing = "focal length",
    edge_slope: float | None = None,
    behind: Medium = AIR,
    square: bool = True,
) -> Lens:
    """A cemented doublet, the crown toward the eye, of one focal length at d and F = C.

    Parameters
    ----------
    thicknesses_mm : (float, float)
        Of crown and flint on the axis.
    agreeing : "focal length" or "focus"
        What is the same for F and C.
    edge_slope : float, optional
        Where the field ends; half the aperture over the focal length by default.

    Raises
    ------
    InputError
        If the glasses make none, or it cannot be made so thin.
    """
    edge = aperture_mm / 2.0 / focal_mm if edge_slope is None else edge_slope
    beams = [Beam(D_LINE_NM), Beam(D_LINE_NM, (0.0, edge))]
    thin = thin_powers(focal_mm, crown, flint)
    # 1 / r1 - 1 / r2 of the crown, 1 / r2 - 1 / r3 of the flint.
    bends = [p / (g.index_at(D_LINE_NM) - 1.0) for p, g in zip(thin, (crown, flint), strict=True)]
    blank = cemented(
        (0.0,) * 3, thicknesses_mm, (crown, flint), aperture_mm, behind=behind, square=square
    )

    def made(share: float) -> Lens:
        first = share * bends[0]
        thin_lenses = (first, first - bends[0], first - bends[0] - bends[1])
        return _solved(blank, thin_lenses, focal_mm, agreeing)

    def size(share: float) -> float:
        try:
            lens = made(share)
            lens.check()
            return _spread(lens, beams)
        except InputError:
            return inf

    lens = made(_least(size))
    lens.check()
    return lens


def _spread(lens: Lens, beams: list[Beam]) -> float:
    """Mean squared spot radius at the best gap."""
    distance_mm = best_distance_mm(lens, beams)
    return sum(spot(lens, beam, distance_mm).rms_mm ** 2 for beam in beams) / len(beams)


def _least(size: Callable[[float], float]) -> float:
    """The bending of least size: the best of a row, then golden sections about it."""
    sizes = [size(float(share)) for share in _SHARES]
    best = int(np.argmin(sizes))
    low = float(_SHARES[max(best - 1, 0)])
    high = float(_SHARES[min(best + 1, len(_SHARES) - 1)])
    for _ in range(_SECTIONS):
        width = _GOLDEN * (high - low)
        if size(high - width) <= size(low + width):
            high = low + width
        else:
            low = high - width
    return (low + high) / 2.0


def _bent(lens: Lens, curvatures: tuple[float, float, float] | Float) -> Lens:
    surfaces = [
        replace(each, curvature_per_mm=float(c))
        for each, c in zip(lens.surfaces, curvatures, strict=True)
    ]
    return replace(lens, surfaces=tuple(surfaces))


def _solved(
    blank: Lens, curvatures: tuple[float, float, float], focal_mm: float, agreeing: Agreeing
) -> Lens:
    """Second and third curvature by Newton's method, the first one kept."""
    c = np.array(curvatures)

    def faults(c: Float) -> Float:
        lens = _bent(blank, c)
        power = focal_mm * power_per_mm(lens, D_LINE_NM) - 1.0
        return np.array([power, colour_difference(lens, agreeing)])

    for _ in range(_STEPS):
        fault = faults(c)
        if np.abs(fault).max() < _EXACT:
            return _bent(blank, c)
        slopes = [(faults(c + step) - faults(c - step)) / (2.0 * _STEP) for step in _NUDGES]
        try:
            c[1:] -= np.linalg.solve(np.stack(slopes, axis=1), fault)
        except np.linalg.LinAlgError:
            break
    raise InputError("achromat: found no curvatures for so thick glasses, wanted thinner ones")


def table_7_1(aperture_mm: float, *, exchanged: bool = False) -> Lens:
    """The thesis's doublet as printed, or with its two glasses exchanged.

    It gives no thicknesses; 0.35 mm and 0.2 mm stand here, as of ``achromat``.
    """
    (inner, concave), (outer, convex) = TABLE_7_1["concave"], TABLE_7_1["convex"]
    first, second = (concave, convex) if exchanged else (convex, concave)
    return cemented((outer, -inner, 0.0), (0.35, 0.2), (first, second), aperture_mm)
