"""The shipped scene: a garden table with an open book, and the garden behind it.

Metres, seen from (0, 0, 0) along -z. Print at 0.35 to 0.5 m, a pot plant at 0.8 m, a bough
at 1.2 m, then grass, a hedge, a house, trees and a brick wall up to 20 m.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vrlf.scene.foliage import (
    Crown,
    Habit,
    Leaves,
    bank_leaves,
    crown_leaves,
    grass_blades,
    rosette,
    twig_leaves,
)
from vrlf.scene.pages import LEFT_PAGE, NOTICE, RIGHT_PAGE, SLIP, Sheet
from vrlf.scene.solids import Material, Solid, box, merge, page, quad, tube, turned

Float = NDArray[np.float64]

GROUND_Y_M = -1.3
TABLE_Y_M = -0.30
TO_SUN = (-0.50, 0.72, 0.48)  # over the left shoulder

_SEED = 20200527
_UP = np.array([0.0, 1.0, 0.0])

# Places of single things.
_POT = np.array([-0.36, TABLE_Y_M, -0.80])
_OAK = np.array([-3.1, GROUND_Y_M, -7.0])
_BIRCH = np.array([2.1, GROUND_Y_M, -12.5])
_FAR_TREES = ((-8.5, -17.0, 5.2), (-2.6, -19.0, 4.4), (5.5, -19.5, 4.8), (10.5, -17.5, 5.6))

_OAK_LEAF = Habit(0.105, (0.085, 0.150, 0.028), slimness=3.6)
_BIRCH_LEAF = Habit(0.085, (0.150, 0.205, 0.045), slimness=3.0)
_FAR_LEAF = Habit(0.20, (0.070, 0.120, 0.040), spread=0.5, slimness=3.0)
_HEDGE_LEAF = Habit(0.055, (0.055, 0.110, 0.024), slimness=3.2, sway_m=0.002)
_GRASS = Habit(0.085, (0.130, 0.190, 0.040), spread=0.5, slimness=26.0, taper=1.0, bend=0.30)
_LILY_LEAF = Habit(0.165, (0.060, 0.155, 0.040), spread=0.22, slimness=7.0, bend=0.45)
_BOUGH_LEAF = Habit(0.085, (0.110, 0.200, 0.035), spread=0.25, slimness=3.3, bend=0.25)
_PETALS = (
    Habit(0.045, (0.70, 0.10, 0.07), slimness=2.2),
    Habit(0.040, (0.80, 0.62, 0.10), slimness=2.2),
    Habit(0.038, (0.78, 0.74, 0.72), slimness=2.2),
)

CROWNS = (
    Crown((-3.1, 1.85, -7.0), (1.75, 1.35, 1.5), 1.5),
    Crown((-2.0, 1.30, -6.6), (1.05, 0.75, 0.9), 1.5),
    Crown((2.1, 1.5, -12.5), (1.25, 2.1, 1.2), 0.9),
    Crown((-0.36, -0.05, -0.80), (0.15, 0.10, 0.14), 3.5),
    # The pot shades the table: a body so dense that no light passes.
    Crown((-0.36, -0.24, -0.80), (0.075, 0.065, 0.075), 200.0),
)


@dataclass(frozen=True)
class Garden:
    """All that is drawn: surfaces, and leaves that are seen near by and from afar."""

    surfaces: Solid
    near_leaves: Leaves
    far_leaves: Leaves


def plant_garden() -> Garden:
    """The scene's arrays; the same ones every time."""
    rng = np.random.default_rng(_SEED)
    bough, bough_leaves = _bough(rng)
    near = [rosette(rng, _POT + 0.125 * _UP, _LILY_LEAF, 46), bough_leaves]
    near += _flower_bed(rng)
    # From near to far: what is hidden is then never shaded.
    surfaces = [*_book(), *_table(), *bough, *_house(), *_trunks(rng), *_grounds()]
    return Garden(merge(surfaces), np.concatenate(near), np.concatenate(_far_leaves(rng)))


def _grounds() -> list[Solid]:
    """Lawn, path, and the brick wall with its coping at the garden's end."""
    y = GROUND_Y_M
    lawn = quad((-60.0, y, 40.0), (120.0, 0, 0), (0, 0, -90.0), Material.LAWN)
    path = quad((0.25, y + 0.01, -1.5), (0.9, 0, 0), (-1.4, 0, -8.4), Material.STONE)
    wall = quad((-7.0, y, -10.0), (9.6, 0, 0), (0, 1.75, 0), Material.BRICK)
    coping = box((-7.05, y + 1.75, -10.3), (2.65, y + 1.83, -9.94), Material.STONE)
    gate = quad((-1.15, y, -9.97), (0.95, 0, 0), (0, 1.62, 0), Material.WOOD)
    return [lawn, path, wall, coping, gate]


