"""A lenslet by its surfaces in a rig, and what follows for the colours."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pass_rigs import LENSLETS, SMALL, rig

from vrlf.errors import RigError
from vrlf.model import Rig, focal_mm, load_rig
from vrlf.model.saving import new_rig_file, rig_of_text, rig_tables, rig_text
from vrlf.optics.bench import bench_of, bends_apart, colour_benches, is_lateral, widest_bend
from vrlf.optics.eye import eye_optics
from vrlf.optics.glass import index_at
from vrlf.optics.lattice import lattice_of
from vrlf.optics.lenslet.given import focal_mm_of_colour, lens_of
from vrlf.optics.lenslet.paraxial import power_per_mm
from vrlf.optics.limits import opening_blur_mm
from vrlf.optics.quadrature import colours_of
from vrlf.reference.forward import forward
from vrlf.reference.perceive import perceive as blind
from vrlf.reference.quadrature import perceive_well

PLAIN = {"radius_mm": 2.961, "thickness_mm": 0.5, "glass": "pmma"}
DOUBLET: dict[str, Any] = {
    "radii_mm": [3.662, -2.6408, -8.4685],
    "thicknesses_mm": [0.35, 0.2],
    "glasses": ["pmma", "polycarbonate"],
}


def given(*changes: str, **lenslet: Any) -> Rig:
    """The thesis's rig with a lenslet."""
    keys = [f"array.lenslet.{key}={value}" for key, value in lenslet.items()]
    return load_rig("thesis-minus-5d", overrides=[*keys, *changes])


def microlens(lenslet: dict[str, Any], **array: Any) -> Rig:
    ideal = {key: LENSLETS[key] for key in ("kind", "pitch_um", "gap_mm")}
    return rig(44, 30, array=ideal | {"lenslet": lenslet} | array)


# What a rig may say


def test_the_focal_length_follows() -> None:
    """T 7.2's lens: r / (n - 1); the file's own focal length gives way."""
    found = given(**PLAIN)
    assert found.array.focal_mm == 0.0
    assert focal_mm(found.array) == pytest.approx(2.961 / (index_at("pmma", 587.56) - 1.0))
    assert focal_mm(given("array.focal_mm=6.0", **PLAIN).array) == focal_mm(found.array)
    assert focal_mm(load_rig("thesis-minus-5d").array) == 6.0


@pytest.mark.parametrize("lenslet", [PLAIN, PLAIN | {"facing": "panel"}, DOUBLET])
def test_model_and_optics_agree_on_it(lenslet: dict[str, Any]) -> None:
    """Behind a spacer of 1.3 too; there a curved face toward the panel is weaker."""
    for gap_index in (1.0, 1.3):
        found = microlens(lenslet, gap_index=gap_index)
        lens = lens_of(found)
        assert lens is not None
        wanted = 1.0 / power_per_mm(lens, 587.56)
        assert focal_mm(found.array) == pytest.approx(wanted, rel=1e-12)
        assert bench_of(found).bend == pytest.approx(3.0 / gap_index / wanted, rel=1e-12)
    weaker = focal_mm(microlens(lenslet, gap_index=1.3).array)
    assert (weaker > 1.5 * focal_mm(microlens(lenslet).array)) is ("facing" in lenslet)


@pytest.mark.parametrize(
    ("changes", "lenslet", "wrong"),
    [
        (("array.focal_mm=5.5",), PLAIN, "array.focal_mm: found 5.5, wanted 6.012, what array"),
        ((), PLAIN | {"glass": "pma"}, r'lenslet.glass: found "pma", wanted "pmma", .*"1.52/55"'),
        ((), PLAIN | {"glass": "0.9/55"}, "lenslet.glass: found"),
        ((), PLAIN | {"glass": "1.5/2"}, "lenslet.glass: found"),
        ((), {"radius_mm": 3.0, "glass": "pmma"}, "lenslet.thickness_mm: found nothing, wanted it"),
        ((), PLAIN | {"radius_mm": -3.0}, "lenslet: found surfaces of none, wanted a focal length"),
        ((), PLAIN | {"facing": "left"}, 'lenslet.facing: found "left", wanted one of "eye"'),
        ((), PLAIN | {"radius": 3.0}, 'lenslet.radius: found an unknown key, wanted "radius_mm"'),
        (("panel.wavelengths_nm=[610.0,545.0,400.0]",), PLAIN, "array.lenslet's .pmma. is known"),
    ],
)
def test_what_it_may_not_say(changes: tuple[str, ...], lenslet: dict[str, Any], wrong: str) -> None:
    with pytest.raises(RigError, match=wrong):
        given(*changes, **lenslet)


