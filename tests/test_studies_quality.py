"""The quality bench: what it measures, in which order, and what it refuses."""

from __future__ import annotations

import json

import numpy as np
import pytest

from vrlf.app.main import run
from vrlf.errors import InputError
from vrlf.gpu import Device
from vrlf.model import Rig, load_rig
from vrlf.renderer import GpuRenderer, Image
from vrlf.studies.quality import QualityReport, quality_table, run_quality

# Room for a border of the blur and a lenslet, and something inside it.
_SMALL = ("panel.width_px=180", "panel.height_px=90", "headset.lens_separation_mm=7.02")


def picture(rig: Rig) -> Image:
    """A smooth picture that differs between the eyes and the colours."""
    y, x = np.mgrid[: rig.panel.height_px, : rig.panel.width_px]
    waves = [np.sin(x / a + y / b) for a, b in ((5.0, 9.0), (7.0, -4.0), (-6.0, 5.0))]
    return (0.5 + 0.35 * np.stack(waves, axis=-1)).astype(np.float32)


@pytest.fixture(scope="module")
def report() -> QualityReport:
    rigs = {name: load_rig(name, overrides=_SMALL) for name in ("matched-microlens", "bare")}
    walled = load_rig("pinhole", overrides=[*_SMALL, "array.barriers=perpendicular"])
    with GpuRenderer() as renderer:
        return run_quality(
            renderer, {**rigs, "walled": walled}, {"waves": picture}, iterations=(0, 8), rays=64
        )


def test_every_method_that_a_rig_allows_is_there_once(report: QualityReport) -> None:
    found = [(q.rig, q.method, q.iterations) for q in report.results]
    assert found == [
        ("matched-microlens", "none", None),
        ("matched-microlens", "forward", None),
        ("matched-microlens", "optimal", 0),
        ("matched-microlens", "optimal", 8),
        ("bare", "none", None),
        ("bare", "optimal", 0),
        ("bare", "optimal", 8),
        ("walled", "none", None),
        ("walled", "forward", None),
    ]


def test_steps_pay(report: QualityReport) -> None:
    psnr_db = {(q.rig, q.method, q.iterations): q.psnr_db for q in report.results}
    matched = [
        psnr_db["matched-microlens", method, steps] or 0.0
        for method, steps in (("forward", None), ("optimal", 0), ("optimal", 8))
    ]
    # A smooth picture, eight steps: several dB over forward, and over no step at all.
    assert matched[2] > matched[0] + 2.0
    assert matched[2] > matched[1] + 1.0


def test_json_and_table_hold_the_same(report: QualityReport) -> None:
    numbers = json.loads(json.dumps(report.to_json(), allow_nan=False))
    assert set(numbers) == {"device", "rays", "results"}
    assert len(numbers["results"]) == len(report.results)
    table = quality_table(report)
    assert table.row_count == 3
    assert [str(c.header) for c in table.columns] == [
        "rig",
        "picture",
        "none",
        "forward",
        "optimal 0",
        "optimal 8",
    ]


def test_wrong_numbers_are_refused(device: Device) -> None:
    rigs = {"bare": load_rig("bare", overrides=_SMALL)}
    renderer = GpuRenderer(device)
    try:
        with pytest.raises(InputError, match="iterations: found -1, wanted 0 or more"):
            run_quality(renderer, rigs, {"waves": picture}, iterations=(-1,))
        with pytest.raises(InputError, match="rays: found 0"):
            run_quality(renderer, rigs, {"waves": picture}, rays=0)
    finally:
        renderer.release()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["-r", "no-such-rig"], "no-such-rig"),
        (["--iterations", "-3"], "--iterations"),
        (["--source", "nowhere.png"], "nowhere.png"),
    ],
)
def test_the_command_refuses_in_one_line(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["bench", "quality", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err.splitlines()[-1]
    assert err.splitlines()[-1].startswith("vrlf: ")
