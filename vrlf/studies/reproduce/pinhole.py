"""Chapter 7.1: the best pinhole, as an optimum of what is seen with diffraction.

What limits a line seen through one hole of width w is its shadow, M w on the panel, and what
diffraction adds, lambda g / w; M = 1 + g / L for an eye that focuses at L before the hole. They
meet at sqrt(2 lambda g / M) as the thesis's lambda / w and w / 2g do at sqrt(2 lambda g): its
case is an eye that sees far, M = 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Any, Final

import numpy as np

from vrlf.model import Rig, rig_from_tables
from vrlf.optics.polynomial import Float
from vrlf.optics.tracing import Tracing
from vrlf.renderer import GpuRenderer
from vrlf.studies.reproduce.drawing import BLACK, BLUE, RED, blank_figure, figure_png
from vrlf.studies.reproduce.item import Item, Number, Picture, Workbench
from vrlf.units import NM_PER_MM, UM_PER_MM

NM: Final = 545.0
GAP_MM: Final = 6.0
THESIS_HOLE_UM: Final = 75.0
ACRYLIC: Final = 1.49
RAYS: Final = 160
# Holes that are tried, in parts of the one that the formula gives.
TRIED: Final = (0.6, 0.78, 0.9, 1.02, 1.14, 1.35, 1.75)
_SHADOWED: Final = slice(None, None, 3)
# Pixels much finer than any hole, so that they blur nothing.
_PX_MM: Final = 0.01
_WIDTH_PX, _HEIGHT_PX = 60, 30
# The rows that see all but 2 % of the column's light.
_MIDDLE_ROWS: Final = slice(10, 20)


@dataclass(frozen=True)
class Eye:
    """An eye before a mask of which it sees one hole at a time.

    Attributes
    ----------
    words : str
    headset, eye : dict
        Tables of the rig.
    pitch_um : float
        Of the mask, wider than the pupil's image on it.
    scale : float
        M, a hole's shadow on the panel over the hole.
    seen : float
        Panel millimetres per retinal one, through one hole.
    """

    words: str
    headset: dict[str, float]
    eye: dict[str, float]
    pitch_um: float
    scale: float
    seen: float

    @property
    def best_um(self) -> float:
        """sqrt(2 lambda g / M)."""
        return UM_PER_MM * sqrt(2.0 * NM / NM_PER_MM * GAP_MM / abs(self.scale))


# No lens, an eye that sees far: y = X/7 + u, x = X + u, through the hole at 0 x = 6/7 X.
FAR: Final = Eye(
    "sees far, no lens: the thesis's case",
    {"lens_to_panel_mm": 7.0, "lens_power_d": 0.0},
    {"sphere_d": 0.0, "pupil_mm": 0.34},
    pitch_um=300.0,
    scale=1.0,
    seen=6.0 / 7.0,
)
# -5 D at 46 mm: y = 40/46 X + phi u, phi = 1 - 40/46 - 0.2, x = X - 0.23 u, M = -0.23 / phi.
_MYOPES_SCALE: Final = -0.23 / (1.0 - 40.0 / 46.0 - 0.2)
MYOPE: Final = Eye(
    "-5 D behind the headset's lens",
    {"lens_to_panel_mm": 46.0},
    {"sphere_d": -5.0, "pupil_mm": 4.6},
    pitch_um=330.0,
    scale=_MYOPES_SCALE,
    seen=1.0 - 40.0 / 46.0 * _MYOPES_SCALE,
)


def mask_rig(eye: Eye, hole_um: float) -> Rig:
    """A square hole on the left eye's axis before a panel of fine pixels."""
    width_mm = _WIDTH_PX * _PX_MM
    person = eye.eye | {"vertex_mm": 0.0}
    tables: dict[str, Any] = {
        "panel": {
            "width_px": 2 * _WIDTH_PX,
            "height_px": _HEIGHT_PX,
            "pixel_pitch_um": UM_PER_MM * _PX_MM,
            "subpixels": "full",
            "wavelengths_nm": [NM, NM, NM],
        },
        "headset": eye.headset | {"lens_separation_mm": width_mm},
        "array": {
            "kind": "pinhole",
            "pitch_um": eye.pitch_um,
            "gap_mm": GAP_MM,
            "aperture_um": hole_um,
            "offset_um": [-UM_PER_MM * width_mm / 2.0, 0.0],
        },
        "left": person,
        "right": person,
    }
    return rig_from_tables(tables, source=f"a hole of {hole_um:g} um")


