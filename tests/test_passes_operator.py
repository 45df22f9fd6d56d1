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
from vrlf.model import Rig, load_rig
from vrlf.optics.lattice import lattice_of
from vrlf.passes import operator, phases
from vrlf.passes.operator import OperatorTables
from vrlf.passes.phases import Rows, Turning, packed, sampling_of
from vrlf.passes.pixels import turned
from vrlf.passes.tabulate import RowBuilder
from vrlf.renderer import GpuRenderer
from vrlf.solve import Optimal, OptimalTables

Light = NDArray[Any]

RIGS: dict[str, Rig] = (
    {
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
            "bgr-walls",
            "rgb-walls-turned",
            "diamonds-lenslets",
            "rgbg-walls",
            "diamonds-holes",
            "rgbg-bare",
            "glass-bare",
            "glass-lenslets-walls",
            "glass-lenslets-full",
            "glass-without-relief",
            "dispersing-lenslets-walls",
            "dispersing-lenslets-glass",
        )
    }
    | {
        name: pass_rigs.HEXAGONAL[name]
        for name in ("hexagonal-lenslets", "hexagonal-walls", "hexagonal-square-holes")
    }
    | {name: pass_rigs.VARYING[name] for name in ("varying-lenslets", "varying-square-holes")}
    | {
        # Each pixel sees some 180 others through several lenslets: read by the nearest phase.
        "spread": pass_rigs.rig(
            63,
            43,
            array=pass_rigs.LENSLETS | {"gap_mm": 6.0, "focal_mm": 6.0, "rotation_deg": 7.0},
            panel={"subpixels": "rgb-stripe"},
            left={"cylinder_d": -1.0, "axis_deg": 25.0, "pupil_mm": 6.0},
            right={"sphere_d": -6.0, "pupil_mm": 5.5, "pupil_offset_mm": [0.3, -0.4]},
        ),
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
)
# Of what is seen of noise, RMS: the table's phases and quadrature together. Measured 0.01 %
# (bare) to 2.5 %; three colours apart leave a third of the rays to each, coma sharpens what few
# rays show.
# Diamonds send the light of a pixel out of an eighth of it, or of two out of a fifth, and share
# their rays among four places: from 512 to 2048 rays a row 5.2 becomes 4.4 % behind lenslets and
# 4.3 becomes 2.6 % behind holes.
PERCEIVED_WITHIN = {
    "one-chromatic-eye": 0.045,
    "hexagonal-lenslets": 0.045,
    "varying-lenslets": 0.045,
    "coma-lenslets": 0.045,
    "round-holes-moved": 0.04,
    "diamonds-lenslets": 0.06,
    "diamonds-holes": 0.05,
    "dispersing-lenslets-walls": 0.045,
}
# Of blind rays few meet a hole: there a row takes as many as it may have.
RAYS_AN_EYE = dict.fromkeys(("round-holes-moved", "square-holes-walls", "diamonds-holes"), 1 << 25)


@pytest.fixture(autouse=True)
def _few_rays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(phases, "_RAYS_AN_EYE", 1 << 22)
    monkeypatch.setattr(phases, "_MOST", 128)


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
        self._optimal.builder.products.apply(self._tables.operator, which, given, result)
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
        patch.setattr(phases, "_RAYS_AN_EYE", RAYS_AN_EYE.get(request.param, 1 << 22))
        patch.setattr(phases, "_MOST", 128)
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
        # An entry moves to the nearest phase, up to half a step off, and behind holes all of
        # one offset by the same part of it; measured 0.9 % at most.
        assert back == pytest.approx(there, rel=0.012)


WALLED = ("bgr-walls", "rgb-walls-turned", "rgbg-walls", "hexagonal-walls", "varying-lenslets")


@pytest.mark.parametrize("name", WALLED)
def test_with_walls_the_adjoint_is_the_true_transpose(renderer: GpuRenderer, name: str) -> None:
    products = Products(renderer, RIGS[name])
    try:
        a, b = (pass_rigs.picture(RIGS[name], seed).astype(np.float64) - 0.5 for seed in (1, 2))
        b += products("forward", a)
        there = float(np.sum(products("forward", a) * b))
        # The same weights both ways; sums of 32 bits.
        assert float(np.sum(a * products("adjoint", b))) == pytest.approx(there, rel=1e-5)
    finally:
        products.release()


