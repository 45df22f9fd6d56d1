"""Fig. 6.2: what is perceived with and without pre-sharpening, and where the difference is seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from vrlf.evaluation.hdrvdp import HdrVdp, hdr_vdp
from vrlf.evaluation.measure import Likeness, border_px, likeness
from vrlf.model import Rig, load_rig
from vrlf.optics.inspect import display_numbers
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import viewport
from vrlf.renderer import Image, bare_rig
from vrlf.scene import luminance
from vrlf.studies.quality import CROP_PX, cropped, with_method
from vrlf.studies.reproduce.drawing import blank_figure, figure_png, shown
from vrlf.studies.reproduce.item import Item, Number, Picture, Workbench

# The thesis's array, and one with which sharpening has more to work on.
RIGS: Final = {"thesis-minus-5d": 1024, "matched-full": 512}
SOURCE: Final = "scene"
# HDR-VDP-2's ``s_map`` is a ratio to the threshold raised to that.
_PSYCHOMETRIC_SLOPE: Final = 3.5
_TIMES_SHOWN: Final = 8.0
_SHARPENED: Final = "forward, pre-sharpened"


@dataclass(frozen=True)
class Look:
    """One way to show the scene, as the left eye sees it, inside the border.

    ``detected`` is the probability of seeing a difference at each pixel, ``times`` how many times
    above its threshold it is, both (h, w); ``at_edges`` and ``on_even_ground`` the median of
    ``times`` over the third of the pixels where the target changes most, and least.
    """

    near: Likeness
    seen: Image
    detected: Float
    times: Float
    q_mos: float
    at_edges: float
    on_even_ground: float


def ways(rig: Rig) -> dict[str, Rig | None]:
    """What is told to the prefilter; None is the bare panel."""
    return {
        "uncorrected": None,
        "forward": with_method(rig, "forward"),
        _SHARPENED: with_method(rig, "forward", wiener=True),
    }


def looks(bench: Workbench, rig: Rig, rays: int) -> dict[str, Look]:
    """Each way's look against the target, at the panel's own luminance."""
    target = bench.target(SOURCE, rig)
    found = {}
    for words, told in ways(rig).items():
        panel = target if told is None else bench.renderer.prefilter(target, told)
        seen = bench.renderer.perceive(panel, told or bare_rig(rig), rays=rays)
        near = likeness(seen, target, rig, "left")
        test, reference = (_inner(each, rig) for each in (near.gain * seen, target))
        bench.say(f"fig-6-2: detection map, {words}")
        seen_map = detection(test, reference, rig)
        times = seen_map.s_map ** (1.0 / _PSYCHOMETRIC_SLOPE)
        by_place = by_edges(times, reference)
        found[words] = Look(near, test, seen_map.p_map, times, seen_map.q_mos, *by_place)
    return found


def by_edges(values: Float, reference: Image) -> tuple[float, float]:
    """Median over the third of the pixels where a picture changes most, and least."""
    change = np.hypot(*np.gradient(luminance(reference.astype(np.float64))))
    low, high = np.quantile(change, (1.0 / 3.0, 2.0 / 3.0))
    return float(np.median(values[change >= high])), float(np.median(values[change <= low]))


def detection(test: Image, reference: Image, rig: Rig) -> HdrVdp:
    """HDR-VDP-2 of two pictures (h, w, 3), linear light, shown at the panel's peak luminance."""
    ppd = display_numbers(rig)["pixels_per_degree"]
    assert ppd is not None
    nit = rig.panel.peak_nit
    one, other = (
        nit * luminance(np.clip(each, 0.0, None).astype(np.float64)) for each in (test, reference)
    )
    return hdr_vdp(one, other, ppd)


def _inner(light: Image, rig: Rig) -> Image:
    border = border_px(rig, "left")
    half = light[:, viewport(rig, "left").columns]
    return np.ascontiguousarray(half[border:-border, border:-border])


