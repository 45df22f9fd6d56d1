"""The quality bench: what it measures, in which order, and what it refuses."""

from __future__ import annotations

import io
import json
from math import inf
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from vrlf.errors import InputError, RigError
from vrlf.evaluation.measure import Likeness
from vrlf.gpu import Device
from vrlf.model import Rig, load_rig
from vrlf.optics.viewport import SIDES, axis_in_viewport_px, viewport
from vrlf.renderer import GpuRenderer, Image
from vrlf.studies import quality
from vrlf.studies.quality import (
    EyeQuality,
    Quality,
    QualityReport,
    cropped,
    quality_table,
    run_quality,
)

# Room for a border of the blur and a lenslet, and something inside it.
_SMALL = (180, 90)


def picture(rig: Rig) -> Image:
    """A smooth picture that differs between the eyes and the colours."""
    y, x = np.mgrid[: rig.panel.height_px, : rig.panel.width_px]
    waves = [np.sin(x / a + y / b) for a, b in ((5.0, 9.0), (7.0, -4.0), (-6.0, 5.0))]
    return (0.5 + 0.35 * np.stack(waves, axis=-1)).astype(np.float32)


@pytest.fixture(scope="module")
def report() -> QualityReport:
    walled = load_rig("pinhole", overrides=["array.barriers=perpendicular"])
    rigs = {"matched-microlens": load_rig("matched-microlens"), "bare": load_rig("bare")}
    small = {name: cropped(rig, _SMALL) for name, rig in (rigs | {"walled": walled}).items()}
    with GpuRenderer() as renderer:
        return run_quality(renderer, small, {"waves": picture}, iterations=(0, 8), rays=64)


def test_every_method_that_a_rig_allows_is_there_once(report: QualityReport) -> None:
    found = [(q.rig, q.method, q.iterations) for q in report.results]
    array = [
        ("none", None),
        ("forward", None),
        ("forward + wiener", None),
        ("optimal", 0),
        ("optimal", 8),
    ]
    # The image of a bare panel is its target, unless that is sharpened.
    bare = [(method, count) for method, count in array if method != "forward"]
    assert found == [
        (rig, method, count)
        for rig, methods in (("matched-microlens", array), ("bare", bare), ("walled", array))
        for method, count in methods
    ]


def test_steps_pay(report: QualityReport) -> None:
    matched = {
        (q.method, q.iterations): (q.psnr_db or 0.0, q.ssim or 0.0)
        for q in report.results
        if q.rig == "matched-microlens"
    }
    forward, start, eight = (
        matched[key] for key in (("forward", None), ("optimal", 0), ("optimal", 8))
    )
    # A smooth picture, eight steps: several dB over forward, and over no step at all.
    assert eight[0] > forward[0] + 2.0
    assert eight[0] > start[0] + 1.0
    assert eight[1] > forward[1]


def test_json_and_table_hold_the_same(report: QualityReport) -> None:
    numbers = json.loads(json.dumps(report.to_json(), allow_nan=False))
    assert set(numbers) == {"device", "panel", "rays", "results"}
    assert (numbers["panel"], numbers["rays"]) == ("180x90", 64)
    for found, wanted in zip(numbers["results"], report.results, strict=True):
        assert set(found) == {
            "rig",
            "picture",
            "method",
            "iterations",
            "left",
            "right",
            "psnr_db",
            "ssim",
        }
        assert set(found["left"]) == set(found["right"]) == {"psnr_db", "ssim"}
        assert found["psnr_db"] == wanted.psnr_db == min(found[side]["psnr_db"] for side in SIDES)
    table = quality_table(report)
    assert [str(c.header).split("\n")[0] for c in table.columns] == [
        "method",
        "matched-microlens",
        "bare",
        "walled",
    ]
    assert list(table.columns[0].cells) == [
        "none",
        "forward",
        "forward + wiener",
        "optimal, 0 steps",
        "optimal, 8 steps",
    ]
    assert list(table.columns[2].cells)[1] == "-"


def result(method: str, count: int | None, *db: float | None, picture: str = "p") -> Quality:
    left, right = (EyeQuality(each, None if each is None else each / 100.0) for each in db)
    return Quality("r", picture, method, count, left, right)


def test_the_worse_eye_counts() -> None:
    assert result("none", None, 31.0, 22.5).psnr_db == 22.5
    assert result("none", None, 31.0, 22.5).ssim == 0.225
    assert result("none", None, None, 22.5).psnr_db == 22.5
    assert result("none", None, None, None).psnr_db is None


def test_means_over_pictures_leave_equal_ones_out() -> None:
    results = (
        result("optimal", 2, 20.0, 30.0),
        result("optimal", 2, 26.0, 24.0, picture="q"),
        result("optimal", 2, None, None, picture="z"),
        result("none", None, 19.0, 18.0),
    )
    means = QualityReport("d", "1x1", 8, results).mean_psnr_db("r")
    assert means == {("optimal", 2): 22.0, ("none", None): 18.0}


