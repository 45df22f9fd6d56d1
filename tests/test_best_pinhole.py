"""T 7.1's best pinhole as an optimum of what is seen, against waves propagated by themselves.

Criteria, the same for rays and waves: the least interval that holds half of a lit panel
column's light, of what falls within a window; and the contrast of a grating on the panel.
An eye sees one hole at a time: cells are wider than the pupil's image on the array.
"""

from __future__ import annotations

from math import sqrt
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from vrlf.gpu import Device
from vrlf.model import Rig, rig_from_tables
from vrlf.optics.tracing import Tracing
from vrlf.renderer import GpuRenderer

Light = NDArray[Any]

NM = 545.0
GAP_MM = 6.0
PX_MM = 0.01
REACH_MM2 = NM * 1e-6 * GAP_MM
DIFFRACTION = Tracing(diffraction=True)
WIDTH_PX, HEIGHT_PX = 60, 30
COLUMNS_MM = (np.arange(WIDTH_PX) + 0.5 - WIDTH_PX / 2.0) * PX_MM


class Setup(NamedTuple):
    """An eye before a mask.

    scale: M; seen: panel millimetres per retinal one, through one hole; window_mm: half of it,
    on the panel.
    """

    headset: dict[str, float]
    eye: dict[str, float]
    pitch_um: float
    scale: float
    seen: float
    window_mm: float


# No lens, an eye that sees far: its beam is parallel, M = 1, T 7.1's own case.
# y = X/7 + u, x = X + u: through the hole at 0, x = 6/7 X.
FAR = Setup(
    {"lens_to_panel_mm": 7.0, "lens_power_d": 0.0},
    {"sphere_d": 0.0, "pupil_mm": 0.34},
    pitch_um=300.0,
    scale=1.0,
    seen=6.0 / 7.0,
    window_mm=0.25,
)
# The thesis's -5 D at 46 mm: y = 40/46 X + phi u, phi = 1 - 40/46 - 0.2, and x = X + psi u,
# psi = -0.23: M = psi / phi, x = (1 - 40/46 M) X.
_SCALE = -0.23 / (1.0 - 40.0 / 46.0 - 0.2)
MYOPE = Setup(
    {"lens_to_panel_mm": 46.0},
    {"sphere_d": -5.0, "pupil_mm": 4.6},
    pitch_um=330.0,
    scale=_SCALE,
    seen=1.0 - 40.0 / 46.0 * _SCALE,
    window_mm=0.25,
)
CASES = {"far": (FAR, "square"), "far-round": (FAR, "circle"), "myope": (MYOPE, "square")}


def rig(setup: Setup, hole_um: float, shape: str = "square") -> Rig:
    """A hole on the left eye's axis, pixels of 10 um."""
    width_mm = WIDTH_PX * PX_MM
    return rig_from_tables(
        {
            "panel": {
                "width_px": 2 * WIDTH_PX,
                "height_px": HEIGHT_PX,
                "pixel_pitch_um": 1e3 * PX_MM,
                "subpixels": "full",
                "wavelengths_nm": [NM, NM, NM],
            },
            "headset": setup.headset | {"lens_separation_mm": width_mm},
            "array": {
                "kind": "pinhole",
                "pitch_um": setup.pitch_um,
                "gap_mm": GAP_MM,
                "aperture_um": hole_um,
                "aperture_shape": shape,
                "offset_um": [-1e3 * width_mm / 2.0, 0.0],
            },
            "left": setup.eye | {"vertex_mm": 0.0},
            "right": setup.eye | {"vertex_mm": 0.0},
        }
    )


def half_width_mm(x_mm: Light, light: Light) -> float:
    """The least interval that holds half of the light of equal cells about x, ascending."""
    edges = np.concatenate([x_mm - (x_mm[1] - x_mm[0]) / 2.0, [1.5 * x_mm[-1] - 0.5 * x_mm[-2]]])
    held = np.concatenate([[0.0], np.cumsum(light)]) / light.sum()
    from_share = np.linspace(0.0, 0.5, 2001)
    low, high = np.interp(from_share, held, edges), np.interp(from_share + 0.5, held, edges)
    return float((high - low).min())


def seen_columns(renderer: GpuRenderer, given: Rig, column: Light, tracing: Tracing) -> Light:
    """What the left eye sees in each column of a panel of columns, the mean of the middle rows.

    The panel's 0.3 mm hold all but 2 % of what the rows between receive from above and below.
    """
    panel = np.zeros((HEIGHT_PX, 2 * WIDTH_PX, 3), np.float32)
    panel[:, :WIDTH_PX] = column[:, None]
    seen = renderer.perceive(panel, given, rays=240, exposure="none", tracing=tracing)
    return np.asarray(seen[10:20, :WIDTH_PX, 1].mean(axis=0), np.float64)


