"""Coarse first, then finer: every pixel once, and in the end the bytes of the whole."""

from __future__ import annotations

import numpy as np
import pass_rigs
import pytest

from vrlf.gpu import Device, Texture
from vrlf.model import load_rig
from vrlf.passes import Perceive, PerceiveTables
from vrlf.passes.perceive import Patch
from vrlf.renderer.refining import COARSEST, Refining, refining_patches


@pytest.mark.parametrize("view_px", [(1, 1), (3, 2), (8, 8), (48, 37), (667, 75)])
def test_each_pixel_is_done_once(view_px: tuple[int, int]) -> None:
    done = np.zeros(view_px[::-1], int)
    for stride, patch in refining_patches(view_px):
        if stride:
            grid = done[::stride, ::stride]
            assert grid.min() == 1, "what counts as whole lacks a pixel"
        rows = slice(patch.first_px[1], None, patch.stride)
        done[rows, patch.first_px[0] :: patch.stride][: patch.rows] += 1
    assert (done == 1).all()


def test_no_piece_is_more_than_a_64th_or_so() -> None:
    sizes = [
        np.zeros((750, 667))[patch.first_px[1] :: patch.stride, patch.first_px[0] :: patch.stride][
            : patch.rows
        ].size
        for _, patch in refining_patches((667, 750))
    ]
    assert sizes[0] <= 1.1 * 667 * 750 / COARSEST**2
    assert max(sizes) <= 1.1 * 667 * 750 / 64


@pytest.mark.parametrize("name", ["odd", "bgr-walls"])
def test_the_finished_picture_has_the_bytes_of_the_whole(device: Device, name: str) -> None:
    """An odd width: the dark column in the middle is somebody's work too."""
    rig = (
        load_rig(
            "two-eyes",
            overrides=["panel.width_px=97", "panel.height_px=37", "headset.lens_separation_mm=4"],
        )
        if name == "odd"
        else pass_rigs.SMALL[name]
    )
    size = (rig.panel.width_px, rig.panel.height_px)
    light = np.random.default_rng(5).random((size[1], size[0], 3)).astype(np.float32)
    tables, perceive = PerceiveTables(device, rig, 24), Perceive(device)
    panel = Texture.from_array(device, light, label="panel")
    whole, grown = (Texture(device, size, label=each) for each in ("whole", "grown"))
    grown.write(np.full((size[1], size[0], 4), np.nan, np.float32))
    perceive.run(tables, panel, whole, exposure=1.3)
    refining = Refining()
    refining.restart((size[0] // 2, size[1]))
    pieces = 0

    def compute(patch: Patch) -> None:
        nonlocal pieces
        pieces += 1
        perceive.run(tables, panel, grown, exposure=1.3, patch=patch)

    strides = []
    while not refining.is_done:
        refining.advance(compute, budget_ms=0.0)
        strides.append(refining.stride)
    assert strides == sorted(strides, reverse=True)
    assert strides[0] == COARSEST
    assert pieces == len(strides)
    assert grown.read().tobytes() == whole.read().tobytes()
    for item in (tables, perceive, panel, whole, grown):
        item.release()
