"""Rigs and pictures on which the GPU's passes are held against their float64 twins.

``KNOWN`` are the rigs with known results in ``tests/data``; ``SMALL`` go where those do not:
every branch of the shaders, odd sizes, moved pupils, one chromatic eye. No two numbers of an
x and a y, a left and a right eye are alike, so that nothing swapped goes unseen.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.model import Rig, load_rig, rig_from_tables

PITCH_UM = 78.0
DATA = Path(__file__).resolve().parent / "data"
KNOWN = tuple(sorted(path.stem for path in DATA.glob("*.toml")))


def known_rig(name: str) -> Rig:
    """A rig of ``tests/data``."""
    return load_rig(DATA / f"{name}.toml")


def known_results(name: str) -> dict[str, NDArray[Any]]:
    """``panel``, ``perceived`` and ``forward`` of a rig of ``tests/data``."""
    with np.load(DATA / f"{name}.npz") as arrays:
        return {key: arrays[key] for key in arrays.files}


def rig(width_px: int, height_px: int, **tables: dict[str, Any]) -> Rig:
    """A rig whose axes meet the panel in the middle of the viewports, but for what is given."""
    base: dict[str, dict[str, Any]] = {
        "panel": {"width_px": width_px, "height_px": height_px, "pixel_pitch_um": PITCH_UM},
        "headset": {"lens_to_panel_mm": 46.0, "lens_separation_mm": width_px / 2 * PITCH_UM / 1e3},
        "array": {"kind": "none"},
        "left": {"vertex_mm": 0.0, "sphere_d": -5.0, "pupil_mm": 5.0},
        "right": {"vertex_mm": 0.0, "sphere_d": -2.5, "pupil_mm": 4.0},
    }
    for name, change in tables.items():
        base[name] = base.get(name, {}) | change
    return rig_from_tables(base)


def picture(given: Rig, seed: int = 5) -> NDArray[np.float32]:
    """Random light, no two pixels alike, the panel's size."""
    size = (given.panel.height_px, given.panel.width_px, 3)
    return np.random.default_rng(seed).random(size, dtype=np.float32)


LENSLETS = {"kind": "microlens", "pitch_um": 390.0, "gap_mm": 3.0, "focal_mm": 1.95}
# An index of 1.6 and an Abbe number of 8, as no glass has: no colour passes for another.
_DISPERSING: dict[str, Any] = {key: LENSLETS[key] for key in ("kind", "pitch_um", "gap_mm")} | {
    "lenslet": {"radius_mm": 1.17, "thickness_mm": 0.4, "glass": "1.6/8"}
}
HOLES = {"kind": "pinhole", "pitch_um": 390.0, "gap_mm": 6.0, "aperture_um": 130.0}
# Axes so far beside the panel that red and blue are seen a pixel apart, and more.
FAR_OFF_GLASS = {
    "glass": "polycarbonate",
    "eye_relief_mm": 16.0,
    "lens_power_d": 20.0,
    "lens_separation_mm": 47.0,
    "lens_height_mm": 6.5,
}
# As far as perpendicular walls leave something to see.
NEARER = {"lens_separation_mm": 8.0, "lens_height_mm": -1.1}
_COMA = {"diameter_mm": 6.0, "coefficients_um": {"3,-1": 0.4, "3,1": -0.25, "2,-2": 0.5}}
_EIGHTH = {
    "diameter_mm": 6.5,
    "coefficients_um": {"8,-4": 0.06, "7,1": -0.08, "5,5": 0.1, "4,-2": 0.12, "3,3": -0.2},
}