def test_walls_on_too_large_a_panel_are_refused_in_one_line(
    renderer: GpuRenderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(operator, "_MOST_BYTES", 50_000)
    renderer.device.make_current()
    builder = RowBuilder(renderer.device)
    before = renderer.device.live_objects
    with pytest.raises(InputError, match="panel: found 45x31 pixels") as caught:
        OperatorTables(renderer.device, RIGS["bgr-walls"], builder)
    assert "\n" not in str(caught.value)
    assert "barriers 'perpendicular'" in str(caught.value)
    added = [label for label in renderer.device.live_objects if label not in before]
    # The program stays with its builder.
    assert all(label.startswith("pass operator_rows") for label in added)
    builder.release()
    assert renderer.device.live_objects == before


@pytest.mark.parametrize("name", ["oblique", "full-leaning-walls", "bgr-walls", "own-lens-bare"])
def test_a_piece_at_a_time_gives_the_same_bytes(renderer: GpuRenderer, name: str) -> None:
    renderer.device.make_current()
    builder = RowBuilder(renderer.device)
    at_once = OperatorTables(renderer.device, RIGS[name], builder)
    building, pieces = OperatorTables.building(renderer.device, RIGS[name], builder), 0
    while True:
        try:
            next(building)
            pieces += 1
        except StopIteration as done:
            by_pieces = done.value
            break
    assert pieces > 10
    for one, other in zip(
        (*at_once.forward, *at_once.adjoint, at_once.crossings),
        (*by_pieces.forward, *by_pieces.adjoint, by_pieces.crossings),
        strict=True,
    ):
        np.testing.assert_array_equal(one.read(np.uint32), other.read(np.uint32))
    for owner in (at_once, by_pieces, builder):
        owner.release()


@pytest.mark.parametrize("name", ["oblique", "bgr-walls"])
def test_closed_anywhere_it_gives_all_back(renderer: GpuRenderer, name: str) -> None:
    renderer.device.make_current()
    builder = RowBuilder(renderer.device)
    OperatorTables(renderer.device, RIGS[name], builder).release()
    before = renderer.device.live_objects
    total = sum(1 for _ in kept_by(OperatorTables.building(renderer.device, RIGS[name], builder)))
    for stop in (1, 2, total // 2, *range(total - 4, total)):
        building = OperatorTables.building(renderer.device, RIGS[name], builder)
        for _ in range(stop):
            next(building)
        building.close()
        assert renderer.device.live_objects == before
    builder.release()


def kept_by(building: Any) -> Iterator[None]:
    """Its rests; what it makes is released."""
    tables = yield from building
    tables.release()


def test_bands_change_nothing() -> None:
    n, rows = 7, random_rows(7)
    turning = turned_about(rows, np.array([[0.37, -0.21], [0.44, 0.83]]), n)
    whole, parts = turning.lines(range(n)), [turning.lines(range(a, a + 1)) for a in range(n)]
    for name in ("row", "offsets", "weights"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        np.testing.assert_array_equal(joined, getattr(whole, name))


def test_turned_to_the_nearest_keeps_every_entry_whole() -> None:
    rows = random_rows(7)
    per_offset = np.array([[0.37, -0.21], [0.44, 0.83]])
    back = transposed(rows, per_offset, 7)
    assert len(back.row) == len(rows.row)
    column, line = (
        (place + np.rint(moved).astype(int)) % 7
        for place, moved in zip(
            (rows.row % 7, rows.row // 7), (rows.offsets @ per_offset.T).T, strict=True
        )
    )
    wanted = {
        (y * 7 + x, *-o): w
        for x, y, o, w in zip(column, line, rows.offsets, rows.weights, strict=True)
    }
    for row, offset, weights in zip(back.row, back.offsets, back.weights, strict=True):
        np.testing.assert_array_equal(weights, wanted[row, *offset])


def test_phases_are_finer_where_a_row_holds_few_pixels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    for name, wanted in (
        ("thesis-minus-5d", 48),
        ("bare", 1),
        ("matched-microlens", 213),
        ("matched-wide", 256),
    ):
        rig = load_rig(name)
        assert sampling_of(rig, lattice_of(rig)) == (wanted, wanted), name


def test_pixels_turned_in_bands_are_the_transpose() -> None:
    width, height = 5, 9
    random = np.random.default_rng(4)
    row = np.sort(random.integers(0, width * height, 60))
    offsets = random.integers(-3, 5, (60, 2))
    rows = Rows(row, offsets, random.random((60, 3)).astype(np.float32))
    matrix = np.zeros((width * height, width * height))
    for r, (dx, dy), w in zip(row, offsets, rows.weights[:, 1], strict=True):
        x, y = r % width + dx, r // width + dy
        if 0 <= x < width and 0 <= y < height:
            matrix[r, y * width + x] += w
    back = np.zeros_like(matrix)
    for band in (range(4), range(4, 5), range(5, height)):
        part = turned(rows, (width, height), band)
        assert np.all(np.diff(part.row) >= 0)
        assert np.all((part.row >= band.start * width) & (part.row < band.stop * width))
        for r, (dx, dy), w in zip(part.row, part.offsets, part.weights[:, 1], strict=True):
            back[r, (r // width + dy) * width + r % width + dx] += w
    np.testing.assert_allclose(back, matrix.T, rtol=1e-6)


# The tables' arithmetic alone.


def transposed(rows: Rows, per_offset: Light, phases_a_side: int) -> Rows:
    """All lines at once."""
    return turned_about(rows, per_offset, phases_a_side).lines(range(phases_a_side))


def turned_about(rows: Rows, per_offset: Light, phases_a_side: int) -> Turning:
    """In two parts, as rows come."""
    turning, half = Turning(per_offset, phases_a_side), len(rows.row) // 2
    turning.take(rows.take(slice(half)))
    turning.take(rows.take(slice(half, None)))
    for _ in turning.join():
        pass
    return turning


def random_rows(phases_a_side: int, seed: int = 3) -> Rows:
    """Three entries in each of many phases, all different."""
    random = np.random.default_rng(seed)
    phase = np.repeat(np.arange(phases_a_side**2), 3)
    offsets = np.stack([random.integers(-4, 9, len(phase)), random.integers(-7, 3, len(phase))], -1)
    kept = np.unique(np.column_stack([phase, offsets]), axis=0)
    weights = random.random((len(kept), 3)).astype(np.float32)
    return Rows(kept[:, 0], kept[:, 1:], weights)


def test_turned_twice_by_whole_phases_is_the_same() -> None:
    rows = random_rows(5)
    per_offset = np.array([[1.0, -2.0], [2.0, 3.0]])
    once = transposed(rows, per_offset, 5)
    again = transposed(once, per_offset, 5)
    order = np.lexsort((again.offsets[:, 0], again.offsets[:, 1], again.row))
    wanted = np.lexsort((rows.offsets[:, 0], rows.offsets[:, 1], rows.row))
    lit = again.weights[order].max(axis=1) > 0.0
    np.testing.assert_array_equal(again.row[order][lit], rows.row[wanted])
    np.testing.assert_array_equal(again.offsets[order][lit], rows.offsets[wanted])
    np.testing.assert_array_equal(again.weights[order][lit], rows.weights[wanted])


def test_turning_keeps_all_light() -> None:
    rows = random_rows(7)
    turned = transposed(rows, np.array([[0.37, -0.21], [0.44, 0.83]]), 7)
    for offset in np.unique(rows.offsets, axis=0):
        there = rows.weights[np.all(rows.offsets == offset, axis=1)].sum()
        back = turned.weights[np.all(turned.offsets == -offset, axis=1)].sum()
        assert back == pytest.approx(there, rel=1e-6)


def test_nothing_makes_an_empty_table() -> None:
    rows = Rows(np.zeros(0, int), np.zeros((0, 2), int), np.zeros((0, 3), np.float32))
    assert len(transposed(rows, np.eye(2), 4).row) == 0
    assert packed(rows).shape == (0, 2)


def test_packing_keeps_signs_and_nine_bits() -> None:
    rows = random_rows(4)
    words = packed(rows)
    np.testing.assert_array_equal(words[:, :1].view(np.int16), rows.offsets)
    found = unpacked(words[:, 1])
    largest = rows.weights.max(axis=1, keepdims=True)
    # Half a step of the largest, which has 256 to 512 of them.
    assert np.all(np.abs(found - rows.weights) <= largest / 512)


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((1.0, 0.5, 0.25), (1.0, 0.5, 0.25)),
        # Rounds up to a power of two, which needs the next exponent.
        ((0.99999, 0.0, 0.5), (1.0, 0.0, 0.5)),
        ((2.0**-24, 0.0, 2.0**-26), (2.0**-24, 0.0, 0.0)),
        ((3.0, 0.01, 1.0), (3.0, 0.0078125, 1.0)),
    ],
)
def test_a_shared_exponent_follows_the_largest(given: Any, wanted: Any) -> None:
    word = phases.shared_exponent(np.array([given], np.float32))
    np.testing.assert_array_equal(unpacked(word)[0], wanted)


def unpacked(words: NDArray[np.uint32]) -> NDArray[Any]:
    """EXT_texture_shared_exponent, equation by equation."""
    mantissa = np.stack([words >> shift & 0x1FF for shift in (0, 9, 18)], axis=-1)
    return mantissa * 2.0 ** ((words >> 27).astype(float) - 15 - 9)[:, None]


@pytest.mark.parametrize("lanes", [2, 4, 8])
@pytest.mark.parametrize("name", ["oblique", "bgr-walls"])
def test_shared_rows_give_the_same_sums(
    renderer: GpuRenderer, monkeypatch: pytest.MonkeyPatch, name: str, lanes: int
) -> None:
    """On a GPU several invocations share a row; here as many."""
    alone = Products(renderer, RIGS[name])
    monkeypatch.setattr(operator, "_lanes", lambda *_: lanes)
    together = Products(renderer, RIGS[name])
    light = pass_rigs.picture(RIGS[name])
    try:
        for which in ("forward", "adjoint"):
            # The order in which floats of 32 bits are added up.
            np.testing.assert_allclose(together(which, light), alone(which, light), atol=2e-6)
    finally:
        alone.release()
        together.release()
