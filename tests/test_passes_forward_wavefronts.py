"""Whole eyes in the forward prefilter: pixels sorted by how they are done, each way against the
float64 twin and the plain shader."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any

import numpy as np
import pass_rigs
import pytest
from numpy.typing import NDArray
from test_passes_forward_footprints import EDGE_SHARE, cut_by_the_twin, fast, hold_same, plain

from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.optics import polynomial
from vrlf.optics.bench import is_lateral
from vrlf.optics.inverse import InverseMap
from vrlf.passes.forward import Forward, ForwardTables
from vrlf.passes.forward_lists import PixelList
from vrlf.passes.forward_maps import moves_from_lenslets_px
from vrlf.reference.forward import forward as twin


def wavefront(diameter_mm: float, **terms: float) -> dict[str, Any]:
    """An eye's, of terms like ``c3m1``: n = 3, m = -1."""
    names = {name: f"{name[1]},{name[2:].replace('m', '-')}" for name in terms}
    return {
        "zernike": {
            "diameter_mm": diameter_mm,
            "coefficients_um": {names[name]: value for name, value in terms.items()},
        }
    }


# Polynomials of all degrees from 3 to 6; 2 and 7 are in pass_rigs. Coma, trefoil, oblique terms;
# no two eyes, and no x and y, are alike.
WHOLE: dict[str, Rig] = {
    "walls-full": pass_rigs.rig(
        65,
        44,
        panel={"subpixels": "full"},
        array=pass_rigs.LENSLETS
        | {"pitch_um": 620.0, "rotation_deg": -14.0, "barriers": "perpendicular"},
        left={"chromatic": True, "pupil_offset_mm": [0.5, -0.3]}
        | wavefront(5.5, c3m1=0.3, c4m2=0.1),
        right={"pupil_mm": 4.5} | wavefront(5.0, c3m3=-0.25, c40=0.2),
    ),
    "stripes-turned-moved": pass_rigs.rig(
        93,
        67,
        headset={"lens_height_mm": -0.41},
        array=pass_rigs.LENSLETS
        | {"pitch_um": 560.0, "rotation_deg": 19.0, "offset_um": [-45.0, 130.0]},
        left={"chromatic": True, "prism_pd": [1.0, -0.5], "cylinder_d": -1.25, "axis_deg": 25.0}
        | wavefront(6.0, c3m1=0.3, c33=-0.15, c4m4=0.1, c5m3=0.06),
        right={"chromatic": True, "stiles_crawford_per_mm2": 0.05, "pupil_mm": 5.5}
        | wavefront(5.5, c31=-0.35, c3m3=0.1, c40=0.2),
    ),
    "hexagons-behind-glass": pass_rigs.rig(
        45,
        41,
        headset=pass_rigs.FAR_OFF_GLASS,
        array=pass_rigs.LENSLETS
        | {
            "lattice": "hexagonal",
            "pitch_um": 640.0,
            "rotation_deg": 11.0,
            "offset_um": [60.0, -25.0],
        },
        left={"pupil_mm": 4.8} | wavefront(5.0, c3m1=0.2, c6m2=0.05),
        right={"chromatic": True} | wavefront(4.5, c33=0.2, c51=-0.1),
    ),
    "diamonds": pass_rigs.rig(
        47,
        38,
        panel={"subpixels": "pentile-diamond"},
        array=pass_rigs.LENSLETS | {"pitch_um": 600.0, "rotation_deg": 8.0},
        left=wavefront(6.0, c3m3=0.3, c7m1=0.04) | {"pupil_offset_mm": [0.4, 0.7]},
        right={"cylinder_d": -1.0, "axis_deg": 40.0} | wavefront(5.0, c31=0.2),
    ),
}


@pytest.mark.parametrize("name", WHOLE)
def test_whole_eyes_show_what_the_twin_does(device: Device, name: str) -> None:
    rig = WHOLE[name]
    target = pass_rigs.picture(rig, seed=21)
    got = fast(device, rig, target)
    # The twin traces in float64: a few 1e-6 px from a float32 polynomial of a place in a cell.
    hold_same(got, twin(target, rig), limit=1e-4)
    if not is_lateral(rig):
        hold_same(got, plain(device, rig, target))


