"""Pictures of a search: quality against pitch and gap, and what each number may be off by."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vrlf.optics.polynomial import Float
from vrlf.studies.design.report import DesignReport
from vrlf.studies.design.sensitivity import Curve
from vrlf.studies.plots import write_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MAP_NAME: Final = "map.png"
SENSITIVITY_NAME: Final = "sensitivity.png"
_COLUMNS: Final = 4
# Numbers in the map's fields as long as they can be read.
_MOST_NAMED: Final = 12


def draw_map(report: DesignReport, path: str | Path) -> None:
    """The grid's best decibels at each pitch and gap, and where the best ten lie."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 6.5), layout="constrained")
    axes = figure.add_subplot()
    maps = report.maps
    db = np.array([[np.nan if v is None else v for v in row] for row in maps.best_db], float)
    drawn = axes.pcolormesh(
        _edges(maps.pitches_um), _edges(maps.gaps_mm), db, cmap="cividis", edgecolors="white"
    )
    figure.colorbar(drawn, label="PSNR in dB on the patch, best over focus and turn")
    _name_fields(axes, report, db)
    ranked = [(each.rig.array.pitch_um, each.rig.array.gap_mm) for each in report.best]
    x, y = zip(*ranked, strict=True)
    axes.plot(x[1:], y[1:], "o", color="#d55e00", markeredgecolor="white", label="the best ten")
    axes.plot(x[:1], y[:1], "*", color="#d55e00", markeredgecolor="white", ms=18, label="the best")
    given = report.before.get("given")
    if given is not None:
        at = given.rig.array
        axes.plot(at.pitch_um, at.gap_mm, "X", color="#000000", mec="white", ms=11, label="given")
    axes.set_xlabel("pitch in um")
    axes.set_ylabel("gap in mm")
    axes.set_title(
        f"{report.method}: the grid's best by pitch and gap, and what the search made of it\n"
        f"{report.candidates} candidates; the best {report.best[0].patch_db:.1f} dB"
    )
    figure.legend(loc="outside lower center", ncols=3, frameon=False)
    write_figure(figure, path)


def _name_fields(axes: Axes, report: DesignReport, db: Float) -> None:
    if max(db.shape) > _MOST_NAMED:
        return
    middle = (np.nanmin(db) + np.nanmax(db)) / 2.0
    for row, gap in enumerate(report.maps.gaps_mm):
        for column, pitch in enumerate(report.maps.pitches_um):
            value = db[row, column]
            if np.isfinite(value):
                colour = "black" if value > middle else "white"
                place: Any = {"ha": "center", "va": "center", "fontsize": 8, "clip_on": True}
                axes.text(pitch, gap, f"{value:.1f}", color=colour, **place)


def _edges(values: tuple[float, ...]) -> Float:
    """Borders half-way between neighbours."""
    centres = np.array(values, float)
    if len(centres) == 1:
        return np.array([0.9 * centres[0], 1.1 * centres[0]])
    middles = (centres[1:] + centres[:-1]) / 2.0
    first, last = 2.0 * centres[0] - middles[0], 2.0 * centres[-1] - middles[-1]
    return np.concatenate([[first], middles, [last]])


def draw_sensitivity(report: DesignReport, path: str | Path) -> None:
    """A curve for each number of the best."""
    from matplotlib.figure import Figure

    drawn: list[Curve] = [*report.curves]
    if report.brightness is not None:
        drawn.append(report.brightness)
    rows = -(-len(drawn) // _COLUMNS)
    figure = Figure(figsize=(3.6 * _COLUMNS, 3.2 * rows + 0.6), layout="constrained")
    figure.suptitle(
        "The best array: PSNR in dB on dead leaves where one number comes out otherwise "
        "(the shaded stretch loses at most 0.5 dB)"
    )
    for index, curve in enumerate(drawn):
        axes = figure.add_subplot(rows, _COLUMNS, index + 1)
        axes.plot(curve.values, curve.db, "o-", color="#0072b2", markersize=4)
        axes.axvline(curve.at, color="0.4", linewidth=1.0)
        if curve is not report.brightness:
            axes.axvspan(*curve.serves, color="#009e73", alpha=0.2, linewidth=0.0)
        axes.set_xlabel(curve.key)
        axes.grid(color="0.9")
        axes.spines[["top", "right"]].set_visible(False)
    write_figure(figure, path)
