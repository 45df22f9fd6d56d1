"""The picture of ``vrlf eye``: a row for each eye, from its wavefront to a blurred letter.

Like Figures 3.4 and 3.6 of the thesis, but in the wearer's view: x to the right and y upward
as the wearer looks out, in angles as the wearer sees them.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vrlf.images import srgb_encode
from vrlf.model import prescription_text
from vrlf.optics import polynomial
from vrlf.optics.polynomial import Float
from vrlf.studies.eyes import (
    COLOURS,
    CYCLES_PER_DEGREE,
    LETTER,
    EyeReport,
    letter_height_arcmin,
    modulation_curves,
    seen_letter,
)
from vrlf.studies.plots import write_figure
from vrlf.units import ARCMIN_PER_DEGREE, ARCMIN_PER_SLOPE, REFERENCE_WAVELENGTH_NM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROW_INCHES: Final = (19.0, 4.5)
_HEADING_INCHES: Final = 0.6
_COLUMNS: Final = 5
_WAVEFRONT_POINTS: Final = 301
_CONTOURS: Final = 12
# A wavefront flatter than this is drawn as flat.
_FLAT_UM: Final = 0.02
# Okabe & Ito 2008: told apart by the colour-blind, and near the panel's colours. Each line is
# thinner than the one below it, so that all show where they coincide.
_LINES: Final = (("#d55e00", 4.0), ("#009e73", 2.6), ("#0072b2", 1.2))
_CLIPPED_LIGHT: Final = 0.05
_GREEN: Final = COLOURS.index("green")


def plot_eyes(
    reports: Mapping[str, EyeReport], path: str | Path, *, title: str, letter_arcmin: float | None
) -> None:
    """Draw the eyes, a row each, and write the picture whole.

    Columns: the wavefront in micrometres, a point by rays and by diffraction in the panel's
    colours, the modulation transfer and a blurred letter.

    Parameters
    ----------
    reports : mapping
        By the eye's name.
    letter_arcmin : float or None
        Height of the letter; None takes for each eye what its blur is about to hide.
    """
    write_figure(eyes_figure(reports, title=title, letter_arcmin=letter_arcmin), path)


def eyes_figure(
    reports: Mapping[str, EyeReport], *, title: str, letter_arcmin: float | None = None
) -> Figure:
    """The picture itself, not yet written."""
    from matplotlib.figure import Figure

    width, height = _ROW_INCHES
    size = (width, height * len(reports) + _HEADING_INCHES)
    figure = Figure(figsize=size, layout="constrained")
    figure.suptitle(title, fontsize="x-large")
    rows: Any = figure.subfigures(len(reports), 1, squeeze=False)[:, 0]
    for row, (name, report) in zip(rows, reports.items(), strict=True):
        row.suptitle(f"{name} eye:  {summary(report)}", fontweight="bold", fontsize="large")
        axes = row.subplots(1, _COLUMNS)
        _draw_wavefront(axes[0], report)
        blurred = max(report.geometric_half_light_arcmin) > _cell_arcmin(report)
        note = "" if blurred else "no blur: all rays meet"
        _draw_spot(axes[1], report, report.geometric, "a point, by rays", note)
        strehl = " / ".join(f"{each:.2g}" for each in report.strehl)
        _draw_spot(
            axes[2], report, report.diffraction, "a point, with diffraction", f"Strehl {strehl}"
        )
        _draw_modulation(axes[3], report)
        _draw_letter(axes[4], report, letter_arcmin or letter_height_arcmin(report))
    return figure


def summary(report: EyeReport) -> str:
    """An eye's numbers in one line."""
    rx = report.residual
    left = prescription_text(rx.sphere_d, rx.cylinder_d, rx.axis_deg)
    text = (
        f"{left} left over, pupil {report.seen.pupil_mm:g} mm, RMS {report.rms_um:.3f} um "
        f"(higher orders {report.higher_order_rms_um:.3f} um)"
    )
    x, y = (slope * ARCMIN_PER_SLOPE for slope in report.seen.shift_slope)
    if max(abs(x), abs(y)) >= 0.05:
        across, upward = "right" if x >= 0.0 else "left", "up" if y >= 0.0 else "down"
        text += f", seen {abs(x):.1f} arcmin {across} and {abs(y):.1f} {upward}"
    return text


def _cell_arcmin(report: EyeReport) -> float:
    return report.cells.step_slope * ARCMIN_PER_SLOPE


