"""Leaves, grass and petals: one folded blade, and where its many instances stand.

Sizes are lognormal, as those of real leaves are; leaves crowd toward the outside of a crown
and hang together in tufts. Every scatterer takes its own generator: the same seed gives the
same garden.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Float = NDArray[np.float64]
Leaves = NDArray[np.void]

BLADE = np.dtype([("in_blade", "f4", 2)])
LEAF = np.dtype(
    [
        ("in_origin", "f4", 3),
        ("in_along", "f4", 3),
        ("in_across", "f4", 3),
        ("in_tint", "f4", 3),
        ("in_traits", "f4", 4),
    ]
)

_UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True)
class Habit:
    """How the leaves of a plant are.

    Attributes
    ----------
    length_m, spread : float
        Median length, and the standard deviation of its logarithm.
    slimness : float
        Length over half the width.
    tint : (r, g, b)
        Albedo, linear; single leaves vary around it.
    taper : float
        0 a leaf, 1 a blade of grass.
    bend : float
        How far the tip hangs, in lengths.
    sway_m : float
        How far the wind moves a tip.
    """

    length_m: float
    tint: tuple[float, float, float]
    spread: float = 0.35
    slimness: float = 4.0
    taper: float = 0.0
    bend: float = 0.15
    sway_m: float = 0.006


@dataclass(frozen=True)
class Crown:
    """An ellipsoid of foliage; ``density`` is its optical depth for sunlight, 1/m."""

    centre_m: tuple[float, float, float]
    radii_m: tuple[float, float, float]
    density: float


def blade(segments: int) -> tuple[NDArray[np.void], NDArray[np.int64]]:
    """The blade that every leaf is: a midrib and two edges, meeting at the tip.

    Returns
    -------
    vertices, triangles
        Three vertices at each of ``segments`` places along it, and the tip.
    """
    # Closer together where the outline curves most, at the stalk.
    along = np.linspace(0.0, 1.0, segments + 1)[:-1] ** 1.3
    rows = [(t, s) for t in along for s in (-1.0, 0.0, 1.0)]
    vertices = np.zeros(len(rows) + 1, BLADE)
    vertices["in_blade"] = [*rows, (1.0, 0.0)]
    triangles: list[tuple[int, int, int]] = []
    for row in range(segments - 1):
        for a in (3 * row, 3 * row + 1):
            triangles += [(a, a + 1, a + 4), (a, a + 4, a + 3)]
    last, tip = 3 * (segments - 1), 3 * segments
    triangles += [(last, last + 1, tip), (last + 1, last + 2, tip)]
    return vertices, np.array(triangles)


def _unit(vectors: Float) -> Float:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def leaves_at(
    rng: np.random.Generator,
    origins: Float,
    along: Float,
    facing: Float,
    habit: Habit,
    open_sky: ArrayLike = 1.0,
) -> Leaves:
    """Leaves at these places.

    Parameters
    ----------
    origins, along, facing : ndarray, shape (N, 3)
        Stalk ends; directions of the midribs; directions that the upper sides tend to face.
    open_sky : array_like, shape (N,) or ()
        Share of the skylight that reaches each.
    """
    count = len(origins)
    length = habit.length_m * np.exp(habit.spread * rng.standard_normal(count))
    direction = _unit(along)
    across = _unit(np.cross(facing, direction))
    leaves = np.zeros(count, LEAF)
    leaves["in_origin"] = origins
    leaves["in_along"] = direction * length[:, None]
    leaves["in_across"] = across * (length / habit.slimness)[:, None]
    # Lightness varies more than hue does; some leaves turn yellow.
    lightness = np.exp(0.30 * rng.standard_normal((count, 1)))
    hue = 1.0 + rng.standard_normal((count, 1)) * np.array([0.16, 0.04, 0.08])
    leaves["in_tint"] = np.clip(np.array(habit.tint) * lightness * hue, 0.005, 0.85)
    bend = habit.bend * rng.uniform(0.3, 1.7, count)
    share = np.broadcast_to(open_sky, count)
    traits = (np.full(count, habit.taper), bend, share, np.full(count, habit.sway_m))
    leaves["in_traits"] = np.stack(traits, axis=-1)
    return leaves


def crown_leaves(
    rng: np.random.Generator, crown: Crown, habit: Habit, count: int, *, tuft: int = 40
) -> Leaves:
    """Leaves in tufts near the outside of a crown."""
    centre, radii = np.array(crown.centre_m), np.array(crown.radii_m)
    tufts = max(1, count // tuft)
    direction = _unit(rng.standard_normal((tufts, 3)))
    # A cube root would fill the ball evenly; leaves crowd where the light is.
    reach = rng.uniform(0.0, 1.0, (tufts, 1)) ** 0.22
    which = rng.integers(0, tufts, count)
    # Tufts differ in size by their own, so that there are gaps of all sizes between them.
    size = 0.16 * np.exp(0.5 * rng.standard_normal((tufts, 1)))
    ball = (direction * reach)[which] + size[which] * rng.standard_normal((count, 3))
    # No leaf hangs in the air: what strays beyond the crown is drawn back to its surface.
    far = np.linalg.norm(ball, axis=1, keepdims=True)
    ball *= np.minimum(1.0, rng.uniform(0.85, 1.06, (count, 1)) / far)
    outward = _unit(ball + 1e-9)
    along = outward + 0.9 * rng.standard_normal((count, 3)) - 0.35 * _UP
    facing = 0.6 * outward + 0.9 * _UP + 0.7 * rng.standard_normal((count, 3))
    depth = np.clip(1.0 - np.linalg.norm(ball, axis=1), 0.0, 1.0)
    lower = np.clip(0.5 - 0.5 * ball[:, 1], 0.0, 1.0)
    open_sky = np.exp(-2.2 * depth) * (1.0 - 0.45 * lower)
    return leaves_at(rng, centre + radii * ball, along, facing, habit, open_sky)


def bank_leaves(
    rng: np.random.Generator, low: ArrayLike, high: ArrayLike, habit: Habit, count: int
) -> Leaves:
    """Leaves of a clipped hedge or a bed, in a box; denser toward its top and front (+z)."""
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    share = rng.uniform(0.0, 1.0, (count, 3))
    share[:, 1:] **= (0.6, 0.5)
    # The hedge's face is not flat: whole stretches stand out.
    wave = np.sin(9.0 * share[:, 0] + 5.0 * share[:, 1]) * np.sin(23.0 * share[:, 0])
    share[:, 2] += 0.25 * wave
    along = rng.standard_normal((count, 3)) + np.array([0.0, 0.5, 0.7])
    facing = rng.standard_normal((count, 3)) * 0.6 + np.array([0.0, 1.0, 0.8])
    open_sky = 0.25 + 0.75 * share[:, 1] * np.clip(share[:, 2], 0.2, 1.0)
    return leaves_at(rng, low + (high - low) * share, along, facing, habit, open_sky)


def grass_blades(
    rng: np.random.Generator,
    *,
    ground_y_m: float,
    near_m: float,
    far_m: float,
    half_slope: float,
    habit: Habit,
    count: int,
) -> Leaves:
    """Grass on a wedge of ground before the eyes, as many blades near as far in the picture."""
    # Even in 1/z is even in the picture's rows.
    z = 1.0 / rng.uniform(1.0 / far_m, 1.0 / near_m, count)
    x = z * rng.uniform(-half_slope, half_slope, count)
    # Meadows grow in patches.
    patchy = np.sin(1.3 * x + 2.0 * np.sin(0.9 * z)) * np.sin(1.1 * z + np.sin(1.7 * x))
    keep = rng.uniform(0.0, 1.0, count) < 0.62 + 0.38 * patchy
    origins = np.stack([x, np.full(count, ground_y_m), -z], axis=-1)[keep]
    lean = rng.standard_normal((len(origins), 3)) * (0.45, 0.1, 0.45)
    facing = rng.standard_normal((len(origins), 3)) * (1.0, 0.1, 1.0)
    return leaves_at(rng, origins, lean + _UP, facing, habit, 0.8)


def rosette(rng: np.random.Generator, centre: ArrayLike, habit: Habit, count: int) -> Leaves:
    """A house plant's leaves: all from one place, arching outward at golden angles."""
    turn = np.arange(count) * np.pi * (3.0 - np.sqrt(5.0)) + 0.3 * rng.standard_normal(count)
    rise = np.linspace(1.9, 0.15, count) + 0.15 * rng.standard_normal(count)
    outward = np.stack([np.cos(turn), np.zeros(count), np.sin(turn)], axis=-1)
    along = outward + rise[:, None] * _UP
    facing = -outward * rise[:, None] + _UP
    stalk = 0.012 * outward * rng.uniform(0.2, 1.0, (count, 1))
    open_sky = np.linspace(1.0, 0.45, count)
    return leaves_at(rng, np.asarray(centre) + stalk, along, facing, habit, open_sky)


def twig_leaves(rng: np.random.Generator, line: Float, habit: Habit, count: int) -> Leaves:
    """Leaves along a twig, shape (P, 3), in turn to the left and the right."""
    at = np.linspace(0.08, 1.0, count) * (len(line) - 1)
    low = np.minimum(at.astype(int), len(line) - 2)
    origins = line[low] + (line[low + 1] - line[low]) * (at - low)[:, None]
    forward = _unit(line[low + 1] - line[low])
    side = _unit(np.cross(forward, _UP)) * np.where(np.arange(count) % 2, 1.0, -1.0)[:, None]
    along = forward * 0.6 + side + 0.3 * rng.standard_normal((count, 3)) - 0.25 * _UP
    facing = _UP + 0.45 * rng.standard_normal((count, 3))
    return leaves_at(rng, origins, along, facing, habit, 0.85)
