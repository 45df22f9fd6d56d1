"""A picture of a lenslet's optics: spots, MTF, field curves and focus of each colour.

As the thesis's Fig. 7.2 shows them, for the rig's own colours and the panel's own pixel.
matplotlib draws it; see ``vrlf/studies/plots.py``.
"""

from __future__ import annotations

from math import atan, degrees, hypot, inf
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from vrlf.errors import InputError
from vrlf.optics.lenslet.diffraction import cutoff_per_mm, transfer, wavefront
from vrlf.optics.lenslet.focus import foci
from vrlf.optics.lenslet.paraxial import cardinal
from vrlf.optics.lenslet.report import LensletReport
from vrlf.optics.lenslet.setting import Setting
from vrlf.optics.lenslet.spots import spot
from vrlf.optics.lenslet.trace import Beam
from vrlf.studies.plots import write_figure
from vrlf.units import UM_PER_MM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SIZE_INCHES: Final = (15.0, 9.0)
# Red, green and blue that the colour-blind tell apart (Okabe & Ito 2008), each with its own mark.
_COLOURS: Final = ("#d55e00", "#009e73", "#0072b2")
_MARKS: Final = ("o", "s", "^")
_NAMES: Final = ("red", "green", "blue")
_SPOT_FIELDS: Final = ("axis", "edge", "corner")
_PLACE_NAMES: Final = {"axis": "on the axis", "edge": "at the edge", "corner": "at the corner"}
_SPOT_RAYS: Final = 12
_ROOM: Final = 1.15
_PLACES: Final = 25
_WAVELENGTHS: Final = 60


def plot_lenslet(setting: Setting, report: LensletReport, title: str, path: str | Path) -> None:
    """Draw the picture and write it whole."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=_SIZE_INCHES, layout="constrained")
    grid = figure.add_gridspec(6, 3, width_ratios=(0.8, 1.1, 1.0))
    spots = [figure.add_subplot(grid[2 * row : 2 * row + 2, 0]) for row in range(3)]
    _spots(spots, setting, report)
    for row, field in ((0, "axis"), (1, "edge")):
        _transfer(figure.add_subplot(grid[3 * row : 3 * row + 3, 1]), setting, field)
    _field_curves(figure.add_subplot(grid[:3, 2]), setting, report)
    _chromatic(figure.add_subplot(grid[3:, 2]), setting, report)
    figure.suptitle(title, fontsize="large")
    _legend(figure, setting, report)
    write_figure(figure, path)


def _legend(figure: Figure, setting: Setting, report: LensletReport) -> None:
    """What colours and lines mean, once for all."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    keys: list[Line2D | Patch] = [
        Line2D([], [], color=_COLOURS[c], marker=_MARKS[c], label=_label(setting, c))
        for c in range(3)
    ]
    depth = f"depth of focus about the panel, {report.depth_of_focus_um:.0f} um either way"
    keys += [
        Line2D([], [], color="0.35", linestyle="-", label="tangential; lines across the field"),
        Line2D([], [], color="0.35", linestyle="--", label="sagittal; lines along it"),
        Patch(facecolor="0.92", edgecolor="0.7", label=depth),
    ]
    figure.legend(handles=keys, loc="outside lower center", ncols=6, frameon=False)


def _label(setting: Setting, colour: int) -> str:
    return f"{_NAMES[colour]} {setting.wavelengths_nm[colour]:g} nm"


def _angle_deg(setting: Setting, field: str) -> float:
    return degrees(atan(hypot(*setting.fields[field])))


def _spots(rows: list[Axes], setting: Setting, report: LensletReport) -> None:
    """Spots in micrometres about their green middle, beside diffraction and the pixel."""
    from matplotlib.patches import Circle, Rectangle

    found = [
        [spot(setting.lens, setting.beam(c, f), setting.distance_mm, _SPOT_RAYS) for c in range(3)]
        for f in _SPOT_FIELDS
    ]
    half_um = report.diffraction_um
    for three in found:
        for each in three:
            from_green = each.errors_mm + each.middle_mm - three[1].middle_mm
            half_um = max(half_um, UM_PER_MM * float(np.abs(from_green).max()))
    half_um *= _ROOM
    for axes, field, three in zip(rows, _SPOT_FIELDS, found, strict=True):
        for colour in (2, 1, 0):
            each = three[colour]
            points = UM_PER_MM * (each.errors_mm + each.middle_mm - three[1].middle_mm)
            axes.scatter(
                points[:, 0],
                points[:, 1],
                s=6,
                color=_COLOURS[colour],
                marker=_MARKS[colour],
                linewidths=0,
            )
        axes.add_patch(
            Circle((0, 0), report.diffraction_um, fill=False, linestyle="--", color="0.35")
        )
        pixel = report.pixel_um
        axes.add_patch(Rectangle((-pixel / 2, -pixel / 2), pixel, pixel, fill=False, color="0.6"))
        axes.set(xlim=(-half_um, half_um), ylim=(-half_um, half_um), aspect="equal")
        axes.set_ylabel("um")
        sizes = report.fields[field].rms_um or (inf,) * 3
        axes.set_title(
            f"spots {_PLACE_NAMES[field]}, {_angle_deg(setting, field):.1f} deg\n"
            f"RMS {', '.join(f'{size:.2g}' for size in sizes)} um",
            fontsize="medium",
        )
    rows[-1].set_xlabel(
        f"um; circle: diffraction's first dark, {report.diffraction_um:.1f} um;\n"
        f"the pixel's square is {report.pixel_um:g} um wide"
    )