def _house() -> list[Solid]:
    """A plastered gable on the right, with a window and a notice beside it."""
    y, z = GROUND_Y_M, -5.2
    wall = quad((1.75, y, z), (4.0, 0, 0), (0, 5.5, 0), Material.PLASTER)
    corner = quad((1.75, y, z - 1.6), (0, 0, 1.6), (0, 5.5, 0), Material.PLASTER)
    plinth = box((1.72, y, z - 0.05), (6.0, y + 0.45, z + 0.04), Material.BRICK)
    sill = box((2.45, 0.02, z), (3.75, 0.09, z + 0.12), Material.STONE)
    parts = [wall, corner, plinth, sill, _sheet_on_wall(NOTICE, (1.98, -0.62, z + 0.01))]
    for left in (2.52, 3.13):
        parts.append(quad((left, 0.10, z + 0.01), (0.56, 0, 0), (0, 1.15, 0), Material.GLASS))
    for bar in (2.46, 3.075, 3.68):
        parts.append(box((bar, 0.09, z), (bar + 0.065, 1.30, z + 0.05), Material.WOOD))
    parts.append(box((2.46, 1.24, z), (3.745, 1.31, z + 0.06), Material.WOOD))
    return parts


def _sheet_on_wall(sheet: Sheet, corner: tuple[float, float, float]) -> Solid:
    """A flat sheet that faces the eyes, from its lower left corner."""
    width, height = sheet.size_m
    right, up = (width, 0.0, 0.0), (0.0, height, 0.0)
    return page(corner, right, up, first_texel_m=sheet.first_m, bulge=np.zeros(2))


def _table() -> list[Solid]:
    y = TABLE_Y_M
    top = box((-0.85, y - 0.035, -1.02), (0.95, y, -0.22), Material.WOOD)
    radius = np.array([0.0, 0.048, 0.052, 0.066, 0.071, 0.078, 0.078, 0.070, 0.066, 0.0])
    height = np.array([0.0, 0.0, 0.01, 0.085, 0.100, 0.102, 0.125, 0.125, 0.112, 0.110])
    pot = turned(_POT, np.stack([radius, height], axis=-1), Material.CLAY)
    slip_right = np.array([0.957, 0.0, 0.290])
    slip_up = np.array([0.290, 0.0, -0.957])
    width, long = SLIP.size_m
    slip = page(
        (0.27, y + 0.002, -0.46),
        width * slip_right,
        long * slip_up,
        first_texel_m=SLIP.first_m,
        bulge=0.006 * np.sin(np.linspace(0.0, 2.6, 9)) ** 2,
    )
    return [top, pot, slip]


def _book() -> list[Solid]:
    """An open book on its stand, leaning back and turned a little to the left."""
    turn, lean = np.radians(-6.0), np.radians(33.0)
    right = np.array([np.cos(turn), 0.0, np.sin(turn)])
    back = np.array([np.sin(turn), 0.0, -np.cos(turn)])
    up = np.cos(lean) * np.array([0.0, 1.0, 0.0]) + np.sin(lean) * back
    foot = np.array([0.06, TABLE_Y_M + 0.012, -0.405])
    facing = np.cross(right, up)
    width, height = LEFT_PAGE.size_m
    # The gutter is deep, the sheets rise out of it and fall off toward the edge.
    s = np.linspace(0.0, 1.0, 17)
    rise = 0.020 * (1.0 - np.exp(-7.0 * s)) * (1.0 - 0.55 * s**2)
    left = page(
        foot - width * right,
        width * right,
        height * up,
        first_texel_m=LEFT_PAGE.first_m,
        bulge=rise[::-1],
    )
    other = page(
        foot, width * right, height * up, first_texel_m=RIGHT_PAGE.first_m, bulge=0.85 * rise
    )
    cover = quad(
        foot - (width + 0.006) * right - 0.006 * up - 0.004 * facing,
        2.0 * (width + 0.006) * right,
        (height + 0.012) * up,
        Material.CLOTH,
    )
    ledge = box((-0.11, TABLE_Y_M, -0.43), (0.24, TABLE_Y_M + 0.012, -0.375), Material.WOOD)
    return [left, other, cover, ledge]


def _line(start: Float, end: Float, rng: np.random.Generator, wander_m: float) -> Float:
    """A crooked line of nine points."""
    s = np.linspace(0.0, 1.0, 9)[:, None]
    steps = np.cumsum(rng.standard_normal((9, 3)), axis=0) * wander_m / 3.0
    return np.asarray(start + (end - start) * s + steps * s)


