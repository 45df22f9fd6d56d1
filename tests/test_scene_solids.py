"""Surfaces and leaves: true sizes, outward fronts, the same garden every time."""

from __future__ import annotations

import re

import numpy as np
import pytest
from numpy.typing import NDArray

from vrlf.resources import shaders_dir
from vrlf.scene import foliage
from vrlf.scene.foliage import Crown, Habit
from vrlf.scene.garden import GROUND_Y_M, Garden, plant_garden
from vrlf.scene.pages import RIGHT_PAGE
from vrlf.scene.solids import Material, Solid, box, merge, page, quad, tube, turned

Float = NDArray[np.float64]

# float32 keeps metres to 1e-7 of their size.
SINGLE = 1e-6


def fronts(solid: Solid) -> Float:
    """Area vectors of the triangles, toward their anticlockwise side; shape (T, 3)."""
    vertices, triangles = solid
    a, b, c = (vertices["in_position"][triangles[:, i]].astype(np.float64) for i in range(3))
    return 0.5 * np.cross(b - a, c - a)


def normals(solid: Solid) -> Float:
    """Mean of the corners' normals of each triangle."""
    vertices, triangles = solid
    return vertices["in_normal"][triangles].astype(np.float64).mean(axis=1)


def volume(solid: Solid) -> float:
    """Enclosed by a closed surface whose fronts look outward (Gauss)."""
    vertices, triangles = solid
    middle = vertices["in_position"][triangles].astype(np.float64).mean(axis=1)
    return float(np.sum(middle * fronts(solid)) / 3.0)


def test_a_quad_has_its_place_in_metres() -> None:
    vertices, _ = quad((1, 2, -3), (0.5, 0, 0), (0, 0.25, 0), Material.WOOD, place=(7.0, 8.0))
    upper_right = vertices[3]
    assert upper_right["in_position"].tolist() == [1.5, 2.25, -3]
    assert upper_right["in_normal"].tolist() == [0, 0, 1]
    assert upper_right["in_place"].tolist() == [7.5, 8.25]
    assert upper_right["in_material"] == Material.WOOD


def test_a_box_is_closed_and_looks_outward() -> None:
    solid = box((-1.0, 0.5, -4.0), (1.0, 1.25, -1.0), Material.STONE)
    assert volume(solid) == pytest.approx(2.0 * 0.75 * 3.0, abs=SINGLE)
    assert fronts(solid).sum(axis=0) == pytest.approx(np.zeros(3), abs=SINGLE)


def test_a_turned_body_looks_outward() -> None:
    """A cylinder of radius 0.2 and height 0.5, closed at both ends."""
    profile = [(0.0, 0.0), (0.2, 0.0), (0.2, 0.5), (0.0, 0.5)]
    solid = turned((3.0, 1.0, -2.0), profile, Material.CLAY, around=60)
    sixty_sided = 0.5 * 60 * np.sin(2 * np.pi / 60) * 0.2**2
    assert volume(solid) == pytest.approx(sixty_sided * 0.5, abs=SINGLE)


def test_a_tube_looks_outward_with_its_radii() -> None:
    solid = tube([(0, 0, 0), (0, 1, 0), (0.5, 2, 0.1)], [0.3, 0.2, 0.1], Material.BARK)
    assert np.all(np.sum(fronts(solid) * normals(solid), axis=1) > 0)
    first = solid[0]["in_position"][:10]
    assert np.linalg.norm(first, axis=1) == pytest.approx(np.full(10, 0.3), abs=SINGLE)


def test_a_page_carries_its_print_upright() -> None:
    """From its upper left corner on, right and down, in metres of print."""
    size, first = RIGHT_PAGE.size_m, RIGHT_PAGE.first_m
    bulge = 0.01 * np.sin(np.linspace(0, np.pi, 9))
    vertices, triangles = page(
        (0, 0, 0), (size[0], 0, 0), (0, size[1], 0), first_texel_m=first, bulge=bulge
    )
    for vertex in vertices:
        x, y, z = vertex["in_position"].tolist()
        down = size[1] - y
        assert vertex["in_place"].tolist() == pytest.approx(
            [first[0] + x, first[1] + down], abs=SINGLE
        )
        assert z == pytest.approx(0.01 * np.sin(np.pi * x / size[0]), abs=SINGLE)
    assert np.all(fronts((vertices, triangles))[:, 2] > 0)
    # The sheet rises to the right of its left edge: its normal leans to the left there.
    assert vertices["in_normal"][0, 0] < 0 < vertices["in_normal"][8, 0]


def test_merging_keeps_every_triangle_with_its_own_vertices() -> None:
    parts = [
        quad((0, 0, -1), (1, 0, 0), (0, 1, 0), Material.WOOD),
        quad((5, 0, -1), (2, 0, 0), (0, 3, 0), Material.CLAY),
    ]
    whole = merge(parts)
    assert fronts(whole)[:, 2].tolist() == [0.5, 0.5, 3.0, 3.0]
    assert whole[0]["in_material"][whole[1][2:]].tolist() == [[Material.CLAY] * 3] * 2


