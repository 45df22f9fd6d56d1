"""Fig. 8.4 and 8.5: desired, shown, uncorrected and corrected, with the prototype's pinholes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from vrlf.evaluation.measure import Likeness, likeness
from vrlf.model import Rig, load_rig
from vrlf.optics.viewport import viewport
from vrlf.renderer import Image, bare_rig
from vrlf.studies.quality import CROP_PX, cropped, with_method
from vrlf.studies.reproduce.drawing import Cell, sheet_png
from vrlf.studies.reproduce.item import Item, Number, Picture, Workbench
from vrlf.studies.reproduce.samplings import OPTIMAL_STEPS

RIG: Final = "thesis-table-8-1"
ACRYLIC: Final = 1.49
# Over all the panel, and on the crop that the numbers are of.
PANEL_RAYS: Final = 256
JUDGING_RAYS: Final = 1024
_BUILT: Final = "forward for air, seen through acrylic"
BARE_RAYS: Final = 64
# T 5.2's camera, at arm's length.
_CAMERA_MM: Final = (50.0, 500.0)
# The open book, at reading size.
_DETAIL_AT: Final = (180, 480)
_DETAIL_PX: Final = (222, 160)
_DETAIL_TIMES: Final = 3


@dataclass(frozen=True)
class Chain:
    """The four pictures of a source, (H, W, 3) linear light, and the corrected one's noise."""

    target: Image
    panel: Image
    uncorrected: Image
    corrected: Image
    noise: float


def chain_of(bench: Workbench, rig: Rig, source: str) -> Chain:
    """With ``forward``, as the thesis did."""
    renderer, rig = bench.renderer, with_method(rig, "forward")
    target = bench.target(source, rig)
    panel = renderer.prefilter(target, rig)
    uncorrected = renderer.perceive(target, bare_rig(rig), rays=BARE_RAYS)
    corrected, noise = renderer.perceive_with_error(panel, rig, rays=PANEL_RAYS)
    return Chain(target, panel, uncorrected, corrected, noise)


def make_8_4(bench: Workbench) -> Item:
    """One eye's view, near, and what the prototype's plate does to it."""
    bench.say(f"fig-8-4: the whole panel, {PANEL_RAYS} rays a pixel")
    rig = load_rig(RIG)
    chain = chain_of(bench, rig, "scene")
    bench.say(f"fig-8-4: numbers on {CROP_PX[0]}x{CROP_PX[1]} pixels, {JUDGING_RAYS} rays a pixel")
    judged = _judged(bench)
    numbers = (*_numbers(judged), _camera_number())
    bare, forward, optimal, plate = (
        judged[each][0].psnr_db for each in ("bare", "forward", "optimal", _BUILT)
    )
    return Item(
        "fig-8-4",
        "Fig. 8.4: corrected against blurry, one eye",
        "Seen through the pinholes fine detail is noticeably sharper than the blurry view of a "
        "near-sighted eye, though darker.",
        f"With 6 mm of air forward changes {bare:.1f} dB to {forward:.1f} dB of PSNR: fine detail "
        "is there that the bare view has lost, but doubled, as a 6 mm pupil sees every pixel "
        "through two holes each way, of which forward knows one. The optimal prefilter makes "
        f"{optimal:.1f} dB of the same holes. The plate that was built is acrylic, 4.03 mm "
        "reduced: if the panel image was made for 6 mm, as the text says, it was shown through "
        f"holes optically too near, which leaves {plate:.1f} dB, less than the bare panel.",
        numbers,
        (
            Picture(
                "fig-8-4.png", f"Left eye; noise {chain.noise:.3f} RMS.", _sheet_8_4(rig, chain)
            ),
        ),
    )