SMALL: dict[str, Rig] = {
    "chromatic": rig(
        44, 30, panel={"subpixels": "full"}, left={"chromatic": True}, right={"chromatic": True}
    ),
    "one-chromatic-eye": rig(
        44, 30, array=LENSLETS | {"rotation_deg": 11.0}, right={"chromatic": True}
    ),
    "bgr-walls": rig(
        45,
        31,
        panel={"subpixels": "bgr-stripe"},
        headset={"lens_height_mm": 0.37, "eye_relief_mm": 6.0},
        array=LENSLETS | {"barriers": "perpendicular", "offset_um": [35.0, 90.0]},
        right={"pupil_offset_mm": [0.7, -0.4]},
    ),
    "rgb-walls-turned": rig(
        45,
        29,
        array=LENSLETS | {"barriers": "perpendicular", "rotation_deg": -23.0},
        left={"cylinder_d": -2.0, "axis_deg": 20.0},
    ),
    "full-leaning-walls": rig(
        44,
        31,
        panel={"subpixels": "full"},
        headset={"eye_relief_mm": 9.0},
        array=LENSLETS | {"barriers": "converging", "rotation_deg": 5.0, "gap_index": 1.49},
        left={"pupil_offset_mm": [-0.6, 0.9]},
    ),
    # |kappa| = |1 - g a / f| is 8.3: too wide an image for area means, so it is sampled.
    "strongest-lenslets": rig(44, 30, array=LENSLETS | {"focal_mm": 0.3, "rotation_deg": 3.0}),
    # |kappa| is 2.0: a retinal pixel's image is wider than a pixel.
    "strong-lenslets": rig(44, 30, array=LENSLETS | {"focal_mm": 0.93, "rotation_deg": 3.0}),
    "strong-lenslets-full": rig(
        45, 31, panel={"subpixels": "full"}, array=LENSLETS | {"focal_mm": 0.93}
    ),
    # kappa is 0: a retinal pixel's image shrinks to a point.
    "focused-lenslets": rig(
        45, 31, array=LENSLETS | {"focal_mm": 3.0 * 43.0 / 46.0, "offset_um": [11.0, -27.0]}
    ),
    "coma-lenslets": rig(
        44,
        30,
        array=LENSLETS | {"offset_um": [-70.0, 20.0]},
        left={"zernike": _COMA},
        right={"zernike": _EIGHTH, "prism_pd": [0.6, -1.1]},
    ),
    "round-holes-moved": rig(
        45,
        30,
        array=HOLES | {"aperture_shape": "circle", "offset_um": [120.0, -50.0]},
        left={"pupil_offset_mm": [0.9, -0.5], "cylinder_d": -1.5, "axis_deg": 65.0},
        right={"chromatic": True},
    ),
    "square-holes-walls": rig(
        44,
        31,
        panel={"subpixels": "bgr-stripe"},
        array=HOLES | {"rotation_deg": 14.0, "barriers": "converging"},
        right={"zernike": _COMA},
    ),
    # The right eye's columns begin at an odd one: a pixel's place on the whole panel counts.
    "diamonds-lenslets": rig(
        45,
        31,
        panel={"subpixels": "pentile-diamond"},
        array=LENSLETS | {"rotation_deg": 8.0, "offset_um": [23.0, -61.0]},
        left={"cylinder_d": -1.0, "axis_deg": 40.0},
        right={"pupil_offset_mm": [0.4, -0.5]},
    ),
    "rgbg-walls": rig(
        46,
        29,
        panel={"subpixels": "pentile-rgbg"},
        array=LENSLETS | {"barriers": "perpendicular", "offset_um": [35.0, 90.0]},
        right={"chromatic": True},
    ),
    "diamonds-holes": rig(
        47,
        30,
        panel={"subpixels": "pentile-diamond"},
        array=HOLES | {"rotation_deg": 4.0},
        left={"zernike": _COMA},
    ),
    "rgbg-bare": rig(
        45,
        31,
        panel={"subpixels": "pentile-rgbg"},
        headset={"eye_relief_mm": 7.0},
        right={"prism_pd": [0.8, 0.3]},
    ),
    "own-lens-bare": rig(
        45,
        31,
        headset={"lens_power_d": 18.0, "eye_relief_mm": 12.0, "lens_height_mm": -0.4},
        left={"prism_pd": [-0.7, 0.4], "accommodation": "best"},
        right={"pupil_offset_mm": [1.1, 0.3], "chromatic": True},
    ),
    "glass-bare": rig(
        45,
        31,
        headset=FAR_OFF_GLASS,
        left={"prism_pd": [-0.3, 0.2], "chromatic": True},
        right={"pupil_offset_mm": [1.1, 0.3]},
    ),
    "glass-lenslets-walls": rig(
        44,
        31,
        headset=FAR_OFF_GLASS | NEARER | {"glass": "pmma"},
        array=LENSLETS | {"rotation_deg": 17.0, "barriers": "perpendicular", "gap_index": 1.2},
        left={"pupil_offset_mm": [-0.4, 0.6], "cylinder_d": -1.0, "axis_deg": 40.0},
    ),
    "glass-lenslets-full": rig(
        45,
        30,
        panel={"subpixels": "full"},
        headset=FAR_OFF_GLASS,
        array=LENSLETS | {"offset_um": [60.0, -25.0], "barriers": "converging"},
        right={"zernike": _COMA},
    ),
    "glass-holes": rig(
        44,
        30,
        headset=FAR_OFF_GLASS,
        array=HOLES | {"rotation_deg": 8.0},
        left={"pupil_offset_mm": [0.5, -0.8]},
    ),
    "glass-round-holes-wavefront": rig(
        45,
        31,
        headset=FAR_OFF_GLASS | {"glass": "n-bk7"},
        array=HOLES | {"aperture_shape": "circle", "barriers": "converging"},
        right={"zernike": _COMA},
    ),
    # Lenslets of glass: each colour is bent by its own focal length, 1.83, 1.95 and 2.21 mm.
    "dispersing-lenslets-walls": rig(
        44,
        31,
        array=_DISPERSING | {"rotation_deg": 13.0, "barriers": "converging", "gap_index": 1.2},
        left={"cylinder_d": -1.5, "axis_deg": 30.0},
        right={"pupil_offset_mm": [0.6, -0.3]},
    ),
    # The same behind a lens of glass: colours apart in every way.
    "dispersing-lenslets-glass": rig(
        45,
        30,
        panel={"subpixels": "full"},
        headset=FAR_OFF_GLASS,
        array=_DISPERSING | {"offset_um": [60.0, -25.0]},
        right={"zernike": _COMA, "chromatic": True},
    ),
    # No relief: the colours focus differently, but are magnified alike.
    "glass-without-relief": rig(
        44, 31, headset={"glass": "polycarbonate"}, array=LENSLETS | {"rotation_deg": 11.0}
    ),
}

