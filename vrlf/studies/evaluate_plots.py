"""Plots of an evaluation, as SVG: a line for each eye, a mark for each method."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING, Final

from vrlf.evaluation.metrics import METRICS
from vrlf.evaluation.report import Pair, Plot, Report, View, flat, short_names

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# The colours of METHODS; the colour-blind tell them apart (Okabe & Ito 2008), and so do marks.
_MARKS: Final = {"none": ("#d55e00", "X"), "forward": ("#0072b2", "o"), "optimal": ("#009e73", "D")}
_WIDTH_INCHES: Final = 5.4
_LINE_INCHES: Final = 0.32
# With more lines than this nobody reads one; means over sources stand in their place.
_MOST_LINES: Final = 36
_PLOTTED: Final = (
    "psnr_db",
    "ssim",
    "flip",
    "cvvdp_jod",
    "hdr_vdp.q_mos",
    "acuity.decimal",
    "fringe",
)
_CURVES: Final = {
    "contrast": ("Contrast kept at each frequency", "contrast, of the target's"),
    "mtf": ("MTF of a slanted edge", "contrast kept"),
}
NO_MATPLOTLIB: Final = "plots: found no matplotlib, wanted it installed; pip install 'vrlf[plots]'"

Lines = dict[str, dict[str, float]]


def have_matplotlib() -> bool:
    """Whether plots can be drawn."""
    return find_spec("matplotlib") is not None


def evaluation_plots(report: Report) -> tuple[Plot, ...]:
    """A plot for each metric that has a number to show."""
    plots = []
    for name in _PLOTTED:
        lines = metric_lines(report.pairs, name)
        if lines:
            plots.append(_plot(name, lines))
    return tuple(plots)


def metric_lines(pairs: Sequence[Pair], name: str) -> Lines:
    """By eye, then by method: what is drawn of a metric; means over sources where too many."""
    lines = _gathered(pairs, name, with_source=len({pair.source for pair in pairs}) > 1)
    if len(lines) > _MOST_LINES:
        lines = _gathered(pairs, name, with_source=False)
    return lines


def _gathered(pairs: Sequence[Pair], name: str, *, with_source: bool) -> Lines:
    found: dict[str, dict[str, list[float]]] = {}
    sources = short_names(pair.source for pair in pairs)
    rigs = short_names(pair.rig for pair in pairs)
    for pair in pairs:
        for eye in pair.eyes:
            label = f"{rigs[pair.rig]}, {eye.side}"
            if with_source:
                label = f"{sources[pair.source]}, {label}"
            for view in eye.views:
                value = flat(view.values).get(name)
                if value is not None:
                    found.setdefault(label, {}).setdefault(view.method, []).append(value)
    return {
        label: {method: sum(each) / len(each) for method, each in methods.items()}
        for label, methods in found.items()
    }


def eye_plots(views: Sequence[View]) -> tuple[Plot, ...]:
    """A plot for each metric of one eye that has a number at each frequency."""
    plots = []
    for name, (heading, axis) in _CURVES.items():
        curves = {
            view.method: {float(x): float(y) for x, y in found.items()}
            for view in views
            if isinstance(found := view.values.get(name), Mapping)
        }
        if curves:
            plots.append(_curves(heading, axis, curves))
    return tuple(plots)


def _curves(heading: str, axis: str, curves: Mapping[str, Mapping[float, float]]) -> Plot:
    with _drawing(3.4) as (axes, finish):
        for method, curve in curves.items():
            colour, mark = _MARKS[method]
            above = {x: y for x, y in curve.items() if x > 0.0}
            points = [*above], [*above.values()]
            axes.plot(*points, color=colour, marker=mark, markersize=3.5, label=method)
        axes.set_xscale("log")
        axes.set_ylim(0.0, 1.5)
        axes.axhline(1.0, color="0.6", linewidth=1.0, zorder=0)
        axes.set_xlabel("cycles per degree")
        axes.set_ylabel(axis)
        axes.grid(color="0.92", which="both")
        svg = finish()
    most = ", ".join(
        f"{method} up to {max(curve):.3g} cycles/degree" for method, curve in curves.items()
    )
    return Plot(heading, f"{heading}: {most}", svg)


def _plot(name: str, lines: Lines) -> Plot:
    metric, _, part = name.partition(".")
    known = METRICS.get(metric)
    title, unit, better = (
        (known.title, known.unit, known.better) if known else (metric, "", "higher")
    )
    heading = f"{title} {part}".strip() + (f", {unit}" if unit else "")
    with _drawing(1.1 + _LINE_INCHES * len(lines)) as (axes, finish):
        for place, methods in enumerate(lines.values()):
            axes.plot([*methods.values()], [place] * len(methods), color="0.8", zorder=1)
        for method, (colour, mark) in _MARKS.items():
            points = [(m[method], place) for place, m in enumerate(lines.values()) if method in m]
            if points:
                x, y = zip(*points, strict=True)
                axes.plot(x, y, mark, color=colour, markersize=7, label=method, linestyle="none")
        axes.set_yticks(range(len(lines)), [_short(label) for label in lines])
        axes.set_ylim(len(lines) - 0.5, -0.5)
        axes.set_xlabel(f"{heading}  ({better} is better)")
        axes.grid(axis="x", color="0.92")
        axes.spines["left"].set_visible(False)
        axes.tick_params(axis="y", length=0)
        svg = finish()
    return Plot(f"{heading}, by eye and method", _words(heading, lines), svg)


@contextlib.contextmanager
def _drawing(height_inches: float) -> Iterator[tuple[Axes, Callable[[], bytes]]]:
    """Axes to draw into, and what turns them into SVG."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    # Without a salt the names inside the file would be other ones each time.
    with rc_context({"svg.hashsalt": "vrlf", "svg.fonttype": "path", "font.size": 9.0}):
        figure = Figure(figsize=(_WIDTH_INCHES, height_inches), layout="constrained")
        axes = figure.add_subplot()

        def finish() -> bytes:
            axes.set_axisbelow(True)
            axes.spines[["top", "right"]].set_visible(False)
            figure.legend(loc="outside upper left", ncols=3, frameon=False)
            drawn = io.BytesIO()
            figure.savefig(drawn, format="svg", metadata={"Date": None})
            return drawn.getvalue()

        yield axes, finish


def _short(label: str, most: int = 36) -> str:
    # A dollar sign would begin a formula.
    text = label if len(label) <= most else f"…{label[1 - most :]}"
    return text.replace("$", r"\$")


def _words(heading: str, lines: Lines) -> str:
    """The plot, for those who cannot see it."""
    said = (
        f"{label}: " + ", ".join(f"{method} {value:.4g}" for method, value in methods.items())
        for label, methods in lines.items()
    )
    return f"{heading}. " + "; ".join(said)
