"""``vrlf.studies.speed``: what is timed at which size, against which limit, and what is refused.

Limits are made up where numbers count; no test depends on how long anything takes.
"""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

import pytest
from rich.console import Console

from vrlf.errors import DeviceError, InputError, RigError
from vrlf.gpu import Device
from vrlf.model import Rig, load_rig
from vrlf.solve import OptimalTables
from vrlf.studies import speed, workloads
from vrlf.studies.bench import Timing
from vrlf.studies.limits import Limits
from vrlf.studies.speed import (
    SIZES_PX,
    SOFTWARE_MEGAPIXELS,
    Speed,
    SpeedReport,
    default_megapixels,
    run_speed,
    speed_table,
)
from vrlf.studies.steps import Step, kept
from vrlf.studies.workloads import Stage, stage_of, tools_of

LIMITS = Limits(copy_gb_per_s=2.0, fetch_g_per_s=0.5)
STEPS_TIMED = [
    "prepare",
    "encode",
    "forward",
    "forward plain",
    "frame forward",
    "frame forward, seen",
    "tables forward",
    "sharpen",
    "tables sharpen",
    "perceive",
    "tables perceive",
    "optimal start",
    "optimal step",
    "optimal, 3 steps",
    "frame optimal",
    "frame optimal, seen",
    "tables optimal",
]


@pytest.fixture
def known_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(speed, "measured_limits", lambda _: LIMITS)
    # A solve of a tiny panel is no sooner done than that of a large one: the fewest runs do.
    monkeypatch.setattr(speed, "_STEP_S", 0.0)


def small_rig(*changes: str) -> Rig:
    return load_rig("two-eyes", overrides=["prefilter.iterations=3", *changes])


@pytest.mark.usefixtures("known_limits")
def test_every_pass_and_frame_is_timed_and_all_is_given_back(device: Device) -> None:
    before, told = device.live_objects, list[str]()
    report = run_speed(
        device, rig=small_rig(), sizes=[(61, 32)], rays=4, runs=1, progress=told.append
    )
    assert device.live_objects == before
    assert (report.device, report.limits, report.left_out) == (device.info.renderer, LIMITS, ())
    assert [each.timing.name for each in report.results] == STEPS_TIMED
    assert len(told) == len(STEPS_TIMED)
    for each in report.results:
        assert each.timing.panel == "61x32"
        assert each.megapixels == pytest.approx(61 * 32 / 1e6)
        assert (each.least_ms is None) == each.timing.name.startswith("tables")
        assert (each.timing.rays == 4) == ("perceive" in each.timing.name or "seen" in str(each))


def one_step(stage: Stage, _: ExitStack) -> Iterator[Step]:
    yield stage.timed("step", lambda: None, 2)


def no_room(_: Stage, __: ExitStack) -> Iterator[Step]:
    raise DeviceError("optimal: found GL_OUT_OF_MEMORY, wanted no error")
    yield