def _draw_wavefront(axes: Axes, report: EyeReport) -> None:
    radius = report.seen.pupil_mm / 2.0
    at = np.linspace(-radius, radius, _WAVEFRONT_POINTS)
    height = polynomial.on_grid(report.seen.reference_um, at, at)
    inside = np.hypot(at[None, :], at[:, None]) <= radius
    most = max(_FLAT_UM, float(np.abs(height[inside]).max()))
    shown = np.where(inside, height, np.nan)
    picture = axes.imshow(
        shown,
        origin="lower",
        extent=(-radius, radius, -radius, radius),
        cmap="RdBu_r",
        vmin=-most,
        vmax=most,
    )
    levels = np.linspace(-most, most, _CONTOURS + 1)
    axes.contour(at, at, shown, levels, colors="black", linewidths=0.4, alpha=0.6)
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    axes.plot(radius * np.cos(turn), radius * np.sin(turn), color="black", linewidth=1.0)
    axes.spines[:].set_visible(False)
    axes.set_title(f"wavefront at {REFERENCE_WAVELENGTH_NM:g} nm")
    axes.set_xlabel("pupil, mm right")
    axes.set_ylabel("mm up")
    figure: Any = axes.figure
    figure.colorbar(picture, ax=axes, label="µm", fraction=0.046, pad=0.03)


def _draw_spot(axes: Axes, report: EyeReport, shares: Float, title: str, note: str) -> None:
    """Light in the panel's colours, sRGB."""
    half = report.cells.half_slope * ARCMIN_PER_SLOPE
    light = np.clip(shares / _white_level(shares), 0.0, 1.0)
    axes.imshow(srgb_encode(light), origin="lower", extent=(-half, half, -half, half))
    axes.set_title(title)
    axes.set_xlabel("arcmin right")
    axes.set_ylabel("arcmin up")
    axes.text(
        0.02, 0.02, note, color="white", fontsize="small", transform=axes.transAxes, va="bottom"
    )
    pixel = report.pixel_arcmin
    to_pixels: Any = (lambda x: x / pixel, lambda x: x * pixel)
    above = axes.secondary_xaxis("top", functions=to_pixels)
    above.set_xlabel("panel pixels", fontsize="small")
    above.tick_params(labelsize="small")


def _white_level(shares: Float) -> float:
    """What is shown as white: a twentieth of the light, of all colours, lies in brighter cells."""
    falling = np.sort(shares, axis=None)[::-1]
    held = np.cumsum(falling)
    return float(falling[np.searchsorted(held, _CLIPPED_LIGHT * held[-1])])


def _draw_modulation(axes: Axes, report: EyeReport) -> None:
    found = [modulation_curves(report, index) for index in range(len(COLOURS))]
    for (colour, width), nm, curves in zip(_LINES, report.seen.wavelengths_nm, found, strict=True):
        at = curves.cycles_per_degree
        axes.plot(at, curves.mean, color=colour, linewidth=width, label=f"{nm:g} nm, mean")
    nm, green = report.seen.wavelengths_nm[_GREEN], found[_GREEN]
    at = green.cycles_per_degree
    thin: Any = {"color": "black", "linewidth": 0.9}
    axes.plot(at, green.horizontal, **thin, label=f"{nm:g} nm, along x")
    axes.plot(at, green.vertical, "--", **thin, label=f"{nm:g} nm, along y")
    axes.plot(at, green.perfect, color="0.6", linewidth=3.0, zorder=1, label=f"{nm:g} nm, limit")
    nyquist = ARCMIN_PER_DEGREE / report.pixel_arcmin / 2.0
    axes.axvline(nyquist, color="0.4", linestyle=":", label="panel's finest")
    axes.set_xscale("log")
    axes.set_xlim(*CYCLES_PER_DEGREE)
    axes.set_xticks([0.1, 1.0, 10.0, 100.0], ["0.1", "1", "10", "100"])
    axes.set_ylim(0.0, 1.02)
    axes.set_box_aspect(1.0)
    axes.set_title("modulation transfer")
    axes.set_xlabel("cycles per degree")
    axes.set_ylabel("contrast left")
    axes.grid(color="0.9")
    axes.legend(fontsize="x-small", framealpha=0.85, edgecolor="none")


def _draw_letter(axes: Axes, report: EyeReport, height_arcmin: float) -> None:
    letter = seen_letter(report, height_arcmin)
    half = letter.half_arcmin
    axes.imshow(srgb_encode(letter.light), origin="lower", extent=(-half, half, -half, half))
    axes.set_title(f"{LETTER} of {height_arcmin:.3g} arcmin (logMAR {letter.logmar:.1f})")
    axes.set_xlabel("arcmin right")
    axes.set_ylabel("arcmin up")
