"""A point as each aberration shows it: the GPU's picture against spot diagrams by hand.

A panel pixel and a retinal pixel are squares, so a ray that lands between pixels shares its
light bilinearly. The spot X = X0 - m T(u) is summed over a dense polar grid of the pupil, whose
wavefronts come from ``optics_by_hand``; neither shares code with the pass.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import optics_by_hand as by_hand
import pytest
from numpy.typing import NDArray

from vrlf.model import Rig
from vrlf.optics.viewport import SIDES, Side
from vrlf.reference.quadrature import perceive_well
from vrlf.renderer import GpuRenderer

SIDE_PX = 41
# Neither in the middle nor on a diagonal.
LIT_COLUMN, LIT_ROW = 19, 22
RAYS = 8192
# Sums of absolute differences, of the point's light: the rays are spread evenly to a few 1/8192
# a pixel, and a spot covers some 50 pixels. Measured: at most 0.012.
LIKENESS = 0.02
# In pixels; of first moments.
CENTRE_PX = 0.01

Image = NDArray[np.float64]
TERMS = [f"{n},{m}" for n in range(2, 6) for m in range(-n, n + 1, 2)] + ["6,-4", "7,1", "8,0"]


@pytest.fixture(scope="module")
def renderer() -> Iterator[GpuRenderer]:
    with GpuRenderer() as made:
        yield made


def point_rig(left: dict[str, Any], right: dict[str, Any]) -> Rig:
    return by_hand.rig(
        panel={"width_px": 2 * SIDE_PX, "height_px": SIDE_PX},
        headset={"lens_separation_mm": SIDE_PX * by_hand.PITCH_MM},
        left={"pupil_mm": 6.0} | left,
        right={"pupil_mm": 5.0} | right,
    )


def lit_panel() -> NDArray[np.float32]:
    panel = np.zeros((SIDE_PX, 2 * SIDE_PX, 3), np.float32)
    panel[LIT_ROW, [LIT_COLUMN, SIDE_PX + LIT_COLUMN]] = 1.0
    return panel


def halves(seen: NDArray[Any], channel: int = 1) -> dict[Side, Image]:
    light = seen[..., channel].astype(np.float64)
    return {"left": light[:, :SIDE_PX], "right": light[:, SIDE_PX:]}


def spot_by_hand(given: Rig, side: Side, rho_per_mm2: float = 0.0) -> Image:
    """The spot diagram of the lit pixel, each ray's light shared bilinearly."""
    eye = given.left if side == "left" else given.right
    # Rings of equal area, with turned spokes.
    rings, spokes = 200, 200
    radius = np.sqrt((np.arange(rings) + 0.5) / rings) * eye.pupil_mm / 2.0
    angle = 2.0 * np.pi * (np.arange(spokes)[None, :] + 0.618 * np.arange(rings)[:, None]) / spokes
    u = np.stack([radius[:, None] * np.cos(angle), radius[:, None] * np.sin(angle)], axis=-1)
    u = u.reshape(-1, 2)
    weight = 10.0 ** (-rho_per_mm2 * np.sum(u**2, axis=-1))
    moved_px = -by_hand.slope_distance_mm(given) * by_hand.aberration(eye, u) / by_hand.PITCH_MM
    column, row = LIT_COLUMN + moved_px[:, 0], LIT_ROW - moved_px[:, 1]
    image = np.zeros((SIDE_PX, SIDE_PX))
    first = np.stack([np.floor(row), np.floor(column)], axis=-1).astype(int)
    part = np.stack([row, column], axis=-1) - first
    for down in (0, 1):
        for right in (0, 1):
            share = np.abs(1 - down - part[:, 0]) * np.abs(1 - right - part[:, 1])
            np.add.at(image, (first[:, 0] + down, first[:, 1] + right), share * weight)
    return image / weight.sum()


def centre(image: Image) -> Image:
    rows, columns = np.indices(image.shape)
    return np.array([(columns * image).sum(), (rows * image).sum()]) / image.sum()