def test_the_shader_has_the_same_materials() -> None:
    text = (shaders_dir() / "scene" / "materials.glsl").read_text(encoding="utf-8")
    declared = re.search(r"const int (LAWN.*?);", text, re.DOTALL)
    assert declared is not None
    found = {name: int(number) for name, number in re.findall(r"(\w+) = (\d+)", declared[1])}
    assert found == {material.name: material.value for material in Material}


@pytest.mark.parametrize("segments", [1, 2, 6])
def test_a_blade_is_one_sheet_from_stalk_to_tip(segments: int) -> None:
    vertices, triangles = foliage.blade(segments)
    places = vertices["in_blade"]
    assert len(triangles) == 4 * segments - 2
    assert places[-1].tolist() == [1.0, 0.0]
    # Flat, as (across, along), the triangles cover the sheet once and face one way.
    a, b, c = (places[triangles[:, i]].astype(np.float64) for i in range(3))
    areas = 0.5 * ((b - a)[:, 1] * (c - a)[:, 0] - (b - a)[:, 0] * (c - a)[:, 1])
    assert np.all(areas > 0)
    last = float(places[-2, 0])
    assert areas.sum() == pytest.approx(2.0 * last + (1.0 - last), abs=SINGLE)


def test_leaves_have_natural_sizes() -> None:
    """Lognormal: the median is the habit's, one standard deviation a factor of exp(spread)."""
    habit = Habit(0.08, (0.1, 0.2, 0.05), spread=0.4, slimness=5.0)
    crown = Crown((1.0, 2.0, -5.0), (1.5, 1.0, 0.5), 1.0)
    leaves = foliage.crown_leaves(np.random.default_rng(1), crown, habit, 20000)
    length = np.linalg.norm(leaves["in_along"], axis=1)
    low, median, high = np.percentile(length, [15.87, 50.0, 84.13])
    # 20000 draws give the median to 0.4 / sqrt(20000) * 1.25, a third of a percent.
    assert median == pytest.approx(0.08, rel=0.015)
    assert (low / median, high / median) == pytest.approx((np.exp(-0.4), np.exp(0.4)), rel=0.02)
    half_width = np.linalg.norm(leaves["in_across"], axis=1)
    assert half_width == pytest.approx(length / 5.0, rel=1e-5)
    across_along = np.sum(leaves["in_across"] * leaves["in_along"], axis=1)
    assert np.abs(across_along).max() < SINGLE


def test_no_leaf_hangs_in_the_air() -> None:
    crown = Crown((1.0, 2.0, -5.0), (1.5, 1.0, 0.5), 1.0)
    habit = Habit(0.08, (0.1, 0.2, 0.05))
    leaves = foliage.crown_leaves(np.random.default_rng(2), crown, habit, 5000)
    inside = (leaves["in_origin"] - np.array(crown.centre_m)) / np.array(crown.radii_m)
    # As far out as leaves are drawn back to.
    assert np.linalg.norm(inside, axis=1).max() < 1.06 + 1e-5


@pytest.fixture(scope="module")
def garden() -> Garden:
    """The shipped scene's arrays."""
    return plant_garden()


def test_the_garden_is_the_same_every_time(garden: Garden) -> None:
    again = plant_garden()
    assert garden.near_leaves.tobytes() == again.near_leaves.tobytes()
    assert garden.far_leaves.tobytes() == again.far_leaves.tobytes()
    assert garden.surfaces[0].tobytes() == again.surfaces[0].tobytes()
    assert np.array_equal(garden.surfaces[1], again.surfaces[1])


def test_the_garden_reaches_from_arms_length_to_twenty_metres(garden: Garden) -> None:
    vertices = garden.surfaces[0]
    printed = -vertices["in_position"][vertices["in_material"] == Material.PAPER][:, 2]
    assert 0.3 < printed.min() < 0.5
    assert 0.5 < -garden.near_leaves["in_origin"][:, 2].max() < 1.0
    # The last tree stands at 19.5 m; its crown reaches 1.7 m behind it.
    assert 18.0 < -garden.far_leaves["in_origin"][:, 2].min() < 19.5 + 1.06 * 1.6
    assert garden.far_leaves["in_origin"][:, 1].min() >= GROUND_Y_M


def test_all_of_the_garden_is_finite_with_albedos_below_one(garden: Garden) -> None:
    arrays = (garden.near_leaves, garden.far_leaves, garden.surfaces[0])
    for array in arrays:
        for name in array.dtype.names or ():
            assert np.isfinite(array[name]).all(), name
    for leaves in arrays[:2]:
        assert 0.0 < leaves["in_tint"].min() < leaves["in_tint"].max() < 1.0
    lengths = np.linalg.norm(garden.surfaces[0]["in_normal"], axis=1)
    assert lengths == pytest.approx(np.ones(len(lengths)), abs=1e-5)