def line_width_um(renderer: GpuRenderer, eye: Eye, hole_um: float, *, diffraction: bool) -> float:
    """How wide a lit panel column of 20 um is seen: what holds half its light, on the panel."""
    lit = slice(_WIDTH_PX // 2 - 1, _WIDTH_PX // 2 + 1)
    panel = np.zeros((_HEIGHT_PX, 2 * _WIDTH_PX, 3), np.float32)
    panel[:, lit] = 1.0
    seen = renderer.perceive(
        panel,
        mask_rig(eye, hole_um),
        rays=RAYS,
        exposure="none",
        tracing=Tracing(diffraction=diffraction),
    )
    light = seen[_MIDDLE_ROWS, :_WIDTH_PX, 1].mean(axis=0).astype(np.float64)
    x_mm = (np.arange(_WIDTH_PX) + 0.5 - _WIDTH_PX / 2.0) * _PX_MM * abs(eye.seen)
    near = np.abs(x_mm) <= 0.25
    return UM_PER_MM * half_width(x_mm[near], light[near])


def half_width(x: Float, light: Float) -> float:
    """The least interval that holds half of the light of equal cells about ascending x."""
    step = x[1] - x[0]
    edges = np.concatenate([x - step / 2.0, [x[-1] + step / 2.0]])
    held = np.concatenate([[0.0], np.cumsum(light)]) / light.sum()
    share = np.linspace(0.0, 0.5, 2001)
    return float((np.interp(share + 0.5, held, edges) - np.interp(share, held, edges)).min())


def best_of(hole_um: Float, width_um: Float) -> float:
    """Where a parabola through the least value and two neighbours on each side has its least."""
    middle = int(np.argmin(width_um))
    part = slice(max(0, middle - 2), middle + 3)
    a, b, _ = np.polyfit(hole_um[part], width_um[part], 2)
    return float(-b / (2.0 * a))


@dataclass(frozen=True)
class Found:
    """Widths of a line through all holes tried; through some without diffraction too."""

    hole_um: Float
    width_um: Float
    shadowed_um: Float
    shadow_um: Float

    @property
    def best_um(self) -> float:
        """The hole through which the line is narrowest."""
        return best_of(self.hole_um, self.width_um)


def search(renderer: GpuRenderer, eye: Eye, tried: tuple[float, ...] = TRIED) -> Found:
    """Try holes about the one that the formula gives."""
    holes = np.round(eye.best_um * np.array(tried), 2)
    widths = [line_width_um(renderer, eye, each, diffraction=True) for each in holes]
    shadowed = holes[_SHADOWED]
    shadows = [line_width_um(renderer, eye, each, diffraction=False) for each in shadowed]
    return Found(holes, np.array(widths), shadowed, np.array(shadows))


def make(bench: Workbench) -> Item:
    """The item."""
    found = {}
    for eye in (FAR, MYOPE):
        bench.say(f"pinhole-7-1: {eye.words}, {len(TRIED)} holes")
        found[eye.words] = search(bench.renderer, eye)
    far, myope = found.values()
    chosen = float(np.interp(THESIS_HOLE_UM, far.hole_um, far.width_um) / far.width_um.min() - 1.0)
    solid_um = FAR.best_um / sqrt(ACRYLIC)
    numbers = (
        Number("best hole, eye that sees far, simulated", "um", far.best_um, FAR.best_um, _FAR_WHY),
        Number(
            "best hole, -5 D in a headset, simulated",
            "um",
            myope.best_um,
            FAR.best_um,
            _MYOPE_WHY,
        ),
        Number("the same by sqrt(2 lambda g / M)", "um", MYOPE.best_um, FAR.best_um, "M = 3.31."),
        Number(
            "best hole for 6 mm of solid acrylic",
            "um",
            solid_um,
            FAR.best_um,
            "Its reduced gap is 6 / 1.49 = 4.03 mm; that counts for diffraction as for rays.",
        ),
        Number(
            "what 75 um cost against the best, eye that sees far",
            "%",
            100.0 * chosen,
            None,
            "The optimum is flat: 75 um is well chosen for the thesis's own case.",
        ),
        Number(
            "light through the best hole for -5 D, pitch 390 um",
            "%",
            100.0 * (MYOPE.best_um / 390.0) ** 2,
            100.0 * (THESIS_HOLE_UM / 390.0) ** 2,
            "The sharper hole costs two thirds of what 75 um lets through.",
        ),
    )
    return Item(
        "pinhole-7-1",
        "7.1: the best pinhole",
        "Diffraction (lambda / p) and the hole's own size (p / 2t) meet at p = sqrt(2 lambda t); "
        "75 um for 5.4 and 6 mm.",
        "For an eye that sees far the simulation has its optimum there. The wearer's is another: a "
        "-5 D eye focuses 2.6 mm before the mask, so that a hole's shadow on the panel is "
        f"M = 1 + 6 / 2.6 = 3.31 times as wide, and the best hole sqrt(M) smaller, "
        f"{MYOPE.best_um:.0f} um; the formula leaves the eye's focus out. Solid acrylic of 6 mm "
        f"wants {solid_um:.0f} um.",
        numbers,
        (
            Picture(
                "pinhole-7-1.png",
                f"How wide a fine line is seen; 545 nm, gap 6 mm, {RAYS} rays a pixel.",
                _draw(found),
            ),
        ),
    )


_FAR_WHY: Final = "A flat optimum: a parabola through noisy widths finds it within some 10 %."
_MYOPE_WHY: Final = (
    "The thesis's formula is for parallel light; an eye that focuses at L before the mask has "
    "sqrt(2 lambda g / (1 + g / L))."
)


def _draw(found: dict[str, Found]) -> bytes:
    figure = blank_figure(12.0, 4.8)
    thesis = f"sqrt(2 lambda t), {FAR.best_um:.0f} um (thesis)"
    for axes, eye in zip(figure.subplots(1, 2), (FAR, MYOPE), strict=True):
        each = found[eye.words]
        axes.plot(each.hole_um, each.width_um, "o-", color=BLACK, label="simulated, diffraction in")
        axes.plot(each.shadowed_um, each.shadow_um, "s:", color="0.5", label="shadows alone")
        axes.axvline(FAR.best_um, color=RED, label=thesis)
        if eye is not FAR:
            words = f"sqrt(2 lambda t / M), {eye.best_um:.0f} um"
            axes.axvline(eye.best_um, color=BLUE, linestyle="--", label=words)
        axes.axvline(THESIS_HOLE_UM, color="0.6", linestyle=":", label="75 um, the prototype's")
        axes.set_xlabel("side of the square hole, um")
        axes.set_ylabel("half-light width of a 20 um line, um on the panel")
        axes.set_ylim(bottom=0.0)
        axes.margins(x=0.08)
        axes.set_title(eye.words)
        axes.grid(color="0.9")
        axes.legend(frameon=False, fontsize="small", loc="lower right")
    return figure_png(figure)
