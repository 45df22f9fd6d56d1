"""MTF from a slanted edge, after ISO 12233 (e-SFR).

An edge a few degrees off the pixel columns is crossed by each row at another place of the
pixel, so the rows together sample it finer than the raster. P. D. Burns: *Slanted-Edge MTF for
Digital Camera and Scanner Analysis*, IS&T PICS 2000.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, radians, tan
from typing import Final

import numpy as np

from vrlf.errors import InputError
from vrlf.evaluation.metrics.model import Float, Picture
from vrlf.scene import luminance

SLANT_DEG: Final = 5.0
# Samples of the edge a pixel, as in the standard.
_OVERSAMPLING: Final = 4
_LEAST_SIDE_PX: Final = 16
# Rows are cut off this many pixels at the left and right of the edge's place, at least.
_LEAST_REACH_PX: Final = 4.0
_LEAST_STEP: Final = 1e-3


@dataclass(frozen=True)
class EdgeMtf:
    """What an edge keeps of each frequency.

    Attributes
    ----------
    cycles_per_degree
        Ascending from 0, across the edge, to one cycle a pixel; the raster itself shows none
        above half of that.
    mtf
        1 at 0. The raster's own share is in it: what a pixel's area takes from a drawn edge,
        sinc of the cycles per pixel.
    slant_deg
        The edge's angle to the columns as found, positive where it leans to the right upwards.
    """

    cycles_per_degree: Float
    mtf: Float
    slant_deg: float


def slanted_edge(
    width_px: int,
    height_px: int,
    *,
    slant_deg: float = SLANT_DEG,
    dark: float = 0.2,
    light: float = 0.8,
) -> Float:
    """A dark left half and a light right one, (H, W, 3), every pixel the mean over its area.

    The edge leans to the right upwards and passes through the picture's middle.
    """
    rows = (np.arange(height_px * 16) + 0.5) / 16.0
    places = width_px / 2.0 + (height_px / 2.0 - rows) * tan(radians(slant_deg))
    # Exact across a row; down a pixel the mean of 16 lines.
    covered = np.clip(np.arange(1, width_px + 1)[None, :] - places[:, None], 0.0, 1.0)
    share = covered.reshape(height_px, 16, width_px).mean(axis=1)
    return np.repeat((dark + (light - dark) * share)[..., None], 3, axis=2)


def edge_mtf(picture: Picture, pixels_per_degree: float) -> EdgeMtf:
    """MTF across the one edge that a picture shows, roughly along its columns.

    Parameters
    ----------
    picture : ndarray (H, W, 3)
        Linear light; 16 pixels a side or more. For an edge along the rows, its transpose.
    pixels_per_degree : float
        Of the raster.

    Raises
    ------
    InputError
        Too small a picture, or no edge in it that leans a little.
    """
    light = luminance(picture)
    if min(light.shape) < _LEAST_SIDE_PX:
        raise InputError(
            f"edge: found {light.shape[1]}x{light.shape[0]} pixels, wanted {_LEAST_SIDE_PX} a side"
        )
    slope, middle = _edge_line(light)
    distance = _distances_px(light.shape, slope, middle)
    spread = _line_spread(light, distance)
    frequencies = np.arange(len(spread) // 2 + 1) * _OVERSAMPLING / len(spread)  # cycles a pixel
    amplitude = np.abs(np.fft.rfft(spread))
    keep = frequencies <= 1.0
    # What a central difference takes, and what the mean over a bin takes.
    lost = np.sinc(2.0 * frequencies / _OVERSAMPLING) * np.sinc(frequencies / _OVERSAMPLING)
    return EdgeMtf(
        frequencies[keep] * pixels_per_degree,
        (amplitude / amplitude[0])[keep] / lost[keep],
        float(np.degrees(np.arctan(slope))),
    )


def _edge_line(light: Float) -> tuple[float, float]:
    """The edge's place is middle + slope * (rows above the middle), in pixels."""
    height, width = light.shape
    step = float(np.mean(light[:, -2:]) - np.mean(light[:, :2]))
    if abs(step) < _LEAST_STEP * max(float(np.max(np.abs(light))), 1e-12):
        raise InputError("edge: found none, wanted a dark side and a light one")
    up = (height - 1) / 2.0 - np.arange(height)
    change = np.diff(light, axis=1) * np.sign(step)
    between = np.arange(1, width, dtype=np.float64)  # where pixels meet, from the left side
    slope, middle = 0.0, width / 2.0
    reach = width / 2.0
    for _ in range(3):  # each time nearer to the edge, so that noise far off doesn't count
        weight = np.hamming(2049)
        off = between[None, :] - (middle + slope * up)[:, None]
        place = np.clip((off / reach + 1.0) * 1024.0, 0.0, 2048.0)
        weighed = np.where(np.abs(off) <= reach, np.interp(place, np.arange(2049), weight), 0.0)
        mass = np.sum(weighed * change, axis=1)
        if np.any(mass <= 0.0):
            raise InputError("edge: found rows without one, wanted it in all of them")
        slope, middle = np.polyfit(up, np.sum(weighed * change * between, axis=1) / mass, 1)
        reach = max(reach / 2.0, 2.0 * _LEAST_REACH_PX)
    if not 0.5 / height < abs(slope) < 1.0:
        raise InputError(
            f"edge: found one {np.degrees(np.arctan(slope)):.2f} degrees off the columns, wanted "
            "a few degrees, so that rows cross it at different places of a pixel"
        )
    return float(slope), float(middle)


def _distances_px(shape: tuple[int, ...], slope: float, middle: float) -> Float:
    """Of each pixel's centre from the edge, across it; positive at the right."""
    height, width = shape
    up = (height - 1) / 2.0 - np.arange(height)
    across = np.arange(width) + 0.5 - middle
    away = across[None, :] - slope * up[:, None]
    return np.asarray(away * cos(np.arctan(slope)))


def _line_spread(light: Float, distance: Float) -> Float:
    """The edge's derivative in bins of a quarter pixel, under a Hamming window."""
    # As far as every row reaches at both sides.
    reach = min(-float(distance[:, 0].max()), float(distance[:, -1].min()))
    if reach < _LEAST_REACH_PX:
        raise InputError("edge: found one too near to the picture's side, wanted it in the middle")
    half = int(reach * _OVERSAMPLING)
    place = np.floor(distance * _OVERSAMPLING).astype(int) + half
    inside = (place >= 0) & (place < 2 * half)
    counts = np.bincount(place[inside], minlength=2 * half)
    sums = np.bincount(place[inside], light[inside], minlength=2 * half)
    filled = counts > 0
    # A bin's pixels need not lie in its middle, so its mean stands where they do in the mean.
    places = np.bincount(place[inside], distance[inside], minlength=2 * half)
    centres = (np.arange(2 * half) + 0.5 - half) / _OVERSAMPLING
    edge = np.interp(centres, places[filled] / counts[filled], sums[filled] / counts[filled])
    spread = (edge[2:] - edge[:-2]) / 2.0
    return np.asarray(spread * np.hamming(len(spread)))
