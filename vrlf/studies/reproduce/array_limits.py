"""Chapter 4.3: the limits of the array, and gratings on either side of its Nyquist limit."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan, degrees, pi
from typing import Final

import numpy as np

from vrlf.evaluation.measure import border_px
from vrlf.model import Rig, load_rig
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.limits import array_limits, signed_focus_mm
from vrlf.optics.viewport import pitch_mm, viewport
from vrlf.renderer import Image, bare_rig
from vrlf.studies.quality import cropped, with_method
from vrlf.studies.reproduce.drawing import BLACK, BLUE, GREEN, RED, blank_figure, figure_png
from vrlf.studies.reproduce.item import Item, Number, Picture, Workbench
from vrlf.studies.reproduce.samplings import OPTIMAL_STEPS

# The thesis's array: pixel pitch, lenslet pitch, gap (chapters 4.2 and 7.2).
PITCH_MM: Final = 0.078
LENSLET_MM: Final = 0.39
GAP_MM: Final = 6.0
ACRYLIC: Final = 1.49
RIGS: Final = ("thesis-minus-5d", "matched-full")
# Cycles per millimetre of the panel; the array's own limit is 1.28, the panel's 6.41.
CYCLES_PER_MM: Final = (0.4, 0.8, 1.28, 1.8, 2.56, 4.0)
_PANEL_PX: Final = (280, 140)
_RAYS: Final = 256
_DEPTH: Final = 0.8


@dataclass(frozen=True)
class Contrast:
    """How much of a grating is seen, and what else is.

    Attributes
    ----------
    kept : float
        Its modulation over what was meant; 1 is all.
    spurious : float
        RMS of all else over the grating's own, as meant.
    """

    kept: float
    spurious: float


def grating(rig: Rig, cycles_per_mm: float) -> Image:
    """A grey grating that varies along y, about the mean 1/2; (H, W, 3)."""
    height, width = rig.panel.height_px, rig.panel.width_px
    y_mm = (np.arange(height) + 0.5) * pitch_mm(rig)
    column = 0.5 + 0.5 * _DEPTH * np.cos(2.0 * pi * cycles_per_mm * y_mm)
    return np.broadcast_to(column[:, None, None], (height, width, 3)).astype(np.float32)


def contrast_of(seen: Image, rig: Rig, cycles_per_mm: float) -> Contrast:
    """What the left eye sees of a grating, in green, inside the border."""
    border = border_px(rig, "left")
    half = seen[:, viewport(rig, "left").columns, 1].astype(np.float64)
    inner = half[border : half.shape[0] - border, border : half.shape[1] - border]
    y_mm = (np.arange(border, border + inner.shape[0]) + 0.5) * pitch_mm(rig)
    phase = 2.0 * pi * cycles_per_mm * y_mm
    basis = np.stack([np.ones_like(phase), np.cos(phase), np.sin(phase)], axis=-1)
    fit = np.linalg.lstsq(basis, inner, rcond=None)[0].mean(axis=1)
    rest = inner - (basis @ fit)[:, None]
    kept = float(np.hypot(fit[1], fit[2]) / fit[0])
    meant = _DEPTH / np.sqrt(2.0)
    return Contrast(kept / _DEPTH, float(np.sqrt(np.mean(rest**2)) / fit[0] / meant))


def curves(bench: Workbench, rig: Rig) -> dict[str, list[Contrast]]:
    """For the bare panel and both prefilters, a contrast at each frequency."""
    found: dict[str, list[Contrast]] = {"uncorrected": [], "forward": [], "optimal": []}
    for cycles in CYCLES_PER_MM:
        target = grating(rig, cycles)
        for method, results in found.items():
            steps = OPTIMAL_STEPS if method == "optimal" else 0
            bare = method == "uncorrected"
            told = with_method(rig, method, steps) if not bare else bare_rig(rig)
            panel = target if bare else bench.renderer.prefilter(target, told)
            seen = bench.renderer.perceive(panel, told, rays=_RAYS)
            results.append(contrast_of(seen, rig, cycles))
    return found


def limit_numbers() -> tuple[Number, ...]:
    """The thesis's formulas, with its own gap and with the acrylic's reduced one."""
    air = array_limits(load_rig("thesis-minus-5d"))
    solid = array_limits(load_rig("thesis-minus-5d", overrides=[f"array.gap_index={ACRYLIC}"]))
    assert air is not None
    assert solid is not None
    step = degrees(PITCH_MM / GAP_MM)
    return (
        Number(
            "field of view of a lenslet, T 4.1",
            "deg",
            air.field_of_view_deg,
            degrees(2.0 * atan(LENSLET_MM / 2.0 / GAP_MM)),
            f"In air. Behind 6 mm of acrylic it is {solid.field_of_view_deg:.2f} degrees.",
        ),
        Number("views", "", air.views, LENSLET_MM / PITCH_MM, "One lenslet over 5 pixels."),
        Number(
            "spatial Nyquist limit 1/2D",
            "1/mm",
            air.spatial_nyquist_per_mm,
            1.0 / (2.0 * LENSLET_MM),
            "Of a picture in the array's own plane; see the gratings for the eye's.",
        ),
        Number(
            "angular step p/g",
            "deg",
            step,
            step,
            f"Angles up to g / 2p = {GAP_MM / (2.0 * PITCH_MM):.1f} cycles a radian.",
        ),
        Number(
            "depth of field D g / p",
            "mm",
            air.depth_of_field_mm,
            LENSLET_MM * GAP_MM / PITCH_MM,
            "From the array: there a pixel's beam is as wide as a lenslet. With acrylic "
            f"{solid.depth_of_field_mm:.1f} mm.",
        ),
        Number(
            "array to the plane of focus, -5 D",
            "mm",
            _array_to_focus_mm(),
            None,
            "Well within the depth of field: it is not what limits this correction.",
        ),
        Number(
            "eyebox D m / g", "mm", air.eyebox_mm, 6.0, "8.4 calls 6 mm the eyebox; 0.39 * 46 / 6."
        ),
    )


def _array_to_focus_mm() -> float:
    rig = load_rig("thesis-minus-5d")
    bench = bench_of(rig)
    return bench.lens_to_array_mm - signed_focus_mm(bench, eye_optics(rig, "left"))


def make(bench: Workbench) -> Item:
    """The item."""
    numbers, found = list(limit_numbers()), {}
    for name in RIGS:
        bench.say(f"limits-4-3: gratings, {name}")
        found[name] = curves(bench, cropped(load_rig(name), _PANEL_PX))
        for index, cycles in enumerate(CYCLES_PER_MM):
            for method in ("uncorrected", "forward", "optimal"):
                each = found[name][method][index]
                beyond = " (beyond 1/2D)" if cycles > 1.0 / (2.0 * LENSLET_MM) else ""
                numbers.append(
                    Number(
                        f"contrast kept, {name}, {method}, {cycles:g} per mm{beyond}",
                        "",
                        each.kept,
                        None,
                        f"All else that is seen: {each.spurious:.2f} of the grating as meant.",
                    )
                )
    best = found["matched-full"]["optimal"][CYCLES_PER_MM.index(1.8)].kept
    return Item(
        "limits-4-3",
        "4.3: limits of the array",
        "D/p views, finest detail 1/2D (anything finer than 2D aliases), field of view "
        "2 atan(D / 2f), depth of field D over the angular step.",
        "The formulas are ours too. But 1/2D is the limit of a picture in the array's plane. The "
        "eye focuses elsewhere, where the beams of neighbouring lenslets' pixels fall between each "
        f"other, and with a matched array the optimal prefilter keeps {best:.0%} of a grating of "
        "1.8 per mm, beyond that limit. In the thesis's headset each pixel is seen through several "
        "lenslets at once: forward keeps little, and at 1.8 per mm more of what aliases than of "
        "the grating, as the thesis warns.",
        tuple(numbers),
        (
            Picture(
                "limits-4-3.png",
                f"Gratings along y as the left eye sees them, green, {_RAYS} rays a pixel.",
                _draw(found),
            ),
        ),
    )


def _draw(found: dict[str, dict[str, list[Contrast]]]) -> bytes:
    figure = blank_figure(12.0, 5.0)
    colours = {"uncorrected": BLACK, "forward": BLUE, "optimal": GREEN}
    for axes, (name, methods) in zip(
        figure.subplots(1, 2, sharey=True), found.items(), strict=True
    ):
        for method, each in methods.items():
            colour = colours[method]
            axes.plot(CYCLES_PER_MM, [c.kept for c in each], "o-", color=colour, label=method)
            rest = [c.spurious for c in each]
            axes.plot(CYCLES_PER_MM, rest, "x:", color=colour, label=f"all else, {method}")
        axes.axvline(1.0 / (2.0 * LENSLET_MM), color=RED, label="1/2D (thesis)")
        axes.axvline(1.0 / (2.0 * PITCH_MM), color="0.6", linestyle="--", label="1/2p, the panel's")
        axes.set_xscale("log")
        axes.set_xticks(CYCLES_PER_MM, [f"{each:g}" for each in CYCLES_PER_MM])
        axes.minorticks_off()
        axes.set_xlabel("cycles per mm of the panel")
        axes.set_title(name)
        axes.grid(color="0.9")
    axes.legend(frameon=False, fontsize="small", loc="upper right")
    figure.axes[0].set_ylabel("contrast over what was meant")
    return figure_png(figure)
