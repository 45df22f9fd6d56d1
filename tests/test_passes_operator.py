"""The operator's tables against perception itself, and against their own transpose.

Rigs asymmetric in every number, both eyes different, odd sizes; ``_RAYS_AN_EYE`` is lowered,
because a table's cost is in its rays and what is held here is not how many there are.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pass_rigs
import pytest
from numpy.typing import NDArray

from vrlf.errors import InputError
from vrlf.gpu import Texture
from vrlf.model import Rig
from vrlf.passes import phases
from vrlf.passes.operator import OperatorTables
from vrlf.passes.phases import PhaseRows, packed, patched, transposed
from vrlf.renderer import GpuRenderer
from vrlf.solve import Optimal, OptimalTables

Light = NDArray[Any]

RIGS: dict[str, Rig] = {
    name: pass_rigs.SMALL[name]
    for name in (
        "one-chromatic-eye",
        "full-leaning-walls",
        "strong-lenslets-full",
        "focused-lenslets",
        "coma-lenslets",
        "round-holes-moved",
        "square-holes-walls",
        "own-lens-bare",
    )
} | {
    # Oblique astigmatism, a turned and moved lattice, axes off the viewports' centres.
    "oblique": pass_rigs.rig(
        47,
        31,
        headset={"lens_separation_mm": 2.1, "lens_height_mm": 0.4},
        array=pass_rigs.LENSLETS | {"rotation_deg": 17.0, "offset_um": [60.0, -110.0]},
        panel={"subpixels": "bgr-stripe"},
        left={"cylinder_d": -2.0, "axis_deg": 35.0},
        right={"cylinder_d": -1.5, "axis_deg": 120.0, "pupil_offset_mm": [0.5, -0.8]},
    ),
}
# Of what is seen of noise, RMS: the table's phases and quadrature together. Measured 0.01 %
# (bare) to 2.5 % (coma-lenslets); three colours apart leave a third of the rays to each: 3.5 %.
PERCEIVED_WITHIN = {"one-chromatic-eye": 0.045}


@pytest.fixture(autouse=True)
def _few_rays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(phases, "_RAYS_AN_EYE", 1 << 22)


@pytest.fixture(scope="module")
def renderer() -> Iterator[GpuRenderer]:
    """On a device of its own: tables outlive a test here."""
    with GpuRenderer() as made:
        yield made


class Products:
    """P and P' of a rig on numpy pictures."""

    def __init__(self, renderer: GpuRenderer, rig: Rig) -> None:
        renderer.device.make_current()
        self._device = renderer.device
        self._optimal = Optimal(renderer.device)
        self._tables = OptimalTables(renderer.device, rig, self._optimal.builder)

    def __call__(self, which: Any, light: Light) -> Light:
        given = Texture.from_array(self._device, light.astype(np.float32), label="light")
        result = Texture(self._device, given.size_px, label="result")
        self._optimal.product(self._tables, which, given, result)
        values = np.asarray(result.read()[..., :3], dtype=np.float64)
        given.release()
        result.release()
        return values

    def release(self) -> None:
        self._tables.release()
        self._optimal.release()


@pytest.fixture(scope="module", params=RIGS)
def case(request: pytest.FixtureRequest, renderer: GpuRenderer) -> Iterator[tuple[str, Products]]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(phases, "_RAYS_AN_EYE", 1 << 22)
        products = Products(renderer, RIGS[request.param])
    yield request.param, products
    products.release()


def test_it_shows_what_perception_shows(case: tuple[str, Products], renderer: GpuRenderer) -> None:
    name, products = case
    light = pass_rigs.picture(RIGS[name])
    seen = renderer.perceive(light, RIGS[name], rays=4096)
    error = products("forward", light) - seen
    share = float(np.sqrt(np.mean(error**2) / np.mean(seen**2)))
    print(f"{name}: {100 * share:.2f} %")
    assert share < PERCEIVED_WITHIN.get(name, 0.03)


