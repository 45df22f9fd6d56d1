"""Footprints against the float64 twin's traced rays, and their windows against brute force."""

from __future__ import annotations

import numpy as np
import pass_rigs
import pytest
from numpy.typing import NDArray

from vrlf.model import Rig
from vrlf.optics import footprint
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.lattice import lattice_of
from vrlf.optics.raster import cells_per_pixel
from vrlf.optics.subpixels import layout
from vrlf.optics.viewport import RASTER_FLIP, SIDES, pitch_mm, viewport
from vrlf.passes.forward_maps import inverse_maps
from vrlf.reference.forward import retinal_points

Float = NDArray[np.float64]
WITH_FOOTPRINTS = (
    "one-chromatic-eye",
    "bgr-walls",
    "rgb-walls-turned",
    "round-holes-moved",
    "strong-lenslets-full",
)


def made(rig: Rig, grid: int = 3) -> footprint.Footprints | None:
    """The footprints of a rig with an array."""
    lattice = lattice_of(rig)
    assert lattice is not None
    maps, ray_sets = inverse_maps(rig, lattice)
    samples = [footprint.sample_grid(r, grid) for r in layout(rig.panel.subpixels).rectangles]
    crossed = bench_of(rig).array_from_panel * cells_per_pixel(rig, lattice)
    return footprint.footprints(maps, [crossed] * len(maps), samples[:ray_sets] * 2, grid)


def traced_px(rig: Rig, side: int, colour: int, places_px: Float) -> Float:
    """Where the twin sees panel points, in pixels right and down; (n, 2) in and out."""
    lattice, name = lattice_of(rig), SIDES[side]
    assert lattice is not None
    optics, view = eye_optics(rig, name), viewport(rig, name)
    x_mm = places_px @ RASTER_FLIP * pitch_mm(rig)
    seen, _ = retinal_points(x_mm, bench_of(rig), lattice, view, optics, colour)
    return np.asarray(seen @ RASTER_FLIP / pitch_mm(rig))


@pytest.mark.parametrize("name", WITH_FOOTPRINTS)
def test_steps_are_those_of_traced_rays(name: str) -> None:
    rig = pass_rigs.SMALL[name]
    got = made(rig)
    assert got is not None
    sets = len(got.steps_px) // 2
    for index, steps in enumerate(got.steps_px):
        side, colour = divmod(index, sets)
        left, top, right, bottom = layout(rig.panel.subpixels).rectangles[colour]
        across, down = np.array([(right - left) / 3, 0.0]), np.array([0.0, (bottom - top) / 3])
        # Rays a thousandth of a step apart cross one lenslet, but for one in a few hundred.
        start = np.random.default_rng(3).uniform(-8.0, 8.0, (50, 2))
        for step, wanted in ((across, steps[:2]), (down, steps[2:])):
            moved = traced_px(rig, side, colour, start + 1e-3 * step)
            step_px = (moved - traced_px(rig, side, colour, start)) / 1e-3
            # A difference of places of 10 pixels, by 1e-3, keeps 1e-11.
            assert np.median(step_px, axis=0) == pytest.approx(wanted, abs=1e-9)


def test_samples_of_a_stripe() -> None:
    """The middle third at the middle of the pixel, three samples down at -1/3, 0 and 1/3."""
    got = footprint.sample_grid(np.array([1 / 3, 0.0, 2 / 3, 1.0]), 3)
    assert got == pytest.approx([-1 / 9, -1 / 3, 1 / 9, 1 / 3])


@pytest.mark.parametrize("reach", [0.0, 0.38, 1.0, 1.139, 2.0, 3.7])
def test_windows_hold_each_footprint_and_hardly_more(reach: float) -> None:
    """A window begins at the floor of the first sample."""
    size, _ = footprint.window_of(np.array([reach, 0.0]))
    first = np.arange(4096) / 4096
    texels = np.arange(12)
    # The weight of a texel is not 0 if a sample, anywhere from first to last, is nearer than 1.
    weighed = (texels > first[:, None] - 1) & (texels < first[:, None] + reach + 1)
    most = int(texels[weighed.any(axis=0)].max()) + 1
    assert most <= size <= most + 2
    assert size % 2 == 0


def test_gathers_cover_windows() -> None:
    assert [footprint.gathers(w) for w in ((2, 2), (4, 4), (4, 6), (6, 4))] == [1, 4, 6, 6]


def test_rows_stay_rows_for_spheres_only() -> None:
    """Whatever the turn of the lattice; an oblique cylinder skews them."""
    turned = {"array": pass_rigs.LENSLETS | {"rotation_deg": 23.0}}
    sphere = made(pass_rigs.rig(44, 30, **turned))
    upright = made(pass_rigs.rig(44, 30, **turned, left={"cylinder_d": -1.0, "axis_deg": 90.0}))
    oblique = made(pass_rigs.rig(44, 30, **turned, right={"cylinder_d": -1.0, "axis_deg": 35.0}))
    assert sphere is not None
    assert upright is not None
    assert oblique is not None
    assert (sphere.aligned, upright.aligned, oblique.aligned) == (True, True, False)


def test_no_footprints_where_samples_are_better() -> None:
    curved, wide = pass_rigs.SMALL["coma-lenslets"], pass_rigs.SMALL["full-leaning-walls"]
    assert made(curved) is None  # no affine map
    assert made(wide) is None  # 6 x 6 texels need 9 gathers, as many as there are samples
    assert made(wide, grid=4) is not None
    assert made(pass_rigs.SMALL["bgr-walls"], grid=1) is None
    assert made(pass_rigs.SMALL["bgr-walls"], grid=2) is None


def test_footprints_pay_until_much_is_cut() -> None:
    """4 gathers of 9 leave 4.1 until nine tenths of 9: pixels done twice may be 0.455 of all."""
    got = made(pass_rigs.SMALL["bgr-walls"])
    assert got is not None
    assert [footprint.pays(got, share, 3) for share in (0.0, 0.45, 0.46)] == [True, True, False]


def test_a_window_holds_narrower_footprints() -> None:
    """Dark and cut pixels fit nowhere; the others by both their sides."""
    kinds = np.array([[0, 1, 4 + 16 * 4, 3 + 16 * 5], [5 + 16 * 3, 2 + 16 * 2, 6 + 16 * 6, 255]])
    got = footprint.fitting(kinds.astype(np.uint8), (4, 6))
    assert got.tolist() == [[False, False, True, True], [False, True, False, False]]


def test_the_window_with_least_work() -> None:
    """Two gathers more for all are paid by samples saved in some; windows never pass a viewport."""
    view = (30, 20)

    def window(narrow: int, tall: int, grid: int = 3, within: tuple[int, int] = view) -> object:
        kinds = np.array([4 + 16 * 4] * narrow + [3 + 16 * 6] * tall + [1] * 50 + [0] * 50)
        return footprint.window_for(kinds.astype(np.uint8), grid, within)

    # 9 samples by themselves cost 21.3 gathers more than 9 in a footprint: 17.3 are saved by
    # 4 x 4 texels, 15.3 by 4 x 6.
    assert window(100, 12) == (4, 4)
    assert window(100, 14) == (4, 6)
    assert window(100, 14, within=(30, 5)) == (4, 4)
    assert window(100, 14, within=(3, 20)) is None
    assert window(100, 14, grid=1) is None
    assert window(0, 0) is None