def listed(pixels: PixelList, shape: tuple[int, int]) -> NDArray[np.bool_]:
    is_in = np.zeros(shape, bool)
    places = pixels.places()
    is_in[places // 65536, places % 65536] = True
    assert is_in.sum() == len(places)  # each once
    return is_in


@pytest.mark.parametrize("name", WHOLE)
def test_pixels_are_sorted_as_the_twin_would(device: Device, name: str) -> None:
    """Nothing dark that shows light, nothing by footprints that is cut, and enough of both ways."""
    rig = WHOLE[name]
    shape = (rig.panel.height_px, rig.panel.width_px)
    with ExitStack() as owned:
        forward, tables = Forward(device), ForwardTables(device, rig)
        owned.callback(forward.release)
        owned.callback(tables.release)
        assert tables.sorted is None
        forward.complete(tables)
        found = tables.sorted
        forward.complete(tables)
        assert tables.sorted is found
        assert found is not None
        assert found.window is not None
        by_footprints = listed(found.by_footprints, shape)
        by_samples, dark = listed(found.by_samples, shape), listed(found.dark, shape)
    lit = twin(np.ones((*shape, 3)), rig).max(axis=-1) > 0.0
    print(f"{by_footprints.mean():.2f} by footprints, {by_samples.mean():.2f} by samples")
    assert np.all(dark + by_footprints.astype(int) + by_samples == 1)
    # A sample on a border may be counted otherwise in float32.
    assert np.mean(lit & ~by_footprints & ~by_samples) <= EDGE_SHARE
    # A colour that a pixel lacks may be looked for alone.
    assert np.mean((by_footprints | by_samples) & ~lit) <= 0.01
    assert min(by_footprints.mean(), by_samples.mean()) > 0.05
    # That test's rays are of lenses without colour, and of the first of a period's places.
    if not is_lateral(rig) and rig.panel.subpixels != "pentile-diamond":
        assert np.mean(by_footprints & cut_by_the_twin(rig)) <= EDGE_SHARE


def test_nothing_crosses_the_septum(device: Device) -> None:
    rig = WHOLE["stripes-turned-moved"]
    target = pass_rigs.picture(rig, seed=4)
    half, clean = rig.panel.width_px // 2, fast(device, rig, target)
    left, right = np.s_[:, :half], np.s_[:, rig.panel.width_px - half :]
    for kept, spoiled in ((left, right), (right, left)):
        other = target.copy()
        other[spoiled] = np.nan
        shown = fast(device, rig, other)
        assert np.array_equal(shown[kept], clean[kept])
        assert np.isnan(shown[spoiled]).any()
    assert np.all(clean[:, half] == 0.0)


def test_one_forward_serves_whole_and_plain_eyes_by_turns(device: Device) -> None:
    """What was dark before is dark again, whatever was shown between."""
    whole = WHOLE["stripes-turned-moved"]
    bare = {"zernike": None, "chromatic": False}
    plain_eyes = whole.model_copy(
        update={side: getattr(whole, side).model_copy(update=bare) for side in ("left", "right")}
    )
    target = pass_rigs.picture(whole)
    wanted = [fast(device, rig, target).tobytes() for rig in (whole, plain_eyes)]
    with ExitStack() as owned:
        forward = Forward(device)
        owned.callback(forward.release)
        light = Texture.from_array(device, target, label="target")
        shown = Texture(device, light.size_px, label="shown")
        for each in (light, shown):
            owned.callback(each.release)
        for rig, shows in [*zip((whole, plain_eyes), wanted, strict=True)] * 2:
            tables = ForwardTables(device, rig)
            owned.callback(tables.release)
            forward.run(tables, light, shown)
            assert np.asarray(shown.read()[..., :3]).tobytes() == shows


def test_places_in_pixels_move_as_places_in_cells_do() -> None:
    random = np.random.default_rng(6)
    curves = tuple(np.flipud(np.tril(random.normal(size=(4, 4)))) for _ in range(2))
    crossed = np.array([[0.11, -0.04], [0.03, -0.12]])
    made = moves_from_lenslets_px([InverseMap(np.eye(2), (curves[0], curves[1]))], [crossed])
    places_px = random.uniform(-4.0, 4.0, (30, 2))
    cells = places_px @ crossed.T
    for axis in range(2):
        got = polynomial.evaluate(made[0, ..., axis].astype(np.float64), *places_px.T)
        wanted = polynomial.evaluate(curves[axis], *cells.T)
        assert got == pytest.approx(wanted, abs=1e-6)  # float32's coefficients
