"""Fig. 3.6: higher-order wavefronts and point spreads of corrected eyes, pupil 5 mm."""

from __future__ import annotations

from dataclasses import asdict
from math import exp, pi
from typing import Final

from vrlf.model import Rig, load_rig
from vrlf.optics.pupil import SPECTACLE_ORDER, looking_far, seen_wavefront, zernike_part_um
from vrlf.optics.refraction import curvature_matrix_d, sphero_cylinder
from vrlf.studies.eyeplot import eyes_figure
from vrlf.studies.eyes import COLOURS, EyeReport, eye_report
from vrlf.studies.reproduce.drawing import figure_png
from vrlf.studies.reproduce.item import Item, Number, Picture, Workbench
from vrlf.units import NM_PER_UM, REFERENCE_WAVELENGTH_NM

PUPIL_MM: Final = 5.0
# The eyes are the shipped ones: what the thesis measured it does not print.
EYES: Final = {
    "myope-typical": "normal myopic",
    "after-surgery": "operated",
    "keratoconus-like": "keratoconus-like",
}
_CAPTION: Final = "The sphere in a heading is what best balances the higher orders over 5 mm."
_GREEN: Final = COLOURS.index("green")


def corrected_eye(name: str) -> Rig:
    """A shipped eye, looking far through glasses that take all sphere and cylinder off.

    What is of second order over this pupil counts, also that which a wider pupil's higher
    orders are here.
    """
    zero = {"sphere_d": 0.0, "cylinder_d": 0.0, "axis_deg": 0.0}
    wavefront_um = seen_wavefront(_looking(name, zero), "left").reference_um
    second_um = zernike_part_um(wavefront_um, PUPIL_MM, SPECTACLE_ORDER)
    glasses = sphero_cylinder(-curvature_matrix_d(second_um))
    return _looking(name, asdict(glasses))


def _looking(name: str, prescription: dict[str, float]) -> Rig:
    changes = [f"left.{key}={value!r}" for key, value in prescription.items()]
    fixed = [f'left.extends="{name}"', f"left.pupil_mm={PUPIL_MM}", "left.vertex_mm=0.0"]
    return looking_far(load_rig("bare", overrides=fixed + changes))


def make(bench: Workbench) -> Item:
    """The item."""
    reports: dict[str, EyeReport] = {}
    for name, words in EYES.items():
        bench.say(f"fig-3-6: {words}")
        reports[words] = eye_report(corrected_eye(name), "left")
    numbers = []
    for words, report in reports.items():
        rms, strehl = report.higher_order_rms_um, report.strehl[_GREEN]
        numbers += [
            Number(
                f"RMS of higher orders, {words} eye",
                "um",
                rms,
                None,
                f"{rms * NM_PER_UM / REFERENCE_WAVELENGTH_NM:.2f} waves; the thesis prints none.",
            ),
            Number(f"Strehl ratio in green, {words} eye", "", strehl, None, _marechal(report)),
        ]
    figure = eyes_figure(
        {words.capitalize(): each for words, each in reports.items()},
        title="Corrected eyes, higher orders alone, pupil 5 mm",
    )
    return Item(
        "fig-3-6",
        "Fig. 3.6: higher-order wavefronts and point spreads",
        "Three people, corrected by glasses, surgery and soft contact lenses, all have "
        "higher-order aberrations left; wavefronts and point spreads over a 5 mm pupil. The "
        "coefficients are not printed.",
        "So do ours, which are other eyes: shipped examples whose sizes come from published means "
        "(a normal eye; one after surgery), and one like keratoconus in place of the contact "
        "lens's. The thesis's eye model has no wavefront, as its 9.1 says; ours traces and "
        "diffracts all orders, and the prefilters correct them too.",
        tuple(numbers),
        (Picture("fig-3-6.png", _CAPTION, figure_png(figure)),),
    )


def _marechal(report: EyeReport) -> str:
    """What a small error would give, and whether this is one."""
    waves = report.rms_um * NM_PER_UM / report.seen.wavelengths_nm[_GREEN]
    if waves > 0.15:
        return f"{waves:.2f} waves: far from small, the light is in a spot of rays."
    return f"exp(-(2 pi sigma)^2) gives {exp(-((2.0 * pi * waves) ** 2)):.2f}."
