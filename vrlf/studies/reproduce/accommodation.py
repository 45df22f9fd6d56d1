"""Fig. 3.2 and chapter 3.3: accommodation against age, and how far eyes see sharp."""

from __future__ import annotations

from typing import Final

import numpy as np

from vrlf.model import Eye
from vrlf.optics.eye import (
    AMPLITUDE_AT_BIRTH_D,
    AMPLITUDE_LOSS_D_PER_YEAR,
    amplitude_of_accommodation_d,
    clear_zone_mm,
)
from vrlf.studies.reproduce.drawing import BLACK, BLUE, RED, blank_figure, figure_png
from vrlf.studies.reproduce.item import Item, Number, Picture, Workbench
from vrlf.units import MM_PER_M

# The thesis's eye: 60 D relaxed, 68 D accommodated, and its two lengths in air.
_RELAXED_D, _ADDED_D, _LENGTH_MM = 60.0, 8.0, 17.0
# Hofstetter 1950: the least and the most that healthy eyes of an age have.
_LEAST, _MOST = (15.0, 0.25), (25.0, 0.40)
# What the thesis states of each eye's clear zone: (near, far); None is infinity.
_STATED: Final = {
    "+5 D too strong (myope)": (-5.0, 70.0, 162.0),
    "emmetrope": (0.0, 125.0, None),
    "5 D too weak (hyperope)": (5.0, 239.0, None),
}
_LOSS_TEXT = (
    "A mean over people; single eyes differ by some 2 D either way (Hofstetter's least and most)."
)


def with_amplitude(amplitude_d: float) -> float:
    """The age in years at which the mean eye has that amplitude."""
    return (AMPLITUDE_AT_BIRTH_D - amplitude_d) / AMPLITUDE_LOSS_D_PER_YEAR


def clear_zone(sphere_d: float) -> tuple[float | None, float | None]:
    """Nearest and farthest sharp distance in mm of an eye with the thesis's 8 D to add."""
    eye = Eye(sphere_d=sphere_d, vertex_mm=0.0, age_years=with_amplitude(_ADDED_D))
    zone = clear_zone_mm(eye)
    assert zone is not None
    return zone


def sharp_at_mm(power_d: float, length_mm: float) -> float:
    """Where an eye of that power and length in air focuses (T 3.1); negative beyond infinity."""
    return MM_PER_M / (power_d - MM_PER_M / length_mm)


def make(bench: Workbench) -> Item:  # noqa: ARG001  every item is made with one
    """The item."""
    gone = AMPLITUDE_AT_BIRTH_D / AMPLITUDE_LOSS_D_PER_YEAR
    bias_d = _RELAXED_D - MM_PER_M / _LENGTH_MM
    zones = {name: clear_zone(sphere_d) for name, (sphere_d, _, _) in _STATED.items()}
    numbers = [
        Number(
            "years that cost one dioptre",
            "years",
            1.0 / AMPLITUDE_LOSS_D_PER_YEAR,
            (3.0, 4.0),
            _LOSS_TEXT,
        ),
        Number(
            "age at which nothing is left", "years", gone, 60.0, "Hofstetter's 18.5 - 0.30 age."
        ),
        Number(
            "error of the thesis's relaxed eye (60 D, 17 mm)",
            "D",
            bias_d,
            0.0,
            "An eye that focuses infinity with 60 D is 16.67 mm long; at 17 mm it is a myope.",
        ),
    ]
    for name, (_, near_mm, far_mm) in _STATED.items():
        near, far = zones[name]
        numbers.append(Number(f"near point, {name}", "mm", near, near_mm, _why(name, near_mm)))
        if far_mm is not None:
            numbers.append(Number(f"far point, {name}", "mm", far, far_mm, _why(name, far_mm)))
    return Item(
        "fig-3-2",
        "Fig. 3.2 and 3.3: accommodation and clear zones",
        "Amplitude falls by roughly one dioptre every 3 to 4 years and is about 0 after 60. A +5 D "
        "myope sees sharp from 70 to 162 mm, an emmetrope from 125 mm, a -5 D hyperope from "
        "239 mm.",
        "The fall agrees with Hofstetter's mean. The clear zones do not: the thesis takes a length "
        "of 16.67 mm for the emmetrope and 17 mm for the other two, which makes those "
        f"{bias_d:.2f} D more myopic than stated. A myope of -5 D sees from 77 to 200 mm, a "
        "hyperope of +5 D from 333 mm. (The sign of its dioptres is the eye's, not the "
        "prescription's; its formula for the near point stands upside down, f d_e / (d_e - f) is "
        "meant; and the muscle that it lets relax for near things contracts, as its own 3.1 says.)",
        tuple(numbers),
        (
            Picture(
                "fig-3-2.png", "Amplitude against age; clear zones of three eyes.", _draw(zones)
            ),
        ),
    )


def _why(name: str, stated_mm: float) -> str:
    if name == "emmetrope":
        return "1000 / 8 D: here the thesis's eye is 16.67 mm long."
    other = MM_PER_M / stated_mm
    return f"{stated_mm:g} mm is {other:.2f} D: with 17 mm where 16.67 mm belongs."


def _draw(zones: dict[str, tuple[float | None, float | None]]) -> bytes:
    figure = blank_figure(13.0, 5.0)
    left, right = figure.subplots(1, 2)
    age = np.linspace(0.0, 80.0, 161)
    left.plot(age, [amplitude_of_accommodation_d(each) for each in age], color=BLACK, label="mean")
    for (start, loss), label, line in ((_LEAST, "least", ":"), (_MOST, "most", "-.")):
        left.plot(age, np.maximum(0.0, start - loss * age), line, color=BLACK, label=label)
    for years, colour in ((3.0, RED), (4.0, BLUE)):
        told = np.maximum(0.0, (60.0 - age) / years)
        left.plot(age, told, "--", color=colour, label=f"1 D in {years:g} years, 0 at 60 (thesis)")
    left.set_xlabel("age, years")
    left.set_ylabel("amplitude of accommodation, D")
    left.set_ylim(0.0, 25.0)
    left.grid(color="0.9")
    left.legend(fontsize="small", frameon=False)
    left.set_title("Hofstetter 1950, and the thesis's words")
    names = list(_STATED)
    for row, name in enumerate(names):
        for shift, (near, far), colour in (
            (0.15, zones[name], BLACK),
            (-0.15, _STATED[name][1:], RED),
        ):
            ends = [MM_PER_M / end if end is not None else 0.0 for end in (far, near)]
            right.plot(ends, [row + shift] * 2, color=colour, linewidth=6, solid_capstyle="butt")
            for end in ends:
                words = f"{MM_PER_M / end:.0f} mm" if end else "infinity"
                right.annotate(
                    words, (end, row + shift), (0, 5), textcoords="offset points", fontsize=8
                )
    right.plot([], [], color=BLACK, linewidth=6, label="ours")
    right.plot([], [], color=RED, linewidth=6, label="thesis")
    right.legend(frameon=False)
    right.set_yticks(range(len(names)), names)
    right.set_xlim(-0.5, 16.0)
    right.set_ylim(-0.5, 2.6)
    right.set_xlabel("vergence of what is sharp, D")
    right.set_title("clear zones with 8 D of accommodation")
    return figure_png(figure)