@pytest.mark.parametrize(
    ("change", "wrong"),
    [
        ({"thicknesses_mm": [0.3]}, "thicknesses_mm: found .*, wanted one less than radii_mm, 2"),
        ({"glasses": ["pmma", "glass"]}, "glasses: found .*, wanted .pmma., "),
        ({"glasses": "pmma"}, "glasses: found .pmma., wanted a list of names"),
        (PLAIN, "radius_mm: found 2.961, wanted no radius_mm beside radii_mm"),
        ({"radii_mm": [1.0]}, "radii_mm: found .1.0., wanted a list of 2 to 9 radii"),
        ({"radii_mm": ["a", 1.0, 2.0]}, "radii_mm: found .*, wanted a list of numbers from -10000"),
    ],
)
def test_what_lists_may_not_say(change: dict[str, Any], wrong: str) -> None:
    with pytest.raises(RigError, match=wrong):
        microlens(DOUBLET | change)


def test_a_mask_has_no_lenslets() -> None:
    """The key means nothing there, as focal_mm does."""
    found = given("array.kind=pinhole", **PLAIN)
    assert lens_of(found) is None
    assert bench_of(found).bend == 0.0
    assert not bends_apart(found)


def test_a_rig_that_extends_another_replaces_its_lenslet(tmp_path: Path) -> None:
    base, own = tmp_path / "base.toml", tmp_path / "own.toml"
    base.write_text(
        'extends = "thesis-minus-5d"\n[array.lenslet]\nradius_mm = 2.961\nthickness_mm = 0.5\n'
        'glass = "pmma"\n'
    )
    own.write_text(
        'extends = "base.toml"\n[array.lenslet]\nradii_mm = [3.662, -2.6408, -8.4685]\n'
        'thicknesses_mm = [0.35, 0.2]\nglasses = ["pmma", "polycarbonate"]\n'
    )
    assert focal_mm(load_rig(own).array) == pytest.approx(6.0, rel=1e-4)
    # One key changes one key.
    own.write_text('extends = "base.toml"\narray.lenslet.glass = "polystyrene"\n')
    lenslet = load_rig(own).array.lenslet
    assert lenslet is not None
    assert (lenslet.radius_mm, lenslet.glass) == (2.961, "polystyrene")


@pytest.mark.parametrize("lenslet", [PLAIN, DOUBLET])
def test_it_is_written_back(tmp_path: Path, lenslet: dict[str, Any]) -> None:
    found = microlens(lenslet)
    path = tmp_path / "own.toml"
    assert rig_of_text(rig_text(found), path, found) == rig_text(found)
    thesis = load_rig("thesis-minus-5d")
    array = rig_tables(thesis)["array"] | {"lenslet": lenslet, "focal_mm": 0.0}
    changed = rig(44, 30, array=array)
    new_rig_file(path, changed, "thesis-minus-5d")
    assert load_rig(path) == changed


# What follows for the colours


def test_each_colour_has_its_own_focus() -> None:
    """f (n - 1) is one for all: red's is longer than blue's by what the index says."""
    found = given(**PLAIN)
    mm = [focal_mm_of_colour(found, colour) for colour in range(3)]
    for each, nm in zip(mm, found.panel.wavelengths_nm, strict=True):
        assert each * (index_at("pmma", nm) - 1.0) == pytest.approx(2.961, rel=1e-12)
    assert mm == pytest.approx([6.0228, 5.9873, 5.9202], abs=1e-4)
    assert [bench.bend for bench in colour_benches(found)] == pytest.approx(
        [6.0 / each for each in mm], rel=1e-12
    )
    assert widest_bend(found) == pytest.approx(6.0 / mm[2], rel=1e-12)
    assert bends_apart(found)
    assert not is_lateral(found)
    assert eye_optics(found, "left").is_chromatic
    assert list(colours_of(found, "right")) == [0, 1, 2]


