"""One case of an evaluation judged: what is shown, seen, and how like it is to the target."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vrlf.evaluation.measure import Compared, compared
from vrlf.evaluation.metrics import METRICS, Scores, Viewing, false_colour, score
from vrlf.evaluation.metrics.colour import light_kept
from vrlf.model import Rig
from vrlf.optics.inspect import display_numbers
from vrlf.optics.lattice import lattice_of
from vrlf.optics.viewport import Side, viewport
from vrlf.renderer import GpuRenderer, Image, bare_rig
from vrlf.studies.evaluate_store import EyeFound

# What a map shows where nothing is judged: middle grey, no colour of a map.
_UNJUDGED: Final = 128
# It asks for what is seen before any gain.
_LIGHT: Final = "light"
# S of HDR-VDP-2 has no end, so no scale of colours.
_UNSHOWN_MAPS: Final = frozenset({"S"})


def rig_viewing(rig: Rig) -> Viewing:
    """True pixels per degree on the axis, and the panel's luminance."""
    ppd = display_numbers(rig)["pixels_per_degree"]
    assert ppd is not None
    return Viewing(ppd, rig.panel.peak_nit)


def method_rig(rig: Rig, method: str) -> Rig:
    """The rig with that prefilter, all its other settings kept."""
    return rig.model_copy(update={"prefilter": rig.prefilter.model_copy(update={"method": method})})


def shown_and_seen(
    renderer: GpuRenderer, target: Image, rig: Rig, rays: int
) -> tuple[Image, Image]:
    """The panel image by the rig's own method, and what both eyes perceive of it.

    ``none`` is seen on a panel without the array.
    """
    panel = renderer.prefilter(target, rig)
    seen_by = bare_rig(rig) if rig.prefilter.method == "none" else rig
    return panel, renderer.perceive(panel, seen_by, rays=rays)


def judge(
    seen: Image, target: Image, rig: Rig, side: Side, metrics: Sequence[str]
) -> tuple[EyeFound, dict[str, NDArray[np.uint8]]]:
    """What one eye perceives against what it should: numbers, and maps as pictures.

    Parameters
    ----------
    seen, target : ndarray (H, W, 3)
        Linear light on the panel's raster.
    rig : Rig
        Whose method made the panel image: ``optimal`` alone raises the black level.
    """
    black = rig.prefilter.black_level if rig.prefilter.method == "optimal" else 0.0
    pair = compared(seen, target, rig, side, black_level=black)
    names = [name for name in metrics if name in METRICS and name != _LIGHT]
    scores = score(names, pair.target, pair.seen, rig_viewing(rig))
    if _LIGHT in metrics:
        scores.values[_LIGHT] = light_of(seen, pair, rig, side)
    view = viewport(rig, side)
    pictures: dict[str, NDArray[np.uint8]] = {}
    named: dict[str, str] = {}
    for title, values in _shown_maps(scores):
        framed = np.full((view.height_px, view.width_px, 3), _UNJUDGED, np.uint8)
        framed[pair.inner] = false_colour(values)
        named[title] = f"{side}-{title}.png"
        pictures[named[title]] = framed
    values_by_name = {**scores.values, "gain": pair.gain}
    return EyeFound(values_by_name, scores.reasons, scores.failed, named), pictures


def light_of(seen: Image, pair: Compared, rig: Rig, side: Side) -> float | None:
    """Share of the target's light that is left, black level, array and all."""
    lattice = None if rig.prefilter.method == "none" else lattice_of(rig)
    throughput = 1.0 if lattice is None else lattice.throughput
    inner = seen[:, viewport(rig, side).columns][pair.inner]
    return light_kept(throughput * inner.astype(np.float64), pair.target)


def _shown_maps(scores: Scores) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Each map that ends at 1, by its metric's name."""
    for metric, maps in scores.maps.items():
        for name, values in maps.items():
            if name not in _UNSHOWN_MAPS:
                yield metric, values
