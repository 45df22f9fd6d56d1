"""The perception pass against its float64 twin, the known results and an independent tracer."""

from __future__ import annotations

import re
from typing import Any

import independent_tracer
import numpy as np
import pass_rigs
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from vrlf.gpu import Device, Texture, compute
from vrlf.model import Rig
from vrlf.optics.bench import bench_of, is_lateral
from vrlf.optics.eye import aberration_at, eye_optics
from vrlf.optics.holes import hole_points
from vrlf.optics.lattice import lattice_of
from vrlf.optics.lines import stretches
from vrlf.optics.quadrature import quadrature_of
from vrlf.optics.samples import pupil_points, ray_tables, uses_area_means
from vrlf.optics.viewport import SIDES, Side, panel_points_mm, viewport
from vrlf.passes import bins
from vrlf.passes import perceive as perceive_pass
from vrlf.passes import rays as rays_pass
from vrlf.passes.perceive import Perceive
from vrlf.passes.rays import PerceiveTables
from vrlf.reference.perceive import trace as twin_trace
from vrlf.reference.quadrature import perceive_well as twin

Light = NDArray[Any]

RAYS = 64
# Both sides trace the same rays; what a 32-bit landing of 1e-4 um and sums of 64 terms leave
# is below 1e-6, but a ray within 0.05 um of an edge may fall on its other side.
SAME_LIGHT = 1e-4
EDGE_SHARE = 1e-3
# A float32 place of a few hundred um is good to 2e-5 um; sums of some of them to a few of these.
LANDING_UM = 0.05


def perceived(device: Device, rig: Rig, panel: Light, rays: int, exposure: float = 1.0) -> Light:
    """What the pass makes of a panel image, (H, W, 3)."""
    owned: list[Any] = [Perceive(device)]
    try:
        owned.append(tables := PerceiveTables(device, rig, rays))
        owned.append(shown := Texture.from_array(device, panel, label="panel"))
        owned.append(seen := Texture(device, shown.size_px, label="seen"))
        owned[0].run(tables, shown, seen, exposure=exposure)
        return seen.read()[..., :3]
    finally:
        for each in owned:
            each.release()


def rms(difference: Light) -> float:
    """Root mean square over pixels and colours."""
    return float(np.sqrt(np.mean(np.asarray(difference, np.float64) ** 2)))


def hold_same(got: Light, wanted: Light, what: str) -> None:
    """All pixels equal, but for the few where a ray fell on the other side of an edge."""
    error = np.abs(got - wanted).max(axis=-1)
    apart = int((error > SAME_LIGHT).sum())
    print(f"{what}: {apart} of {error.size} pixels apart, greatest error {error.max():.1e}")
    assert apart <= EDGE_SHARE * error.size
    # Two rays' light, at three times the radiance: more than edges explain is no edge.
    assert error.max() <= 2 * 3 / RAYS


@pytest.mark.parametrize("name", pass_rigs.CASES)
def test_perceive_matches_its_twin(device: Device, name: str) -> None:
    rig, panel = pass_rigs.case(name)
    hold_same(perceived(device, rig, panel, RAYS), twin(panel, rig, RAYS), name)


def test_small_rigs_reach_the_sampled_lenslets() -> None:
    # "strongest-lenslets" is there for the branch without area means.
    for name, wanted in (("strongest-lenslets", False), ("strong-lenslets", True)):
        rig = pass_rigs.SMALL[name]
        assert uses_area_means(bench_of(rig), lattice_of(rig)) is wanted


# (width, height, pixel pitch um): a thesis phone and a 4K one.
_FULL_SIZES = {"phone": (1334, 750, 78.0), "4k": (3840, 2160, 31.5)}


def full_size_rig(name: str, **array: Any) -> Rig:
    """A whole panel with all that moves a landing: lattice, relief, pupil, cylinder."""
    width, height, pitch_um = _FULL_SIZES[name]
    return pass_rigs.rig(
        width,
        height,
        panel={"pixel_pitch_um": pitch_um},
        headset={
            "lens_separation_mm": 61.0,
            "lens_height_mm": 1.7,
            "eye_relief_mm": 11.0,
            "lens_power_d": 21.0,
        },
        array=array | {"rotation_deg": 17.3, "offset_um": [83.0, -141.0]},
        left={"pupil_offset_mm": [-1.3, 0.8], "cylinder_d": -2.0, "axis_deg": 33.0},
        right={
            "pupil_offset_mm": [0.9, 1.2],
            "zernike": {"diameter_mm": 6.0, "coefficients_um": {"3,-1": 0.4, "4,0": 0.2}},
        },
    )