_COMA_AND_DEFOCUS: dict[str, Any] = {
    "diameter_mm": 5.5,
    "coefficients_um": {"3,1": 0.3, "5,-3": 0.1, "2,0": 0.6},
}
# Rigs that no known result covers, for the independent tracer, each joining what the others lack.
APART: dict[str, Rig] = {
    "dispersing-lenslets-turned": rig(
        25,
        16,
        array=_DISPERSING | {"rotation_deg": 9.0, "barriers": "converging"},
        left={"pupil_offset_mm": [0.3, -0.5], "cylinder_d": -1.5, "axis_deg": 70.0},
    ),
    "walls-stripes-relief": rig(
        24,
        17,
        headset={"lens_height_mm": 0.31, "eye_relief_mm": 8.0, "lens_power_d": 19.0},
        array=LENSLETS | {"barriers": "perpendicular", "rotation_deg": 9.0},
        left={"pupil_offset_mm": [0.4, -0.6]},
        right={"prism_pd": [0.8, 0.5], "vertex_mm": 13.0},
    ),
    "diamonds-walls-relief": rig(
        25,
        18,
        panel={"subpixels": "pentile-diamond"},
        headset={"lens_height_mm": -0.17, "eye_relief_mm": 5.0},
        array=LENSLETS | {"barriers": "converging", "rotation_deg": -12.0},
        left={"cylinder_d": -1.5, "axis_deg": 70.0},
    ),
    "rgbg-holes": rig(
        27,
        17,
        panel={"subpixels": "pentile-rgbg"},
        array=HOLES | {"offset_um": [40.0, 25.0]},
        left={"pupil_offset_mm": [-0.4, 0.3]},
    ),
    "round-holes-chromatic": rig(
        25,
        16,
        panel={"subpixels": "full"},
        array=HOLES | {"aperture_shape": "circle", "offset_um": [140.0, -60.0]},
        left={"chromatic": True, "pupil_mm": 4.5},
        right={"chromatic": True, "accommodation": "best", "sphere_d": 1.5, "age_years": 50.0},
    ),
    "glass-bare-accommodating": rig(
        24,
        16,
        panel={"subpixels": "bgr-stripe"},
        headset=FAR_OFF_GLASS,
        left={"accommodation": "best", "chromatic": True},
        right={"pupil_offset_mm": [-0.5, 0.7], "cylinder_d": -1.5, "axis_deg": 70.0},
    ),
    "glass-lenslets-leaning": rig(
        25,
        16,
        headset=FAR_OFF_GLASS | {"glass": "pmma"},
        array=LENSLETS | {"barriers": "converging", "rotation_deg": 12.0, "gap_index": 1.3},
        left={"pupil_offset_mm": [0.3, -0.5]},
        right={"prism_pd": [0.4, 0.3]},
    ),
    "glass-holes-walls": rig(
        24,
        15,
        headset=FAR_OFF_GLASS | NEARER | {"glass": "n-bk7"},
        panel={"subpixels": "full"},
        array=HOLES | {"barriers": "perpendicular", "offset_um": [70.0, 20.0]},
        left={"pupil_mm": 6.0},
    ),
    "leaning-walls-acrylic-astigmatic": rig(
        26,
        15,
        panel={"subpixels": "full"},
        array=LENSLETS
        | {"barriers": "converging", "gap_mm": 4.2, "gap_index": 1.49, "rotation_deg": -6.0},
        left={"cylinder_d": -2.5, "axis_deg": 25.0, "vertex_mm": 12.0},
        right={"cylinder_d": 1.75, "axis_deg": 160.0},
    ),
    "bare-wavefront-own-power": rig(
        24,
        16,
        panel={"subpixels": "bgr-stripe"},
        headset={"lens_power_d": 17.0, "lens_height_mm": -0.4, "eye_relief_mm": 10.0},
        left={"zernike": _COMA_AND_DEFOCUS, "accommodation": "best"},
        right={"chromatic": True, "pupil_offset_mm": [-0.5, 0.7]},
    ),
}

