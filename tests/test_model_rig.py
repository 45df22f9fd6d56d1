"""The models: what they accept, refuse and derive."""

from __future__ import annotations

import copy
import json
import pickle
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from vrlf.errors import RigError
from vrlf.model import (
    Array,
    Eye,
    Headset,
    Rig,
    Zernike,
    layout_names,
    lens_power_d,
    rig_from_tables,
    rig_json_schema,
)
from vrlf.model.layouts import names_wanted


def tables(**changes: dict[str, Any] | None) -> dict[str, Any]:
    """A small rig; a table given as None is left out, others are laid over it."""
    rig: dict[str, Any] = {
        "panel": {"width_px": 96, "height_px": 64, "pixel_pitch_um": 78.0},
        "headset": {"lens_to_panel_mm": 46.0},
        "array": {"kind": "microlens", "pitch_um": 390, "gap_mm": 3.0, "focal_mm": 1.95},
        "left": {"sphere_d": -5.0, "cylinder_d": 1.25, "axis_deg": 30},
        "right": {"sphere_d": 2.5, "pupil_mm": 4},
    }
    for name, change in changes.items():
        if change is None:
            del rig[name]
        else:
            rig[name] = rig.get(name, {}) | change
    return rig


def problems(**changes: dict[str, Any] | None) -> tuple[str, ...]:
    with pytest.raises(RigError) as caught:
        rig_from_tables(tables(**changes), source="my.toml")
    assert caught.value.exit_code == 2
    assert str(caught.value).startswith("my.toml: ")
    return caught.value.problems


def test_defaults_are_those_of_the_documented_file() -> None:
    rig = rig_from_tables(tables(array=None))
    assert rig.schema_version == 1
    assert rig.panel.subpixels == "rgb-stripe"
    assert rig.panel.wavelengths_nm == (610.0, 545.0, 465.0)
    assert rig.headset.lens_separation_mm == 62.0
    assert rig.headset.eye_relief_mm == 0.0
    assert rig.array.kind == "none"
    assert rig.left.vertex_mm == 12.0
    assert rig.left.pupil_mm == 6.0
    assert rig.right.pupil_mm == 4.0
    assert rig.prefilter.method == "forward"
    assert rig.prefilter.subpixel_grid == 3
    assert rig.prefilter.wiener is False
    assert rig.prefilter.wiener_noise == 0.03


def test_whole_numbers_become_floats_and_lists_tuples() -> None:
    rig = rig_from_tables(tables(left={"prism_pd": [1, -2.5]}))
    assert rig.left.prism_pd == (1.0, -2.5)
    assert isinstance(rig.left.prism_pd[0], float)
    assert isinstance(rig.array.pitch_um, float)


def test_rigs_are_frozen_hashable_and_travel() -> None:
    left = {
        "pupil_mm": 5.0,
        "zernike": {"diameter_mm": 5.5, "coefficients_um": {"4,0": 0.2, "3,-1": 0.14}},
    }
    rig = rig_from_tables(tables(left=left))
    assert hash(rig) == hash(copy.deepcopy(rig))
    assert pickle.loads(pickle.dumps(rig)) == rig
    assert rig_from_tables(rig.model_dump()) == rig
    assert Rig.model_validate_json(rig.model_dump_json()) == rig
    with pytest.raises(ValidationError, match="frozen"):
        rig.left.sphere_d = 1.0  # type: ignore[misc]


def test_a_rig_without_array_survives_its_own_dump() -> None:
    rig = rig_from_tables(tables(array=None))
    assert rig_from_tables(rig.model_dump()) == rig


def test_lens_power_defaults_to_the_panel_at_the_focus() -> None:
    assert lens_power_d(Headset(lens_to_panel_mm=40.0)) == 25.0
    assert lens_power_d(Headset(lens_to_panel_mm=40.0, lens_power_d=0.0)) == 0.0


