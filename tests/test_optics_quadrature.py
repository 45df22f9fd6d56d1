"""Lines and holes' points: what they cover, what they weigh, and how few of them do."""

from __future__ import annotations

from typing import Any

import numpy as np
import pass_rigs
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from vrlf.app.preview.steps import altered
from vrlf.model import Rig
from vrlf.optics import lines as lines_module
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.holes import hole_points, hole_table
from vrlf.optics.lattice import is_open, lattice_of, nearest_cell
from vrlf.optics.lines import line_table, stretches
from vrlf.optics.maps import ray_maps
from vrlf.optics.quadrature import quadrature_of
from vrlf.optics.raster import cells_per_pixel, pixels_per_cell
from vrlf.optics.sequence import half_of
from vrlf.optics.viewport import SIDES, pitch_mm

Light = NDArray[Any]

# Oblique astigmatism, a moved pupil, a turned lattice; then a wavefront of the eighth order.
OBLIQUE = pass_rigs.rig(
    44,
    30,
    array=pass_rigs.LENSLETS | {"rotation_deg": 17.0, "offset_um": [60.0, -110.0]},
    left={"cylinder_d": -2.0, "axis_deg": 35.0, "pupil_offset_mm": [0.4, -0.7]},
    right={"cylinder_d": -1.5, "axis_deg": 120.0},
)
CURVED = pass_rigs.SMALL["coma-lenslets"]
HOLES = pass_rigs.rig(
    44,
    30,
    array=pass_rigs.HOLES | {"rotation_deg": 14.0, "aperture_shape": "circle"},
    left={"cylinder_d": -1.5, "axis_deg": 65.0, "pupil_offset_mm": [0.9, -0.5]},
    right={"sphere_d": -6.5},
)


@pytest.mark.parametrize(
    ("name", "rays", "wanted"),
    [
        ("own-lens-bare", 256, "points"),
        ("coma-lenslets", 256, "lines"),
        ("strongest-lenslets", 4, "lines"),
        ("square-holes-walls", 256, "points"),  # behind coma
        ("round-holes-moved", 256, "points"),  # the right pupil's image is less than a hole
    ],
)
def test_which_rays_serve(name: str, rays: int, wanted: str) -> None:
    assert quadrature_of(pass_rigs.SMALL[name], rays) == wanted


def test_holes_have_points_where_the_pupil_shows_few_of_them() -> None:
    assert quadrature_of(HOLES, 256) == "holes"
    # Three rays over a cell, and thousands of holes in the pupil, leave none to each.
    assert quadrature_of(HOLES, 3) == "points"
    fine = {"array": HOLES.array.model_copy(update={"pitch_um": 20.0, "aperture_um": 8.0})}
    assert quadrature_of(HOLES.model_copy(update=fine), 256) == "points"


@pytest.mark.parametrize("half", ["all", "first", "second"])
@pytest.mark.parametrize("given_rig", [OBLIQUE, CURVED], ids=["oblique", "curved"])
def test_lines_fill_pupil_and_pixel_evenly(given_rig: Rig, half: Any) -> None:
    """Second moments over a disc are r^2 / 4, over a pixel p^2 / 12, across both 0."""
    for side in SIDES:
        optics = eye_optics(given_rig, side)
        lines = stretches(given_rig, optics, 0, 4096, half)
        assert lines.share.sum() == pytest.approx(1.0, abs=1e-12)
        u = lines.from_centre_mm / (optics.pupil_mm / 2.0)
        w = lines.within_pixel_mm / pitch_mm(given_rig)
        assert np.hypot(u[..., 0], u[..., 1]).max() <= 1.0 + 1e-12
        assert np.abs(w).max() <= 0.5 + 1e-12
        # A quadratic's mean along a stretch, exactly (Simpson).
        joint = np.concatenate([u, w], axis=-1)
        nodes = np.stack([joint[:, 0], joint.mean(axis=1), joint[:, 1]])
        weights = np.array([1.0, 4.0, 1.0])[:, None] / 6.0 * lines.share
        mean = np.einsum("kn,kni->i", weights, nodes)
        moments = np.einsum("kn,kni,knj->ij", weights, nodes, nodes)
        # Some hundred lines; a half lies a quarter of its step to one side.
        assert np.abs(mean).max() < 0.01
        assert moments == pytest.approx(np.diag([0.25, 0.25, 1 / 12, 1 / 12]), abs=0.01)


@given(st.floats(1e-6, 1.0 - 1e-6))
@settings(max_examples=60, deadline=None)
def test_offsets_cut_off_their_share_of_the_disc(share: float) -> None:
    r = float(lines_module._offset_of_area(np.array([share]))[0])
    area = 0.5 + (r * np.sqrt(1.0 - r**2) + np.arcsin(r)) / np.pi
    # Near the rim the area grows as the depth's 3/2 power; 60 steps reach this.
    assert area == pytest.approx(share, abs=1e-9)


def test_a_wavefront_bends_its_chords_less_the_more_rays_there_are() -> None:
    optics = eye_optics(CURVED, "right")
    counts = {
        rays: len(stretches(CURVED, optics, 0, rays, "all").share) for rays in (64, 1024, 16384)
    }
    assert counts[64] < counts[1024] < counts[16384]
    # A sphero-cylinder's are straight: two stretches each, parted where w wraps around.
    lattice = lattice_of(OBLIQUE)
    assert lattice is not None
    maps = ray_maps(OBLIQUE, lattice, eye_optics(OBLIQUE, "left"), 0)
    assert lines_module._parts(maps, np.array([1.0, 0.0]), 10**6) == 1