def _transfer(axes: Axes, setting: Setting, field: str) -> None:
    """The MTF of each colour, both directions, and green light's limit."""
    most = 0.0
    for colour in range(3):
        beam = setting.beam(colour, field)
        front = wavefront(setting.lens, beam, setting.distance_mm)
        most = max(most, float(cutoff_per_mm(front, beam.wavelength_nm).max()))
        found = transfer(front, beam.wavelength_nm)
        if colour == 1:
            best = transfer(front, beam.wavelength_nm, perfect=True)
            axes.plot(
                best.per_mm[0], best.contrast[0], color="0.7", linewidth=4, label="limit, green"
            )
        axes.plot(found.per_mm[1], found.contrast[1], color=_COLOURS[colour])
        if field != "axis":  # on the axis both directions are one
            axes.plot(found.per_mm[0], found.contrast[0], color=_COLOURS[colour], linestyle="--")
    nyquist = 1.0 / (2.0 * setting.pixel_mm)
    axes.axvline(
        nyquist, color="0.5", linestyle=":", label=f"lines one pixel wide, {nyquist:.1f}/mm"
    )
    axes.set(
        xlim=(0, most), ylim=(0, 1.02), xlabel="line pairs per mm on the panel", ylabel="contrast"
    )
    axes.set_title(f"MTF {_PLACE_NAMES[field]}, {_angle_deg(setting, field):.1f} deg")
    axes.legend(frameon=False, fontsize="small")
    _plain(axes)


def _field_curves(axes: Axes, setting: Setting, report: LensletReport) -> None:
    """Foci over the field, from the panel: sagittal and tangential, for each colour."""
    slopes = np.linspace(0.0, hypot(*setting.fields["corner"]), _PLACES)
    angles = np.degrees(np.arctan(slopes))
    for colour in range(3):
        nm = setting.wavelengths_nm[colour]
        ends = [foci(setting.lens, Beam(nm, (0.0, float(s)), setting.object_mm)) for s in slopes]
        for values, dashes in (
            ([e.tangential_mm for e in ends], "-"),
            ([e.sagittal_mm for e in ends], "--"),
        ):
            off_um = UM_PER_MM * (np.array(values) - setting.distance_mm)
            axes.plot(off_um, angles, color=_COLOURS[colour], linestyle=dashes)
    _panel_and_depth(axes, report)
    axes.set(
        ylim=(0, angles[-1]), xlabel="focus behind the panel, um", ylabel="degrees off the axis"
    )
    axes.set_title("field curvature")
    _plain(axes)


def _chromatic(axes: Axes, setting: Setting, report: LensletReport) -> None:
    """The paraxial focus over the wavelength, from the panel."""
    ends = setting.wavelengths_nm
    waves = np.linspace(min(ends), max(ends), _WAVELENGTHS)
    off_um = [_off_um(setting, float(nm)) for nm in waves]
    axes.plot(off_um, waves, color="black")
    for colour, nm in enumerate(ends):
        axes.plot(
            _off_um(setting, nm),
            nm,
            color=_COLOURS[colour],
            marker=_MARKS[colour],
            linestyle="none",
        )
        axes.annotate(
            f"f {report.focal_mm[colour]:.3f} mm",
            (_off_um(setting, nm), nm),
            xytext=(10, 0),
            textcoords="offset points",
            va="center",
        )
    _panel_and_depth(axes, report)
    axes.set(xlabel="focus behind the panel, um", ylabel="wavelength, nm")
    axes.set_title(f"focus of each colour: red {report.chromatic_um:+.0f} um behind blue")
    axes.margins(x=0.15)
    _plain(axes)


def _off_um(setting: Setting, nm: float) -> float:
    image_mm = setting.gap_index * cardinal(setting.lens, nm).image_mm(setting.object_mm)
    return UM_PER_MM * (image_mm - setting.distance_mm)


def _panel_and_depth(axes: Axes, report: LensletReport) -> None:
    """The panel, and a quarter wave's depth of focus about it."""
    depth = report.depth_of_focus_um
    axes.axvspan(-depth, depth, color="0.92", zorder=0)
    axes.axvline(0.0, color="0.6", linewidth=1.0, zorder=1)


def _plain(axes: Axes) -> None:
    axes.grid(color="0.9")
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def check_drawable(setting: Setting) -> None:
    """Make sure that the fields drawn let light through.

    Raises
    ------
    InputError
        If one does not.
    """
    for field in _SPOT_FIELDS:
        try:
            spot(setting.lens, setting.beam(1, field), setting.distance_mm)
        except InputError as error:
            raise InputError(f"{error} (at the {field} of the field)") from None
