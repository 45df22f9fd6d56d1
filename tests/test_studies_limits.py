"""The probes do what their names say: every pixel copied, every texel fetched."""

from __future__ import annotations

import numpy as np
import pytest

from vrlf.gpu import ComputePass, Device, Texture
from vrlf.studies import limits
from vrlf.studies.limits import PROBE, SOURCE_PX, Limits, measured_limits, run_probe

# No multiple of a group's eight, and not square.
SIZE_PX = (43, 21)


def probed(device: Device, shader: str, source: np.ndarray, fetches: int) -> np.ndarray:
    probe = ComputePass(device, shader, PROBE, defines={"SOURCE_PX": SOURCE_PX})
    given = Texture.from_array(device, source, label="source")
    result = Texture(device, SIZE_PX, label="result")
    try:
        run_probe(probe, given, result, fetches)
        return result.read()
    finally:
        for item in (probe, given, result):
            item.release()


def noise(width: int, height: int) -> np.ndarray:
    return np.random.default_rng(7).random((height, width, 4), dtype=np.float32)


def test_the_copy_moves_every_pixel(device: Device) -> None:
    source = noise(*SIZE_PX)
    assert np.array_equal(probed(device, "bench_copy.comp", source, 1), source)


def test_the_fetches_are_all_done(device: Device) -> None:
    """Summed up again by numpy: a driver that leaves one out, or fetches one twice, is seen."""
    source, fetches = noise(SOURCE_PX, SOURCE_PX), 77
    rows, columns = np.mgrid[: SIZE_PX[1], : SIZE_PX[0]]
    wanted = sum(
        source[(rows + n // SOURCE_PX) % SOURCE_PX, (columns + n) % SOURCE_PX].astype(np.float64)
        for n in range(fetches)
    )
    found = probed(device, "bench_fetch.comp", source, fetches)
    # 77 float32 sums of up to 50 in another order of rounding: 77 times 2e-6.
    assert found == pytest.approx(wanted, abs=2e-4)


def test_the_limits_are_what_the_best_run_did(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    """4 ms for a copy and 2 ms for fetches of known sizes, by a made-up clock."""
    asked = []

    def made_up(_: Device, shader: str, source: int, result: int, fetches: int, runs: int) -> float:
        asked.append((shader, source, result, fetches, runs))
        return 4.0 if "copy" in shader else 2.0

    monkeypatch.setattr(limits, "best_ms", made_up)
    found = measured_limits(device, runs=3)
    (copy, side, same, once, _), (fetch, source, pixels, many, _) = asked
    assert (copy, fetch, side, once, source) == (
        "bench_copy.comp",
        "bench_fetch.comp",
        same,
        1,
        SOURCE_PX,
    )
    # 16 bytes read and 16 written for each pixel.
    assert found.copy_gb_per_s == pytest.approx(32 * side * side / 4e-3 / 1e9, rel=1e-12)
    assert found.fetch_g_per_s == pytest.approx(many * pixels * pixels / 2e-3 / 1e9, rel=1e-12)


def test_probes_give_back_what_they_took(device: Device) -> None:
    before = device.live_objects
    assert limits.best_ms(device, "bench_copy.comp", 64, 64, 1, 2) > 0.0
    assert limits.best_ms(device, "bench_fetch.comp", SOURCE_PX, 64, 8, 2) > 0.0
    assert device.live_objects == before


def test_the_longer_of_copy_and_fetches_is_the_limit() -> None:
    given = Limits(copy_gb_per_s=2.0, fetch_g_per_s=0.5)
    assert given.least_ms(6e6) == pytest.approx(3.0)
    assert given.least_ms(6e6, 1e6) == pytest.approx(3.0)
    assert given.least_ms(6e6, 4e6) == pytest.approx(8.0)
