"""The optimal prefilter's twin: an exact operator, its exact adjoint, and the solver's steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pass_rigs
import pytest
from numpy.typing import NDArray

from vrlf.errors import InputError
from vrlf.model import Rig
from vrlf.optics.eye import eye_optics
from vrlf.optics.lattice import lattice_of
from vrlf.optics.viewport import Side, viewport
from vrlf.reference import optimal as module
from vrlf.reference.optimal import Operator, descend, optimal
from vrlf.reference.perceive import perceive

Light = NDArray[Any]
RAYS = 24  # what is held here is exact at any number
RIGS = {
    name: pass_rigs.APART[name] if name in pass_rigs.APART else pass_rigs.SMALL[name]
    for name in (
        "walls-stripes-relief",
        "round-holes-chromatic",
        "leaning-walls-acrylic-astigmatic",
        "bare-wavefront-own-power",
        "strong-lenslets",
        "diamonds-walls-relief",
    )
}


def operator(rig: Rig, side: Side) -> Operator:
    return Operator(rig, viewport(rig, side), eye_optics(rig, side), RAYS)


def half(rig: Rig, side: Side, seed: int) -> Light:
    view = viewport(rig, side)
    return np.random.default_rng(seed).random((view.height_px, view.width_px, 3))


@pytest.mark.parametrize("name", RIGS)
def test_it_is_perception_over_throughput(name: str) -> None:
    rig = RIGS[name]
    panel = pass_rigs.picture(rig).astype(np.float64)
    lattice = lattice_of(rig)
    seen = perceive(panel, rig, RAYS) / (1.0 if lattice is None else lattice.throughput)
    for side in ("left", "right"):
        columns = viewport(rig, side).columns
        applied = operator(rig, side).apply(panel[:, columns])
        # The same hits, added in another order.
        np.testing.assert_allclose(applied, seen[:, columns], atol=1e-12)


@pytest.mark.parametrize("name", RIGS)
def test_the_adjoint_is_exact(name: str) -> None:
    rig = RIGS[name]
    for side in ("left", "right"):
        p, a, b = operator(rig, side), half(rig, side, 1), half(rig, side, 2)
        there, back = np.sum(p.apply(a) * b), np.sum(a * p.adjoint(b))
        assert back == pytest.approx(there, rel=1e-12)


@pytest.mark.parametrize("name", RIGS)
def test_every_step_is_within_bounds_and_they_lead_down(name: str) -> None:
    rig = RIGS[name]
    p, meant = operator(rig, "left"), half(rig, "left", 3)
    left = []
    for steps in (0, 1, 2, 4, 16):
        shown = descend(p, meant, steps)
        assert shown.min() >= 0.0
        assert shown.max() <= 1.0
        left.append(float(np.sum((p.apply(shown) - meant) ** 2)))
    assert left == sorted(left, reverse=True)
    assert left[-1] < left[0]


def test_what_can_be_shown_is_shown() -> None:
    """Of a picture that some panel image makes exactly, nothing is left but what has no weight."""
    rig = RIGS["leaning-walls-acrylic-astigmatic"]
    p = operator(rig, "right")
    meant = p.apply(half(rig, "right", 4))
    start, end = (p.apply(descend(p, meant, steps)) - meant for steps in (0, 200))
    # Measured: 0.4 %. What is left has singular values too small for 200 steps.
    assert np.sum(end**2) < 0.02 * np.sum(start**2)


def test_unreached_pixels_stay_dark_whatever_the_black_level() -> None:
    # Two prism dioptres move the picture by 12 pixels.
    rig = pass_rigs.rig(40, 15, left={"sphere_d": -1.0, "prism_pd": [2.0, 0.0]})
    shown = optimal(np.ones((15, 40, 3)), with_prefilter(rig, black_level=0.4), RAYS)
    reached = perceive(np.ones((15, 40, 3)), rig, RAYS)
    assert reached[:, :20].min() == 0.0
    assert np.all(shown[:, :8] == 0.0)
    assert shown[:, 14:20].min() > 0.4


def with_prefilter(rig: Rig, **changes: Any) -> Rig:
    given = rig.prefilter.model_copy(update={"method": "optimal", **changes})
    return rig.model_copy(update={"prefilter": given})


def test_levels_map_black_and_white() -> None:
    rig = RIGS["walls-stripes-relief"]
    target = pass_rigs.picture(rig).astype(np.float64)
    mapped = optimal(0.2 + 0.5 * target, with_prefilter(rig), RAYS)
    levels = with_prefilter(rig, black_level=0.2, brightness=0.7)
    np.testing.assert_allclose(optimal(target, levels, RAYS), mapped, atol=1e-12)


def test_a_large_panel_is_refused_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_MOST_BYTES", 1000)
    with pytest.raises(InputError, match="panel: found 24x17 pixels") as caught:
        operator(RIGS["walls-stripes-relief"], "left")
    assert "\n" not in str(caught.value)