@pytest.mark.usefixtures("known_limits")
def test_sizes_come_in_order_each_once(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(speed, "GROUPS", (one_step,))
    sizes = [(120, 40), (40, 24), (120, 40), (400, 300)]
    report = run_speed(device, rig=small_rig(), sizes=sizes, max_megapixels=0.0048, runs=1)
    assert [each.timing.panel for each in report.results] == ["40x24", "120x40"]


@pytest.mark.usefixtures("known_limits")
def test_what_does_not_fit_is_told_and_the_rest_goes_on(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(speed, "GROUPS", (no_room, one_step))
    before, told = device.live_objects, list[str]()
    # A rig may have as wide a panel as the widest GPUs hold.
    monkeypatch.setattr(device, "info", replace(device.info, max_texture_px=2048))
    too_wide = 2056
    sizes = [(40, 24), (too_wide, 24)]
    report = run_speed(device, rig=small_rig(), sizes=sizes, runs=1, progress=told.append)
    assert [each.timing.panel for each in report.results] == ["40x24"]
    first, second = report.left_out
    assert first == "40x24 no room: optimal: found GL_OUT_OF_MEMORY, wanted no error"
    assert second.startswith(f"{too_wide}x24: panel: found {too_wide}x24 pixels")
    assert [line for line in told if line.startswith("left out: ")] == [
        f"left out: {reason}" for reason in report.left_out
    ]
    assert report.to_json()["left_out"] == [first, second]
    assert device.live_objects == before


@pytest.mark.usefixtures("known_limits")
def test_a_texture_that_the_gpu_refuses_leaves_its_size_out(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(speed, "GROUPS", (one_step,))
    whole = speed.stage_of

    def refuse_large(tools: Any, rig: Rig, rays: int, by: ExitStack) -> Stage:
        stage = whole(tools, rig, rays, by)
        if rig.panel.width_px > 100:
            raise DeviceError("codes: found GL_OUT_OF_MEMORY, wanted no error")
        return stage

    monkeypatch.setattr(speed, "stage_of", refuse_large)
    before = device.live_objects
    report = run_speed(device, rig=small_rig(), sizes=[(40, 24), (120, 40)], runs=1)
    assert [each.timing.panel for each in report.results] == ["40x24"]
    assert report.left_out == ("120x40: codes: found GL_OUT_OF_MEMORY, wanted no error",)
    assert device.live_objects == before


def test_the_least_that_each_step_moves(device: Device) -> None:
    """By hand: pictures of 16 bytes a pixel; a ray is a fetch."""
    pixels, least = 61 * 32, dict[str, Step]()
    given = speed.resized(small_rig(), (61, 32))
    with ExitStack() as by:
        stage = stage_of(tools_of(device, by), given, 4, by)
        operator = kept(by, OptimalTables(device, given, stage.tools.optimal.builder)).operator
        table_bytes = [
            sum(buffer.nbytes for buffer in buffers)
            for buffers in (operator.forward, operator.adjoint)
        ]
        for group in (
            workloads.picture_passes,
            workloads.forward_passes,
            workloads.perception,
            workloads.optimal_passes,
        ):
            least |= {step.name: step for step in group(stage, by)}
    copies = {"prepare": 32, "encode": 20, "forward": 32, "forward plain": 32, "perceive": 32}
    for name, a_pixel in copies.items():
        assert least[name].least_bytes == a_pixel * pixels, name
    assert least["frame forward"].least_bytes == 52 * pixels
    assert least["frame forward, seen"].least_bytes == 84 * pixels
    rays = least["perceive"].work.args[0]  # type: ignore[attr-defined]
    assert least["perceive"].least_fetches == pytest.approx(rays.points * rays.cost * pixels)
    start, step, whole = (
        least[name] for name in ("optimal start", "optimal step", "optimal, 3 steps")
    )
    # P x - t: x and t are read, the residual is written. Down and ahead: that, P'1, P'P1, w and z
    # are read; x, w and z are written.
    assert step.least_bytes == pytest.approx((3 + 5 + 3) * 16 * pixels + sum(table_bytes))
    # P't: t is read, the product written. That and P'1 are read; x, w, z, the start are written.
    assert start.least_bytes == pytest.approx((2 + 2 + 4) * 16 * pixels + table_bytes[1])
    assert whole.least_bytes == pytest.approx(start.least_bytes + 3 * step.least_bytes)
    assert whole.least_fetches == pytest.approx(start.least_fetches + 3 * step.least_fetches)
    # A row of P and one of P': each looks at one pixel at least, where the pupil is 6 mm.
    assert step.least_fetches > 2 * pixels
    assert least["frame optimal"].least_bytes == pytest.approx(whole.least_bytes + 20 * pixels)


@pytest.mark.parametrize(
    ("nbytes", "fetches", "least_ms", "bound_by"),
    [(6e6, 1e6, 3.0, "copy"), (6e6, 4e6, 8.0, "fetch"), (0.0, 0.0, None, None)],
)
def test_the_limit_of_a_step(
    device: Device,
    monkeypatch: pytest.MonkeyPatch,
    nbytes: float,
    fetches: float,
    least_ms: float | None,
    bound_by: str | None,
) -> None:
    """At 2 GB/s and 0.5 G texels/s, by hand; the step takes 16 ms by a made-up clock."""

    def one(_: Stage, __: ExitStack) -> Iterator[Step]:
        yield Step("step", lambda _: 16.0, lambda: None, None, nbytes, fetches)

    monkeypatch.setattr(speed, "measured_limits", lambda _: LIMITS)
    monkeypatch.setattr(speed, "GROUPS", (one,))
    (found,) = run_speed(device, rig=small_rig(), sizes=[(40, 25)], runs=2).results
    assert (found.timing.ms, found.least_ms, found.bound_by) == (16.0, least_ms, bound_by)
    assert found.share_of_limit == (None if least_ms is None else least_ms / 16.0)
    assert found.ns_per_px == pytest.approx(16000.0)  # 16 ms over 1000 pixels


def test_a_step_is_what_more_steps_take_longer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workloads, "_STEPS_TIMED", 4)
    durations = {"start": 3.0, "work": 11.0}
    clock = lambda work: durations[work()]  # noqa: E731
    assert workloads._a_step_ms(clock, lambda: "start", lambda: "work") == 2.0
    durations["work"] = 2.9  # noise on a tiny panel
    assert workloads._a_step_ms(clock, lambda: "start", lambda: "work") == 0.0


@pytest.mark.usefixtures("known_limits")
def test_a_bare_panel_has_no_forward(device: Device) -> None:
    bare = load_rig("bare", overrides=["prefilter.iterations=1"])
    report = run_speed(device, rig=bare, sizes=[(40, 24)], rays=2, runs=1)
    names = {each.timing.name for each in report.results}
    assert not {name for name in names if name.split(",")[0].endswith("forward")}
    assert {"perceive", "optimal step", "frame optimal", "tables optimal"} <= names


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"sizes": []}, InputError, "sizes: found none"),
        ({"max_megapixels": 0.0001}, InputError, r"within 0.0001 mega.* smallest has 0.00096"),
        ({"runs": 0}, InputError, "runs: found 0, wanted .* at least 1"),
        ({"rays": 0}, InputError, "rays: found 0"),
        ({"sizes": [(40, 24), (0, 64)]}, RigError, "panel of 0x64 pixels"),
        ({"rig": "no-such-rig"}, InputError, "no-such-rig"),
    ],
)
def test_bad_input_is_one_clear_line(
    device: Device, options: dict[str, Any], error: type[InputError], message: str
) -> None:
    told: list[str] = []
    with pytest.raises(error, match=message):
        run_speed(device, **{"sizes": [(40, 24)], "progress": told.append, **options})
    assert told == []


