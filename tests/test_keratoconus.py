"""What a keratoconus-like eye gains on natural pictures, judged by what it perceives."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import skimage.data

from vrlf.evaluation.measure import likeness
from vrlf.images import resize_area, srgb_decode
from vrlf.model import load_rig
from vrlf.renderer import GpuRenderer
from vrlf.renderer.steps import bare_rig
from vrlf.studies.quality import cropped, with_method

SIDE_PX = 110


@pytest.fixture(scope="module")
def renderer() -> Iterator[GpuRenderer]:
    with GpuRenderer() as made:
        yield made


@pytest.mark.parametrize("name", ["astronaut", "coffee"])
def test_optimal_gains_four_decibels_behind_a_matched_array(
    renderer: GpuRenderer, name: str
) -> None:
    eyes = ["left.extends=keratoconus-like", "right.extends=keratoconus-like"]
    rig = cropped(load_rig("matched-wide", overrides=eyes), (2 * SIDE_PX, SIDE_PX))
    photograph = getattr(skimage.data, name)()[:400, 60:460].astype(np.float32) / 255.0
    half = resize_area(srgb_decode(photograph), SIDE_PX, SIDE_PX)
    target = np.concatenate([half, half], axis=1)
    solved = renderer.prefilter(target, with_method(rig, "optimal", 16))
    corrected = likeness(renderer.perceive(solved, rig, rays=128), target, rig, "left")
    bare = likeness(renderer.perceive(target, bare_rig(rig), rays=128), target, rig, "left")
    assert corrected.psnr_db > bare.psnr_db + 4.0
