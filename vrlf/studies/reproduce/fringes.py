"""Chapter 5.3: colour fringes, and what ever more samples of a pixel do against them."""

from __future__ import annotations

from typing import Final

import numpy as np

from vrlf.evaluation.fringes import fringe
from vrlf.model import Rig, load_rig
from vrlf.optics.viewport import viewport
from vrlf.renderer import GpuRenderer, Image
from vrlf.studies.quality import CROP_PX, cropped
from vrlf.studies.reproduce.drawing import Cell, sheet_png
from vrlf.studies.reproduce.item import Item, Number, Picture, Workbench
from vrlf.studies.reproduce.samplings import SAMPLINGS, Sampling, panels

# Rays of the judge, enough that its noise is a fraction of the fringes; see ``quadrature``.
RAYS: Final = {"thesis-minus-5d": 2048, "matched-microlens": 512}
PICTURES: Final = {"letters": "chart:logmar", "star": "chart:siemens"}
TAKEN: Final = tuple(each for each in SAMPLINGS if each.grid < 5)
_SHOWN: Final = ("one a pixel", "one a sub-pixel", "nine a sub-pixel", "optimal")
# The part that is shown.
_CUT_PX: Final = 110


def fringes_of(
    renderer: GpuRenderer,
    rig: Rig,
    target: Image,
    rays: int,
    samplings: tuple[Sampling, ...] = TAKEN,
) -> dict[str, tuple[float, Image]]:
    """The left eye's fringe in percent with each sampling, and what both eyes see."""
    found = {}
    for sampling, panel, _ in panels(renderer, rig, target, samplings):
        seen = renderer.perceive(panel, rig, rays=rays)
        found[sampling.name] = 100.0 * (fringe(seen, target, rig, "left") or 0.0), seen
    return found


def make(bench: Workbench) -> Item:
    """The item."""
    numbers, rows = [], []
    for name, rays in RAYS.items():
        rig = cropped(load_rig(name), CROP_PX)
        for content, source in PICTURES.items():
            target = bench.target(source, rig)
            bench.say(f"fringes-5-3: {name}, {content}, {rays} rays a pixel")
            found = fringes_of(bench.renderer, rig, target, rays)
            one = found["one a sub-pixel"][0]
            for sampling, (percent, _) in found.items():
                change = f"{100.0 * (percent / one - 1.0):+.0f} % against one a sub-pixel."
                numbers.append(
                    Number(f"fringe, {name}, {content}, {sampling}", "%", percent, None, change)
                )
            if content == "star":
                rows.append([_cell(rig, name, each, *found[each]) for each in _SHOWN])
    return Item(
        "fringes-5-3",
        "5.3: colour fringes",
        "With one ray a pixel much of the panel image stays black; one for each sub-pixel helps, "
        "but where not all three meet the pupil colours appear; nine samples erase the chromatic "
        "artifacts.",
        "Nine samples of each sub-pixel leave about a tenth to a seventh less colour than one: "
        "they lessen fringes and do not erase them. In the thesis's headset every pixel is seen "
        "through several lenslets (its eyebox is half the pupil), so fringes are small from the "
        "start, and one sample that all three colours share leaves less colour than one for each: "
        "then all three err alike. What is left is geometry, a lenslet's image of stripes with "
        "gaps between them; optimal, which knows all the light, takes about two fifths of it away.",
        tuple(numbers),
        (
            Picture(
                "fringes-5-3.png",
                "A grey star as the left eye sees it, its middle, each pixel drawn 3 x 3.",
                sheet_png(
                    "A grey star as it is seen: all colour in it is a fringe", rows, enlarge=3
                ),
            ),
        ),
    )


def _cell(rig: Rig, name: str, sampling: str, percent: float, seen: Image) -> Cell:
    half = seen[:, viewport(rig, "left").columns]
    top, left = ((size - _CUT_PX) // 2 for size in half.shape[:2])
    cut = np.ascontiguousarray(half[top : top + _CUT_PX, left : left + _CUT_PX])
    return Cell(f"{name}, {sampling}", cut, f"fringe {percent:.2f} %")