def test_the_default_sizes_span_what_was_promised(device: Device) -> None:
    megapixels = [width * height / 1e6 for width, height in SIZES_PX]
    assert megapixels[0] == pytest.approx(0.25, abs=0.001)
    assert megapixels[-1] == pytest.approx(33.2, abs=0.1)
    assert device.info.is_software == (default_megapixels(device) == SOFTWARE_MEGAPIXELS)


# The report.

REPORT = SpeedReport(
    "A Graphics Card With a Long Name/PCIe/SSE2",
    LIMITS,
    (
        Speed(Timing("forward", "1334x750", 4.0, 5.0, 9), 1.0005, 2.0, "copy"),
        Speed(Timing("frame optimal, seen", "1334x750", 40.0, 41.0, 3, 64), 1.0005, 10.0, "fetch"),
        Speed(Timing("tables optimal", "1334x750", 900.0, 900.0, 1), 1.0005, None, None),
        Speed(Timing("forward", "7680x4320", 0.0, 0.0, 9), 33.1776, 2.0, "copy"),
    ),
    ("7680x4320 optimal passes: no room",),
)


def test_the_json_has_the_names_of_bench_and_more() -> None:
    report = json.loads(json.dumps(REPORT.to_json(), allow_nan=False))
    assert report.keys() == {"device", "limits", "results", "left_out"}
    assert report["limits"] == {"copy_gb_per_s": 2.0, "fetch_g_per_s": 0.5}
    assert report["results"][0] == {
        "name": "forward",
        "panel": "1334x750",
        "ms": 4.0,
        "p95_ms": 5.0,
        "runs": 9,
        "rays": None,
        "megapixels": 1.0005,
        "ns_per_px": pytest.approx(3.998, abs=1e-3),
        "least_ms": 2.0,
        "bound_by": "copy",
        "share_of_limit": 0.5,
    }
    assert [row["share_of_limit"] for row in report["results"]] == [0.5, 0.25, None, None]


def test_the_table_fits_eighty_columns_uncut() -> None:
    text = io.StringIO()
    Console(file=text, width=80).print(speed_table(REPORT))
    assert max(map(len, text.getvalue().splitlines())) <= 80
    assert "…" not in text.getvalue()
    rows = [line.split() for line in text.getvalue().splitlines()]
    assert ["1334x750", "forward", "4.00", "5.00", "9", "4.00", "50.0", "%"] in rows
    seen = ["frame", "optimal,", "seen", "40.0", "41.0", "3", "40.0", "25.0", "%", "f"]
    assert seen in rows
    assert ["tables", "optimal", "900", "900", "1", "900"] in rows