# The same branches on hexagonal lattices, of odd sizes, moved and turned; both eyes unlike.
_HEX_LENSLETS = LENSLETS | {"lattice": "hexagonal"}
_HEX_HOLES = HOLES | {"lattice": "hexagonal"}
HEXAGONAL: dict[str, Rig] = {
    "hexagonal-lenslets": rig(
        27,
        19,
        headset={"lens_height_mm": 0.23},
        array=_HEX_LENSLETS | {"offset_um": [70.0, -40.0], "rotation_deg": 11.0},
        left={"cylinder_d": -1.5, "axis_deg": 35.0, "pupil_offset_mm": [0.4, -0.3]},
        right={"chromatic": True},
    ),
    "hexagonal-leaning-walls": rig(
        26,
        17,
        panel={"subpixels": "full"},
        headset={"eye_relief_mm": 9.0},
        array=_HEX_LENSLETS
        | {"barriers": "converging", "rotation_deg": -8.0, "gap_mm": 4.2, "gap_index": 1.49},
        left={"pupil_offset_mm": [-0.6, 0.9]},
    ),
    "hexagonal-walls": rig(
        25,
        18,
        panel={"subpixels": "bgr-stripe"},
        headset={"lens_height_mm": 0.37, "eye_relief_mm": 6.0},
        array=_HEX_LENSLETS | {"barriers": "perpendicular", "offset_um": [35.0, 90.0]},
        right={"pupil_offset_mm": [0.7, -0.4]},
    ),
    "hexagonal-coma": rig(
        26,
        19,
        array=_HEX_LENSLETS | {"offset_um": [-70.0, 20.0], "rotation_deg": 90.0},
        left={"zernike": _COMA},
        right={"zernike": _EIGHTH, "prism_pd": [0.6, -1.1]},
    ),
    "hexagonal-square-holes": rig(
        27,
        18,
        panel={"subpixels": "full"},
        array=_HEX_HOLES | {"rotation_deg": 14.0, "aperture_um": 190.0},
        left={"cylinder_d": -1.5, "axis_deg": 65.0},
        right={"pupil_offset_mm": [0.5, -0.6]},
    ),
    "hexagonal-round-holes-walls": rig(
        26,
        17,
        panel={"subpixels": "pentile-diamond"},
        array=_HEX_HOLES
        | {"aperture_shape": "circle", "barriers": "converging", "offset_um": [140.0, -60.0]},
        right={"chromatic": True},
    ),
    "hexagonal-holes-blind": rig(
        25,
        18,
        array=_HEX_HOLES | {"rotation_deg": -21.0, "aperture_um": 285.0},
        left={"zernike": _COMA},
    ),
}

