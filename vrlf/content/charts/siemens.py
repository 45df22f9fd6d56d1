"""The Siemens star: every spatial frequency up to the pixels' own limit, in every direction."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from vrlf.content.charts.model import BLACK, GREY, WHITE, Chart, Viewport
from vrlf.content.charts.raster import blank, blend, pixel_offsets
from vrlf.content.charts.shapes import Floats

CYCLES: Final = 36
NYQUIST_CYCLES_PER_PIXEL: Final = 0.5
# Where a cycle of the star is two pixels long. Inside lies the grey centre disc.
NYQUIST_RADIUS_PX: Final = CYCLES / (2.0 * math.pi * NYQUIST_CYCLES_PER_PIXEL)


def draw_siemens(viewport: Viewport) -> Chart:
    """Draw white spokes on black about the viewport's centre, grey outside and inside.

    The star fills the shorter side. The grey is the star's mean light.
    """
    x, y = pixel_offsets(viewport, (viewport.width_px / 2.0, viewport.height_px / 2.0))
    radius_px = np.hypot(x, y)
    outer_px = viewport.shorter_side_px / 2.0 - 1.0
    # Coverage of an edge by the distance to it: exact to a pixel's own slant.
    in_star = np.clip(outer_px - radius_px + 0.5, 0.0, 1.0)
    in_star *= np.clip(radius_px - NYQUIST_RADIUS_PX + 0.5, 0.0, 1.0)
    white = in_star * _spokes(np.arctan2(y, x), radius_px)
    picture = blank(viewport, GREY)
    blend(picture, in_star, BLACK)
    picture += white[..., np.newaxis].astype(np.float32) * np.array(WHITE, np.float32)
    return Chart(np.clip(picture, 0.0, 1.0), tuple(_notes(viewport, outer_px)))


def _spokes(angle_rad: Floats, radius_px: Floats) -> Floats:
    """White share of each pixel: the square wave's mean over one pixel along the ring.

    Unlike the distance to the nearest edge this holds down to Nyquist's radius,
    where a pixel meets two edges.
    """
    phase = CYCLES * angle_rad
    half_pixel = CYCLES * 0.5 / np.maximum(radius_px, 0.5)
    rise = _square_wave_integral(phase + half_pixel) - _square_wave_integral(phase - half_pixel)
    return rise / (2.0 * half_pixel)


def _square_wave_integral(phase_rad: Floats) -> Floats:
    """Integral from 0 of the wave that is 1 on the first half of each turn, 0 on the second."""
    turns = np.floor(phase_rad / (2.0 * math.pi))
    rest = phase_rad - turns * (2.0 * math.pi)
    return turns * math.pi + np.minimum(rest, math.pi)


def _notes(viewport: Viewport, outer_px: float) -> list[str]:
    ppd = viewport.pixels_per_degree
    # Along a ring of r pixels a degree holds this many cycles, times 1 / r.
    cycles_per_degree_times_px = CYCLES / (2.0 * math.pi) * ppd
    return [
        f"{CYCLES} cycles a turn; centre at x {viewport.width_px / 2.0:g} px, "
        f"y {viewport.height_px / 2.0:g} px, outer radius {outer_px:g} px",
        f"pixel Nyquist at radius {NYQUIST_RADIUS_PX:.2f} px, the edge of the centre disc: "
        f"{ppd * NYQUIST_CYCLES_PER_PIXEL:.2f} cycles per degree",
        f"{cycles_per_degree_times_px / outer_px:.2f} cycles per degree at the outer radius; "
        f"at radius r px {cycles_per_degree_times_px:.2f} / r cycles per degree",
    ]
