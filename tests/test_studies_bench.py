"""``vrlf.studies.bench``: what is timed, how often, and what the report says of it.

Nothing here depends on how long anything takes: where durations matter, the clock is made up.
"""

from __future__ import annotations

import io
import json
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from vrlf.errors import DeviceError, InputError, RigError
from vrlf.gpu import Device
from vrlf.model import load_rig
from vrlf.passes import Encode, Perceive, Prepare
from vrlf.studies import steps
from vrlf.studies.bench import (
    FEWEST_RUNS,
    PANEL_SIZES_PX,
    BenchReport,
    Schedule,
    Timing,
    bench_table,
    resized,
    run_bench,
)
from vrlf.studies.steps import Step, noise_picture

# The smaller one second, so that "the smallest" is not just "the first".
SIZES = ((96, 64), (48, 33))
PASSES = ["prepare", "forward", "perceive", "encode"]
TABLES = ["tables forward", "tables perceive"]
BESIDE_TWIN = ["prepare", "forward", "perceive", "perceive (2 rays)", "encode"]
TWINS = ["prepare", "forward", "perceive (2 rays)", "encode"]


def of(report: BenchReport, panel: str) -> list[str]:
    return [timing.name for timing in report.results if timing.panel == panel]


def test_every_pass_is_timed_at_every_size_and_the_twins_at_the_smallest(device: Device) -> None:
    before, told = device.live_objects, list[str]()
    report = run_bench(device, sizes=SIZES, rays=5, runs=3, progress=told.append)
    assert report.device == device.info.renderer
    assert of(report, "96x64") == PASSES + TABLES
    assert of(report, "48x33") == BESIDE_TWIN + TABLES + [f"float64 {name}" for name in TWINS]
    for timing in report.results:
        assert 0.0 < timing.ms <= timing.p95_ms, timing
        few = "2 rays" in timing.name
        traces = "perceive" in timing.name
        assert timing.rays == ((2 if few else 5) if traces else None), timing
    assert len(told) == len(report.results)
    assert told[0].startswith("96x64 prepare: ")
    assert device.live_objects == before


def test_the_default_sizes_are_those_promised() -> None:
    assert PANEL_SIZES_PX == ((1334, 750), (2560, 1440), (3840, 2160))


def test_a_bare_panel_has_no_forward_pass(device: Device) -> None:
    report = run_bench(device, sizes=[(48, 33)], rays=3, runs=3, rig="bare")
    names = of(report, "48x33")
    assert not [name for name in names if "forward" in name]
    assert {"prepare", "perceive", "encode", "tables perceive", "float64 prepare"} <= set(names)


@pytest.mark.parametrize(("budget_s", "runs"), [(0.0, FEWEST_RUNS), (1e6, 5)])
def test_a_spent_budget_leaves_the_fewest_runs(device: Device, budget_s: float, runs: int) -> None:
    report = run_bench(device, sizes=[(48, 33)], rays=3, runs=5, budget_s=budget_s)
    assert {timing.runs for timing in report.results} == {runs}