@pytest.mark.parametrize("term", TERMS)
def test_each_aberrations_point_is_its_spot_diagram(renderer: GpuRenderer, term: str) -> None:
    # Half a micrometre, at most 4 pixels of blur a term; the right eye's sign is the other.
    given = point_rig(
        {"zernike": {"diameter_mm": 6.0, "coefficients_um": {term: 0.5}}},
        {"zernike": {"diameter_mm": 5.5, "coefficients_um": {term: -0.4}}, "sphere_d": -0.5},
    )
    seen = halves(renderer.perceive(lit_panel(), given, rays=RAYS, exposure="none"))
    for side in SIDES:
        spot = spot_by_hand(given, side)
        assert seen[side].sum() == pytest.approx(1.0, abs=1e-4)
        assert np.abs(seen[side] - spot).sum() < LIKENESS
        assert centre(seen[side]) == pytest.approx(centre(spot), abs=CENTRE_PX)


def test_many_aberrations_with_prism_and_cylinder_add_up(renderer: GpuRenderer) -> None:
    left = {"3,-1": 0.3, "3,3": -0.25, "4,2": 0.15, "2,-2": 0.4, "5,-3": 0.08}
    right = {"3,1": -0.3, "4,-4": 0.2, "2,2": 0.3, "6,0": 0.05, "2,0": 0.2}
    given = point_rig(
        {
            "sphere_d": -1.0,
            "cylinder_d": -0.75,
            "axis_deg": 30.0,
            "prism_pd": [0.3, -0.2],
            "zernike": {"diameter_mm": 6.5, "coefficients_um": left},
        },
        {
            "cylinder_d": 1.0,
            "axis_deg": 110.0,
            "zernike": {"diameter_mm": 5.0, "coefficients_um": right},
        },
    )
    seen = halves(renderer.perceive(lit_panel(), given, rays=RAYS, exposure="none"))
    for side in SIDES:
        spot = spot_by_hand(given, side)
        assert np.abs(seen[side] - spot).sum() < LIKENESS
        assert centre(seen[side]) == pytest.approx(centre(spot), abs=CENTRE_PX)


# cos k theta keeps its sign under x -> -x where k is even, sin k theta where it is odd.
MIRRORED = ["3,1", "3,-1", "3,3", "3,-3", "2,-2", "4,-2", "4,4", "5,1", "5,-3"]


@pytest.mark.parametrize("term", MIRRORED)
def test_a_mirrored_eye_sees_a_mirrored_point(renderer: GpuRenderer, term: str) -> None:
    n, m = (int(part) for part in term.split(","))
    turned = (abs(m) % 2 == 0) == (m < 0)  # odd in x
    wavefront = {"diameter_mm": 6.0, "coefficients_um": {term: 0.5}}
    mirror = {"diameter_mm": 6.0, "coefficients_um": {term: -0.5 if turned else 0.5}}
    given = point_rig(
        {"zernike": wavefront, "sphere_d": -0.5, "cylinder_d": -1.0, "axis_deg": 25.0},
        {
            "zernike": mirror,
            "sphere_d": -0.5,
            "cylinder_d": -1.0,
            "axis_deg": 155.0,
            "pupil_mm": 6.0,
        },
    )
    panel = np.zeros((SIDE_PX, 2 * SIDE_PX, 3), np.float32)
    panel[LIT_ROW, [LIT_COLUMN, 2 * SIDE_PX - 1 - LIT_COLUMN]] = 1.0
    seen = halves(renderer.perceive(panel, given, rays=RAYS, exposure="none"))
    # The two eyes' rays are not each other's mirror image.
    assert np.abs(seen["left"] - seen["right"][:, ::-1]).sum() < LIKENESS
    if turned or n == 2:
        assert np.abs(seen["left"] - seen["left"][:, ::-1]).sum() > 10.0 * LIKENESS