# Far from the lattice's middle, where the pitch is another than there and changes fast: both ways.
_GROWING = {"pitch_growth_per_cm2": [0.3, -0.08], "offset_um": [-8000.0, 7000.0]}
VARYING: dict[str, Rig] = {
    "varying-lenslets": rig(
        27,
        19,
        headset={"lens_height_mm": 0.23},
        array=LENSLETS | _GROWING,
        left={"cylinder_d": -1.5, "axis_deg": 35.0, "pupil_offset_mm": [0.4, -0.3]},
        right={"chromatic": True},
    ),
    "varying-leaning-walls": rig(
        26,
        17,
        panel={"subpixels": "full"},
        headset={"eye_relief_mm": 9.0},
        array=LENSLETS | _GROWING | {"barriers": "converging", "gap_mm": 4.2, "gap_index": 1.49},
        left={"pupil_offset_mm": [-0.6, 0.9]},
    ),
    "varying-walls": rig(
        25,
        18,
        panel={"subpixels": "bgr-stripe"},
        headset={"lens_height_mm": 0.37, "eye_relief_mm": 6.0},
        array=LENSLETS | _GROWING | {"barriers": "perpendicular"},
        right={"pupil_offset_mm": [0.7, -0.4]},
    ),
    "varying-coma": rig(
        26,
        19,
        array=LENSLETS | {"pitch_growth_per_cm2": [-0.08, 0.2], "offset_um": [7000.0, -6000.0]},
        left={"zernike": _COMA, "stiles_crawford_per_mm2": 0.05},
        right={"zernike": _EIGHTH, "prism_pd": [0.6, -1.1]},
    ),
    "varying-square-holes": rig(
        27,
        18,
        panel={"subpixels": "full"},
        array=HOLES | _GROWING | {"aperture_um": 190.0},
        left={"cylinder_d": -1.5, "axis_deg": 65.0},
        right={"pupil_offset_mm": [0.5, -0.6]},
    ),
    "varying-round-holes-walls": rig(
        26,
        17,
        panel={"subpixels": "pentile-diamond"},
        array=HOLES | _GROWING | {"aperture_shape": "circle", "barriers": "converging"},
        right={"chromatic": True},
    ),
    # With all that may stand beside it: each colour bent and focused by itself, places of a period.
    "varying-dispersing": rig(
        27,
        18,
        panel={"subpixels": "pentile-diamond"},
        headset={"glass": "polycarbonate", "lens_height_mm": -0.19},
        array=_DISPERSING | _GROWING | {"barriers": "converging", "gap_index": 1.2},
        left={"pupil_offset_mm": [0.3, -0.5]},
        right={"chromatic": True, "cylinder_d": -1.5, "axis_deg": 70.0},
    ),
    "varying-holes-blind": rig(
        25, 18, array=HOLES | _GROWING | {"aperture_um": 210.0}, left={"zernike": _COMA}
    ),
}

for _name in ("lenslets", "walls", "round-holes-walls", "holes-blind", "dispersing"):
    APART[f"varying-{_name}"] = VARYING[f"varying-{_name}"]
for _name in ("lenslets", "walls", "leaning-walls", "round-holes-walls", "holes-blind"):
    APART[f"hexagonal-{_name}"] = HEXAGONAL[f"hexagonal-{_name}"]

CASES = (*KNOWN, *SMALL, *HEXAGONAL, *VARYING)


def case(name: str) -> tuple[Rig, NDArray[np.float32]]:
    """One of ``CASES``: the rig and a picture for it."""
    made = (SMALL | HEXAGONAL | VARYING).get(name)
    if made is not None:
        return made, picture(made)
    return known_rig(name), known_results(name)["panel"]
