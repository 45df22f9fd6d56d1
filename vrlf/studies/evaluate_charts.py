"""What an eye reads and resolves: letters and an edge, shown through the whole chain.

Both are shown in the middle of the viewports, on a panel cut to what they need: an acuity takes
some ten pages of letters, each filtered and perceived, and none asks what is far from the axis.
Both eyes look at the same pages, so that each is computed once.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Collection
from math import ceil
from typing import Any, Final

import numpy as np

from vrlf.errors import InputError
from vrlf.evaluation.measure import border_px
from vrlf.evaluation.metrics.edge import EdgeMtf, edge_mtf, slanted_edge
from vrlf.evaluation.metrics.letters import smallest_line
from vrlf.model import Rig
from vrlf.optics.inspect import display_numbers
from vrlf.optics.viewport import SIDES, Side, viewport
from vrlf.renderer import Image
from vrlf.studies.evaluate_store import EyeFound
from vrlf.studies.quality import cropped

CHART_METRICS: Final = ("acuity", "mtf50", "mtf")
# The reader's own noise is ten times what so few rays leave.
CHART_RAYS: Final = 256
# A letter of half of this stands at logMAR 2: 20/2000.
_ROOM_DEG: Final = 16.0
_LEAST_ROOM_PX, _MOST_ROOM_PX = 160, 480
_MOST_FREQUENCIES: Final = 32
_HALF: Final = 0.5

Show = Callable[[Image, Rig], Image]


def chart_rig(rig: Rig) -> Rig:
    """The middle of both viewports, as large as letters and border need, at most the rig itself."""
    ppd = _pixels_per_degree(rig)
    room_px = min(max(ceil(_ROOM_DEG * ppd), _LEAST_ROOM_PX), _MOST_ROOM_PX)
    side_px = room_px + 2 * _border_px(rig)
    width, height = rig.panel.width_px, rig.panel.height_px
    size = (min(width, 2 * side_px), min(height, side_px))
    return rig if size == (width, height) else cropped(rig, size)


def read_charts(rig: Rig, show: Show, names: Collection[str]) -> dict[Side, EyeFound]:
    """Acuity and MTF of both eyes.

    Parameters
    ----------
    rig : Rig
        As ``chart_rig`` gives it.
    show : callable
        From a target on the rig's panel to what both eyes perceive of the panel image.
    names : collection of str
        Of ``CHART_METRICS``.

    Returns
    -------
    dict
        By eye. ``acuity`` is ``decimal`` and ``logmar`` of the smallest legible line; ``mtf50``
        the cycles per degree where half of the contrast is left, ``mtf`` what is left by cycles
        per degree.
    """
    pages = _Pages(rig, show)
    found = {}
    for side in SIDES:
        eye = EyeFound({})
        for part, add in (({"acuity"}, _add_acuity), ({"mtf50", "mtf"}, _add_mtf)):
            asked = part.intersection(names)
            try:
                if asked:
                    add(eye, rig, side, pages, asked)
            except InputError as error:
                eye.failed.update(dict.fromkeys(asked, str(error)))
        found[side] = eye
    return found


class _Pages:
    """What both eyes perceive of a page that both are shown; each page is computed once."""

    def __init__(self, rig: Rig, show: Show) -> None:
        self._rig, self._show = rig, show
        self._seen: dict[str, Image] = {}

    def look(self, page: Image, side: Side) -> Image:
        """One eye's view of a page of its viewport's size."""
        target = self._both(page)
        name = hashlib.sha256(target.tobytes()).hexdigest()
        if name not in self._seen:
            self._seen[name] = self._show(target, self._rig)
        return self._seen[name][:, viewport(self._rig, side).columns]

    def _both(self, page: Image) -> Image:
        panel = self._rig.panel
        target = np.zeros((panel.height_px, panel.width_px, 3), np.float32)
        for side in SIDES:
            target[:, viewport(self._rig, side).columns] = page
        return target


def _add_acuity(eye: EyeFound, rig: Rig, side: Side, pages: _Pages, _: Collection[str]) -> None:
    view = viewport(rig, side)
    read = smallest_line(
        lambda page: pages.look(page, side),
        width_px=view.width_px,
        height_px=view.height_px,
        pixels_per_degree=_pixels_per_degree(rig),
        border_px=_border_px(rig),
    )
    if read.logmar is None:
        largest = f"logMAR {read.lines[0].logmar:.1f}" if read.lines else "any size"
        eye.values["acuity"] = None
        eye.reasons["acuity"] = f"not even letters of {largest}, the largest shown, are legible"
        return
    eye.values["acuity"] = {"decimal": read.decimal_acuity, "logmar": read.logmar}


def _add_mtf(eye: EyeFound, rig: Rig, side: Side, pages: _Pages, asked: Collection[str]) -> None:
    view, border, ppd = viewport(rig, side), _border_px(rig), _pixels_per_degree(rig)
    page = slanted_edge(view.width_px, view.height_px).astype(np.float32)
    seen = pages.look(page, side)
    inner = seen[border : view.height_px - border, border : view.width_px - border]
    found = edge_mtf(inner, ppd)
    half = half_frequency(found)
    if "mtf50" in asked:
        eye.values["mtf50"] = half
        if half is None:
            eye.reasons["mtf50"] = "more than half is left at every frequency that is shown"
    if "mtf" in asked:
        eye.values["mtf"] = _thinned(found, ppd)


def half_frequency(found: EdgeMtf) -> float | None:
    """The first frequency at which no more than half of the contrast is left; None if none."""
    below = np.flatnonzero(found.mtf <= _HALF)
    if below.size == 0:
        return None
    i = int(below[0])
    x, y = found.cycles_per_degree[i - 1 : i + 1], found.mtf[i - 1 : i + 1]
    return float(x[0] + (y[0] - _HALF) / (y[0] - y[1]) * (x[1] - x[0]))


def _thinned(found: EdgeMtf, pixels_per_degree: float) -> dict[str, Any]:
    """Some frequencies up to the raster's own limit, half a cycle a pixel."""
    shown = np.flatnonzero(found.cycles_per_degree <= pixels_per_degree / 2.0)
    chosen = shown[:: max(1, ceil(shown.size / _MOST_FREQUENCIES))]
    return {f"{found.cycles_per_degree[i]:.3g}": float(found.mtf[i]) for i in chosen}


def _border_px(rig: Rig) -> int:
    """The wider one of both eyes', so that both are shown the same pages."""
    return max(border_px(rig, side) for side in SIDES)


def _pixels_per_degree(rig: Rig) -> float:
    ppd = display_numbers(rig)["pixels_per_degree"]
    assert ppd is not None
    return ppd
