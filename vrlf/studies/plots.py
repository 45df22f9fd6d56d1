"""Pictures of what a bench has found: time against size, sharpness against steps.

matplotlib draws them, an optional extra. It is imported when a picture is asked for, and without
its global state (``pyplot``): a ``Figure`` draws itself to bytes on any machine, without a
screen.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from vrlf.errors import InputError, OutputPathError
from vrlf.files import atomic_write_bytes, check_target, shown
from vrlf.studies.limits import PIXEL_BYTES
from vrlf.studies.quality import METHODS, QualityReport
from vrlf.studies.speed import SpeedReport

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ENDINGS: Final = (".png", ".svg")
_SIZE_INCHES: Final = (9.0, 6.0)
_DOTS_PER_INCH: Final = 150
# Colours that the colour-blind tell apart (Okabe & Ito 2008), darkest first.
_COLOURS: Final = (
    "#000000",
    "#0072b2",
    "#d55e00",
    "#009e73",
    "#cc79a7",
    "#e69f00",
    "#56b4e9",
)
_MARKERS: Final = "osD^vPX*p<h>dH"
_LINE_OF: Final = {
    "none": (0, (1, 2)),
    "forward": (0, (5, 2)),
    "forward + wiener": (0, (5, 2, 1, 2)),
    "converged": (0, (9, 3)),
}


def check_plot(path: str, option: str = "--plot") -> Path:
    """Make sure that a plot can be drawn and put at ``path``, before anything is measured.

    ``option`` is what asked for it.

    Raises
    ------
    OutputPathError
        If the ending is none that can be drawn, or the place cannot hold a file.
    InputError
        If matplotlib is not there.
    """
    if Path(path).suffix.lower() not in ENDINGS:
        raise OutputPathError(
            f"{shown(path)}: found the ending {Path(path).suffix or 'none'!r}, "
            f"wanted {' or '.join(ENDINGS)}"
        )
    target = check_target(path)
    require_matplotlib(option)
    return target


def require_matplotlib(what: str) -> None:
    """Make sure that plots can be drawn for ``what``, before anything is measured.

    Raises
    ------
    InputError
        If matplotlib is not there.
    """
    if find_spec("matplotlib") is None:
        raise InputError(
            f"{what}: found no matplotlib, wanted it installed; pip install 'vrlf[plots]'"
        )


def plot_speed(report: SpeedReport, path: str | Path) -> None:
    """Milliseconds against megapixels, both logarithmic: a line for each step.

    The grey line is a copy of one rgba32f picture, the least that a step takes which reads a
    picture and writes one.
    """
    figure, axes = _blank("megapixels of the panel", "ms")
    names = [n for n in dict.fromkeys(each.timing.name for each in report.results) if _drawn(n)]
    for index, name in enumerate(names):
        points = [
            (each.megapixels, each.timing.ms)
            for each in report.results
            if each.timing.name == name and each.timing.ms > 0.0
        ]
        dashes = (0, (4, 2)) if name.startswith("frame") else "-"
        _line(axes, points, name, index, linestyle=dashes)
    sizes = sorted({each.megapixels for each in report.results})
    copied = [report.limits.least_ms(2 * PIXEL_BYTES * 1e6 * size) for size in sizes]
    axes.plot(sizes, copied, color="0.6", linewidth=4, zorder=1, label="copy of a picture (limit)")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xticks(sizes, [f"{size:.3g}" for size in sizes])
    axes.minorticks_off()
    axes.set_title(f"{report.device}\ncopies {report.limits.copy_gb_per_s:.3g} GB/s")
    _finish(figure, axes, path)


def _drawn(name: str) -> bool:
    """Tables are made once for a prescription: no part of a frame."""
    return not name.startswith("tables")


def plot_quality(report: QualityReport, path: str | Path) -> None:
    """PSNR against the steps of ``optimal``, a line for each rig: the mean over its pictures.

    The other methods have no steps and are drawn as broken lines in their rig's colour.
    """
    figure, axes = _blank("steps of optimal", "PSNR in dB of the worse eye, mean over pictures")
    for index, rig in enumerate(dict.fromkeys(each.rig for each in report.results)):
        means = report.mean_psnr_db(rig)
        colour = _COLOURS[index % len(_COLOURS)]
        steps = [(n or 0, db) for (method, n), db in means.items() if method == "optimal"]
        _line(axes, steps, rig, index, linestyle="-")
        for (method, _), db in means.items():
            if method in _LINE_OF:
                axes.axhline(db, color=colour, linestyle=_LINE_OF[method], linewidth=1.2)
    for method in METHODS:
        if any(each.method == method for each in report.results) and method in _LINE_OF:
            axes.plot([], [], color="0.3", linestyle=_LINE_OF[method], label=method)
    counts = sorted({each.iterations for each in report.results if each.iterations is not None})
    # Powers of two, evenly; 0 has its place too.
    axes.set_xscale("symlog", base=2, linthresh=1)
    axes.set_xticks(counts, [str(count) for count in counts])
    axes.minorticks_off()
    axes.set_title(f"{report.device}\npanel {report.panel}, judged with {report.rays} rays a pixel")
    _finish(figure, axes, path)


def _blank(x_label: str, y_label: str) -> tuple[Figure, Axes]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=_SIZE_INCHES, layout="constrained")
    axes = figure.add_subplot()
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    axes.grid(color="0.9")
    return figure, axes


def _line(
    axes: Axes, points: Sequence[tuple[float, float]], label: str, index: int, *, linestyle: Any
) -> None:
    if points:
        x, y = zip(*sorted(points), strict=True)
        colour = _COLOURS[index % len(_COLOURS)]
        axes.plot(
            x,
            y,
            color=colour,
            # Colours come round again; the marks then are others, and hollow.
            marker=_MARKERS[index % len(_MARKERS)],
            markerfacecolor=colour if index < len(_COLOURS) else "white",
            linestyle=linestyle,
            label=label,
        )


def _finish(figure: Figure, axes: Axes, path: str | Path) -> None:
    """Name the lines beside the picture, draw it, and write it whole."""
    axes.spines[["top", "right"]].set_visible(False)
    figure.legend(loc="outside right upper", frameon=False, fontsize="small", handlelength=3.5)
    write_figure(figure, path)


def write_figure(figure: Figure, path: str | Path) -> None:
    """Draw a figure and write it whole."""
    drawn = io.BytesIO()
    kind = Path(path).suffix.lower().removeprefix(".")
    figure.savefig(drawn, format=kind, dpi=_DOTS_PER_INCH)
    atomic_write_bytes(path, drawn.getvalue())
