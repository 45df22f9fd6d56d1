"""The fringe metric by closed forms, and what samples of the sub-pixels do to fringes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from vrlf.evaluation.fringes import fringe
from vrlf.evaluation.metrics.colour import colour_error
from vrlf.model import Rig, load_rig
from vrlf.optics.viewport import SIDES, viewport
from vrlf.renderer import GpuRenderer, Image
from vrlf.studies.quality import cropped

# ITU-R BT.709-6.
RED, GREEN, BLUE = 0.2126, 0.7152, 0.0722


def test_a_grey_error_has_no_fringe() -> None:
    rng = np.random.default_rng(3)
    target = rng.random((12, 9, 3))
    assert colour_error(target + rng.random((12, 9, 1)), target) == pytest.approx(0.0, abs=1e-15)


def test_a_colour_error_has_luminance_zero_and_its_own_size() -> None:
    target = np.zeros((1, 1, 3))
    found = colour_error(np.array([[[0.5, 0.0, 0.0]]]), target)[0, 0]
    assert found == pytest.approx([0.5 * (1 - RED), -0.5 * RED, -0.5 * RED])
    assert found @ [RED, GREEN, BLUE] == pytest.approx(0.0, abs=1e-15)


def bare_rig(size: tuple[int, int]) -> Rig:
    """Eyes without a blur, so that the border is nothing."""
    sharp = {"sphere_d": 0.0, "vertex_mm": 0.0}
    changes = [f"{side}.{key}={value}" for side in SIDES for key, value in sharp.items()]
    return cropped(load_rig("bare", overrides=changes), size)


def edge(rig: Rig, moved_px: tuple[int, int, int]) -> NDArray[np.float32]:
    """A grey edge in the middle of each viewport, each colour so far to the right of it."""
    shown = np.zeros((rig.panel.height_px, rig.panel.width_px, 3), np.float32)
    for side in SIDES:
        view = viewport(rig, side)
        for colour, moved in enumerate(moved_px):
            middle = view.first_column + view.width_px // 2 + moved
            shown[:, middle : view.first_column + view.width_px, colour] = 0.8
    return shown


def test_red_a_pixel_beside_the_edge() -> None:
    """By hand: one column in forty lacks red, and the gain moves all others a little."""
    rig = bare_rig((80, 20))
    target, seen = edge(rig, (0, 0, 0)), edge(rig, (1, 0, 0))
    # Light meets its target on 20 columns of green and blue, on 19 of red.
    assert fringe(seen, target, rig, "left") == pytest.approx(
        0.8 * np.sqrt(((1 - RED) ** 2 + 2 * RED**2) / (3 * 40)) / (0.8 * 20 / 40)
    )
    # Green carries more of the luminance: the colour it leaves is stronger.
    green = fringe(edge(rig, (0, 1, 0)), target, rig, "right")
    assert green == pytest.approx(np.sqrt(((1 - GREEN) ** 2 + 2 * GREEN**2) / 120) * 2)


def test_all_colours_beside_the_edge_are_a_shift_without_fringe() -> None:
    rig = bare_rig((80, 20))
    found = fringe(edge(rig, (2, 2, 2)), edge(rig, (0, 0, 0)), rig, "left")
    assert found == pytest.approx(0.0, abs=1e-12)


def test_how_bright_it_is_makes_no_difference() -> None:
    rig = bare_rig((80, 20))
    target, seen = edge(rig, (0, 0, 0)), edge(rig, (0, -1, 1))
    strong = fringe(seen, target, rig, "left")
    assert strong == pytest.approx(fringe(0.2 * seen, target, rig, "left"), rel=1e-5)
    assert strong == pytest.approx(fringe(0.5 * seen, 0.5 * target, rig, "left"), rel=1e-5)
    assert fringe(seen, 0.0 * target, rig, "left") is None


def star(rig: Rig) -> Image:
    """Grey spokes in each viewport, finer toward the middle."""
    target = np.zeros((rig.panel.height_px, rig.panel.width_px, 3), np.float32)
    for side in SIDES:
        view = viewport(rig, side)
        y, x = np.mgrid[: view.height_px, : view.width_px]
        angle = np.arctan2(y - view.height_px / 2 + 0.5, x - view.width_px / 2 + 0.5)
        target[:, view.columns] = (0.5 + 0.5 * np.sign(np.sin(16.0 * angle)))[..., None]
    return target


def test_nine_samples_of_each_sub_pixel_leave_less_colour_than_one() -> None:
    """Thesis 5.3, measured on its own headset: the table of ``vrlf/evaluation/fringes.py``."""
    rig = cropped(load_rig("thesis-minus-5d"), (300, 150))
    target, found = star(rig), {}
    with GpuRenderer() as renderer:
        for grid in (1, 3):
            sampled = rig.prefilter.model_copy(update={"subpixel_grid": grid})
            panel = renderer.prefilter(target, rig.model_copy(update={"prefilter": sampled}))
            seen = renderer.perceive(panel, rig, rays=1024)
            found[grid] = fringe(seen, target, rig, "left") or 0.0
    print(found)
    assert 0.0 < found[3] < 0.95 * found[1]