@pytest.mark.parametrize("rho", [0.02, 0.05, 0.2])
def test_stiles_and_crawford_dim_the_rim_of_a_spot(renderer: GpuRenderer, rho: float) -> None:
    given = point_rig(
        {
            "sphere_d": -4.0,
            "zernike": {"diameter_mm": 6.0, "coefficients_um": {"3,1": 0.5}},
            "stiles_crawford_per_mm2": rho,
        },
        {"sphere_d": -3.0, "cylinder_d": -2.0, "axis_deg": 40.0, "stiles_crawford_per_mm2": rho},
    )
    seen = halves(renderer.perceive(lit_panel(), given, rays=RAYS, exposure="none"))
    for side in SIDES:
        # All of the light is still there: exposure is by what the effect leaves.
        assert seen[side].sum() == pytest.approx(1.0, abs=1e-4)
        assert np.abs(seen[side] - spot_by_hand(given, side, rho)).sum() < LIKENESS
        assert np.abs(seen[side] - spot_by_hand(given, side)).sum() > LIKENESS


@pytest.mark.parametrize("kind", ["microlens", "pinhole"])
def test_stiles_and_crawford_behind_an_array(renderer: GpuRenderer, kind: str) -> None:
    eye = {"sphere_d": -5.0, "pupil_offset_mm": [0.4, -0.3], "stiles_crawford_per_mm2": 0.1}
    array = {
        "kind": kind,
        "pitch_um": 390.0,
        "gap_mm": 3.0,
        "focal_mm": 1.95,
        "aperture_um": 150.0,
        "rotation_deg": 11.0,
    }
    given = by_hand.rig(array=array, left=eye, right={"sphere_d": -2.0, "pupil_mm": 4.0})
    panel = np.random.default_rng(4).random((30, 60, 3), dtype=np.float32)
    seen = renderer.perceive(panel, given, rays=256, exposure="none")
    wanted = perceive_well(panel.astype(np.float64), given, 256)
    # The project's promise between a pass and its twin, but for rays on a border.
    assert np.quantile(np.abs(seen - wanted), 0.99) < 1e-4
    # And between the quadrature and the law itself: blind points of the pupil, each weighed.
    assert _root_mean_square(seen - _weighed(panel, given, 0.1)) < 0.012


def _root_mean_square(difference: NDArray[Any]) -> float:
    return float(np.sqrt(np.mean(difference[:, :30] ** 2)))


def _weighed(panel: NDArray[np.float32], given: Rig, rho: float) -> Image:
    """The left eye's view by many rays of its pupil, each with its weight; the rest is dark."""
    random = np.random.default_rng(7)
    count = 1500
    radius = np.sqrt(random.random(count)) * given.left.pupil_mm / 2.0
    angle = random.random(count) * 2.0 * np.pi
    from_centre = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    weight = 10.0 ** (-rho * radius**2)
    rows, columns = np.indices((30, 30))
    total, open_to = np.zeros((30, 60, 3)), 0.0
    for index in range(count):
        within = random.random((30, 30, 2)) - 0.5
        X = np.stack([columns - 14.5, 14.5 - rows], axis=-1) + within
        u = from_centre[index] + np.array(given.left.pupil_offset_mm)
        slope = by_hand.aberration(given.left, from_centre[index])
        ray = by_hand.backward(given, "left", X * by_hand.PITCH_MM, u, slope)
        place = ray.panel_mm / by_hand.PITCH_MM * [1.0, -1.0] + 15.0
        pixel = np.floor(place).astype(int)
        seen = np.all((pixel >= 0) & (pixel < 30), axis=-1)
        if given.array.kind == "pinhole":
            off = (ray.array_mm - ray.centre_mm) @ _turn(given.array.rotation_deg)
            seen &= np.abs(off).max(axis=-1) <= given.array.aperture_um / 2000.0
        column, row = np.clip(pixel, 0, 29)[..., 0], np.clip(pixel, 0, 29)[..., 1]
        total[:, :30] += weight[index] * seen[..., None] * panel[row, column]
        open_to += weight[index]
    return total / open_to


def _turn(degrees: float) -> Image:
    angle = np.radians(degrees)
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