def line_width_mm(
    renderer: GpuRenderer, setup: Setup, hole_um: float, tracing: Tracing, shape: str = "square"
) -> float:
    """Of a lit panel column of two pixels about the axis, as it is seen; on the panel."""
    lit = np.zeros(WIDTH_PX)
    lit[WIDTH_PX // 2 - 1 : WIDTH_PX // 2 + 1] = 1.0
    seen = seen_columns(renderer, rig(setup, hole_um, shape), lit, tracing)
    x_mm = COLUMNS_MM * abs(setup.seen)
    return half_width_mm(seen_places_mm(setup), seen[np.abs(x_mm) <= setup.window_mm])


def seen_places_mm(setup: Setup) -> Light:
    """Where on the panel the retinal pixels of the window look, about the hole."""
    x_mm = COLUMNS_MM * abs(setup.seen)
    return np.asarray(x_mm[np.abs(x_mm) <= setup.window_mm])


def wave_width_mm(setup: Setup, hole_um: float, shape: str = "square") -> float:
    """The same of a wave: through the hole from where the eye focuses, to the panel."""
    count, step = 1024, 1.0e-3
    x = (np.arange(count) - count // 2) * step
    square = x[None, :] ** 2 + x[:, None] ** 2
    half = hole_um / 2e3
    if shape == "circle":
        inside = np.clip((half - np.sqrt(square)) / step + 0.5, 0.0, 1.0)
    else:
        one = np.clip((half - np.abs(x)) / step + 0.5, 0.0, 1.0)
        inside = one[None, :] * one[:, None]
    # M = 1 + g / L: light that comes from L before the hole.
    curvature = (setup.scale - 1.0) / GAP_MM
    field = inside * np.exp(1j * np.pi * curvature / (NM * 1e-6) * square)
    per_mm = np.fft.fftfreq(count, step)
    turned = np.exp(-1j * np.pi * REACH_MM2 * (per_mm[None, :] ** 2 + per_mm[:, None] ** 2))
    light = np.abs(np.fft.ifft2(np.fft.fft2(field) * turned)) ** 2
    column = light.sum(axis=0)
    # The lit column's and the retinal pixel's own widths.
    for width_mm in (2.0 * PX_MM, PX_MM * abs(setup.seen)):
        column = np.real(np.fft.ifft(np.fft.fft(column) * np.sinc(per_mm * width_mm)))
    seen_mm = seen_places_mm(setup)
    return half_width_mm(seen_mm, np.interp(seen_mm, x, column))


def best(hole_um: Light, sharpness: Light) -> float:
    """Where a parabola through the least three values' neighbourhood has its minimum."""
    middle = int(np.argmin(sharpness))
    assert 0 < middle < len(hole_um) - 1, "the optimum lies within what was tried"
    part = slice(max(0, middle - 2), middle + 3)
    a, b, _ = np.polyfit(hole_um[part], sharpness[part], 2)
    return float(-b / (2.0 * a))


@pytest.mark.parametrize("name", CASES)
def test_the_best_hole_is_the_waves(device: Device, name: str) -> None:
    setup, shape = CASES[name]
    thesis_um = 1e3 * sqrt(2.0 * REACH_MM2 / abs(setup.scale))
    tried_um = np.round(thesis_um * np.arange(0.73, 1.5, 0.12) * (1.15 if shape == "circle" else 1))
    with GpuRenderer(device) as renderer:
        rays = [line_width_mm(renderer, setup, w, DIFFRACTION, shape) for w in tried_um]
        plain = [line_width_mm(renderer, setup, w, Tracing(), shape) for w in tried_um[::3]]
    waves = [wave_width_mm(setup, w, shape) for w in tried_um]
    ray_um, wave_um = best(tried_um, np.array(rays)), best(tried_um, np.array(waves))
    print(
        f"{name}: best hole {ray_um:.1f} um by rays, {wave_um:.1f} by waves, "
        f"sqrt(2 lambda g / M) {thesis_um:.1f}; widths um {np.round(1e3 * np.array(rays), 1)}, "
        f"waves {np.round(1e3 * np.array(waves), 1)}, shadows {np.round(1e3 * np.array(plain), 1)}"
    )
    assert ray_um == pytest.approx(wave_um, rel=0.1)
    # The widths themselves are the waves' too: pixels of a fifth of them, 240 rays a pixel.
    assert rays == pytest.approx(waves, rel=0.08)
    # A square's is T 7.1's; a disc as wide has less of its light at the rim.
    assert ray_um == pytest.approx(thesis_um * (1.15 if shape == "circle" else 1.0), rel=0.1)
    # Without diffraction the smallest hole is the sharpest.
    assert np.all(np.diff(plain) > 0.0)


def test_the_best_hole_for_a_grating_is_the_waves(device: Device) -> None:
    """Through a square hole a grating of f cycles keeps sin(pi N v (1 - v)) / (pi N v) of its
    contrast, v = f lambda g / w: the autocorrelation of exp(i pi N s^2) over the hole
    (Goodman 2005, equation 6-41, for a defocus of w / 4 lambda).
    """
    per_mm = 8.0
    tried_um = np.arange(45.0, 111.0, 8.0)
    x_mm = COLUMNS_MM
    near = np.abs(x_mm) <= 0.25
    waves = [
        np.ones(WIDTH_PX),
        *(f(2.0 * np.pi * per_mm * FAR.seen * x_mm) for f in (np.cos, np.sin)),
    ]
    basis = np.stack(waves, axis=-1)[near]
    column = 0.5 + 0.5 * np.cos(2.0 * np.pi * per_mm * x_mm)
    contrast = []
    with GpuRenderer(device) as renderer:
        for hole_um in tried_um:
            seen = seen_columns(renderer, rig(FAR, hole_um), column, DIFFRACTION)[near]
            mean, cosine, sine = np.linalg.lstsq(basis, seen, rcond=None)[0]
            contrast.append(np.hypot(cosine, sine) / mean)
    number = (tried_um * 1e-3) ** 2 / REACH_MM2
    v = per_mm * REACH_MM2 / (tried_um * 1e-3)
    wanted = np.sin(np.pi * number * v * (1.0 - v)) / (np.pi * number * v)
    wanted *= np.sinc(per_mm * PX_MM) * np.sinc(per_mm * PX_MM * FAR.seen)
    ray_um, wave_um = best(tried_um, -np.array(contrast)), best(tried_um, -wanted)
    print(f"best hole {ray_um:.1f} um, {wave_um:.1f} by waves; {contrast}, {wanted}")
    assert ray_um == pytest.approx(wave_um, rel=0.1)
    assert contrast == pytest.approx(wanted, abs=0.03)