def test_zernike_terms_are_sorted_by_order_then_frequency() -> None:
    wavefront = Zernike(
        diameter_mm=6.0, coefficients_um={"3,1": -0.25, "2,-2": 0.5, "3,-3": 1, "0,0": 0.1}
    )
    assert wavefront.terms == (((0, 0), 0.1), ((2, -2), 0.5), ((3, -3), 1.0), ((3, 1), -0.25))


@given(n=st.integers(-2, 11), m=st.integers(-11, 11))
def test_zernike_names_are_those_of_real_polynomials(n: int, m: int) -> None:
    real = 0 <= n <= 8 and m in range(-n, n + 1, 2)
    coefficients = {f"{n},{m}": 0.1}
    if real:
        assert Zernike(diameter_mm=6.0, coefficients_um=coefficients).terms == (((n, m), 0.1),)
    else:
        with pytest.raises(ValidationError):
            Zernike(diameter_mm=6.0, coefficients_um=coefficients)


@pytest.mark.parametrize("name", ["3", "3,-1,0", "c3", "3, -1", "03,-1", "3,+1", "2,-0", "٣,1", ""])
def test_zernike_names_have_one_spelling(name: str) -> None:
    with pytest.raises(ValidationError):
        Zernike(diameter_mm=6.0, coefficients_um={name: 0.1})


@pytest.mark.parametrize("layout", layout_names())
def test_layouts_are_accepted(layout: str) -> None:
    assert rig_from_tables(tables(panel={"subpixels": layout})).panel.subpixels == layout


NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    ("table", "key", "value", "wanted"),
    [
        ("panel", "width_px", 1, "a whole number from 2 to 32768"),
        ("panel", "width_px", 96.0, "a whole number from 2 to 32768"),
        ("panel", "height_px", 40_000, "a whole number from 2 to 32768"),
        ("panel", "pixel_pitch_um", -78.0, "a number from 0.5 to 10000"),
        ("panel", "subpixels", "rgb", names_wanted()),
        ("panel", "wavelengths_nm", [610.0, 545.0], "a list of 3 numbers from 380 to 780"),
        ("panel", "wavelengths_nm", [610.0, 545.0, 300.0], "a list of 3 numbers from 380 to 780"),
        ("headset", "lens_to_panel_mm", "46", "a number from 1 to 10000"),
        ("headset", "eye_relief_mm", -1, "a number from 0 to 1000"),
        ("headset", "distortion", 0.3, "a list of 2 numbers from -100 to 100"),
        ("array", "kind", "lenticular", 'one of "microlens", "pinhole", "none"'),
        ("array", "pitch_um", -390.0, 'a number from 1 to 100000 for kind "microlens"'),
        ("array", "focal_mm", 0, 'a number from 0.001 to 1e+06 for kind "microlens"'),
        ("array", "focal_mm", -2, 'a number from 0.001 to 1e+06 for kind "microlens"'),
        ("array", "gap_index", 0.9, 'a number from 1 to 3 for kind "microlens"'),
        ("array", "gap_mm", 46.0, "less than headset.lens_to_panel_mm, 46"),
        ("array", "offset_um", [1, True], "a list of 2 numbers from -1e+06 to 1e+06"),
        ("array", "barriers", True, 'one of "none", "perpendicular", "converging"'),
        ("left", "sphere_d", True, "a number from -40 to 40"),
        ("left", "sphere_d", -40.5, "a number from -40 to 40"),
        ("left", "sphere_d", NAN, "a number from -40 to 40"),
        ("left", "sphere_d", 10**400, "a number from -40 to 40"),
        ("left", "cylinder_d", 20.25, "a number from -20 to 20"),
        ("left", "axis_deg", 180.5, "a number from 0 to 180"),
        ("right", "pupil_mm", 0, "a number above 0 and up to 12"),
        ("right", "pupil_mm", INF, "a number above 0 and up to 12"),
        ("right", "age_years", 121, "a number from 0 to 120"),
        ("right", "chromatic", 1, "true or false"),
        ("right", "accommodation", "Best", 'one of "relaxed", "best"'),
        ("right", "zernike", 0.1, "a table [right.zernike]"),
        ("prefilter", "subpixel_grid", 17, "a whole number from 1 to 16"),
        ("prefilter", "black_level", 1.0, "less than the brightness of 1"),
        ("prefilter", "brightness", 0.0, "a number above 0 and up to 1"),
        ("prefilter", "wiener_noise", 0.0, "a number from 1e-06 to 100"),
        ("prefilter", "wiener", 1, "true or false"),
    ],
)
def test_an_impossible_value_is_named(table: str, key: str, value: Any, wanted: str) -> None:
    (problem,) = problems(**{table: {key: value}})
    assert problem.startswith(f"{table}.{key}: found ")
    assert problem.endswith(f", wanted {wanted}")