def pieces_of(given_rig: Rig, side: Any, rays: int, phases: Light) -> float:
    """Pieces that a retinal pixel's lines fall into: cells and pixels entered, counted densely."""
    lattice = lattice_of(given_rig)
    assert lattice is not None
    table = line_table(given_rig, eye_optics(given_rig, side), 0, rays)
    per_cell = pixels_per_cell(given_rig, lattice)
    along = np.linspace(0.0, 1.0, 400)[:, None]
    count = 0.0
    for begin, landing, share in zip(
        table.crossing_cells, table.landing_px, table.share, strict=True
    ):
        if share > 0.0:
            cell = nearest_cell(lattice, phases[:, None] + begin[:2] + along * begin[2:])
            bent = bench_of(given_rig).bend * (cell - phases[:, None]) @ per_cell.T
            pixel = np.floor(landing[:2] + along * landing[2:] + bent + 0.5)
            place = np.concatenate([cell, pixel], axis=-1)
            count += 1.0 + float(np.any(np.diff(place, axis=1) != 0.0, axis=-1).sum(axis=1).mean())
    return count


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("cells", ["square", "hexagonal"])
def test_a_ray_is_a_piece(side: Any, cells: str) -> None:
    phases = np.random.default_rng(2).random((40, 2)) - 0.5
    given_rig = altered(OBLIQUE, {"array": {"lattice": cells}})
    # Counts are rounded to whole pairs of lines of some eight pieces.
    assert pieces_of(given_rig, side, 512, phases) == pytest.approx(512, rel=0.1)


@pytest.mark.parametrize("cells", ["square", "hexagonal"])
def test_how_many_borders_a_way_meets(cells: str) -> None:
    lattice = lattice_of(altered(OBLIQUE, {"array": {"lattice": cells}}))
    assert lattice is not None
    random = np.random.default_rng(6)
    moved = random.normal(size=(400, 2)) * [3.0, 2.0]
    begin = 20.0 * random.random((400, 1, 2))
    way = begin + np.linspace(0.0, 1.0, 4001)[:, None] * moved[:, None]
    stepped = np.diff(nearest_cell(lattice, way), axis=1)
    met = np.any(stepped != 0.0, axis=-1).sum(axis=1)
    # 400 ways of some four borders, each off by less than one: 2 % of chance.
    assert met.mean() == pytest.approx(lattice.mean_borders(moved).mean(), rel=0.03)
    assert np.all(met <= lattice.most_borders(moved) + 2.0)
    # Along a row of hexagons, through their zigzag, two a pitch.
    if cells == "hexagonal":
        start = np.array([0.2, 0.5]) @ np.linalg.inv(lattice.upright_from_cell).T
        zigzag = start + np.linspace(0.0, 10.0, 40001)[:, None] * [1.0, 0.0]
        entered = np.diff(nearest_cell(lattice, zigzag), axis=0).any(axis=-1).sum()
        assert entered == lattice.most_borders(np.array([10.0, 0.0])) == 20


@pytest.mark.parametrize("changed", [{}, {"lattice": "hexagonal", "aperture_shape": "square"}])
def test_points_of_holes_come_from_where_they_say(changed: dict[str, str]) -> None:
    """phi at the pupil point of each is the hole's point, less what the pixel's place moves."""
    given_rig = altered(HOLES, {"array": changed})
    lattice = lattice_of(given_rig)
    assert lattice is not None
    for side in SIDES:
        optics = eye_optics(given_rig, side)
        points = hole_points(given_rig, lattice, optics, 100, "all")
        assert is_open(lattice, points[:, :2]).all()
        assert np.abs(points[:, 2:]).max() <= 0.5
        table = hole_table(given_rig, optics, 0, points)
        maps = ray_maps(given_rig, lattice, optics, 0)
        for off in (np.zeros(2), np.array([0.3, -0.8])):
            radii = table.pupil_from_cells @ off + table.in_pupil
            phi, psi = maps(radii * optics.pupil_mm / 2.0)
            per_px = maps.bench.array_from_panel * cells_per_pixel(given_rig, lattice)
            crossing = phi + points[:, 2:] @ per_px.T
            assert crossing - table.centre_cells == pytest.approx(off + points[:, :2], abs=1e-12)
            landing = table.centre_px + table.px_from_cells @ off + table.landing_px
            assert landing == pytest.approx(psi + points[:, 2:], abs=1e-10)


def test_no_hole_beyond_the_reach_is_seen() -> None:
    lattice = lattice_of(HOLES)
    assert lattice is not None
    for side in SIDES:
        optics = eye_optics(HOLES, side)
        points = hole_points(HOLES, lattice, optics, 3000, "all")
        table = hole_table(HOLES, optics, 0, points)
        offs = 3.0 * table.reach_cells * (np.random.default_rng(4).random((500, 2)) - 0.5)
        beyond = np.any(np.abs(offs) > table.reach_cells, axis=1)
        for off in offs[beyond]:
            radii = table.pupil_from_cells @ off + table.in_pupil
            assert np.hypot(*radii.T).min() > 1.0


def test_halves_are_the_whole() -> None:
    values = np.arange(10.0)[:, None]
    halves = np.concatenate([half_of(values, "first"), half_of(values, "second")])
    np.testing.assert_array_equal(halves, half_of(values, "all"))
    optics = eye_optics(OBLIQUE, "left")
    whole = stretches(OBLIQUE, optics, 0, 512, "all")
    first, second = (stretches(OBLIQUE, optics, 0, 512, half) for half in ("first", "second"))
    assert len(first.share) == len(second.share) == len(whole.share) / 2
    both = np.concatenate([first.from_centre_mm, second.from_centre_mm]).reshape(-1, 4)
    np.testing.assert_array_equal(
        np.unique(both, axis=0), np.unique(whole.from_centre_mm.reshape(-1, 4), axis=0)
    )