def test_without_the_table_nothing_is_told_apart() -> None:
    ideal = load_rig("thesis-minus-5d")
    assert colour_benches(ideal) == (bench_of(ideal),) * 3
    assert not bends_apart(ideal)
    assert list(colours_of(ideal, "left")) == [0]
    assert [focal_mm_of_colour(ideal, colour) for colour in range(3)] == [6.0] * 3
    # An index without an Abbe number disperses nothing either.
    assert not bends_apart(microlens(PLAIN | {"glass": "1.49"}))


def test_an_achromat_keeps_the_colours_together() -> None:
    """Its three focal lengths differ by a twentieth of the single lens's."""
    mm = np.array(
        [
            [focal_mm_of_colour(r, c) for c in range(3)]
            for r in (microlens(PLAIN), microlens(DOUBLET))
        ]
    )
    single, doublet = np.ptp(mm, axis=1) / mm[:, 1]
    assert doublet < single / 10.0


def test_red_and_blue_are_not_sharp_at_once() -> None:
    """Lenslets that image the panel onto a -5 D eye's plane of focus for one colour alone.

    f = 1.95 mm does at a gap of 3 mm. Each colour's own lenslet spreads a panel point by (m / g)
    |B - (g / f) Phi| of its width, nothing for the colour in focus; what is perceived of a
    prefiltered target is as near to it there as through ideal lenslets, and farther off in the
    other colour.
    """
    glass = {"thickness_mm": 0.4, "glass": "1.6/8"}
    eyes = {"left": {"pupil_mm": 4.0}, "right": {"sphere_d": -5.0}}
    full = {"panel": {"subpixels": "full"}, **eyes}
    array = {key: LENSLETS[key] for key in ("kind", "pitch_um", "gap_mm")}
    ideal = rig(56, 44, array=LENSLETS, **full)
    plain = misses(ideal)
    for wanted, other in ((0, 2), (2, 0)):
        # The radius that gives this colour the ideal focal length.
        trial = microlens(glass | {"radius_mm": 1.0})
        radius = LENSLETS["focal_mm"] / focal_mm_of_colour(trial, wanted)
        own = rig(56, 44, array=array | {"lenslet": glass | {"radius_mm": radius}}, **full)
        assert focal_mm_of_colour(own, wanted) == pytest.approx(LENSLETS["focal_mm"], rel=1e-12)
        blur_px = [blur_of_colour_px(own, colour) for colour in range(3)]
        missed = misses(own)
        # Blue is twice as far from green as red is.
        assert blur_px[wanted] < 0.05 < 0.5 < blur_px[1] < blur_px[other]
        # Both are traced by the same rays but for rounding, which may choose another direction.
        assert missed[wanted] == pytest.approx(plain[wanted], abs=0.005)
        # Measured 0.346 in focus; 0.406 for blue and 0.356 for red where the other is.
        assert missed[other] > missed[wanted] + 0.005


def blur_of_colour_px(given_rig: Rig, colour: int) -> float:
    """How far one lenslet spreads a panel point, in pixels."""
    lattice, optics = lattice_of(given_rig), eye_optics(given_rig, "left")
    assert lattice is not None
    return opening_blur_mm(optics.benches[colour], lattice, optics) / 0.078


def misses(given_rig: Rig) -> Any:
    """RMS by which each colour that the left eye sees misses bars, inside a border."""
    target = np.zeros((44, 56, 3))
    target[:, np.arange(56) // 3 % 2 == 0] = 1.0
    seen = perceive_well(forward(target, given_rig), given_rig, 100)
    return np.sqrt(np.mean((seen - target)[8:-8, 8:20] ** 2, axis=(0, 1)))


def test_blind_rays_and_lines_have_the_same_truth() -> None:
    dispersing = SMALL["dispersing-lenslets-walls"]
    panel = np.random.default_rng(4).random((31, 44, 3))
    truth = perceive_well(panel, dispersing, 512)
    few, more = (np.sqrt(np.mean((blind(panel, dispersing, n) - truth) ** 2)) for n in (32, 512))
    assert more < 0.4 * few  # by the rays' number, but for what both have left
