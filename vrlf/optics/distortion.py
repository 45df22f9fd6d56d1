"""The headset lens's radial distortion, and the way back.

Brown 1966 ("Decentering Distortion of Lenses"), radial terms: the lens shows the panel slope r,
r = |X| / m, at

    R = r (1 + k1 r^2 + k2 r^4).

A target is drawn for the slope that is seen, so what stands on the panel at r shows R, and a
thing to be seen at R is drawn at the r that leads there: one root of a polynomial of the fifth
degree. It is found by Newton's steps held in a bracket, to rounding. Outward R may turn back
(k1 or k2 below 0): beyond that nothing new is shown and R has no r of its own.
"""

from __future__ import annotations

from math import inf, sqrt

import numpy as np

from vrlf.errors import InputError
from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import Side, pitch_mm, viewport

Coefficients = tuple[float, float]
# Bisection alone needs 60 steps for 1e-18 of the bracket; Newton's are 6 or 7 as a rule.
_MOST_STEPS = 80


def coefficients_of(rig: Rig) -> Coefficients:
    """k1 and k2; zeros for a lens that bends no line."""
    return rig.headset.distortion or (0.0, 0.0)


def seen_slopes(slopes: Float, k: Coefficients) -> Float:
    """Where the lens shows slopes of panel points, shape (..., 2) in and out."""
    r2 = np.sum(np.square(slopes), axis=-1, keepdims=True)
    return np.asarray(slopes * (1.0 + r2 * (k[0] + r2 * k[1])))


def seen_radius(r: Float, k: Coefficients) -> Float:
    """The same of distances from the axis."""
    return np.asarray(r * (1.0 + r**2 * (k[0] + r**2 * k[1])))


def turning_radius(k: Coefficients) -> float:
    """The panel slope beyond which R falls again, 1 + 3 k1 r^2 + 5 k2 r^4 = 0; infinite if none."""
    a, b = 5.0 * k[1], 3.0 * k[0]
    below_root = b * b - 4.0 * a
    if below_root <= 0.0:  # at 0 it rests, and rises again
        return inf
    # r^2 = 2 / (-b +- sqrt(b^2 - 4 a)): no difference of like numbers, and no division by k2.
    below = [-b - sqrt(below_root), -b + sqrt(below_root)]
    roots = [2.0 / each for each in below if each > 0.0]
    return sqrt(min(roots)) if roots else inf


def most_seen(k: Coefficients) -> float:
    """How far from the axis the lens shows anything, before it turns back; infinite as a rule."""
    turn = turning_radius(k)
    return float(seen_radius(np.asarray(turn), k)) if turn < inf else inf


def panel_radius(seen: Float, k: Coefficients) -> Float:
    """The panel slopes r that the lens shows at distances ``seen`` from the axis.

    Parameters
    ----------
    seen : ndarray (...)
        Not below 0.

    Returns
    -------
    ndarray (...)
        Of several the one nearest the axis, which runs on from it without a turn.

    Raises
    ------
    InputError
        If the lens shows nothing there.
    """
    seen = np.asarray(seen, np.float64)
    turn, most = turning_radius(k), most_seen(k)
    if seen.size and float(seen.max()) > most:
        raise InputError(
            f"headset.distortion: found {list(k)}, which shows nothing beyond the slope {most:.4g} "
            f"(it turns back there), wanted one that reaches {float(seen.max()):.4g}"
        )
    low, high = np.zeros_like(seen), _bracket(seen, k, turn)
    r = np.minimum(seen, high)
    for _ in range(_MOST_STEPS):
        error = seen_radius(r, k) - seen
        low, high = np.where(error < 0.0, r, low), np.where(error < 0.0, high, r)
        rising = 1.0 + r**2 * (3.0 * k[0] + 5.0 * k[1] * r**2)
        step = r - np.divide(error, rising, out=np.full_like(r, np.nan), where=rising > 0.0)
        following = np.where((step > low) & (step < high), step, (low + high) / 2.0)
        # Where nothing is off, nothing moves: a step of 0 lies on the bracket's end.
        following = np.where(error == 0.0, r, following)
        if np.array_equal(following, r):
            break
        r = following
    return np.asarray(r)


def _bracket(seen: Float, k: Coefficients, turn: float) -> Float:
    """A radius that is shown beyond each of ``seen``, no further than the turn."""
    if turn < inf:
        return np.full_like(seen, turn)
    high = np.maximum(seen, 1e-300)
    for _ in range(2000):
        short = seen_radius(high, k) < seen
        if not short.any():
            break
        high = np.where(short, 2.0 * high, high)
    return np.asarray(high)


def panel_slopes(seen: Float, k: Coefficients) -> Float:
    """The panel slopes of points that are seen at ``seen``, shape (..., 2) in and out.

    Raises
    ------
    InputError
        As ``panel_radius``.
    """
    seen = np.asarray(seen, np.float64)
    distance = np.hypot(seen[..., 0], seen[..., 1])
    ratio = np.divide(
        panel_radius(distance, k), distance, out=np.ones_like(distance), where=distance > 0.0
    )
    return np.asarray(seen * ratio[..., None])


def edge_radius(rig: Rig, side: Side) -> float:
    """The largest panel slope |X| / m in an eye's viewport: its farthest corner's."""
    view, pitch = viewport(rig, side), pitch_mm(rig)
    left_mm = (view.first_column - rig.panel.width_px / 2.0) * pitch - view.axis_mm[0]
    top_mm = rig.panel.height_px / 2.0 * pitch - view.axis_mm[1]
    across_mm = max(abs(left_mm), abs(left_mm + view.width_px * pitch))
    up_mm = max(abs(top_mm), abs(top_mm - view.height_px * pitch))
    return float(np.hypot(across_mm, up_mm)) / bench_of(rig).panel_per_slope_mm
