"""Chapter 9.1: one sample a pixel against many, in the prefilter and in the simulation."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from vrlf.evaluation.measure import likeness
from vrlf.model import load_rig
from vrlf.optics.viewport import viewport
from vrlf.reference.perceive import perceive as plain_perceive
from vrlf.renderer import bare_rig
from vrlf.studies.quality import CROP_PX, cropped
from vrlf.studies.reproduce.drawing import BLACK, BLUE, RED, blank_figure, figure_png, shown
from vrlf.studies.reproduce.item import Item, Number, Picture, Workbench
from vrlf.studies.reproduce.samplings import SAMPLINGS, panels

RIGS: Final = {"thesis-minus-5d": 1024, "matched-microlens": 512}
# The simulation's own noise: plain rays in float64 on a small panel, against many fast ones.
NOISE_RAYS: Final = (1, 9, 81)
_BARE: Final = "uncorrected"
_SMALL_PX: Final = (120, 60)
_MANY_RAYS: Final = 4096
# What Huang et al.'s Matlab took over the pupil, as 9.1 says.
_HUANGS_RAYS: Final = 22000
_CUT: Final = (slice(60, 160), slice(60, 160))


def make(bench: Workbench) -> Item:
    """The item."""
    numbers: list[Number] = []
    pictures, db = [], {}
    for name, rays in RIGS.items():
        rig = cropped(load_rig(name), CROP_PX)
        bench.say(f"rays-9-1: {name}")
        target = bench.target("scene", rig)
        bare = bench.renderer.perceive(target, bare_rig(rig), rays=256)
        db[name, _BARE] = likeness(bare, target, rig, "left").psnr_db
        numbers.append(
            Number(
                f"PSNR, {name}, uncorrected",
                "dB",
                db[name, _BARE],
                None,
                "The bare panel: what a sampling must beat.",
            )
        )
        for sampling, panel, seconds in panels(bench.renderer, rig, target):
            seen, error = bench.renderer.perceive_with_error(panel, rig, rays=rays)
            told = f"{1e3 * seconds:.0f} ms a panel image here; the judge's noise is {error:.4f}."
            psnr_db = likeness(seen, target, rig, "left").psnr_db
            db[name, sampling.name] = psnr_db
            numbers.append(Number(f"PSNR, {name}, {sampling.name}", "dB", psnr_db, None, told))
            half = seen[:, viewport(rig, "left").columns]
            pictures.append((f"{name}\n{sampling.name}: {psnr_db:.1f} dB", half[_CUT]))
    noise = simulation_noise(bench)
    numbers += noise_numbers(noise)
    return Item(
        "rays-9-1",
        "9.1: one, nine and many rays a pixel",
        f"Instead of some {_HUANGS_RAYS} rays over the pupil for every pixel one pupil sample a "
        "pixel is kept: considerable quality at a fraction of the time (below a second).",
        "True of the time. In the thesis's headset the number of samples makes no difference "
        f"({db['thesis-minus-5d', 'one a pixel']:.1f} dB with one, "
        f"{db['thesis-minus-5d', 'nine a sub-pixel']:.1f} with 27, "
        f"{db['thesis-minus-5d', _BARE]:.1f} on the bare panel): a pixel is seen through several "
        "lenslets, a sample knows of one, and more of them do not bring the others back. Behind a "
        "matched array one sample leaves a net of black, which nine fill "
        f"({db['matched-microlens', 'one a pixel']:.1f} and "
        f"{db['matched-microlens', 'nine a sub-pixel']:.1f} dB). Taking all light into account, "
        f"optimal makes {db['thesis-minus-5d', 'optimal']:.1f} and "
        f"{db['matched-microlens', 'optimal']:.1f} dB, at tens to hundreds of times the "
        "work: what was given up for speed is most of what an array can do. A simulation needs "
        "many rays: with one or nine it shows noise, which falls about as 1 / sqrt(N).",
        tuple(numbers),
        (
            Picture(
                "rays-9-1.png",
                "What the left eye sees, part of the scene; the simulation's noise.",
                _draw(pictures, noise),
            ),
        ),
    )


def simulation_noise(bench: Workbench) -> dict[int, float]:
    """RMS error of what is seen with so many plain rays a pixel, of both eyes, peak 1."""
    rig = cropped(load_rig("thesis-minus-5d"), _SMALL_PX)
    target = bench.target("scene", rig)
    panel = bench.renderer.prefilter(target, rig)
    truth = bench.renderer.perceive(panel, rig, rays=_MANY_RAYS).astype(np.float64)
    found = {}
    for rays in NOISE_RAYS:
        seen = plain_perceive(panel.astype(np.float64), rig, rays)
        found[rays] = float(np.sqrt(np.mean((seen - truth) ** 2)))
    return found


def noise_numbers(noise: dict[int, float]) -> list[Number]:
    most = max(noise)
    told = f"Well-spread points do at least as well as chance, which makes {most} rays' "
    numbers = [
        Number(f"noise of a simulation with {rays} plain rays a pixel", "", rms)
        for rays, rms in noise.items()
    ]
    chance = noise[most] * (most / _HUANGS_RAYS) ** 0.5
    told += f"{noise[most]:.3f} at most {chance:.4f} with {_HUANGS_RAYS}."
    return [
        *numbers,
        Number(f"the same with {_HUANGS_RAYS}, from {most} by 1/sqrt(N)", "", chance, None, told),
    ]


def _draw(pictures: list[tuple[str, np.ndarray]], noise: dict[int, float]) -> bytes:
    columns = len(SAMPLINGS)
    figure = blank_figure(2.9 * columns, 3.4 * len(RIGS) + 3.6)
    parts: Any = figure.subfigures(2, 1, height_ratios=(3.4 * len(RIGS), 3.6))
    top, bottom = parts
    grid = top.subplots(len(RIGS), columns)
    for axes, (title, cut) in zip(grid.flat, pictures, strict=True):
        axes.imshow(shown(cut), interpolation="nearest")
        axes.set_title(title, fontsize="small")
        axes.set_axis_off()
    axes = bottom.subplots(1, 1)
    rays = np.array(sorted(noise))
    axes.loglog(
        rays, [noise[each] for each in rays], "o-", color=BLACK, label="plain rays, measured"
    )
    far = np.array([rays[-1], _HUANGS_RAYS])
    axes.loglog(far, noise[rays[-1]] * np.sqrt(rays[-1] / far), "--", color=BLUE, label="1/sqrt(N)")
    axes.axvline(_HUANGS_RAYS, color=RED, linestyle=":", label="Huang et al., as 9.1 says")
    axes.set_xlabel("rays for each retinal pixel")
    axes.set_ylabel("RMS error of what is seen, peak 1")
    axes.set_title("noise of a simulation in the thesis's headset")
    axes.grid(color="0.9")
    axes.legend(frameon=False, fontsize="small")
    return figure_png(figure)