def make_8_5(bench: Workbench) -> Item:
    """A stereo pair, whole."""
    bench.say(f"fig-8-5: the whole panel, {PANEL_RAYS} rays a pixel")
    rig = load_rig(RIG)
    chain = chain_of(bench, rig, "orrery")
    numbers = []
    for side in ("left", "right"):
        for words, seen in (("uncorrected", chain.uncorrected), ("corrected", chain.corrected)):
            found = likeness(seen, chain.target, rig, side)
            numbers.append(
                Number(f"PSNR, {side} eye, {words}", "dB", found.psnr_db, None, _ssim_words(found))
            )
    gain = (numbers[1].ours or 0.0) - (numbers[0].ours or 0.0)
    noise = (
        f"RMS, peak 1; it alone would be {-20.0 * np.log10(chain.noise):.0f} dB. More rays: less."
    )
    numbers.append(Number("noise of the corrected picture", "", chain.noise, None, noise))
    rows = [
        [Cell("desired", chain.target), Cell("on the panel", chain.panel)],
        [
            Cell("seen without correction", chain.uncorrected),
            Cell("seen through the pinholes (exposed for the light they take)", chain.corrected),
        ],
    ]
    return Item(
        "fig-8-5",
        "Fig. 8.5: stereo pairs",
        "Desired pairs, rendered pairs, and pairs observed through the pinhole array: more results "
        "of the correction.",
        "The same chain on the shipped orrery, whole panel, both eyes. Grain and planks come back, "
        f"doubled; the even ground, which a blur spares, gets the holes' lattice: {gain:+.1f} dB. "
        "The light that is left is 3.7 %, for which the thesis exposed 2 s.",
        tuple(numbers),
        (
            Picture(
                "fig-8-5.png",
                f"Both eyes, {rig.panel.width_px} x {rig.panel.height_px} pixels.",
                sheet_png("Fig. 8.5's counterpart: a stereo pair, pixel for pixel", rows),
            ),
        ),
    )


def _judged(bench: Workbench) -> dict[str, tuple[Likeness, float]]:
    """Ways to show the scene: how near the left eye's view comes, and the judge's noise."""
    air = cropped(load_rig(RIG), CROP_PX)
    solid = cropped(load_rig(RIG, overrides=[f"array.gap_index={ACRYLIC}"]), CROP_PX)
    target = bench.target("scene", air)
    forward = with_method(air, "forward")
    ways = {
        "bare": (None, bare_rig(air)),
        "forward": (forward, air),
        "optimal": (with_method(air, "optimal", OPTIMAL_STEPS), air),
        _BUILT: (forward, solid),
        "forward for acrylic": (with_method(solid, "forward"), solid),
        "optimal for acrylic": (with_method(solid, "optimal", OPTIMAL_STEPS), solid),
    }
    found = {}
    for words, (told, seen_by) in ways.items():
        panel = target if told is None else bench.renderer.prefilter(target, told)
        seen, noise = bench.renderer.perceive_with_error(panel, seen_by, rays=JUDGING_RAYS)
        found[words] = likeness(seen, target, air, "left"), noise
    return found


def _numbers(judged: dict[str, tuple[Likeness, float]]) -> tuple[Number, ...]:
    return tuple(
        Number(
            f"PSNR, left eye, {words}",
            "dB",
            each.psnr_db,
            None,
            f"{_ssim_words(each)} The judge's noise is {noise:.3f}.",
        )
        for words, (each, noise) in judged.items()
    )


def _noise_words(chain: Chain) -> str:
    return f"The left eye's; (d) has {PANEL_RAYS} rays a pixel and noise of {chain.noise:.3f} RMS."


def sensor_mm(focal_mm: float, focus_mm: float) -> float:
    """From a camera's lens to its sensor, for a plane of focus so far before it."""
    return focal_mm * focus_mm / (focus_mm - focal_mm)


def _camera_number() -> Number:
    focal_mm, focus_mm = _CAMERA_MM
    return Number(
        f"lens to sensor, a {focal_mm:g} mm camera focused at {focus_mm:g} mm",
        "mm",
        sensor_mm(focal_mm, focus_mm),
        focal_mm * focus_mm / (focus_mm + focal_mm),
        "T 5.2 adds where it must subtract: nearer than its focal length nothing is sharp. The eye "
        "of fixed length, for which it adds rightly, is the other way round.",
    )


def _ssim_words(each: Likeness) -> str:
    return "" if each.ssim is None else f"SSIM {each.ssim:.3f}."


def _sheet_8_4(rig: Rig, chain: Chain) -> bytes:
    view = viewport(rig, "left")
    named = {
        "(a) desired": chain.target,
        "(b) on the panel": chain.panel,
        "(c) seen without correction": chain.uncorrected,
        "(d) seen through the pinholes": chain.corrected,
    }
    whole, detail = [], []
    for heading, picture in named.items():
        half = np.ascontiguousarray(picture[:, view.columns])
        whole.append(Cell(heading, half))
        width, height = _DETAIL_PX
        left, top = _DETAIL_AT
        cut = half[top : top + height, left : left + width]
        times = np.repeat(np.repeat(cut, _DETAIL_TIMES, axis=0), _DETAIL_TIMES, axis=1)
        detail.append(Cell(f"{heading}, a part, {_DETAIL_TIMES} times", times))
    return sheet_png(
        "Fig. 8.4's counterpart: the left eye's view of the shipped scene", [whole, detail]
    )
