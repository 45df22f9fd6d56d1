"""The float64 twin of perception ray by ray: what its options mean."""

from __future__ import annotations

import numpy as np
import pass_rigs
import pytest

from vrlf.errors import InputError
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.lattice import lattice_of
from vrlf.optics.tracing import Tracing, diffraction_of
from vrlf.optics.viewport import panel_points_mm, viewport
from vrlf.reference.perceive import perceive, trace
from vrlf.reference.traced import Tracer, diffracted_cells, perceive_traced, points_of


def test_without_options_it_is_plain_sampling() -> None:
    # Behind holes the fast twin's blind sampling is the same, point by point.
    rig, panel = pass_rigs.case("square-holes-walls")
    light = panel.astype(np.float64)
    wanted = perceive(light, rig, 9)
    assert perceive_traced(light, rig, 9, Tracing()) == pytest.approx(wanted, abs=1e-12)


def test_two_halves_are_the_whole() -> None:
    rig, panel = pass_rigs.case("diamonds-lenslets")
    light, how = panel.astype(np.float64), Tracing(diffraction=True)
    halves = [perceive_traced(light, rig, 8, how, half) for half in ("first", "second")]
    assert np.mean(halves, axis=0) == pytest.approx(perceive_traced(light, rig, 8, how), abs=1e-12)


@pytest.mark.parametrize("name", ["coma-lenslets", "full-leaning-walls"])
def test_exact_lenslets_are_thin_ones_up_to_the_third_order(name: str) -> None:
    rig = pass_rigs.SMALL[name]
    view, optics = viewport(rig, "left"), eye_optics(rig, "left")
    points = points_of(rig, optics, 0, 16)
    tracer, x_mm = Tracer(rig, view, Tracing(exact=True)), panel_points_mm(rig, view)
    for u, slope, scale in zip(points.u_mm, points.slope, points.spread_scale, strict=True):
        exact, _ = tracer.landing(x_mm, u, slope, scale, 1)
        thin = trace(bench_of(rig), lattice_of(rig), view, x_mm, u, slope)
        assert np.array_equal(exact.cell, thin.cell)
        lattice = lattice_of(rig)
        assert lattice is not None
        off = np.linalg.norm(exact.panel_mm - thin.panel_mm, axis=-1)
        y = np.linalg.norm(exact.in_cell @ lattice.panel_from_cell.T, axis=-1)
        # Aberrations of a third-order lens of f = 1.95 mm: y^3 and products with slopes of 0.1.
        assert np.all(off <= 3.0 * (y / 1.95 + 0.1) ** 3)
    assert off.max() > 1e-4  # and there are some


def test_a_ray_through_an_openings_middle_is_not_diffracted() -> None:
    rig = pass_rigs.SMALL["square-holes-walls"]
    lattice = lattice_of(rig)
    assert lattice is not None
    spread = diffraction_of(rig, lattice)
    moved = diffracted_cells(spread, lattice, np.zeros(2), np.array([1.3, -0.7]), 0)
    assert moved == pytest.approx([0.0, 0.0], abs=1e-15)


def test_a_shadow_upside_down_spreads_the_other_way() -> None:
    rig = pass_rigs.SMALL["round-holes-moved"]
    lattice = lattice_of(rig)
    assert lattice is not None
    spread = diffraction_of(rig, lattice)
    place = np.array([0.11, -0.06])
    upright, turned = (
        diffracted_cells(spread, lattice, place, np.full(2, m), 2) for m in (0.4, -0.4)
    )
    assert turned == pytest.approx(-upright)
    # Along the place's own direction.
    assert upright[0] * place[1] == pytest.approx(upright[1] * place[0])


@pytest.mark.parametrize(
    ("name", "how", "words"),
    [
        ("rgbg-bare", Tracing(diffraction=True), 'diffraction: found array.kind = "none"'),
        ("rgbg-bare", Tracing(exact=True), 'exact: found array.kind = "none"'),
        ("diamonds-holes", Tracing(exact=True), 'exact: found array.kind = "pinhole"'),
        ("strongest-lenslets", Tracing(exact=True), "array.focal_mm: found 0.3"),
    ],
)
def test_what_a_rig_has_nothing_for_is_refused(name: str, how: Tracing, words: str) -> None:
    rig, panel = pass_rigs.case(name)
    with pytest.raises(InputError, match=words):
        perceive_traced(panel, rig, 4, how)