def test_what_is_timed_is_what_the_report_says(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The rays of a row were traced, and each eye has its own picture."""
    gpu_rays, twin_rays, pictures = list[int](), list[int](), list[Any]()
    asked_for, tables_of = dict[int, int](), steps.PerceiveTables

    def spy_tables(device: Device, rig: Any, rays: int) -> Any:
        made = tables_of(device, rig, rays)
        asked_for[id(made)] = rays
        return made

    perceive, prepare, twin = Perceive.run, Prepare.run, steps.perceive

    def spy_perceive(self: Perceive, tables: Any, *rest: Any, **options: Any) -> None:
        gpu_rays.append(asked_for[id(tables)])
        perceive(self, tables, *rest, **options)

    def spy_prepare(self: Prepare, rig: Any, eyes: Any, target: Any) -> None:
        pictures[:] = [eye.texture.read()[..., :3] for eye in eyes]
        prepare(self, rig, eyes, target)
        assert np.ptp(target.read()[..., :3]) > 0.5  # the noise is there, not a flat field

    def spy_twin(panel: Any, rig: Any, rays: int) -> Any:
        twin_rays.append(rays)
        return twin(panel, rig, rays)

    monkeypatch.setattr(steps, "PerceiveTables", spy_tables)
    monkeypatch.setattr(Perceive, "run", spy_perceive)
    monkeypatch.setattr(Prepare, "run", spy_prepare)
    monkeypatch.setattr(steps, "perceive", spy_twin)
    run_bench(device, sizes=[(96, 64)], rays=7, runs=4, budget_s=1e6)
    # How many runs warm up depends on how long they take, so only the least is known: one that
    # compiles and four that count; the twin compiles nothing.
    assert set(gpu_rays) == {2, 7}
    assert min(gpu_rays.count(2), gpu_rays.count(7)) >= 1 + 4
    assert set(twin_rays) == {2}
    assert len(twin_rays) >= 4
    assert pictures[0].shape == (64, 48, 3)
    assert np.abs(pictures[0] - pictures[1]).mean() > 0.1


def test_all_is_given_back_when_a_pass_fails(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: Any, **__: Any) -> None:
        raise DeviceError("encode: found a fault, wanted none")

    monkeypatch.setattr(Encode, "run", fail)
    before = device.live_objects
    with pytest.raises(DeviceError, match="found a fault"):
        run_bench(device, sizes=SIZES, rays=3, runs=3)
    assert device.live_objects == before


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"sizes": []}, InputError, "sizes: found none"),
        ({"runs": 2}, InputError, "runs: found 2, wanted .* at least 3"),
        ({"rays": 0}, InputError, "rays: found 0"),
        ({"sizes": [(96, 64), (0, 64)]}, RigError, "panel of 0x64 pixels: .*width_px: found 0"),
        ({"rig": "no-such-rig"}, InputError, "no-such-rig"),
    ],
)
def test_bad_input_is_one_clear_line(
    device: Device, options: dict[str, Any], error: type[InputError], message: str
) -> None:
    told: list[str] = []
    with pytest.raises(error, match=message):
        run_bench(device, **{"sizes": SIZES, "progress": told.append, **options})
    assert told == []


def test_a_panel_larger_than_the_gpu_holds_is_refused_before_anything_is_timed(
    device: Device,
) -> None:
    told, width_px = list[str](), device.info.max_texture_px + 1
    with pytest.raises(InputError, match=f"found {width_px}"):
        run_bench(device, sizes=[(96, 64), (width_px, 64)], progress=told.append)
    assert told == []


# Runs and percentiles, by a clock that is made up.


def timed(times_ms: list[float], runs: int) -> Timing:
    left = iter(times_ms)
    step = Step("step", lambda _: next(left), lambda: None)
    schedule = Schedule(runs, panel_share_s=1e6, progress=lambda _: None)
    (timing,) = schedule.timings(load_rig("bare"), [step])
    assert next(left, None) is None, "not all runs were asked for"
    return timing


def test_two_runs_warm_up_and_are_not_counted() -> None:
    timing = timed([900.0, 700.0, 4.0, 1.0, 2.0], runs=3)
    # Percentiles by hand: of 1, 2, 4 the 95th lies nine tenths of the way from 2 to 4.
    assert (timing.panel, timing.runs, timing.ms) == ("1334x750", 3, 2.0)
    assert timing.p95_ms == pytest.approx(3.8, rel=1e-12)  # rounding only


def test_a_long_run_is_counted_from_the_first() -> None:
    timing = timed([1500.0, 1100.0, 1200.0, 1300.0], runs=4)
    assert (timing.runs, timing.ms) == (4, 1250.0)


# The panels and the pictures.


def test_a_resized_panel_keeps_its_width_and_the_rest_of_the_rig() -> None:
    rig = load_rig("two-eyes", overrides=["array.offset_um=[20, -5]", "left.prism_pd=[1, 0.5]"])
    finer = resized(rig, (3840, 2160))
    assert (finer.panel.width_px, finer.panel.height_px) == (3840, 2160)
    width_um = finer.panel.width_px * finer.panel.pixel_pitch_um
    assert width_um == pytest.approx(1334 * 78.0, rel=4e-15)  # two roundings
    kept = {"panel": rig.panel}
    assert finer.model_copy(update=kept) == rig
    assert resized(rig, (1334, 750)) == rig


def test_the_noise_is_the_same_for_a_seed_and_another_for_another() -> None:
    first = noise_picture(50, 31, 4)
    assert first.shape == (31, 50, 3)
    assert first.dtype == np.float32
    assert np.array_equal(first, noise_picture(50, 31, 4))
    assert not np.array_equal(first, noise_picture(50, 31, 5))
    assert 0.0 <= first.min() < 0.1
    assert 0.9 < first.max() <= 1.0


def test_the_noise_falls_as_one_over_f() -> None:
    height, width = 192, 256
    amplitude = np.abs(np.fft.fft2(noise_picture(width, height, 3)[..., 1]))
    f = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.fftfreq(width))
    band = (f > 0.02) & (f < 0.4)
    slope = np.polyfit(np.log(f[band]), np.log(amplitude[band]), 1)[0]
    # Clipping and some 10^4 random amplitudes move it by a few hundredths; white noise has 0,
    # 1/f^2 noise -2.
    assert slope == pytest.approx(-1.0, abs=0.1)


# The report.

REPORT = BenchReport(
    "A Graphics Card With a Long Name/PCIe/SSE2",
    (
        Timing("perceive", "3840x2160", 28249.4, 33072.0, 3, 65536),
        Timing("perceive (2 rays)", "1334x750", 0.25, 0.5, 1000, 2),
        Timing("encode", "1334x750", 40.0, 41.0, 9),
        Timing("float64 perceive (2 rays)", "1334x750", 3000.0, 3100.0, 3, 2),
        Timing("float64 encode", "1334x750", 60.0, 61.0, 3),
        Timing("float64 encode", "3840x2160", 500.0, 500.0, 3),
    ),
)


def test_only_equal_work_is_compared() -> None:
    ratios = [REPORT.speed_up(timing) for timing in REPORT.results]
    assert ratios == [None, 12000.0, 1.5, None, None, None]
    other_rays = BenchReport(
        "", (Timing("a", "1x1", 1, 1, 3, 8), Timing("float64 a", "1x1", 2, 2, 3, 2))
    )
    assert other_rays.speed_up(other_rays.results[0]) is None
    no_time = BenchReport("", (Timing("a", "1x1", 0, 0, 3), Timing("float64 a", "1x1", 2, 2, 3)))
    assert no_time.speed_up(no_time.results[0]) is None


def test_the_json_has_the_promised_keys() -> None:
    report = json.loads(json.dumps(REPORT.to_json(), allow_nan=False))
    assert report.keys() == {"device", "results"}
    assert report["device"] == REPORT.device
    assert report["results"][1] == {
        "name": "perceive (2 rays)",
        "panel": "1334x750",
        "ms": 0.25,
        "p95_ms": 0.5,
        "runs": 1000,
        "rays": 2,
        "speed_up": 12000.0,
    }


def test_the_table_fits_eighty_columns_uncut() -> None:
    text = io.StringIO()
    Console(file=text, width=80).print(bench_table(REPORT))
    lines = text.getvalue().splitlines()
    assert max(map(len, lines)) <= 80
    assert "…" not in text.getvalue()
    assert REPORT.device in text.getvalue()
    rows = [line.split() for line in lines]
    assert ["3840x2160", "perceive", "65536", "28249", "33072", "3"] in rows
    assert ["1334x750", "perceive", "(2", "rays)", "2", "0.250", "0.500", "1000", "12000x"] in rows
    assert ["encode", "40.0", "41.0", "9", "1.50x"] in rows