@pytest.mark.parametrize("value", [2, 1.0, True, "1"])
def test_only_schema_1_is_known(value: Any) -> None:
    with pytest.raises(RigError, match=r"schema: found .*, wanted a whole number equal to 1"):
        rig_from_tables({"schema": value} | tables())


def test_spectacles_with_their_focus_before_the_eye_are_refused() -> None:
    # 22 + 3 D focus 40 mm behind the lens; 22 D alone would reach 45.5 mm.
    strong = {"sphere_d": 22.0, "cylinder_d": 3.0, "vertex_mm": 40.0}
    (problem,) = problems(left=strong)
    assert problem == "left.vertex_mm: found 40.0, wanted less than 40 mm, the focal length of 25 D"
    assert Eye(sphere_d=25.0, cylinder_d=-3.0, vertex_mm=39.9).vertex_mm == 39.9
    assert Eye(sphere_d=-40.0, vertex_mm=100.0).vertex_mm == 100.0


def test_an_eye_behind_the_panels_image_is_refused() -> None:
    # 1 / (80 D - 1 / 46 mm) = 17.2 mm behind the lens the panel's image stands.
    (problem,) = problems(headset={"lens_power_d": 80.0, "eye_relief_mm": 18.0}, array=None)
    assert problem.startswith("headset.eye_relief_mm: found 18.0, wanted less than 17.16 mm")
    assert rig_from_tables(tables(headset={"lens_power_d": 80.0, "eye_relief_mm": 17.1}))
    # A solid spacer moves the panel nearer: 39.4 mm, image at 18.3 mm.
    solid = {"gap_mm": 20.0, "gap_index": 1.49}
    assert rig_from_tables(
        tables(headset={"lens_power_d": 80.0, "eye_relief_mm": 18.0}, array=solid)
    )


@pytest.mark.parametrize(
    ("kind", "needed"),
    [
        ("microlens", {"array.pitch_um", "array.gap_mm", "array.focal_mm"}),
        ("pinhole", {"array.pitch_um", "array.gap_mm"}),
    ],
)
def test_an_array_needs_its_lengths(kind: str, needed: set[str]) -> None:
    rig = tables() | {"array": {"kind": kind}}
    with pytest.raises(RigError) as caught:
        rig_from_tables(rig)
    assert {
        line.partition(": found nothing, wanted")[0] for line in caught.value.problems
    } == needed


def test_holes_fit_their_cells_but_lenslets_have_none() -> None:
    holes = {"kind": "pinhole", "aperture_um": 391.0}
    assert problems(array=holes) == (
        "array.aperture_um: found 391.0, wanted at most the pitch of 390 um",
    )
    assert rig_from_tables(tables(array={"aperture_um": 391.0})).array.aperture_um == 391.0


def test_square_holes_fit_hexagons() -> None:
    """Side of the largest upright square: 390 (root 3 - 1) = 285.5 um. A circle may touch."""
    holes = {"kind": "pinhole", "lattice": "hexagonal", "aperture_um": 285.6}
    assert problems(array=holes) == (
        "array.aperture_um: found 285.6, wanted at most 285.5 um: larger squares pass a "
        "hexagonal cell",
    )
    for fits in ({"aperture_um": 285.4}, {"aperture_um": 390.0, "aperture_shape": "circle"}):
        assert rig_from_tables(tables(array=holes | fits)).array.lattice == "hexagonal"


