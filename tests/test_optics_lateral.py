"""Colours that the headset's lens takes apart, and how each prefilter brings them together."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pass_rigs
import pytest
from numpy.typing import NDArray

from vrlf.model import Rig
from vrlf.optics.bench import bench_of, colour_benches
from vrlf.optics.inspect import inspect_rig
from vrlf.optics.lateral import forward_changes, lateral_px, longitudinal_d, registering_maps
from vrlf.passes.forward_plain import PlainForwardTables
from vrlf.renderer import GpuRenderer, ReferenceRenderer

Light = NDArray[Any]

# Sharp eyes before a panel at the focus, the axes 23 mm beside it: blue is seen 3 pixels off.
SHARP = {"sphere_d": 0.0, "pupil_mm": 1.0}
AT_FOCUS = pass_rigs.FAR_OFF_GLASS | {"lens_power_d": 1000.0 / 46.0}


def sharp_rig(**tables: dict[str, Any]) -> Rig:
    given: dict[str, Any] = {"panel": {"subpixels": "full"}, "headset": AT_FOCUS}
    given |= {"left": SHARP, "right": SHARP | {"pupil_offset_mm": [0.6, -0.4]}}
    for name, change in tables.items():
        given[name] = given.get(name, {}) | change
    return pass_rigs.rig(90, 41, **given)


@pytest.fixture(scope="module")
def gpu() -> Iterator[GpuRenderer]:
    with GpuRenderer() as made:
        yield made


def middles(seen: Light, half: slice) -> Light:
    """Where the light of each colour of one eye's view has its middle, in pixels; (3, 2)."""
    light = seen[:, half].astype(np.float64)
    total = light.sum(axis=(0, 1))
    rows, columns = np.indices(light.shape[:2])
    across = (light * columns[..., None]).sum(axis=(0, 1)) / total
    return np.stack([across, (light * rows[..., None]).sum(axis=(0, 1)) / total], axis=-1)


HALVES = (slice(0, 45), slice(45, 90))


def spot(given: Rig) -> Light:
    """Soft white spots about the viewports' middles: a shift shows in where their light lies."""
    rows, columns = np.indices((given.panel.height_px, given.panel.width_px))
    light = np.zeros((*rows.shape, 3), np.float32)
    for middle in (22.3, 67.6):
        off = ((columns - middle) ** 2 + (rows - 19.4) ** 2) / (2 * 3.0**2)
        light += np.exp(-off)[..., None].astype(np.float32)
    return light


def test_colours_go_apart_by_what_is_said(gpu: GpuRenderer) -> None:
    """A white spot at X is seen in a colour at X m_0 / m: uncorrected, by three pixels and more."""
    given = sharp_rig(prefilter={"method": "none"}, right={"pupil_offset_mm": [0.0, 0.0]})
    target = spot(given)
    seen = gpu.perceive(gpu.prefilter(target, given), given, rays=512)
    for half, side in zip(HALVES, (1, -1), strict=True):
        was, found = middles(target, half), middles(seen, half)
        # The axis: 23.5 mm beside the panel's middle, 6.5 mm above it.
        axis = np.array([45.0 - side * 23.5 / 0.078 - half.start, 20.5 - 6.5 / 0.078]) - 0.5
        for colour, bench in enumerate(colour_benches(given)):
            wanted = axis + (was[colour] - axis) / bench.panel_from_retina
            assert found[colour] == pytest.approx(wanted, abs=0.02)
        assert np.abs(found[0] - found[2]).max() > 1.5


@pytest.mark.parametrize("method", ["forward", "optimal"])
def test_a_bare_panels_colours_come_together(gpu: GpuRenderer, method: str) -> None:
    given = sharp_rig(prefilter={"method": method})
    target = spot(given)
    seen = gpu.perceive(gpu.prefilter(target, given), given, rays=512)
    for half in HALVES:
        found = middles(seen, half)
        # An eye whose pupil is moved sees all of them displaced alike.
        assert np.abs(found - found[1]).max() < 0.03


