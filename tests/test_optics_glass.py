"""Lens materials against published indices, and what their dispersion does to the bench."""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np
import pytest
from pass_rigs import LENSLETS, rig

from vrlf.errors import InputError, RigError
from vrlf.model import load_rig
from vrlf.model.glasses import glasses
from vrlf.optics.bench import bench_of, colour_benches, is_lateral
from vrlf.optics.eye import eye_optics
from vrlf.optics.glass import abbe_number, index_at, relative_power

# Sultanova, Kasarova & Nikolov 2009, table: indices at these nm, measured to 0.001.
NM = (436.8, 486.1, 587.6, 632.8, 703.0, 833.0, 879.0, 1052.0)
MEASURED = {
    "pmma": (1.502, 1.497, 1.491, 1.489, 1.486, 1.484, 1.483, 1.481),
    "polycarbonate": (1.612, 1.599, 1.585, 1.580, 1.575, 1.569, 1.568, 1.565),
    "polystyrene": (1.617, 1.606, 1.592, 1.587, 1.582, 1.577, 1.576, 1.572),
}


@pytest.mark.parametrize("name", MEASURED)
def test_plastics_against_measured_indices(name: str) -> None:
    """Samples of a plastic differ by 0.003, here PMMA's; from one colour to another much less."""
    found = np.array([index_at(name, nm) for nm in NM])
    measured = np.array(MEASURED[name])
    assert found == pytest.approx(measured, abs=3e-3)
    # Of two indices rounded to 0.001, and as good as that.
    assert found - found[2] == pytest.approx(measured - measured[2], abs=1.5e-3)


@pytest.mark.parametrize("name", ["n-bk7", "polycarbonate", "polystyrene"])
def test_indices_and_abbe_numbers_as_published(name: str) -> None:
    """SCHOTT states 1.5168 and 64.17; the plastics' are of indices rounded to 0.001."""
    glass = glasses()[name]
    exact = name == "n-bk7"
    assert index_at(name, 587.56) == pytest.approx(glass.nd, abs=5e-6 if exact else 1e-3)
    # An Abbe number of 30 is (nd - 1) / 0.02: 0.001 either way is 5 % of it.
    assert abbe_number(name) == pytest.approx(glass.vd, abs=0.01 if exact else 1.5)


def test_pmma_and_fused_silica() -> None:
    """Abbe numbers 59.2 (Sultanova 2009) and 67.82 (Malitson 1965: 1.45846 at d)."""
    assert abbe_number("pmma") == pytest.approx(59.2, abs=0.5)
    assert index_at("fused-silica", 587.56) == pytest.approx(1.45846, abs=5e-6)
    assert abbe_number("fused-silica") == pytest.approx(67.82, abs=0.01)


def test_a_formula_by_hand() -> None:
    """Polycarbonate at 500 nm: 1 + 1.4182 0.25 / (0.25 - 0.021304)."""
    assert index_at("polycarbonate", 500.0) == sqrt(1.0 + 1.4182 * 0.25 / (0.25 - 0.021304))


@pytest.mark.parametrize("name", list(glasses()))
def test_every_material_is_whole_and_disperses_as_matter_does(name: str) -> None:
    glass = glasses()[name]
    assert glass.source
    assert bool(glass.sellmeier) != bool(glass.powers)
    low, high = (1000.0 * end for end in glass.range_um)
    visible = np.linspace(max(low, 380.0), min(high, 780.0), 100)
    indices = [index_at(name, nm) for nm in visible]
    assert np.all(np.diff(indices) < 0.0)
    assert relative_power(name, 589.0) == 1.0
    for wrong in (0.99 * low, 1.01 * high):
        with pytest.raises(InputError, match="nm, where its index is known"):
            index_at(name, wrong)


def test_no_such_material() -> None:
    with pytest.raises(InputError, match="found 'unobtainium', wanted one of pmma, "):
        index_at("unobtainium", 589.0)


# In rigs

RELIEF = {"glass": "polycarbonate", "eye_relief_mm": 12.0, "lens_power_d": 20.0}


def test_a_rig_names_its_glass() -> None:
    assert load_rig("bare", overrides=["headset.glass=pmma"]).headset.glass == "pmma"
    with pytest.raises(RigError, match=r'headset\.glass: found "glas", wanted one of "pmma", '):
        load_rig("bare", overrides=["headset.glass=glas"])
    with pytest.raises(RigError, match=r"panel\.wavelengths_nm: .*from 420 to 1620 nm.*pmma"):
        load_rig(
            "bare", overrides=["headset.glass=pmma", "panel.wavelengths_nm=[610.0,545.0,410.0]"]
        )


def test_power_of_each_colour() -> None:
    """F (n - 1) / (n_589 - 1): stronger for blue."""
    given_rig = rig(44, 31, headset=RELIEF)
    n = {nm: sqrt(1 + 1.4182 * nm**2 / (nm**2 - 21304.0)) for nm in (610.0, 545.0, 465.0, 589.0)}
    for bench, nm in zip(colour_benches(given_rig), (610.0, 545.0, 465.0), strict=True):
        power = 0.020 * (n[nm] - 1.0) / (n[589.0] - 1.0)
        assert bench.lens_power_per_mm == pytest.approx(power, rel=1e-12)
        # m = e + d - d e F of the colour, over that of 589 nm.
        m, m_0 = (12.0 + 46.0 - 46.0 * 12.0 * f for f in (power, 0.020))
        assert bench.panel_from_retina == pytest.approx(m / m_0, rel=1e-12)
    red, _, blue = colour_benches(given_rig)
    assert blue.lens_power_per_mm > 1.02 * red.lens_power_per_mm
    assert is_lateral(given_rig)


@pytest.mark.parametrize(
    ("headset", "chromatic", "lateral"),
    [
        ({}, False, False),
        ({"glass": "pmma"}, True, False),
        ({"glass": "pmma", "eye_relief_mm": 10.0}, True, True),
        ({"glass": "pmma", "eye_relief_mm": 10.0, "lens_power_d": 0.0}, False, False),
        ({"eye_relief_mm": 10.0}, False, False),
    ],
)
def test_when_the_colours_go_apart(headset: dict[str, Any], chromatic: bool, lateral: bool) -> None:
    """Without relief they focus differently, but are magnified alike."""
    for array in ({"kind": "none"}, LENSLETS):
        given_rig = rig(44, 31, headset=headset, array=array)
        assert eye_optics(given_rig, "left").is_chromatic is chromatic
        assert is_lateral(given_rig) is lateral
        if not chromatic:
            assert colour_benches(given_rig) == (bench_of(given_rig),) * 3


def test_where_a_colour_has_no_upright_image() -> None:
    """At 589 nm m = 10 + 46 - 460 F is just above 0, for green and blue it is below."""
    strong = {"lens_power_d": 121.5, "eye_relief_mm": 10.0, "glass": "polycarbonate"}
    given_rig = rig(44, 31, headset=strong)
    assert bench_of(given_rig).panel_per_slope_mm > 0.0
    with pytest.raises(InputError, match=r"headset\.eye_relief_mm: found 10, .*545 nm"):
        colour_benches(given_rig)