def _tree(
    rng: np.random.Generator, foot: Float, top: Float, radius_m: float, boughs: int, reach_m: float
) -> list[Solid]:
    """A trunk with boughs that leave it from half its height on."""
    trunk = _line(foot, top, rng, 0.10)
    parts = [tube(trunk, np.linspace(radius_m, 0.35 * radius_m, 9), Material.BARK, around=13)]
    for each in range(boughs):
        start = trunk[4 + each % 4]
        angle = 2.4 * each + rng.uniform(-0.4, 0.4)
        out = np.array([np.cos(angle), rng.uniform(0.35, 1.0), np.sin(angle)])
        limb = _line(start, start + reach_m * rng.uniform(0.5, 1.0) * out, rng, 0.16)
        parts.append(tube(limb, np.linspace(0.4 * radius_m, 0.06 * radius_m, 9), Material.BARK))
    return parts


def _trunks(rng: np.random.Generator) -> list[Solid]:
    parts = _tree(rng, _OAK, _OAK + np.array([0.25, 3.1, 0.1]), 0.20, 14, 1.7)
    parts += _tree(rng, _BIRCH, _BIRCH + np.array([-0.1, 4.2, 0.0]), 0.10, 10, 1.2)
    for x, z, height in _FAR_TREES:
        foot = np.array([x, GROUND_Y_M, z])
        parts += _tree(rng, foot, foot + 0.8 * height * _UP, 0.14, 6, 1.0)
    return parts


def _bough(rng: np.random.Generator) -> tuple[list[Solid], Leaves]:
    """A bough that hangs in from the upper right at about 1.2 m."""
    wood: list[Solid] = []
    leaves: list[Leaves] = []
    stem = _line(np.array([1.05, 0.86, -1.25]), np.array([0.10, 0.42, -1.10]), rng, 0.03)
    twigs = [stem]
    for at in (1, 2, 3, 4, 5, 6):
        out = rng.standard_normal(3) * (0.10, 0.06, 0.10) + (-0.16, -0.17, 0.02)
        twigs.append(_line(stem[at], stem[at] + out, rng, 0.02))
    for index, twig in enumerate(twigs):
        thick = 0.011 if index == 0 else 0.004
        wood.append(tube(twig, np.linspace(thick, 0.3 * thick, 9), Material.BARK))
        leaves.append(twig_leaves(rng, twig, _BOUGH_LEAF, 26 if index == 0 else 11))
    return wood, np.concatenate(leaves)


def _flower_bed(rng: np.random.Generator) -> list[Leaves]:
    """A bed of leaves and flowers at the left, 4.4 to 5.4 m away."""
    low, high = (-3.6, GROUND_Y_M, -5.4), (-0.55, GROUND_Y_M + 0.45, -4.5)
    leaf = Habit(0.075, (0.075, 0.145, 0.035), spread=0.45, slimness=4.5, bend=0.3)
    parts = [bank_leaves(rng, low, high, leaf, 3200)]
    head_low = (-3.6, GROUND_Y_M + 0.28, -5.3)
    head_high = (-0.55, GROUND_Y_M + 0.60, -4.45)
    parts += [bank_leaves(rng, head_low, head_high, petal, 170) for petal in _PETALS]
    return parts


def _far_leaves(rng: np.random.Generator) -> list[Leaves]:
    y = GROUND_Y_M
    oak, oak_arm, birch = CROWNS[:3]
    parts = [
        crown_leaves(rng, oak, _OAK_LEAF, 13000),
        crown_leaves(rng, oak_arm, _OAK_LEAF, 4500),
        crown_leaves(rng, birch, _BIRCH_LEAF, 8000, tuft=24),
        bank_leaves(rng, (-5.6, y, -9.9), (-1.6, y + 0.9, -9.2), _HEDGE_LEAF, 4500),
        bank_leaves(rng, (0.3, y, -9.9), (2.7, y + 0.75, -9.3), _HEDGE_LEAF, 3000),
        # Ivy on the gable.
        bank_leaves(rng, (3.9, y, -5.2), (5.4, y + 3.6, -5.05), _HEDGE_LEAF, 2600),
        grass_blades(
            rng, ground_y_m=y, near_m=4.0, far_m=9.8, half_slope=0.75, habit=_GRASS, count=30000
        ),
    ]
    for x, z, height in _FAR_TREES:
        crown = Crown((x, y + 0.72 * height, z), (0.42 * height, 0.38 * height, 1.6), 1.0)
        parts.append(crown_leaves(rng, crown, _FAR_LEAF, 3500))
    for start in (-20.0, 2.6):
        low, high = (start, y, -19.8), (start + 17.0, y + 1.9, -18.6)
        parts.append(bank_leaves(rng, low, high, _FAR_LEAF, 2600))
    return parts
