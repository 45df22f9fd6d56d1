"""The study of moving pictures: what it shows, what it holds, what it refuses."""

from __future__ import annotations

import json
from math import inf

import numpy as np
import pass_rigs
import pytest

from vrlf.errors import InputError
from vrlf.gpu import Device
from vrlf.passes import phases
from vrlf.renderer import Image
from vrlf.studies.frames import Frames, FramesReport, Motion, frames_table, part_of, run_frames

MATCHED = pass_rigs.rig(
    90,
    41,
    array=pass_rigs.LENSLETS | {"rotation_deg": 13.0, "offset_um": [70.0, -40.0]},
    left={"cylinder_d": -0.75, "axis_deg": 35.0},
    right={"pupil_offset_mm": [0.3, -0.2]},
)
MOTIONS = (
    Motion("still"),
    Motion("drift", (0.25, 0.1)),
    Motion("pan", (6.3, -3.2)),
    Motion("cut", is_cut=True),
)
FRAMES = 6


def waves(seed: int) -> Image:
    """Waves of many lengths and directions, other for each colour, and edges."""
    y, x = np.mgrid[:130, :150] / 3.0
    random = np.random.default_rng(seed)
    picture = np.zeros((130, 150, 3))
    for channel in range(3):
        for _ in range(12):
            a, b, start = random.normal(size=3) * (0.7, 0.7, 3.0)
            picture[..., channel] += np.sin(a * x + b * y + start) / (1.0 + 3.0 * np.hypot(a, b))
    picture = np.where(np.sin(x / 3.0 + seed)[..., None] > 0.4, 1.0 - picture, picture)
    return np.clip(0.5 + 0.3 * picture, 0.0, 1.0).astype(np.float32)


@pytest.fixture(scope="module")
def report() -> FramesReport:
    with pytest.MonkeyPatch.context() as patch, Device.headless() as device:
        patch.setattr(phases, "_RAYS_AN_EYE", 1 << 21)
        pictures = waves(1), waves(2)
        return run_frames(
            device, {"m": MATCHED}, pictures, motions=MOTIONS, steps=(2,), frames=FRAMES, rays=512
        )


def found(report: FramesReport, motion: str, start: str) -> Frames:
    return next(f for f in report.results if (f.motion, f.start) == (motion, start))


def test_a_still_converges_while_it_is_watched(report: FramesReport) -> None:
    cold, warm = (found(report, "still", start) for start in ("cold", "warm"))
    print(cold, warm)
    assert cold.flicker_db == inf
    assert len(set(cold.psnr_db)) == 1
    assert warm.psnr_db[0] == cold.psnr_db[0]
    # Never worse than the frame before, but for what 512 rays are wrong by.
    assert np.all(np.diff(warm.psnr_db) > -0.05)
    assert warm.psnr_db[-1] > cold.psnr_db[-1] + 1.0


@pytest.mark.parametrize("motion", ["drift", "pan", "cut"])
def test_what_moves_is_never_worse_than_cold(report: FramesReport, motion: str) -> None:
    cold, warm = (found(report, motion, start) for start in ("cold", "warm"))
    print(cold, warm)
    # What little is kept where everything changed costs at most this, and in the mean nothing.
    assert np.all(np.array(warm.psnr_db) > np.array(cold.psnr_db) - 0.1)
    assert np.mean(warm.psnr_db) > np.mean(cold.psnr_db) - 0.001


def test_a_drift_is_better_than_cold(report: FramesReport) -> None:
    cold, warm = (found(report, "drift", start) for start in ("cold", "warm"))
    assert warm.psnr_db[-1] > cold.psnr_db[-1] + 0.5


def test_json_and_table_hold_the_same(report: FramesReport) -> None:
    numbers = json.loads(json.dumps(report.to_json(), allow_nan=False))
    assert [each["motion"] for each in numbers["results"][::2]] == [m.name for m in MOTIONS]
    assert numbers["results"][0]["flicker_db"] is None
    assert len(numbers["results"][0]["psnr_db"]) == FRAMES
    assert frames_table(report).row_count == len(report.results) == 8


def test_wrong_numbers_are_refused(device: Device) -> None:
    pictures = waves(1), waves(2)
    for given, said in (
        ({"frames": 1}, "frames: found 1, wanted 2 or more"),
        ({"steps": (-1,)}, "steps: found -1, wanted 0 or more"),
        ({"rays": 0}, "rays: found 0"),
    ):
        with pytest.raises(InputError, match=said):
            run_frames(device, {"m": MATCHED}, pictures, **given)


def test_parts_are_exact_means_and_move_by_fractions() -> None:
    picture = waves(3)
    here = part_of(picture, (20, 12), (0.0, 0.0))
    assert here.shape == (12, 20, 3)
    # A pixel of the part is 75 / 14 samples; each sample cut into 14 makes 75 of them a pixel.
    fine = np.repeat(np.repeat(picture.astype(float), 14, axis=0), 14, axis=1)[: 12 * 75, : 20 * 75]
    np.testing.assert_allclose(here, fine.reshape(12, 75, 20, 75, 3).mean(axis=(1, 3)), atol=1e-6)
    moved = part_of(picture, (20, 12), (3.0, -2.0))
    np.testing.assert_allclose(moved[2:, :17], here[:10, 3:], atol=1e-6)
    # A third of a pixel on is 25 of the 75.
    third = part_of(picture, (20, 12), (1.0 / 3.0, 0.0))
    fine = np.repeat(np.repeat(picture.astype(float), 14, axis=0), 14, axis=1)[
        : 12 * 75, 25 : 25 + 20 * 75
    ]
    np.testing.assert_allclose(third, fine.reshape(12, 75, 20, 75, 3).mean(axis=(1, 3)), atol=1e-6)


def test_beyond_its_edges_a_picture_is_mirrored() -> None:
    picture = waves(3)[:, :140]
    width_px = 140 / (140 / 20 / 1.4)
    there = part_of(picture, (20, 12), (width_px, 0.0))
    back = part_of(picture, (20, 12), (width_px - 20.0, 0.0))
    np.testing.assert_allclose(there, back[:, ::-1], atol=1e-6)
