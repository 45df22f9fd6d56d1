"""Perception ray by ray on the GPU against its float64 twin."""

from __future__ import annotations

from typing import Any

import numpy as np
import pass_rigs
import pytest
from numpy.typing import NDArray

from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.optics.tracing import Tracing
from vrlf.passes import PerceiveTraced, TracedTables
from vrlf.reference.traced import perceive_traced

Light = NDArray[Any]

RAYS = 24
# Both sides trace the same rays; a 32-bit landing is good to 1e-4 um where the map of
# diffraction is smooth. A ray within 0.05 um of an edge may fall on its other side.
SAME_LIGHT = 1e-4
EDGE_SHARE = 2e-3
BOTH = Tracing(diffraction=True, exact=True)
DIFFRACTION, EXACT = Tracing(diffraction=True), Tracing(exact=True)
CASES = {
    "chromatic-one": ("one-chromatic-eye", BOTH),
    "walls": ("bgr-walls", BOTH),
    "walls-turned": ("rgb-walls-turned", DIFFRACTION),
    "leaning-walls-acrylic": ("full-leaning-walls", BOTH),
    "coma": ("coma-lenslets", EXACT),
    "eighth-order": ("coma-lenslets", DIFFRACTION),
    "round-holes": ("round-holes-moved", DIFFRACTION),
    "square-holes": ("square-holes-walls", DIFFRACTION),
    "diamonds": ("diamonds-lenslets", BOTH),
    "diamonds-holes": ("diamonds-holes", DIFFRACTION),
    "rgbg": ("rgbg-walls", EXACT),
}


def perceived(
    device: Device,
    rig: Rig,
    panel: Light,
    tracing: Tracing,
    exposure: float = 1.0,
    rays: int = RAYS,
) -> Light:
    """What the pass makes of a panel image, (H, W, 3)."""
    owned: list[Any] = [PerceiveTraced(device)]
    try:
        owned.append(tables := TracedTables(device, rig, rays, tracing))
        owned.append(shown := Texture.from_array(device, panel, label="panel"))
        owned.append(seen := Texture(device, shown.size_px, label="seen"))
        owned[0].run(tables, shown, seen, exposure=exposure)
        return seen.read()[..., :3]
    finally:
        for each in owned:
            each.release()


@pytest.mark.parametrize("name", CASES)
def test_traced_perception_matches_its_twin(device: Device, name: str) -> None:
    small, tracing = CASES[name]
    rig, panel = pass_rigs.case(small)
    error = perceived(device, rig, panel, tracing) - perceive_traced(panel, rig, RAYS, tracing)
    off = np.abs(error).max(axis=-1)
    print(f"{name}: {(off > SAME_LIGHT).sum()} of {off.size} apart, greatest {off.max():.1e}")
    assert (off > SAME_LIGHT).mean() <= EDGE_SHARE
    # Two rays' light, at most at four times the radiance (a diamond's red).
    assert off.max() <= 2 * 4 / RAYS
