"""The float64 optimum: its matrices against the twin of perception, its solution against scipy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from optics_by_hand import rig
from scipy.optimize import lsq_linear
from scipy.sparse import csr_array, random_array

from vrlf.errors import InputError
from vrlf.model import Rig
from vrlf.optics.eye import eye_optics
from vrlf.optics.lattice import lattice_of
from vrlf.optics.viewport import SIDES, viewport
from vrlf.reference import converged as module
from vrlf.reference.converged import (
    bounded_least_squares,
    converged,
    converging_matrices,
    operator_matrices,
)
from vrlf.reference.perceive import perceive

EYES: dict[str, Any] = {
    "left": {"sphere_d": -3.0, "cylinder_d": -1.5, "axis_deg": 20.0, "pupil_mm": 5.0},
    "right": {"sphere_d": 1.0, "pupil_mm": 3.0, "pupil_offset_mm": [0.4, -0.2]},
}
TURNED = {"pitch_um": 300.0, "gap_mm": 3.0, "rotation_deg": 17.0, "offset_um": [40.0, -25.0]}
RIGS: dict[str, dict[str, Any]] = {
    # An odd width: the middle column is nobody's.
    "lenslets, stripes": {
        "array": {"kind": "microlens", "focal_mm": 2.1, **TURNED},
        "panel": {"width_px": 41, "height_px": 17, "subpixels": "rgb-stripe"},
    },
    "holes, coloured rays": {
        "array": {"kind": "pinhole", "aperture_um": 150.0, **TURNED},
        "panel": {"width_px": 40, "height_px": 15},
        "left": {"chromatic": True},
    },
    "bare": {"panel": {"width_px": 40, "height_px": 15}},
}


def small(name: str) -> Rig:
    tables = {eye: EYES[eye] | RIGS[name].get(eye, {}) for eye in EYES}
    return rig(**RIGS[name] | tables)


@pytest.mark.parametrize("name", RIGS)
def test_a_matrix_is_the_twin_of_perception(name: str) -> None:
    given, rays = small(name), 24
    size = (given.panel.height_px, given.panel.width_px, 3)
    panel = np.random.default_rng(1).random(size)
    lattice = lattice_of(given)
    throughput = 1.0 if lattice is None else lattice.throughput
    seen = perceive(panel, given, rays) / throughput
    for side in SIDES:
        view = viewport(given, side)
        matrices = operator_matrices(given, view, eye_optics(given, side), rays)
        for channel, matrix in enumerate(matrices):
            shown = panel[:, view.columns, channel].ravel()
            # Sums of some hundred float64 in another order.
            assert matrix @ shown == pytest.approx(
                seen[:, view.columns, channel].ravel(), rel=1e-11, abs=1e-13
            )


def test_pieces_add_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever the number of entries that are put together at once."""
    given = small("lenslets, stripes")
    view, optics = viewport(given, "left"), eye_optics(given, "left")
    whole = operator_matrices(given, view, optics, 9)
    monkeypatch.setattr(module, "_PIECE", 100)
    for matrix, other in zip(whole, operator_matrices(given, view, optics, 9), strict=True):
        assert abs(matrix - other).max() < 1e-14  # rounding of sums near 1
        assert matrix.nnz == other.nnz


def problem(seed: int) -> tuple[csr_array, np.ndarray]:
    """A sparse matrix without negative entries, one column empty, and a wish out of reach."""
    rng = np.random.default_rng(seed)
    matrix = random_array((60, 60), density=0.12, rng=rng) + 0.4 * csr_array(np.eye(60))
    dense = matrix.toarray()
    dense[:, 11] = 0.0
    return csr_array(dense), rng.random(60) * 3.0 - 1.0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_solution_is_that_of_another_solver(seed: int) -> None:
    matrix, wanted = problem(seed)
    found = bounded_least_squares(matrix, wanted)
    assert found.min() >= 0.0
    assert found.max() <= 1.0
    assert found[11] == 0.0
    least = lsq_linear(matrix.toarray(), wanted, bounds=(0.0, 1.0), tol=1e-13).cost
    cost = 0.5 * float(np.sum((matrix @ found - wanted) ** 2))
    # Proved to be within 5e-4 of it; nothing is better than the least but for rounding.
    assert least * (1.0 - 1e-9) <= cost <= least * (1.0 + 5e-4)


def test_a_wish_within_reach_is_met() -> None:
    matrix, _ = problem(4)
    wanted = matrix @ np.random.default_rng(5).random(60)
    left = matrix @ bounded_least_squares(matrix, wanted) - wanted
    # What is left at the gap of 1e-14 a pixel.
    assert np.abs(left).max() < 1e-5


def test_too_few_steps_are_no_optimum(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_MOST_STEPS", 3)
    with pytest.raises(ArithmeticError, match="no optimum within 3 steps"):
        bounded_least_squares(*problem(1))


def test_the_panel_image_is_the_best_of_each_eye_and_colour() -> None:
    given = small("lenslets, stripes")
    changed = given.prefilter.model_copy(update={"brightness": 0.8, "black_level": 0.1})
    given = given.model_copy(update={"prefilter": changed})
    target = np.random.default_rng(6).random((17, 41, 3))
    matrices = converging_matrices(given, 16)
    shown = converged(target, given, matrices)
    assert shown.shape == target.shape
    assert np.all(shown[:, 20] == 0.0)  # the middle column
    rng = np.random.default_rng(7)
    for side in SIDES:
        columns = viewport(given, side).columns
        for channel, matrix in enumerate(matrices[side]):
            meant = (0.1 + 0.7 * target[:, columns, channel]).ravel()
            best = shown[:, columns, channel].ravel()

            def error(x: np.ndarray, matrix: csr_array = matrix, meant: Any = meant) -> float:
                return float(np.sum((matrix @ x - meant) ** 2))

            for size in (1e-3, 0.03, 0.3):
                other = np.clip(best + size * rng.standard_normal(len(best)), 0.0, 1.0)
                assert error(other) >= error(best) * (1.0 - 5e-4)


def test_a_panel_too_large_to_wait_for_is_refused() -> None:
    given = rig(panel={"width_px": 500, "height_px": 201})
    with pytest.raises(InputError, match=r"found 500x201 pixels.*wanted at most 100000"):
        converging_matrices(given, 4)
