"""The search for an array: its patch, its target, its space, and a small search from end to end."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vrlf.errors import InputError, RigError
from vrlf.model import Rig, focal_mm, load_rig
from vrlf.model.catalogue import catalogue
from vrlf.model.reading import load_rig_text
from vrlf.model.searching import SearchLimits, search_limits
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.limits import best_focal_mm, signed_focus_mm
from vrlf.optics.viewport import viewport
from vrlf.reference.converged import operator_matrices
from vrlf.scene import spectrum_slope
from vrlf.studies.design.design import Task, run_design
from vrlf.studies.design.patch import Patch, patch_matrices
from vrlf.studies.design.pictures import draw_map, draw_sensitivity
from vrlf.studies.design.report import DesignReport, best_text, design_table
from vrlf.studies.design.score import judging_of, psnr_db, score_db
from vrlf.studies.design.scorer import Scorer
from vrlf.studies.design.search import Effort, Scored, Search, distinct, grid
from vrlf.studies.design.sensitivity import Curve, brightest_that_serves
from vrlf.studies.design.space import Axis, Space, matched_bend
from vrlf.studies.design.target import dead_leaves
from vrlf.studies.quality import cropped

SIZE = 28
PATCH = Patch(SIZE, 8)
# Of the reference, which takes its time; what they leave to chance is the bound on the patch.
RAYS = 64


def small(name: str, *changes: str) -> Rig:
    """A rig on the panel of a patch."""
    return cropped(load_rig(name, overrides=changes), (2 * SIZE, SIZE))


@pytest.mark.parametrize(
    ("name", "changes", "most"),
    [
        ("matched-microlens", (), 0.25),
        ("matched-wide", ("left.cylinder_d=-1.5", "left.axis_deg=30"), 0.25),
        (
            "matched-microlens",
            ('array.lattice="hexagonal"', 'array.barriers="converging"', 'panel.subpixels="full"'),
            0.25,
        ),
        ("matched-microlens", ('panel.subpixels="pentile-rgbg"', "left.chromatic=true"), 0.3),
        # What comes through a hole is a few pixels, each of them seen by few of the rays.
        ("pinhole", ("array.rotation_deg=20", 'array.aperture_shape="circle"'), 0.7),
        ("bare", ("left.pupil_mm=1",), 0.3),
    ],
)
def test_the_patch_is_the_references_operator(
    name: str, changes: tuple[str, ...], most: float
) -> None:
    """Row by row, to what so few rays of the reference leave to chance."""
    rig = small(name, *changes)
    found = patch_matrices(rig, "left", PATCH, 2048)
    rows = np.arange(SIZE**2).reshape(SIZE, SIZE)[PATCH.seen, PATCH.seen].ravel()
    others = np.setdiff1d(np.arange(SIZE**2), rows)
    wanted = operator_matrices(rig, viewport(rig, "left"), eye_optics(rig, "left"), RAYS)
    for mine, reference in zip(found, wanted, strict=True):
        apart = np.abs((mine - reference)[rows]).sum() / len(rows)
        assert apart < most
        light = reference[rows].sum() / len(rows)
        assert mine[rows].sum() / len(rows) == pytest.approx(
            light, abs=0.1 if name == "pinhole" else 0.05
        )
        assert mine[others].sum() == 0.0


def test_a_shifted_array_is_another_operator() -> None:
    """So that the bound above tells right from wrong."""
    rig = small("matched-microlens")
    off = small("matched-microlens", "array.offset_um=[60.0, 0.0]")
    mine, other = (patch_matrices(each, "left", PATCH, 2048)[1] for each in (rig, off))
    assert np.abs(mine - other).sum() / PATCH.seen_px**2 > 0.5


def test_dead_leaves_are_natural_and_the_same_again() -> None:
    picture = dead_leaves(96, 5)
    assert picture.shape == (96, 96, 3)
    assert picture.min() >= 0.0
    assert picture.max() <= 1.0
    np.testing.assert_array_equal(picture, dead_leaves(96, 5))
    assert np.abs(picture - dead_leaves(96, 6)).mean() > 0.05
    assert not np.array_equal(picture[..., 0], picture[..., 1])
    # Amplitude falls about as 1 / f in photographs (Field 1987).
    assert -2.2 < spectrum_slope(dead_leaves(128, 5)[..., 1]) < -0.8


def test_psnr_is_after_one_gain() -> None:
    wanted = dead_leaves(32, 1)
    assert psnr_db(0.25 * wanted, wanted) == 100.0
    noise = 0.01 * np.resize([1.0, -1.0], wanted.shape)
    assert psnr_db(wanted + noise, wanted) == pytest.approx(40.0, abs=0.1)


def test_scores_know_a_good_turn_from_a_bad_one() -> None:
    """23 degrees against 26, 34.8 to 24.4 dB on a photograph; and bare against any."""
    rig = load_rig("matched-microlens")
    judging = replace(judging_of(rig, 635.0, 40, "optimal"), seeds=(3,))
    turned = [
        rig.model_copy(update={"array": rig.array.model_copy(update={"rotation_deg": turn})})
        for turn in (23.0, 26.0)
    ]
    good, bad = (score_db(each, judging) for each in turned)
    bare = score_db(load_rig("bare"), judging)
    assert good > bad + 5.0
    assert bad > bare
    assert score_db(rig, replace(judging, method="forward")) < good - 5.0


def test_cases_that_are_off_cost() -> None:
    rig = load_rig("matched-microlens", overrides=["tolerance.array_um=40", "tolerance.draws=2"])
    judging = replace(judging_of(rig, 635.0, 32, "optimal"), seeds=(3,), rays=128)
    sharp = score_db(rig.model_copy(update={"tolerance": None}), judging)
    mean = score_db(rig, replace(judging, cases=2))
    worst = score_db(rig, replace(judging, cases=2, over_cases="worst"))
    assert worst <= mean < sharp


def test_the_matched_focus_is_that_of_the_advice() -> None:
    rig = load_rig("matched-wide")
    bench = bench_of(rig)
    focal = best_focal_mm(bench, signed_focus_mm(bench, eye_optics(rig, "left")))
    assert focal is not None
    assert matched_bend(rig, 4.0, 1.0) == pytest.approx(4.0 / focal, rel=1e-12)


def test_a_point_is_an_array_and_back() -> None:
    rig = load_rig("matched-microlens")
    space = Space(rig, "microlens", SearchLimits())
    point = space.place_of(rig.array)
    assert point is not None
    array = space.array(point)
    assert array is not None
    assert array.pitch_um == pytest.approx(635.0, abs=0.1)
    assert array.gap_mm == pytest.approx(3.6, abs=0.001)
    assert focal_mm(array) == pytest.approx(2.3, abs=1e-3)
    assert array.rotation_deg == pytest.approx(23.0, abs=0.01)
    assert Axis("spacer", 0.0, 1.0, 3).value(Axis("spacer", 0.0, 1.0, 3).place(2)) == 2.0


def test_an_eye_that_is_not_mirrored_needs_all_turns() -> None:
    limits = SearchLimits()
    for both, most in (("-5", 45.0), ("-2.00/-1.50x30", 90.0), ("-2.00/-1.50x90", 45.0)):
        space = Space(load_rig("matched-microlens", both=both), "microlens", limits)
        assert {axis.name: axis.high for axis in space.axes}["rotation_deg"] == most


def test_what_is_on_sale_is_taken_as_it_is() -> None:
    limits = SearchLimits(arrays=("fresnel-630", "mla150-5c"), spacers=("acrylic-4", "3.5"))
    space = Space(load_rig("matched-microlens"), "microlens", limits)
    points = grid(space, 5)
    assert len(points) == 2 * 2 * 2  # parts, spacers, turns
    arrays = [space.array(point) for point in points]
    assert {(a.pitch_um, a.focal_mm) for a in arrays if a} == {(1000.0, 3.3), (150.0, 5.6)}
    assert {(a.gap_mm, a.gap_index) for a in arrays if a} == {(4.0, 1.49), (3.5, 1.0)}
    assert "Fresnel" in space.part_at(points[0])
    assert all(each.source for each in catalogue().arrays.values())
    assert all(each.source for each in catalogue().spacers.values())


def test_focal_lengths_out_of_bounds_are_no_candidates() -> None:
    space = Space(load_rig("matched-wide"), "microlens", SearchLimits(focal_mm=(50.0, 60.0)))
    assert {space.array(point) for point in grid(space, 2)} == {None}


def test_the_best_differ() -> None:
    points = [(0.5, 0.5), (0.5, 0.505), (0.5, 0.6)]
    scored = [Scored(point, db, "grid") for point, db in zip(points, (3.0, 2.0, 1.0), strict=True)]
    assert [each.db for each in distinct(scored, 3, 0.02)] == [3.0, 1.0]
    assert [each.db for each in distinct(scored, 1, 0.02)] == [3.0]


def test_a_curve_says_what_serves() -> None:
    curve = Curve("array.gap_mm", 2.0, (1.0, 1.5, 2.0, 2.5, 3.0), (30.0, 32.0, 32.4, 32.2, 31.2))
    low, high = curve.serves
    # 31.9 dB: between 30 and 32 at 1.475, between 32.2 and 31.2 at 2.65.
    assert low == pytest.approx(1.475)
    assert high == pytest.approx(2.65)
    assert curve.slope_db == pytest.approx(0.2)
    dim = Curve("prefilter.brightness", 1.0, (0.8, 0.9, 1.0), (32.0, 31.9, 31.0))
    assert brightest_that_serves(dim, 0.2) == 0.9


TINY = Effort(grid=2, trials=8, turned=1, polished=1, steps=4)


@pytest.fixture(scope="module")
def tiny_task() -> Task:
    limits = SearchLimits(
        pitch_um=(500.0, 700.0), gap_mm=(3.0, 4.0), rotation_deg=(20.0, 26.0), brightness=(0.9, 1.0)
    )
    return Task(limits=limits, effort=TINY, best=3, judged_px=24, fine_px=24)


@pytest.fixture(scope="module")
def tiny_report(tiny_task: Task) -> DesignReport:
    """From a turn that moire spoils."""
    rig = load_rig("matched-microlens", overrides=["array.rotation_deg=26"])
    return run_design(rig, tiny_task, workers=1)


def test_a_small_search_beats_what_was_given(tiny_report: DesignReport) -> None:
    report = tiny_report
    assert [each.name for each in report.stages] == ["grid", "optuna", "turns", "polish"]
    assert report.candidates == sum(each.candidates for each in report.stages) > 20
    assert report.best[0].fine_db > report.before["given"].fine_db + 2.0
    assert report.before["given"].fine_db > report.before["bare"].fine_db
    assert report.cpu_s > 0.0
    assert len({each.rig.array for each in report.best}) == 3
    told = report.to_json()
    assert told["best"][0]["array"]["focal_mm"] > 0.0
    assert len(told["map"]["best_db"]) == len(told["map"]["gaps_mm"]) == 2
    assert design_table(report).row_count == 5


def test_the_same_seed_finds_the_same(tiny_task: Task) -> None:
    """On any number of workers: what is proposed goes out in batches of one size."""
    rig = load_rig("matched-microlens", overrides=["array.rotation_deg=26"])
    judging = judging_of(rig, 700.0, 16, "optimal")
    space = Space(rig, "microlens", tiny_task.limits)
    found = []
    for workers in (1, 2):
        with Scorer(workers) as scorer:
            search = Search(space, scorer, replace(judging, rays=32), lambda _: None)
            search.run(replace(TINY, trials=16, turned=0, polished=0), seed=7)
            found.append(search.scored)
    assert found[0] == found[1]


def test_the_best_is_a_rig_file(tiny_report: DesignReport, tmp_path: Path) -> None:
    text = best_text(tiny_report, "matched-microlens")
    assert load_rig_text(text, tmp_path / "best.toml") == tiny_report.best[0].rig
    assert text.startswith("# Found by vrlf ")
    assert "# array.pitch_um" in text


def test_pictures_are_drawn(tiny_report: DesignReport, tmp_path: Path) -> None:
    for name, draw in (("map.png", draw_map), ("curves.png", draw_sensitivity)):
        draw(tiny_report, tmp_path / name)
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")


def test_holes_are_searched_too() -> None:
    limits = SearchLimits(pitch_um=(390.0, 390.0), gap_mm=(6.0, 6.0), aperture_um=(60.0, 300.0))
    space = Space(load_rig("pinhole"), "pinhole", limits)
    assert {axis.name for axis in space.axes if not axis.is_fixed} == {
        "aperture_um",
        "rotation_deg",
    }
    judging = replace(judging_of(space.rig, 390.0, 20, "optimal"), rays=64)
    rigs = [space.rig_at((0.5, 0.5, place, 0.1)) for place in (0.0, 0.5, 1.0)]
    assert [each.array.aperture_um for each in rigs if each is not None] == [60.0, 180.0, 300.0]
    scores = [score_db(each, judging) for each in rigs if each is not None]
    assert all(10.0 < each < 30.0 for each in scores)
    assert len(set(scores)) == 3


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"pitch_um": [800.0, 300.0]}, ("pitch_um", "[800.0, 300.0]", "the smaller one first")),
        ({"pitch": [1.0, 2.0]}, ("pitch", "unknown key", "pitch_um")),
        ({"gap_mm": [0.0, 3.0]}, ("gap_mm", "from 0.05 to 100")),
        ({"gap_mm": 3.0}, ("gap_mm", "3.0", "two numbers")),
        ({"barriers": []}, ("barriers", "converging")),
        ({"focal_mm": "long"}, ("focal_mm", '"long"')),
    ],
)
def test_wrong_limits_are_named(given: dict[str, object], named: tuple[str, ...]) -> None:
    with pytest.raises(RigError) as caught:
        search_limits(None, given)
    for word in named:
        assert word in str(caught.value)


def test_limits_that_allow_nothing_are_refused(tiny_task: Task) -> None:
    task = replace(
        tiny_task, limits=SearchLimits(focal_mm=(90.0, 100.0)), effort=replace(TINY, trials=0)
    )
    with pytest.raises(InputError, match="allow no array"):
        run_design(load_rig("matched-microlens"), task, workers=1)
    with pytest.raises(InputError, match=r"less than headset\.lens_to_panel_mm"):
        Space(load_rig("bare"), "microlens", SearchLimits(gap_mm=(1.0, 60.0)))
    with pytest.raises(InputError, match="wanted some of mla150-7ar"):
        Space(load_rig("bare"), "microlens", SearchLimits(arrays=("nothing",)))
    with pytest.raises(InputError, match="millimetres of air or some of"):
        Space(load_rig("bare"), "microlens", SearchLimits(spacers=("-3",)))
