"""Table 8.1: the prototype's distances, and what follows from them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from vrlf.model import Rig, load_rig
from vrlf.optics.inspect import array_numbers, eye_numbers
from vrlf.studies.reproduce.drawing import BLUE, GREEN, RED, blank_figure, figure_png
from vrlf.studies.reproduce.item import Item, Number, Picture, Workbench
from vrlf.units import MM_PER_M

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PANEL_MM: Final = 46.0
FOCUS_MM: Final = 33.0
SPHERE_D: Final = -5.0
ACRYLIC: Final = 1.49


def focus_mm(panel_mm: float, sphere_d: float) -> float:
    """T 8.4: where an eye before the panel at the lens's focus sees sharp, in front of the lens."""
    return panel_mm / (1.0 - panel_mm * sphere_d / MM_PER_M)


def sphere_of(panel_mm: float, focus: float) -> float:
    """The error for which T 8.4 gives that plane of focus."""
    return MM_PER_M * (1.0 / panel_mm - 1.0 / focus)


def numbers_of(air: Rig, solid: Rig) -> tuple[Number, ...]:
    """From the rigs of the table with 6 mm of air and of acrylic."""
    plate, gap = array_numbers(solid), array_numbers(air)
    return (
        Number(
            "panel from the lens, d_ed",
            "mm",
            PANEL_MM,
            FOCUS_MM,
            "The table swaps d_ef and d_ed: a myope's plane of focus lies before the panel.",
        ),
        Number(
            "plane of focus of -5 D, d_ef",
            "mm",
            focus_mm(PANEL_MM, SPHERE_D),
            FOCUS_MM,
            "T 8.4: 46 / (1 + 5 * 0.046). (As the table prints them, 33 mm would give 28.3 mm.)",
        ),
        Number(
            "eye for which the pair 46, 33 mm holds",
            "D",
            sphere_of(PANEL_MM, FOCUS_MM),
            SPHERE_D,
            "1000 (1/46 - 1/33): what was photographed is a stronger myope than stated.",
        ),
        Number(
            "focus of that eye, by inspect",
            "mm",
            eye_numbers(air, "left")["focus_distance_mm"],
            FOCUS_MM,
            "The rig thesis-table-8-1 keeps the pair of distances.",
        ),
        Number(
            "reduced gap of the 6 mm acrylic plate",
            "mm",
            plate["reduced_gap_mm"],
            6.0,
            "A ray in acrylic is 1.49 times as steep outside: t / n counts, not t.",
        ),
        Number(
            "eyebox, 6 mm of air", "mm", gap["eyebox_mm"], 6.0, "pitch * d / g = 0.39 * 46 / 6."
        ),
        Number(
            "eyebox, the plate as it is",
            "mm",
            plate["eyebox_mm"],
            6.0,
            "0.39 * 44.03 / 4.03. Either way a 6 mm pupil sees a pixel through several holes.",
        ),
        Number(
            "uncorrected blur of that eye",
            "pixels",
            eye_numbers(air, "left")["blur_px"],
            None,
            "a d |R| / 1000 over the pitch of 78 um.",
        ),
        Number(
            "light through the mask",
            "%",
            100.0 * float(gap["throughput"] or 0.0),
            None,
            "(75 / 390)^2; the thesis exposed for 2 s.",
        ),
    )


def make(bench: Workbench) -> Item:  # noqa: ARG001  every item is made with one
    """The item."""
    air = load_rig("thesis-table-8-1")
    solid = load_rig("thesis-table-8-1", overrides=[f"array.gap_index={ACRYLIC}"])
    return Item(
        "table-8-1",
        "Table 8.1: the prototype's set-up",
        "t = 6 mm, d_ef = 46 mm, d_ed = 33 mm for a -5.00 D eye; p = 75 um, i = 390 um; a = 6 mm, "
        "which equals the eyebox.",
        "d_ef and d_ed are swapped; -5 D at 46 mm focuses at 37.4 mm, and 33 mm is the plane of "
        "focus of -8.56 D; the plate is a reduced gap of 4.03 mm; the eyebox is 3.0 mm (4.3 mm "
        "with the plate as it is), half the pupil and not equal to it, so that every pixel is seen "
        "through about two holes each way: crosstalk that the forward prefilter does not know of.",
        numbers_of(air, solid),
        (Picture("table-8-1.png", "The table as printed, and as it can be meant.", _draw()),),
    )


def _draw() -> bytes:
    figure = blank_figure(11.0, 6.5)
    cases = (
        ("as printed", FOCUS_MM, PANEL_MM, None),
        ("swap undone, the pair kept: -8.56 D", PANEL_MM, FOCUS_MM, 6.0),
        ("-5 D at 46 mm", PANEL_MM, focus_mm(PANEL_MM, SPHERE_D), 6.0),
    )
    for axes, case in zip(figure.subplots(len(cases), 1, sharex=True), cases, strict=True):
        _bench(axes, *case)
    axes.set_xlabel("mm before the headset's lens")
    figure.suptitle("The rays that an eye brings together, back from its 6 mm pupil to the panel")
    return figure_png(figure)


def _bench(axes: Axes, title: str, panel_mm: float, focus: float, gap_mm: float | None) -> None:
    """Lens, plane of focus, array and panel; the rays of a point that the eye sees sharp."""
    axes.axvline(0.0, color="0.4", linewidth=5, alpha=0.4)
    axes.text(0.3, 3.2, "lens and pupil", fontsize="small", color="0.3")
    for at_mm, colour, name in ((focus, GREEN, "plane of focus"), (panel_mm, BLUE, "panel")):
        axes.axvline(at_mm, color=colour, linewidth=2)
        shift_mm, side = (0.3, "left") if at_mm == max(focus, panel_mm) else (-0.3, "right")
        label = f"{name} {at_mm:.1f} mm"
        axes.text(at_mm + shift_mm, 3.2, label, fontsize="small", color=colour, ha=side)
    if gap_mm is not None:
        array_mm = panel_mm - gap_mm
        axes.axvline(array_mm, color=RED, linestyle=(0, (2, 2)), linewidth=2)
        axes.text(array_mm + 0.3, -3.8, f"array {array_mm:.0f} mm", fontsize="small", color=RED)
    for u_mm in (-3.0, -1.5, 0.0, 1.5, 3.0):
        far = u_mm * (1.0 - panel_mm / focus)
        axes.plot([0.0, focus, panel_mm], [u_mm, 0.0, far], color="0.6", linewidth=0.8)
    axes.set_ylim(-4.2, 4.2)
    axes.set_xlim(-1.0, 60.0)
    axes.set_ylabel("mm")
    axes.set_title(title, fontsize="medium", loc="left")