@pytest.mark.parametrize("method", ["forward", "optimal"])
def test_and_so_they_do_behind_lenslets(gpu: GpuRenderer, method: str) -> None:
    """-5 D eyes behind lenslets that suit them; with another lens's numbers they would not."""
    eye = {"sphere_d": -5.0, "pupil_mm": 4.0, "pupil_offset_mm": [0.0, 0.0]}
    array = pass_rigs.LENSLETS | {"rotation_deg": 23.0}
    given = sharp_rig(array=array, left=eye, right=eye, prefilter={"method": method})
    target = spot(given)
    panel = gpu.prefilter(target, given)
    seen = gpu.perceive(panel, given, rays=512)
    headset = given.headset.model_copy(update={"glass": None})
    ignored = gpu.prefilter(target, given.model_copy(update={"headset": headset}))
    off = gpu.perceive(ignored, given, rays=512)
    for half in HALVES:
        found, wrong = middles(seen, half), middles(off, half)
        assert np.abs(found - found[1]).max() < 0.15
        assert np.abs(wrong - wrong[1]).max() > 1.0


@pytest.mark.parametrize("name", ["glass-bare", "glass-bare-accommodating"])
def test_registering_matches_its_twin(gpu: GpuRenderer, name: str) -> None:
    given = (pass_rigs.SMALL | pass_rigs.APART)[name]
    target = pass_rigs.picture(given)
    shown = gpu.prefilter(target, given)
    # Places of some hundred pixels times some thousandths: good to 1e-6 of a pixel.
    assert np.abs(shown - ReferenceRenderer().prefilter(target, given)).max() < 1e-5
    assert np.abs(shown - target).max() > 0.1
    middle = given.panel.width_px // 2
    if given.panel.width_px % 2:
        assert not shown[:, middle].any()


def test_the_same_bytes_without_glass(gpu: GpuRenderer) -> None:
    """Neither the glass of a lens without power nor that of an eye at the lens moves a colour."""
    for headset in ({"lens_power_d": 0.0}, {"eye_relief_mm": 0.0}):
        given = sharp_rig(headset=headset)
        assert not forward_changes(given)
        target = pass_rigs.picture(given)
        assert gpu.prefilter(target, given).tobytes() == target.tobytes()


def test_the_map_by_hand() -> None:
    """Scale m_0 / m; of the pupil's offset the difference between the colours' defocus."""
    given = sharp_rig(headset={"lens_power_d": 18.0})
    named = bench_of(given)
    for colour, bench in enumerate(colour_benches(given)):
        scale, right, down = registering_maps(given, "right")[colour]
        m, m_0 = (16.0 + 46.0 - 46.0 * 16.0 * b.lens_power_per_mm for b in (bench, named))
        assert 1.0 + scale == pytest.approx(m_0 / m, rel=1e-12)
        shift = (1 - 46 * named.lens_power_per_mm) - m_0 / m * (1 - 46 * bench.lens_power_per_mm)
        assert [right, down] == pytest.approx([0.6 * shift / 0.078, 0.4 * shift / 0.078])


def test_what_inspect_says() -> None:
    given = sharp_rig()
    red, _, blue = colour_benches(given)
    # Of error at the pupil, 1000 (1 - d F) / m.
    errors = [1000 * (1 - 46 * b.lens_power_per_mm) / b.panel_per_slope_mm for b in (red, blue)]
    assert longitudinal_d(given) == pytest.approx(errors[0] - errors[1])
    # The left viewport runs from 3.51 mm left of the panel's middle, the axis is at -23.5 mm.
    corner_px = np.hypot(23.5, 41 * 0.039 + 6.5) / 0.078
    wanted = (1 / blue.panel_from_retina - 1 / red.panel_from_retina) * corner_px
    assert lateral_px(given, "left") == pytest.approx(wanted)
    found = inspect_rig(given)["headset"]
    assert found["lateral_px"] == pytest.approx(wanted)
    plain = inspect_rig(pass_rigs.rig(44, 31))["headset"]
    assert (plain["longitudinal_d"], plain["lateral_px"]) == (0.0, 0.0)


def test_plain_forward_refuses_what_it_does_not_know(gpu: GpuRenderer) -> None:
    with pytest.raises(ValueError, match="magnified alike"):
        PlainForwardTables(gpu.device, pass_rigs.SMALL["glass-lenslets-full"])