def test_the_middle_column_stays_dark(case: tuple[str, Products]) -> None:
    name, products = case
    width = RIGS[name].panel.width_px
    if width % 2:
        for which in ("forward", "adjoint"):
            seen = products(which, pass_rigs.picture(RIGS[name]))
            assert np.all(seen[:, width // 2] == 0.0)


def test_the_eyes_do_not_mix(case: tuple[str, Products]) -> None:
    name, products = case
    half = RIGS[name].panel.width_px // 2
    light = pass_rigs.picture(RIGS[name])
    light[:, half:] = 0.0
    for which in ("forward", "adjoint"):
        assert np.all(products(which, light)[:, half:] == 0.0)
        assert products(which, light)[:, :half].max() > 0.1


def test_the_adjoint_is_the_adjoint(case: tuple[str, Products]) -> None:
    name, products = case
    a, b = (pass_rigs.picture(RIGS[name], seed).astype(np.float64) for seed in (1, 2))
    # With noise about 0 nothing but the entries themselves can make the two products equal.
    for first, second in ((a, b), (a - 0.5, products("forward", a - 0.5))):
        there = float(np.sum(products("forward", first) * second))
        back = float(np.sum(first * products("adjoint", second)))
        print(f"{name}: {there / back - 1.0:.2e}")
        # Entries moved between phases lose some of their sharpness; measured 2.6 % at most.
        assert back == pytest.approx(there, rel=0.002 if first is a else 0.04)


def test_perpendicular_barriers_are_refused_in_one_line(renderer: GpuRenderer) -> None:
    before = renderer.device.live_objects
    with pytest.raises(InputError) as caught:
        OperatorTables(renderer.device, pass_rigs.SMALL["bgr-walls"], builder=None)  # type: ignore[arg-type]
    message = str(caught.value)
    assert "\n" not in message
    assert "barriers 'perpendicular'" in message
    assert renderer.device.live_objects == before


# The tables' arithmetic alone.


def random_rows(phases_a_side: int, seed: int = 3) -> PhaseRows:
    """Three entries in each of many phases, all different."""
    random = np.random.default_rng(seed)
    phase = np.repeat(np.arange(phases_a_side**2), 3)
    offsets = np.stack([random.integers(-4, 9, len(phase)), random.integers(-7, 3, len(phase))], -1)
    kept = np.unique(np.column_stack([phase, offsets]), axis=0)
    weights = random.random((len(kept), 3)).astype(np.float32)
    return PhaseRows(kept[:, 0], kept[:, 1:], weights)


def test_turned_twice_by_whole_phases_is_the_same() -> None:
    rows = random_rows(5)
    per_offset = np.array([[1.0, -2.0], [2.0, 3.0]])
    once = transposed(rows, per_offset, 5)
    again = transposed(once, per_offset, 5)
    order = np.lexsort((again.offsets[:, 0], again.offsets[:, 1], again.phase))
    wanted = np.lexsort((rows.offsets[:, 0], rows.offsets[:, 1], rows.phase))
    lit = again.weights[order].max(axis=1) > 0.0
    np.testing.assert_array_equal(again.phase[order][lit], rows.phase[wanted])
    np.testing.assert_array_equal(again.offsets[order][lit], rows.offsets[wanted])
    np.testing.assert_array_equal(again.weights[order][lit], rows.weights[wanted])


def test_turning_keeps_all_light() -> None:
    rows = random_rows(7)
    turned = transposed(rows, np.array([[0.37, -0.21], [0.44, 0.83]]), 7)
    for offset in np.unique(rows.offsets, axis=0):
        there = rows.weights[np.all(rows.offsets == offset, axis=1)].sum()
        back = turned.weights[np.all(turned.offsets == -offset, axis=1)].sum()
        assert back == pytest.approx(there, rel=1e-6)


def test_a_patch_holds_its_four_corners() -> None:
    rows, n = random_rows(6), 6
    patches = patched(rows, n)
    by_key = {(p, *o): w for p, o, w in zip(rows.phase, rows.offsets, rows.weights, strict=True)}
    assert patches.starts[-1] == len(patches.offsets)
    for row in range(n * n):
        for i in range(patches.starts[row], patches.starts[row + 1]):
            for corner in range(4):
                phase = (row // n + corner // 2) % n * n + (row % n + corner % 2) % n
                wanted = by_key.get((phase, *patches.offsets[i]), np.zeros(3))
                np.testing.assert_array_equal(patches.weights[i, :, corner], wanted)


def test_nothing_makes_an_empty_table() -> None:
    rows = PhaseRows(np.zeros(0, int), np.zeros((0, 2), int), np.zeros((0, 3), np.float32))
    patches = patched(transposed(rows, np.eye(2), 4), 4)
    assert patches.starts.tolist() == [0] * 17
    assert packed(patches).shape == (0, 8)


def test_packing_keeps_signs_and_halves() -> None:
    patches = patched(random_rows(4), 4)
    words = packed(patches)
    np.testing.assert_array_equal(words[:, :1].view(np.int16), patches.offsets)
    halves = np.ascontiguousarray(words[:, 1:7]).view(np.float16).reshape(-1, 3, 4)
    np.testing.assert_array_equal(halves, patches.weights.astype(np.float16))