def test_the_table_says_both_numbers_and_what_is_equal() -> None:
    results = (
        result("optimal", 1, 20.04, 30.0),
        result("none", None, None, None),
        Quality("r", "p", "converged", None, EyeQuality(9.0, None), EyeQuality(9.5, None)),
    )
    text = io.StringIO()
    Console(file=text, width=80).print(quality_table(QualityReport("d", "1x1", 8, results)))
    rows = [line.split() for line in text.getvalue().splitlines()]
    # In the order of the methods, not of the results.
    first = rows.index(["none", "equal"])
    assert rows[first + 1 : first + 3] == [
        ["optimal,", "1", "step", "20.0", "/", "0.200"],
        ["converged", "9.0"],
    ]


# The converged optimum.


def test_the_converged_optimum_is_judged_last_and_best(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Few rays for speed, the same for all: the solver's 4 steps stay behind."""
    monkeypatch.setattr(quality, "CONVERGED_RAYS", 192)
    small, told = cropped(load_rig("matched-wide"), (130, 65)), list[str]()
    eye = small.left.model_copy(update={"sphere_d": -2.0, "pupil_mm": 3.0})
    small = small.model_copy(update={"left": eye, "right": eye})
    renderer = GpuRenderer(device)
    try:
        report = run_quality(
            renderer,
            {"wide": small},
            {"waves": picture},
            iterations=(1,),
            rays=192,
            with_converged=True,
            progress=told.append,
        )
    finally:
        renderer.release()
    *_, one_step, best = report.results
    assert (one_step.method, best.method, best.iterations) == ("optimal", "converged", None)
    assert (best.psnr_db or 0.0) > (one_step.psnr_db or 0.0)
    assert told == ["wide: tracing 192 rays a pixel in float64", "wide: waves"]


# The small panel.


def test_a_crop_keeps_the_pixels_and_the_eyes_and_moves_the_axes_to_the_middles() -> None:
    whole = load_rig(
        "two-eyes", overrides=["array.offset_um=[20, -5]", "headset.lens_height_mm=2.5"]
    )
    small = cropped(whole, (222, 97))
    assert (small.panel.width_px, small.panel.height_px) == (222, 97)
    assert small.panel.pixel_pitch_um == whole.panel.pixel_pitch_um
    for side in SIDES:
        view = viewport(small, side)
        middle = (view.width_px / 2.0, view.height_px / 2.0)
        assert axis_in_viewport_px(small, view) == pytest.approx(middle, abs=1e-9)
    moved = {"lens_separation_mm": whole.headset.lens_separation_mm, "lens_height_mm": 2.5}
    restored = {
        "panel": whole.panel,
        "headset": small.headset.model_copy(update=moved),
    }
    assert small.model_copy(update=restored) == whole


def test_a_crop_that_is_no_panel_is_refused() -> None:
    with pytest.raises(RigError, match="panel of 0x97 pixels"):
        cropped(load_rig("bare"), (0, 97))


@pytest.mark.parametrize(
    ("sizes", "said"), [((_SMALL, _SMALL), "180x90"), ((_SMALL, (200, 90)), "each rig's own")]
)
def test_the_report_names_the_panel(
    device: Device,
    monkeypatch: pytest.MonkeyPatch,
    sizes: tuple[tuple[int, int], ...],
    said: str,
) -> None:
    same = Likeness(rmse=0.0, psnr_db=inf, gain=1.0, ssim=1.0)
    monkeypatch.setattr(quality, "_panels", lambda *_: iter([("none", None, _[1], _[2])]))
    monkeypatch.setattr(quality, "likeness", lambda *_: same)
    rigs = {str(n): cropped(load_rig("bare"), size) for n, size in enumerate(sizes)}
    renderer = GpuRenderer(device)
    try:
        report = run_quality(renderer, rigs, {"waves": picture}, rays=1)
    finally:
        renderer.release()
    assert report.panel == said
    assert [each.psnr_db for each in report.results] == [None, None]


# What is refused.


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"iterations": (-1,)}, "iterations: found -1, wanted 0 or more"),
        ({"rays": 0}, "rays: found 0"),
        ({"with_converged": True}, "found 1000x500 pixels, .* at most 100000"),
    ],
)
def test_wrong_numbers_are_refused(device: Device, options: dict[str, Any], said: str) -> None:
    rigs = {"bare": cropped(load_rig("bare"), (1000, 500))}
    renderer = GpuRenderer(device)
    try:
        with pytest.raises(InputError, match=said):
            run_quality(renderer, rigs, {"waves": picture}, **options)
    finally:
        renderer.release()