def test_a_lattice_has_a_name() -> None:
    assert problems(array={"lattice": "triangular"}) == (
        'array.lattice: found "triangular", wanted one of "square", "hexagonal"',
    )


def test_without_an_array_its_lengths_mean_nothing_but_keep_their_types() -> None:
    ignored = {"kind": "none", "gap_mm": 99.0, "focal_mm": -1.0, "aperture_um": 500.0}
    assert rig_from_tables(tables(array=ignored)).array.kind == "none"
    (problem,) = problems(array=ignored | {"focal_mm": "2"})
    assert problem == 'array.focal_mm: found "2", wanted a number'


def test_an_array_table_says_its_kind() -> None:
    with pytest.raises(ValidationError, match="kind"):
        Array(pitch_um=390.0)  # type: ignore[call-arg]


def test_all_wrong_keys_are_named_at_once() -> None:
    found = problems(
        panel={"width_px": -1, "hieght_px": 3},
        headset={"foo": 1},
        array={"gap_mm": 50.0, "bar": 2},
        left={"sphere": -3.0, "prism_pd": [True, "x"], "vertex_mm": 200.0},
        right=None,
        prefliter={"method": "forward"},
    )
    assert {line.partition(":")[0] for line in found} == {
        "panel.width_px",
        "panel.hieght_px",
        "headset.foo",
        "array.gap_mm",
        "array.bar",
        "left.sphere",
        "left.prism_pd",
        "left.vertex_mm",
        "right",
        "prefliter",
    }
    assert 'panel.hieght_px: found an unknown key, wanted "height_px"' in found
    assert 'left.sphere: found an unknown key, wanted "sphere_d"' in found
    assert 'prefliter: found an unknown key, wanted "prefilter"' in found
    assert "right: found nothing, wanted a table [right]" in found


def test_wrong_coefficients_are_named_with_their_quotes() -> None:
    coefficients = {"9,1": 0.1, "3,-1": "a", "2,0": 0.1}
    found = problems(left={"zernike": {"coefficients_um": coefficients}})
    assert [line.partition(": found ")[0] for line in found] == [
        "left.zernike.diameter_mm",
        'left.zernike.coefficients_um."9,1"',
        'left.zernike.coefficients_um."3,-1"',
    ]


def test_a_file_of_something_else_is_cut_short() -> None:
    found = problems(left={f"key{i}": i for i in range(5000)})
    assert len(found) == 101
    assert found[-1] == "and 4900 more"


def test_the_json_schema_holds_the_files_keys() -> None:
    schema = rig_json_schema()
    assert json.loads(json.dumps(schema)) == schema
    assert set(schema["required"]) == {"panel", "headset", "left", "right"}
    assert "schema" in schema["properties"]


_SCALARS = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=5), st.dates()
)
_JUNK = st.recursive(
    _SCALARS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner),
    max_leaves=6,
)


def _rig_or_refusal(rig: dict[str, Any]) -> Rig | RigError:
    try:
        return rig_from_tables(rig)
    except RigError as error:
        return error


@given(
    table=st.sampled_from(["panel", "headset", "array", "left", "right", "prefilter", "schema"]),
    key=st.sampled_from(["width_px", "gap_mm", "kind", "sphere_d", "zernike", "distortion", ""]),
    junk=_JUNK,
)
def test_junk_is_accepted_or_refused_in_one_line(table: str, key: str, junk: Any) -> None:
    rig = tables()
    rig[table] = rig.get(table, {}) | {key: junk} if key else junk
    outcome = _rig_or_refusal(rig)
    if isinstance(outcome, RigError):
        assert outcome.problems
        assert str(outcome).isprintable()
        assert all(": found " in line and ", wanted " in line for line in outcome.problems)