def point_on_gpu(rig: Rig, rays: int, point: int) -> dict[str, int]:
    """Which of its blind points each eye's table holds at ``point``: holes keep them sorted."""
    lattice = lattice_of(rig)
    if lattice is None:
        return dict.fromkeys(SIDES, point)
    tables = [ray_tables(rig, side, rays) for side in SIDES]
    colours = max(len(each) for each in tables)
    flat = [table for each in tables for table in each * (colours // len(each))]
    crossings = [t.array_cells + t.within_cells for t in flat]
    grid = bins.grid_over(crossings, lattice.hole_reach)
    orders = [bins.sort_into(grid, each)[0] for each in crossings]
    return {side: int(orders[i * colours][point]) for i, side in enumerate(SIDES)}


def some_pixels(length: int, count: int) -> Any:
    """Rows or columns all over a viewport, its corners too."""
    return np.unique(np.linspace(0, length - 1, count).astype(int))


def hold_landings(rig: Rig, landed: Light, rays: int, point: int) -> None:
    """``landed`` (H, W, 4) against the twin, on a grid of pixels that holds all corners."""
    for side in SIDES:
        view, optics = viewport(rig, side), eye_optics(rig, side)
        rows, columns = some_pixels(view.height_px, 40), some_pixels(view.width_px, 60)
        centre_mm = panel_points_mm(rig, view)[np.ix_(rows, columns)]
        got = landed[:, view.columns][np.ix_(rows, columns)].astype(np.float64)
        u_mm, within_mm, in_cell = begun(rig, side, rays, point, got[..., :2])
        slope = aberration_at(optics.aberration[0], u_mm)
        u_mm = u_mm + np.array(optics.pupil_offset_mm)
        x_mm = centre_mm + within_mm
        wanted = twin_trace(optics.benches[0], lattice_of(rig), view, x_mm, u_mm, slope)
        off_um = (in_cell - wanted.in_cell) * rig.array.pitch_um
        # A crossing on a border between cells may be counted to either; rare, and left out.
        same_cell = (np.abs(off_um) < 0.5 * rig.array.pitch_um).all(axis=-1)
        if rig.array.kind == "none":
            same_cell[...] = True
        assert same_cell.mean() > 0.999
        assert np.abs(off_um[same_cell]).max() <= LANDING_UM
        moved_um = (wanted.panel_mm - centre_mm) * 1e3 * [1.0, -1.0]
        error_um = np.abs(got[..., 2:] * rig.panel.pixel_pitch_um - moved_um)[same_cell]
        assert error_um.max() <= LANDING_UM


def begun(rig: Rig, side: Side, rays: int, point: int, got: Light) -> tuple[Light, Light, Light]:
    """From the pupil's centre, from the pixel's, and in its cell: where the traced ray begins.

    ``got`` is the place in the cell, or, where holes have points, in the pupil.
    """
    optics, kind = eye_optics(rig, side), quadrature_of(rig, rays)
    if kind == "points":
        index = point_on_gpu(rig, rays, point)[side]
        points = pupil_points(rig, optics, rays)
        # With lateral colour the table of a mask's ray holds its place in the pixel, too.
        folded = is_lateral(rig) and rig.array.kind != "none"
        within_mm = points.within_pixel_mm[index] if folded else np.zeros(2)
        return points.from_centre_mm[index], within_mm, got
    if kind == "lines":
        lines = stretches(rig, optics, 0, rays, "all")
        begin_mm = optics.weighed(lines.from_centre_mm[point, 0])
        return begin_mm, lines.within_pixel_mm[point, 0], got
    lattice = lattice_of(rig)
    assert lattice is not None
    both = [hole_points(rig, lattice, eye_optics(rig, each), rays, "all") for each in SIDES]
    in_hole, within_px = np.split(max(both, key=len)[point], 2)
    within_mm = within_px * [1.0, -1.0] * rig.panel.pixel_pitch_um / 1e3
    return got * optics.pupil_mm / 2.0, within_mm, in_hole


def landings(device: Device, rig: Rig, rays: int, point: int) -> Light:
    """What ``Perceive.trace`` writes, (H, W, 4)."""
    tracer, tables = Perceive(device), PerceiveTables(device, rig, rays)
    landing = Texture(device, tables.size_px, label="landing")
    try:
        tracer.trace(tables, point, landing)
        return landing.read()
    finally:
        for each in (tracer, tables, landing):
            each.release()


@pytest.mark.parametrize("name", pass_rigs.CASES)
def test_rays_land_where_the_twin_says(device: Device, name: str) -> None:
    rig, _ = pass_rigs.case(name)
    for point in (0, 13):
        hold_landings(rig, landings(device, rig, RAYS, point), RAYS, point)


@pytest.mark.parametrize("size", _FULL_SIZES)
@pytest.mark.parametrize("kind", ["lenslets", "holes", "bare"])
def test_rays_land_where_the_twin_says_on_whole_panels(
    device: Device, size: str, kind: str
) -> None:
    array: dict[str, Any] = {
        "lenslets": pass_rigs.LENSLETS | {"barriers": "converging"},
        "holes": pass_rigs.HOLES,
        "bare": {"kind": "none"},
    }[kind]
    rig = full_size_rig(size, **array)
    if kind == "holes":  # blind points behind the wavefront, each hole's own behind a lens
        assert quadrature_of(rig, 16) == "points"
        hold_landings(rig, landings(device, rig, 16, 5), 16, 5)
        rig = rig.model_copy(update={"right": rig.left})
        assert quadrature_of(rig, 16) == "holes"
    hold_landings(rig, landings(device, rig, 16, 5), 16, 5)


def vector_tolerance(rig: Rig) -> float:
    """RMS: 4096 rays' noise on smooth integrands, and where edges cut many of them."""
    smooth = rig.panel.subpixels == "full" and rig.array.kind != "pinhole"
    return 0.002 if smooth and rig.array.barriers == "none" else 0.006


@pytest.mark.parametrize("name", pass_rigs.KNOWN)
def test_perceive_matches_known_results(device: Device, name: str) -> None:
    rig, known = pass_rigs.known_rig(name), pass_rigs.known_results(name)
    error = rms(perceived(device, rig, known["panel"], 4096) - known["perceived"])
    print(f"{name}: {error:.5f} RMS")
    assert error <= vector_tolerance(rig)


@pytest.mark.parametrize("name", pass_rigs.APART)
def test_perceive_matches_an_independent_tracer(device: Device, name: str) -> None:
    rig = pass_rigs.APART[name]
    panel = pass_rigs.picture(rig, seed=11)
    # The tracer's points are shifted from pixel to pixel, so its noise is white: four times the
    # rays where edges make it loud.
    rays = 4096 if vector_tolerance(rig) < 0.005 else 16384
    wanted = independent_tracer.perceived(panel, rig, rays, seed=2)
    error = rms(perceived(device, rig, panel, 4096) - wanted)
    print(f"{name}: {error:.5f} RMS")
    assert error <= vector_tolerance(rig)


def test_same_input_gives_the_same_bytes(device: Device) -> None:
    rig, panel = pass_rigs.case("holes-square-perpendicular")
    first = perceived(device, rig, panel, RAYS).tobytes()
    assert perceived(device, rig, panel, RAYS).tobytes() == first
    with Device.headless() as other:
        assert perceived(other, rig, panel, RAYS).tobytes() == first


@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(1, 300),
    half_aperture=st.floats(0.002, 0.5),
    spread=st.floats(1e-6, 50.0),
)
@settings(max_examples=60, deadline=None)
def test_each_ray_lies_in_one_bin(
    seed: int, count: int, half_aperture: float, spread: float
) -> None:
    random = np.random.default_rng(seed)
    crossings = [spread * (random.random((count, 2)) - 0.3) for _ in range(2)]
    grid = bins.grid_over(crossings, np.array([half_aperture, 1.4 * half_aperture]))
    for each in crossings:
        order, starts = bins.sort_into(grid, each)
        assert sorted(order) == list(range(count))
        assert (starts[0], starts[-1]) == (0, count)
        assert len(starts) == grid.count[0] * grid.count[1] + 1
        numbers = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
        corner = np.stack([numbers % grid.count[0], numbers // grid.count[0]], axis=-1)
        within = (each[order] - grid.origin) / grid.size - corner
        assert within.min() >= -1e-9  # a bin's border, to rounding
        assert within.max() <= 1.0 + 1e-9


# Narrow and wide holes, an open array, masks so fine that a ray table spans thousands of holes.
_MASKS: dict[str, dict[str, Any]] = {
    "narrow": {"aperture_um": 60.0},
    "wide": {"aperture_um": 370.0},
    "wide-round": {"aperture_um": 380.0, "aperture_shape": "circle"},
    "open": {"aperture_um": 390.0},
    "fine": {"pitch_um": 40.0, "aperture_um": 35.0},
    "very-fine": {"pitch_um": 6.0, "aperture_um": 3.0},
}


@pytest.mark.parametrize("mask", _MASKS)
def test_each_ray_under_a_hole_counts_once(device: Device, mask: str) -> None:
    # A white panel that reaches beyond all rays: the mean over a cell of what is seen counts them.
    rig = pass_rigs.rig(
        16,
        12,
        panel={"subpixels": "full"},
        array=pass_rigs.HOLES | _MASKS[mask] | {"rotation_deg": 8.0},
        left={"sphere_d": 1.0},
        right={"sphere_d": -4.0},
    )
    white = np.ones((12, 16, 3), np.float32)
    hold_same(perceived(device, rig, white, RAYS), twin(white, rig, RAYS), mask)


def test_an_open_mask_is_a_bare_panel_point_by_point(device: Device) -> None:
    # Many rays: a bin under several holes must not exhaust a software driver's loops either.
    rig = pass_rigs.rig(8, 6, array=pass_rigs.HOLES | {"aperture_um": 390.0})
    bare = pass_rigs.rig(8, 6, array={"kind": "none"})
    panel = pass_rigs.picture(rig)
    seen = perceived(device, rig, panel, 40000)
    # Points of an area here, its mean there: 1e-3 is twice the noise of the latter's 4096 rays.
    assert rms(seen - perceived(device, bare, panel, 4096)) <= 1e-3


@pytest.mark.parametrize(
    "name", ["one-chromatic-eye", "round-holes-moved", "own-lens-bare", "bgr-walls"]
)
@pytest.mark.parametrize("limit", ["_LOOP_TURNS", "_DISPATCH_RAYS"])
def test_cut_up_work_gives_the_same_image(
    device: Device, monkeypatch: pytest.MonkeyPatch, name: str, limit: str
) -> None:
    rig, panel = pass_rigs.case(name)
    whole = perceived(device, rig, panel, RAYS)
    rows = 5 * panel.shape[1] * RAYS * 3  # about; not a divisor of the height
    # Masks count a turn for each lane of a software driver.
    turns = 20 * (16 if rig.array.kind == "pinhole" else 1)
    module = rays_pass if limit == "_LOOP_TURNS" else perceive_pass
    monkeypatch.setattr(module, limit, {"_LOOP_TURNS": turns, "_DISPATCH_RAYS": rows}[limit])
    groups = count_groups(monkeypatch)
    cut = perceived(device, rig, panel, RAYS)
    assert len(groups) > 2
    # The rays are added in another order: rounding of a sum of up to 64 x 3.
    assert np.abs(cut - whole).max() <= 1e-6


def count_groups(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """A list that grows with each dispatch of the perception pass."""
    dispatched: list[int] = []

    class Counting(compute.ComputePass):
        def run(self, width_px: int, height_px: int = 1, layers: int = 1) -> None:
            dispatched.append(height_px)
            super().run(width_px, height_px, layers)

    monkeypatch.setattr(compute, "ComputePass", Counting)
    return dispatched


def test_exposure_scales_what_is_seen(device: Device) -> None:
    rig, panel = pass_rigs.case("round-holes-moved")
    plain = perceived(device, rig, panel, RAYS)
    # One float32 product more.
    np.testing.assert_allclose(
        perceived(device, rig, panel, RAYS, exposure=7.5), 7.5 * plain, rtol=1e-6
    )


def test_the_middle_column_of_an_odd_width_is_dark(device: Device) -> None:
    rig, panel = pass_rigs.case("bgr-walls")
    seen = perceived(device, rig, panel, RAYS)
    assert np.all(seen[:, 22] == 0.0)
    assert np.all(seen[5:-5, 10:14].sum(axis=-1) > 0.0)


def test_a_perfect_eye_sees_the_bare_panel(device: Device) -> None:
    perfect = {"sphere_d": 0.0}
    rig = pass_rigs.rig(30, 18, left=perfect, right=perfect)
    panel = pass_rigs.picture(rig)
    # 64 equal means of float32 sums: rounding only.
    np.testing.assert_allclose(perceived(device, rig, panel, RAYS), panel, atol=2e-6)


def test_shader_names_its_twin(repo_root: Any) -> None:
    for name, count in (("perceive", 2), ("forward", 1)):
        head = (repo_root / "shaders" / f"{name}.comp").read_text(encoding="utf-8")[:1500]
        twins = re.findall(r"vrlf/reference/\w+\.py", head)
        assert [(repo_root / each).is_file() for each in twins] == [True] * count


def test_many_rays_behind_a_turned_mask_do_not_run_out_of_turns(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Software GL ends the loops of neighbouring pixels together, after 65,535 turns in all.

    Rays that cross the mask close together, chromatic eyes and a turned lattice make
    neighbours meet their rays at different holes; whole batches then lost up to a sixth of
    the light. Batches of a few hundred rays cannot.
    """
    eye = {"sphere_d": -3.25, "vertex_mm": 0.0, "pupil_mm": 6.0, "chromatic": True}
    array = pass_rigs.HOLES | {"pitch_um": 390.0, "gap_mm": 6.0, "aperture_um": 150.0}
    rig = pass_rigs.rig(160, 80, array=array | {"rotation_deg": 17.0}, left=eye, right=eye)
    panel = pass_rigs.picture(rig)
    seen = perceived(device, rig, panel, 4096)
    monkeypatch.setattr(rays_pass, "_LOOP_TURNS", 16 * 3 * 300)
    # The rays are added in another order: rounding of a sum of some 28,000 x 3.
    assert np.abs(perceived(device, rig, panel, 4096) - seen).max() <= 1e-5
