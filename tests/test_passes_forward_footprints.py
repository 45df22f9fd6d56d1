"""Footprints, cut pixels and the plain shader of the forward prefilter against each other."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any

import numpy as np
import pass_rigs
import pytest
from numpy.typing import NDArray

from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.lattice import cell_coordinates, lattice_of, nearest_cell
from vrlf.optics.subpixels import layout
from vrlf.optics.viewport import SIDES, axis_in_viewport_px, panel_points_mm, pitch_mm, viewport
from vrlf.passes.forward import Forward, ForwardTables
from vrlf.passes.forward_plain import PlainForward, PlainForwardTables
from vrlf.reference.forward import forward as twin
from vrlf.reference.forward import retinal_points

Light = NDArray[Any]

# Both compute places in float32, by other sums; a few 1e-6 of a pixel apart, for light of 1.
SAME_LIGHT = 1e-5
# A sample on the border of a cell, of the pupil or of the viewport may be counted otherwise.
EDGE_SHARE = 1e-3


def shown_by(device: Device, passes: Any, tables_of: Any, rig: Rig, target: Light) -> Light:
    """What a pass shows for a target, (H, W, 3)."""
    with ExitStack() as owned:

        def kept(item: Any) -> Any:
            owned.callback(item.release)
            return item

        forward, tables = kept(passes(device)), kept(tables_of(device, rig))
        wanted = kept(Texture.from_array(device, target, label="target"))
        shown = kept(Texture(device, wanted.size_px, label="shown"))
        forward.run(tables, wanted, shown)
        return np.asarray(shown.read()[..., :3])


def fast(device: Device, rig: Rig, target: Light) -> Light:
    return shown_by(device, Forward, ForwardTables, rig, target)


def plain(device: Device, rig: Rig, target: Light) -> Light:
    return shown_by(device, PlainForward, PlainForwardTables, rig, target)


def with_grid(rig: Rig, grid: int) -> Rig:
    prefilter = rig.prefilter.model_copy(update={"subpixel_grid": grid})
    return rig.model_copy(update={"prefilter": prefilter})


def hold_same(got: Light, wanted: Light, limit: float = SAME_LIGHT) -> None:
    error = np.abs(got - wanted).max(axis=-1)
    apart = int((error > limit).sum())
    print(f"{apart} of {error.size} pixels apart, greatest error {error.max():.1e}")
    assert apart <= EDGE_SHARE * error.size


# Each joins what the others lack; no number of x and y, of left and right is alike.
RIGS: dict[str, Rig] = {
    "prism-beyond-the-viewport": pass_rigs.rig(
        91,
        67,
        array=pass_rigs.LENSLETS
        | {"pitch_um": 560.0, "rotation_deg": 19.0, "offset_um": [-45.0, 130.0]},
        left={"prism_pd": [1.2, -0.5], "cylinder_d": -1.25, "axis_deg": 25.0},
        right={"prism_pd": [-0.6, 1.0], "pupil_mm": 5.5},
    ),
    "acrylic-relief-moved": pass_rigs.rig(
        66,
        43,
        headset={"eye_relief_mm": 10.0, "lens_height_mm": -0.41, "lens_power_d": 20.0},
        array=pass_rigs.LENSLETS | {"gap_mm": 4.4, "gap_index": 1.49, "pitch_um": 520.0},
        left={"pupil_offset_mm": [0.8, -0.3], "vertex_mm": 13.0},
        right={"pupil_offset_mm": [-0.4, 1.1], "cylinder_d": 1.5, "axis_deg": 155.0},
    ),
    "full-walls-turned": pass_rigs.rig(
        65,
        44,
        panel={"subpixels": "full"},
        array=pass_rigs.HOLES | {"barriers": "perpendicular", "rotation_deg": -31.0},
        left={"pupil_mm": 3.0, "pupil_offset_mm": [0.5, 0.9]},
        right={"cylinder_d": -2.25, "axis_deg": 80.0},
    ),
    "chromatic-leaning-walls": pass_rigs.rig(
        69,
        37,
        panel={"subpixels": "bgr-stripe"},
        array=pass_rigs.LENSLETS | {"barriers": "converging", "rotation_deg": 8.0},
        left={"chromatic": True, "sphere_d": 2.0},
        right={"chromatic": True, "cylinder_d": -0.75, "axis_deg": 10.0},
    ),
    # A cell as wide as a viewport, a pupil that sees all of it: hardly a cut pixel.
    "one-wide-cell": pass_rigs.rig(
        24,
        17,
        array=pass_rigs.LENSLETS | {"pitch_um": 2600.0, "offset_um": [900.0, 300.0]},
        left={"pupil_mm": 12.0},
        right={"pupil_mm": 11.0},
    ),
    "hexagons": pass_rigs.rig(
        67,
        41,
        array=pass_rigs.LENSLETS
        | {
            "lattice": "hexagonal",
            "pitch_um": 540.0,
            "rotation_deg": 19.0,
            "offset_um": [-45.0, 130.0],
        },
        left={"pupil_mm": 3.5, "pupil_offset_mm": [0.5, 0.9], "cylinder_d": -1.0, "axis_deg": 70.0},
    ),
    # Viewports narrower than a footprint's window.
    "five-columns": pass_rigs.rig(
        5, 4, array=pass_rigs.LENSLETS, headset={"lens_separation_mm": 0.2}, left={"sphere_d": -4.0}
    ),
}


@pytest.mark.parametrize("grid", [1, 2, 3, 4])
@pytest.mark.parametrize("name", RIGS)
def test_fast_and_plain_show_the_same(device: Device, name: str, grid: int) -> None:
    rig = with_grid(RIGS[name], grid)
    target = pass_rigs.picture(rig, seed=grid)
    hold_same(fast(device, rig, target), plain(device, rig, target))


OTHERS = pass_rigs.SMALL | pass_rigs.HEXAGONAL | pass_rigs.VARYING


@pytest.mark.parametrize(
    "name",
    [
        "coma-lenslets",
        "square-holes-walls",
        "focused-lenslets",
        "hexagonal-lenslets",
        "hexagonal-walls",
        "varying-lenslets",
        "varying-walls",
    ],
)
def test_fast_and_plain_show_the_same_of_the_other_rigs(device: Device, name: str) -> None:
    rig = OTHERS[name]
    target = pass_rigs.picture(rig, seed=8)
    hold_same(fast(device, rig, target), plain(device, rig, target))


@pytest.mark.parametrize("name", RIGS)
def test_fast_shows_what_its_twin_does(device: Device, name: str) -> None:
    rig = RIGS[name]
    target = pass_rigs.picture(rig, seed=21)
    # The twin traces in float64: a few 1e-6 px from a float32 polynomial of a place in a cell.
    hold_same(fast(device, rig, target), twin(target, rig), limit=1e-4)


def test_all_ways_are_tried(device: Device) -> None:
    """Footprints with and without aligned rows, and samples alone: or the tests above are idle."""
    ways = {}
    forward = Forward(device)
    for name, rig in (RIGS | pass_rigs.SMALL).items():
        if rig.array.kind == "none":
            continue
        tables = ForwardTables(device, rig)
        forward.complete(tables)
        ways[name] = tables.footprints.aligned if tables.footprints else None
        tables.release()
    forward.release()
    print(ways)
    assert (ways["one-wide-cell"], ways["prism-beyond-the-viewport"]) == (True, False)
    assert ways["coma-lenslets"] is None
    assert all(sum(each is way for each in ways.values()) >= 4 for way in (True, False, None))


def cut_by_the_twin(rig: Rig) -> NDArray[np.bool_]:
    """Pixels with a sub-pixel of which some samples read the target, but not all, not through one
    cell, or where texels would be repeated."""
    lattice, grid = lattice_of(rig), rig.prefilter.subpixel_grid
    assert lattice is not None
    is_cut = np.zeros((rig.panel.height_px, rig.panel.width_px), bool)
    bench = bench_of(rig)
    for side in SIDES:
        view, optics = viewport(rig, side), eye_optics(rig, side)
        centre = axis_in_viewport_px(rig, view)
        for colour, (left, top, right, bottom) in enumerate(layout(rig.panel.subpixels).rectangles):
            rays = []
            for row, column in np.ndindex(grid, grid):
                x = left + (column + 0.5) / grid * (right - left) - 0.5
                y = 0.5 - top - (row + 0.5) / grid * (bottom - top)
                x_mm = panel_points_mm(rig, view) + np.array([x, y]) * pitch_mm(rig)
                seen, met = retinal_points(x_mm, bench, lattice, view, optics, colour)
                offset = np.array(optics.pupil_offset_mm)
                chief = x_mm * bench.array_per_slope_mm + bench.reduced_gap_mm * offset
                chief = chief / bench.panel_per_slope_mm + np.array(view.axis_mm)
                cell = nearest_cell(lattice, cell_coordinates(lattice, chief))
                texel = centre + seen * np.array([1.0, -1.0]) / pitch_mm(rig) - 0.5
                limit = np.array([view.width_px, view.height_px]) - 1
                within = np.all((texel >= 0) & (texel <= limit), axis=-1)
                inside = np.all((texel >= -0.5) & (texel <= limit + 0.5), axis=-1)
                rays.append(((met > 0) & inside, cell, within))
            reads, cell, within = (np.stack(part) for part in zip(*rays, strict=True))
            alike = np.all(cell == cell[0], axis=(0, -1)) & np.all(reads & within, axis=0)
            is_cut[:, view.columns] |= reads.any(axis=0) & ~alike
    return is_cut


@pytest.mark.parametrize("name", ["prism-beyond-the-viewport", "acrylic-relief-moved"])
def test_cut_pixels_are_those_of_the_twin(device: Device, name: str) -> None:
    rig = RIGS[name]
    forward, tables = Forward(device), ForwardTables(device, rig)
    forward.complete(tables)
    assert tables.cut is not None
    listed, counts = tables.cut.places(), tables.cut.counts
    forward.release()
    tables.release()
    middle = rig.panel.width_px // 2
    assert np.all(np.diff(listed[: counts[0]].astype(np.int64)) > 0)  # by rows, each once
    assert np.all(np.diff(listed[counts[0] :].astype(np.int64)) > 0)
    assert np.all(listed[: counts[0]] % 65536 < middle)
    assert np.all(listed[counts[0] :] % 65536 >= middle)
    got = np.zeros((rig.panel.height_px, rig.panel.width_px), bool)
    got[listed // 65536, listed % 65536] = True
    wanted = cut_by_the_twin(rig)
    # The middle of a sub-pixel may read the target where no sample does, seldom.
    print(f"{wanted.sum()} cut, {(got & ~wanted).sum()} more, {(wanted & ~got).sum()} missing")
    assert not np.any(wanted & ~got)
    assert np.count_nonzero(got & ~wanted) <= 0.01 * got.size
    assert 0.1 * got.size < np.count_nonzero(wanted) < 0.9 * got.size


def test_cut_pixels_are_looked_for_once(device: Device) -> None:
    rig = RIGS["full-walls-turned"]
    forward, tables = Forward(device), ForwardTables(device, rig)
    assert tables.cut is None
    forward.complete(tables)
    first, live = tables.cut, len(device.live_objects)
    forward.complete(tables)
    assert tables.cut is first
    assert len(device.live_objects) == live
    forward.release()
    tables.release()


def test_footprints_are_given_up_where_most_is_cut(device: Device) -> None:
    """Cells hardly wider than a pixel: found once, and shown sample by sample from then on."""
    rig = pass_rigs.rig(
        44, 31, array=pass_rigs.LENSLETS | {"pitch_um": 150.0, "rotation_deg": 12.0}
    )
    forward, tables = Forward(device), ForwardTables(device, rig)
    assert tables.footprints is not None
    forward.complete(tables)
    assert tables.footprints is None
    assert tables.cut is None
    forward.release()
    tables.release()
    target = pass_rigs.picture(rig, seed=3)
    hold_same(fast(device, rig, target), plain(device, rig, target))


def test_tables_without_cut_pixels_are_given_back(device: Device) -> None:
    """The device's guard counts what is left."""
    ForwardTables(device, RIGS["full-walls-turned"]).release()


