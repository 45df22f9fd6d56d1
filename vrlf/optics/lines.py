"""Lines through pupil and retinal pixel, for lenslets; see ``vrlf/optics/quadrature.py``."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, sqrt

import numpy as np

from vrlf.model import Rig
from vrlf.optics import sequence
from vrlf.optics.eye import EyeOptics
from vrlf.optics.lattice import lattice_of
from vrlf.optics.maps import RayMaps, ray_maps
from vrlf.optics.polynomial import Float
from vrlf.optics.raster import pixels_per_cell
from vrlf.optics.sequence import Half
from vrlf.optics.subpixels import layout
from vrlf.optics.viewport import RASTER_FLIP, pitch_mm

# Fewer lines than this sample no pupil.
_FEWEST_LINES = 8
# A wavefront's chord is cut until the middle of each part lies within this, divided by the root
# of the rays, of where the part's ends put it.
_STRAIGHT_PX = 8.0
_MOST_PARTS = 32
_DIRECTIONS = 72


@dataclass(frozen=True)
class Stretches:
    """Straight stretches through pupil and retinal pixel, begin and end in the middle axis.

    Attributes
    ----------
    from_centre_mm : ndarray (n, 2, 2)
        Pupil points from the pupil's own centre, wearer's frame; spread evenly, so not weighed by
        the Stiles-Crawford effect yet.
    within_pixel_mm : ndarray (n, 2, 2)
        Places in the retinal pixel, from its centre, y up.
    share : ndarray (n,)
        How much of the mean each stands for; the sum is 1.
    """

    from_centre_mm: Float
    within_pixel_mm: Float
    share: Float


@dataclass(frozen=True)
class LineTable:
    """Stretches as the shaders count, of one eye and colour.

    Attributes
    ----------
    crossing_cells : ndarray (n, 4)
        phi + a w in cells where the stretch begins, and how far it moves to its end.
    landing_px : ndarray (n, 4)
        psi + w - (g / f) (phi + a w) there in pixels, right and down, and how far it moves.
    share : ndarray (n,)
        Times n: the mean over the table is the light.
    pieces : int
        Into which a stretch can be cut, at most.
    """

    crossing_cells: Float
    landing_px: Float
    share: Float
    pieces: int


def stretches(rig: Rig, optics: EyeOptics, colour: int, rays: int, half: Half) -> Stretches:
    """The lines of one eye and colour, about ``rays`` pieces of them for a retinal pixel."""
    lattice = lattice_of(rig)
    assert lattice is not None
    maps = ray_maps(rig, lattice, optics, colour)
    along = _direction(maps)
    parts = _parts(maps, along, rays)
    trial = _cut(maps, along, 16, parts)
    pieces = float(_pieces(maps, trial)[0].sum()) / 16.0
    count = 2 * max(_FEWEST_LINES // 2, round(rays / pieces / 2.0))
    lines = _cut(maps, along, count, parts)
    if half == "all":
        return lines
    kept = np.arange(len(lines.share)) // (parts + 1) % 2 == (half == "second")
    return Stretches(
        lines.from_centre_mm[kept], lines.within_pixel_mm[kept], 2.0 * lines.share[kept]
    )


def _cut(maps: RayMaps, along: Float, count: int, parts: int) -> Stretches:
    """``count`` chords of equal area, each in ``parts`` and once more where w wraps around."""
    place = (np.arange(count) + 0.5) / count
    offset = _offset_of_area(place)
    within = sequence.points(count)[:, 2:]
    wrap = 1.0 - within[:, :1]
    even = np.broadcast_to(np.linspace(0.0, 1.0, parts + 1), (count, parts + 1))
    breaks = np.sort(np.concatenate([even, wrap], axis=1), axis=1)
    at = np.stack([breaks[:, :-1], breaks[:, 1:]], axis=-1)  # (count, parts + 1, 2)
    beyond = at.mean(axis=-1, keepdims=True) > wrap[..., None]
    right = within[:, :1, None] + at - beyond
    up = np.broadcast_to(within[:, 1:, None], right.shape)
    across = np.array([-along[1], along[0]])
    half_chord = np.sqrt(1.0 - offset**2)[:, None, None]
    disc = offset[:, None, None, None] * across + (half_chord * (2.0 * at - 1.0))[..., None] * along
    return Stretches(
        from_centre_mm=disc.reshape(-1, 2, 2) * maps.optics.pupil_mm / 2.0,
        within_pixel_mm=(np.stack([right, up], axis=-1).reshape(-1, 2, 2) - 0.5)
        * pitch_mm(maps.rig),
        share=(at[..., 1] - at[..., 0]).ravel() / count,
    )


def _offset_of_area(share: Float) -> Float:
    """Offset of the chord of the unit disc that has this share of its area on one side."""
    # Newton's steps from the middle on (angle - sin angle) / 2 pi, of which they never pass the
    # root: convex below pi, concave above.
    angle = np.full_like(share, np.pi)
    for _ in range(60):
        slope = np.maximum(1.0 - np.cos(angle), 1e-9)
        angle = angle - (angle - np.sin(angle) - 2.0 * np.pi * share) / slope
    return np.asarray(-np.cos(angle / 2.0))


def _direction(maps: RayMaps) -> Float:
    """The direction whose line through the pupil's centre meets the most borders.

    Of cells and of emitting areas: what a line averages by itself is not left to the number of
    lines. Measured over all directions, 200 rays: the error varies three- to fourfold and
    falls with that number; this picks within a fifth of the best.
    """
    angle = 2.0 * np.pi * (np.arange(_DIRECTIONS) + 0.5) / _DIRECTIONS
    along = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    phi, psi = maps.linear()
    rightward = np.array([1.0, 0.0])
    crossing = 2.0 * along @ phi.T + maps.crossed_by_px(rightward)
    bent = maps.bench.bend * crossing @ pixels_per_cell(maps.rig, maps.lattice).T
    landing = 2.0 * along @ psi.T + maps.landed_by_px(rightward) - bent
    boxes = layout(maps.rig.panel.subpixels).lit
    sides = (boxes[:, 2:] - boxes[:, :2]).mean(axis=0)
    borders = maps.lattice.mean_borders(crossing) + np.sum(np.abs(landing) / sides, axis=1)
    return np.asarray(along[int(np.argmax(borders))])


def _parts(maps: RayMaps, along: Float, rays: int) -> int:
    """Into how many parts a chord is cut so that each is as good as straight.

    What few rays leave is more than a bent line's error; so many cuts would eat them up.
    """
    if maps.is_affine:
        return 1
    straight_px = _STRAIGHT_PX / sqrt(rays)
    parts = 2
    while parts < _MOST_PARTS and _sag_px(maps, along, parts) > straight_px:
        parts *= 2
    return parts


def _sag_px(maps: RayMaps, along: Float, parts: int) -> float:
    """How far the middle of a part lands from the middle of its ends, at most."""
    ends = _cut(maps, along, 16, parts).from_centre_mm
    middle = maps(ends.mean(axis=1))
    sags = [np.abs(each.mean(axis=1) - mid) for each, mid in zip(maps(ends), middle, strict=True)]
    # What a crossing is off, the lenslet bends.
    bend = max(maps.bench.bend, 1.0) * maps.lattice.pitch_mm / pitch_mm(maps.rig)
    return float(max(sags[0].max() * bend, sags[1].max()))


def _table(maps: RayMaps, lines: Stretches) -> tuple[Float, Float]:
    """phi + a w in cells and the landing in pixels at both ends; each (n, 2, 2)."""
    phi, psi = maps(lines.from_centre_mm)
    within_px = lines.within_pixel_mm @ (RASTER_FLIP / pitch_mm(maps.rig)).T
    crossing = phi + maps.crossed_by_px(within_px)
    bent = maps.bench.bend * crossing @ pixels_per_cell(maps.rig, maps.lattice).T
    return crossing, psi + maps.landed_by_px(within_px) - bent


def _pieces(maps: RayMaps, lines: Stretches) -> tuple[Float, Float]:
    """How many a stretch falls into, on the average and at most: one, and one for each border."""
    crossing, landing = (each[:, 1] - each[:, 0] for each in _table(maps, lines))
    edges = 1.0 + np.abs(landing).sum(axis=1)
    return maps.lattice.mean_borders(crossing) + edges, maps.lattice.most_borders(crossing) + edges


def line_table(
    rig: Rig, optics: EyeOptics, colour: int, rays: int, half: Half = "all"
) -> LineTable:
    """The lines of one eye and colour behind lenslets."""
    lattice = lattice_of(rig)
    assert lattice is not None
    maps = ray_maps(rig, lattice, optics, colour)
    lines = stretches(rig, optics, colour, rays, half)
    crossing, landing = _table(maps, lines)
    return LineTable(
        crossing_cells=np.concatenate([crossing[:, 0], crossing[:, 1] - crossing[:, 0]], axis=1),
        landing_px=np.concatenate([landing[:, 0], landing[:, 1] - landing[:, 0]], axis=1),
        share=lines.share * len(lines.share),
        # Each coordinate may meet one border more than it is long; hexagons two in all.
        pieces=ceil(float(_pieces(maps, lines)[1].max())) + 4,
    )
