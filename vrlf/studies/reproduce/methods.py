"""Forward against optimal, pinholes against lenslets, and the brightness that each leaves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from vrlf.evaluation.measure import border_px, likeness
from vrlf.model import Rig, load_rig
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.lattice import lattice_of
from vrlf.optics.viewport import viewport
from vrlf.renderer import Image, bare_rig, exposure_factor
from vrlf.scene import luminance
from vrlf.studies.quality import CROP_PX, cropped, with_method
from vrlf.studies.reproduce.drawing import BLUE, GREEN, RED, blank_figure, figure_png, shown
from vrlf.studies.reproduce.item import Item, Number, Picture, Workbench
from vrlf.studies.reproduce.samplings import OPTIMAL_STEPS
from vrlf.units import MM_PER_M

# Rays that judge each rig: holes let few of them through.
RIGS: Final = {
    "thesis-minus-5d": 512,
    "pinhole": 1024,
    "matched-microlens": 512,
    "matched-full": 256,
    "matched-wide": 256,
}
# Arrays of the thesis's own sizes.
_THESIS: Final = ("thesis-minus-5d", "pinhole")
METHODS: Final = ("uncorrected", "forward", "optimal")
_CUT: Final = (slice(50, 170), slice(50, 170))


@dataclass(frozen=True)
class Shown:
    """One rig and method: how near, how bright, with which noise, and what it looks like.

    ``light`` is what reaches the eye over what the bare panel sends it.
    """

    psnr_db: float
    ssim: float | None
    light: float
    noise: float
    seen: Image


def shown_by(bench: Workbench, rig: Rig, rays: int) -> dict[str, Shown]:
    """The scene, by each method, as the left eye sees it."""
    target = bench.target("scene", rig)
    found, plain = {}, target
    for method in METHODS:
        bare = method == "uncorrected"
        steps = OPTIMAL_STEPS if method == "optimal" else 0
        told = bare_rig(rig) if bare else with_method(rig, method, steps)
        panel = target if bare else bench.renderer.prefilter(target, told)
        seen, noise = bench.renderer.perceive_with_error(panel, told, rays=rays)
        near = likeness(seen, target, rig, "left")
        plain = seen if bare else plain
        light = light_of(seen, plain, rig) / exposure_factor(told, "auto")
        half = np.ascontiguousarray(seen[:, viewport(rig, "left").columns])
        found[method] = Shown(near.psnr_db, near.ssim, light, noise, half)
    return found


def light_of(seen: Image, plain: Image, rig: Rig) -> float:
    """Mean luminance of one picture over another's, inside the left eye's border."""
    border, columns = border_px(rig, "left"), viewport(rig, "left").columns
    inner = (slice(border, -border), slice(border, -border))
    one, other = (
        float(luminance(each[:, columns][inner].astype(np.float64)).mean())
        for each in (seen, plain)
    )
    return one / other


def make(bench: Workbench) -> Item:
    """The item."""
    found: dict[str, dict[str, Shown]] = {}
    numbers = []
    for name, rays in RIGS.items():
        bench.say(f"methods: {name}, {rays} rays a pixel")
        rig = cropped(load_rig(name), CROP_PX)
        found[name] = shown_by(bench, rig, rays)
        numbers += _numbers(name, rig, found[name])
    names = ("thesis-minus-5d", "pinhole", "matched-microlens")
    thesis, holes, matched = (found[name] for name in names)
    return Item(
        "methods",
        "Forward and optimal, pinholes and lenslets, brightness",
        "Lenslets do away with the pinholes' loss of light and keep resolution and contrast high; "
        "forward keeps considerable quality of the projection matrix that was given up for speed.",
        "Lenslets do keep the light: all of it, where holes leave "
        f"{100.0 * holes['forward'].light:.1f} %. Sharp is another matter. Lenslets whose focal "
        "length is the gap image the panel at infinity, where no -5 D eye looks: forward gains "
        f"{_gain(thesis, 'forward'):+.1f} dB over the bare panel, optimal "
        f"{_gain(thesis, 'optimal'):+.1f}. Holes bring a -5 D eye "
        f"{_gain(holes, 'forward'):+.1f} dB with forward and {_gain(holes, 'optimal'):+.1f} with "
        "optimal: it focuses 2.6 mm before "
        f"the mask, where its beam is {beam_at_array_mm():.2f} mm wide, hardly a pitch, and so "
        "sees the mask itself, dark dots that no panel image lights. (The stronger myope of "
        "Fig. 8.4 does not.) Lenslets that image the panel onto the eye's own plane of focus bring "
        f"{_gain(matched, 'optimal'):+.1f} dB with optimal and {_gain(matched, 'forward'):+.1f} "
        "with forward, which leaves black what its samples miss, and with it some of the light.",
        tuple(numbers),
        (
            Picture(
                "methods.png",
                "Part of what the left eye sees, exposed alike; below, sharpness against light.",
                _draw(found),
            ),
        ),
    )


def _gain(methods: dict[str, Shown], method: str) -> float:
    return methods[method].psnr_db - methods["uncorrected"].psnr_db


def beam_at_array_mm() -> float:
    """How wide a retinal point's beam is where it crosses the thesis's array, -5 D."""
    rig = load_rig("thesis-minus-5d")
    bench, optics = bench_of(rig), eye_optics(rig, "left")
    error_per_mm = float(optics.matrix_d[0, 0]) / MM_PER_M
    factor = bench.array_defocus_factor + bench.array_per_slope_mm * error_per_mm
    return optics.pupil_mm * abs(factor)


def _numbers(name: str, rig: Rig, found: dict[str, Shown]) -> list[Number]:
    lattice = lattice_of(rig)
    assert lattice is not None
    numbers = []
    for method, each in found.items():
        similar = "" if each.ssim is None else f"SSIM {each.ssim:.3f}, "
        told = f"{similar}the judge's noise {each.noise:.4f}."
        numbers.append(Number(f"PSNR, {name}, {method}", "dB", each.psnr_db, None, told))
    for method in METHODS[1:]:
        nit = rig.panel.peak_nit * min(1.0, found[method].light)
        numbers.append(
            Number(
                f"light left, {name}, {method}",
                "%",
                100.0 * found[method].light,
                100.0 * lattice.throughput if name in _THESIS else None,
                f"White is some {nit:.0f} cd/m^2 of the panel's {rig.panel.peak_nit:g}; "
                f"{100.0 * lattice.throughput:.3g} % of the array is open.",
            )
        )
    return numbers


def _draw(found: dict[str, dict[str, Shown]]) -> bytes:
    figure = blank_figure(2.7 * len(found), 13.0)
    parts: Any = figure.subfigures(2, 1, height_ratios=(2.4, 1.0))
    top, bottom = parts
    grid = top.subplots(len(METHODS), len(found))
    for column, (name, methods) in enumerate(found.items()):
        for row, (method, each) in enumerate(methods.items()):
            axes = grid[row][column]
            axes.imshow(shown(each.seen[_CUT]), interpolation="nearest")
            axes.set_title(f"{name}\n{method}: {each.psnr_db:.1f} dB", fontsize="small")
            axes.set_axis_off()
    axes = bottom.subplots(1, 1)
    for method, colour, mark in (("forward", BLUE, "o"), ("optimal", GREEN, "s")):
        x = [100.0 * each[method].light for each in found.values()]
        gain = [each[method].psnr_db - each["uncorrected"].psnr_db for each in found.values()]
        axes.plot(x, gain, mark, color=colour, markersize=8, label=method)
        for number, (name, at, db) in enumerate(zip(found, x, gain, strict=True)):
            side = (8, "left") if at < 20.0 else (-8, "right")
            axes.annotate(
                name,
                (at, db),
                (side[0], -6 if method == "optimal" and number % 2 else 6),
                textcoords="offset points",
                fontsize="small",
                ha=side[1],
                va="center",
            )
    axes.axhline(0.0, color=RED, linewidth=1, label="no gain")
    axes.set_xlabel("light left, % of the bare panel's")
    axes.set_ylabel("PSNR gained over the bare panel, dB")
    axes.grid(color="0.9")
    axes.legend(frameon=False, loc="center")
    return figure_png(figure)