@pytest.mark.parametrize("name", ["prism-beyond-the-viewport", "full-walls-turned"])
def test_same_input_gives_the_same_bytes(device: Device, name: str) -> None:
    rig = RIGS[name]
    target = pass_rigs.picture(rig, seed=2)
    first = fast(device, rig, target).tobytes()
    assert fast(device, rig, target).tobytes() == first
    with Device.headless() as other:
        assert fast(other, rig, target).tobytes() == first


def test_one_forward_serves_rigs_by_turns(device: Device) -> None:
    """Neither a list nor a window of one rig is left for the next one."""
    rigs = [with_grid(RIGS[name], 3) for name in ("acrylic-relief-moved", "full-walls-turned")]
    wanted = [fast(device, rig, pass_rigs.picture(rig)).tobytes() for rig in rigs]
    with ExitStack() as owned:
        forward = Forward(device)
        owned.callback(forward.release)
        for rig, shows in [*zip(rigs, wanted, strict=True)] * 2:
            tables = ForwardTables(device, rig)
            target = Texture.from_array(device, pass_rigs.picture(rig), label="target")
            shown = Texture(device, target.size_px, label="shown")
            for each in (tables, target, shown):
                owned.callback(each.release)
            forward.run(tables, target, shown)
            assert np.asarray(shown.read()[..., :3]).tobytes() == shows


@pytest.mark.parametrize("name", ["prism-beyond-the-viewport", "full-walls-turned", "coma"])
def test_nothing_crosses_the_septum(device: Device, name: str) -> None:
    """Each eye's half depends on that half of the target alone: not even a NaN gets over."""
    rig = pass_rigs.SMALL["coma-lenslets"] if name == "coma" else RIGS[name]
    target = pass_rigs.picture(rig, seed=4)
    half, clean = rig.panel.width_px // 2, fast(device, rig, target)
    left, right = np.s_[:, :half], np.s_[:, rig.panel.width_px - half :]
    for kept, spoiled in ((left, right), (right, left)):
        other = target.copy()
        other[spoiled] = np.nan
        shown = fast(device, rig, other)
        assert np.array_equal(shown[kept], clean[kept])
        assert np.isnan(shown[spoiled]).any()