def make(bench: Workbench) -> Item:
    """The item."""
    found: dict[str, dict[str, Look]] = {}
    numbers = []
    for name, rays in RIGS.items():
        bench.say(f"fig-6-2: {name}, {rays} rays a pixel")
        rig = cropped(load_rig(name), CROP_PX)
        found[name] = looks(bench, rig, rays)
        for words, look in found[name].items():
            numbers += _numbers(f"{name}, {words}", look)
    gains = {
        name: each[_SHARPENED].near.psnr_db - each["forward"].near.psnr_db
        for name, each in found.items()
    }
    plain = found["thesis-minus-5d"]["forward"]
    edges, even = plain.at_edges, plain.on_even_ground
    nit = load_rig("thesis-minus-5d").panel.peak_nit
    return Item(
        "fig-6-2",
        "Fig. 6.2: pre-sharpening, simulation and detection map",
        "The chain is nearly a convolution, so the target may be sharpened first, by a Wiener "
        "filter: impressive improvement; visible differences lie at margins, edges and fine "
        "detail. RMSE as in T 6.1.",
        f"It helps, a little: {gains['thesis-minus-5d']:+.1f} dB with the thesis's array, "
        f"{gains['matched-full']:+.1f} dB with a matched one. Only what all places of a lenslet "
        "have in common is a convolution; what they differ by is noise, which no filter of the "
        "target takes back, and what the blur took away entirely is not there to be raised. In "
        "the headset differences are seen nearly everywhere, so that the map is all but full; "
        f"they are {edges:.1f} times their threshold at edges and {even:.1f} times on even ground "
        "(medians, the thesis's array): edges, as it says. T 6.1 lacks the 1/N, without "
        f"which RMSE grows with the picture's size; ours has it. White is {nit:g} cd/m^2 (the "
        "rig's panel.peak_nit; the thesis states none).",
        tuple(numbers),
        (
            Picture(
                "fig-6-2.png",
                "The left eye's view inside the border, and where a difference is seen.",
                _draw(found),
            ),
        ),
    )


def _numbers(words: str, look: Look) -> list[Number]:
    similar = "" if look.near.ssim is None else f"SSIM {look.near.ssim:.3f}."
    seen = (
        f"HDR-VDP-2; {look.at_edges:.1f} times the threshold at edges, {look.on_even_ground:.1f} "
        f"on even ground; quality Q_MOS {look.q_mos:.1f} of 100."
    )
    part = 100.0 * float(np.mean(look.detected > 0.5))
    return [
        Number(f"PSNR, {words}", "dB", look.near.psnr_db, None, similar),
        Number(f"RMSE with its 1/N, {words}", "", look.near.rmse, None, "Linear light, peak 1."),
        Number(f"part where a difference is likely seen, {words}", "%", part, None, seen),
    ]


def _draw(found: dict[str, dict[str, Look]]) -> bytes:
    rows = [(name, *each) for name, methods in found.items() for each in methods.items()]
    figure = blank_figure(13.0, 4.2 * len(rows))
    grid = figure.subplots(len(rows), 3)
    for (seen, probability, times), (name, words, look) in zip(grid, rows, strict=True):
        seen.imshow(shown(look.seen), interpolation="nearest")
        seen.set_title(f"{name}\n{words}: {look.near.psnr_db:.2f} dB")
        sure = probability.imshow(look.detected, cmap="turbo", vmin=0.0, vmax=1.0)
        probability.set_title(f"detection map\nQ_MOS {look.q_mos:.1f}")
        above = times.imshow(look.times, cmap="magma", vmin=0.0, vmax=_TIMES_SHOWN)
        times.set_title(
            f"times the threshold: {look.at_edges:.1f} at edges,\n"
            f"{look.on_even_ground:.1f} on even ground"
        )
        for axes in (seen, probability, times):
            axes.set_axis_off()
        figure.colorbar(
            sure, ax=probability, label="probability of seeing a difference", shrink=0.8
        )
        figure.colorbar(above, ax=times, label="difference over its threshold", shrink=0.8)
    return figure_png(figure)
