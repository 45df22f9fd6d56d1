"""The rays of a retinal pixel, reduced to what does not depend on the pixel.

With X the retinal pixel's panel point, a ray through the pupil at u crosses the array at
y = a X + phi(u) and, not bent, meets the panel at x = (m / m_0) X + psi(u), where a, phi and psi
follow from the design's backward ray:

    a   = (e + s_a (1 - e F)) / m_0
    phi = (1 - s_a F) u + (e + s_a (1 - e F)) T(u - o)
    psi = (1 - d F) u + m T(u - o)

and a lenslet centred at c subtracts (g / f) (y - c) from x. phi and psi are the same for
every pixel: a table of them, made once for a prescription, is all that tracing needs.
m / m_0 is 1 but for a colour that the headset's lens magnifies differently
(``vrlf/optics/bench.py``).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np

from vrlf.model import Rig
from vrlf.optics import sequence
from vrlf.optics.bench import Bench
from vrlf.optics.eye import EyeOptics, aberration_at, eye_optics
from vrlf.optics.lattice import Lattice, lattice_of
from vrlf.optics.polynomial import Float
from vrlf.optics.raster import cells_per_pixel
from vrlf.optics.viewport import RASTER_FLIP, Side, pitch_mm

# 16 MiB of table an eye and colour: what a mask of 0.4 % opening needs for 4096 seen rays.
MAX_POINTS = 1 << 20
# An area mean over more pixels a side than this costs more than the samples it saves.
_MOST_PIXELS = 8


@dataclass(frozen=True)
class PupilPoints:
    """Where an eye's rays pass the pupil, and which part of the retinal pixel each stands for.

    Attributes
    ----------
    u_mm : ndarray (n, 2)
        Pupil points from the optical axis, wearer's frame.
    from_centre_mm : ndarray (n, 2)
        The same from the pupil's own centre.
    within_pixel_mm : ndarray (n, 2)
        The retinal point's place in its pixel, from the pixel's centre, y up.
    """

    u_mm: Float
    from_centre_mm: Float
    within_pixel_mm: Float


def point_count(rays: int, lattice: Lattice | None) -> int:
    """How many pupil points it takes for about ``rays`` of them to be let through the array."""
    open_fraction = 1.0 if lattice is None else lattice.opening
    return min(MAX_POINTS, ceil(rays / open_fraction))


def pupil_points(rig: Rig, optics: EyeOptics, rays: int) -> PupilPoints:
    """Well-spread points over the pupil and over the retinal pixel's area."""
    square = sequence.points(point_count(rays, lattice_of(rig)))
    from_centre_mm = optics.weighed(sequence.to_disc(square[:, :2]) * optics.pupil_mm / 2.0)
    return PupilPoints(
        u_mm=from_centre_mm + np.array(optics.pupil_offset_mm),
        from_centre_mm=from_centre_mm,
        within_pixel_mm=(square[:, 2:] - 0.5) * pitch_mm(rig),
    )


@dataclass(frozen=True)
class RayTable:
    """phi and psi of one eye and colour, in the units that the shaders count in.

    Attributes
    ----------
    array_cells : ndarray (n, 2)
        phi in cells, lattice frame; zero without an array.
    landing_px : ndarray (n, 2)
        psi in pixels, right and down.
    within_pixel : ndarray (n, 2)
        Place in the retinal pixel, in pixels from its centre, right and down.
    within_cells : ndarray (n, 2)
        By how much that place moves the crossing; zero without an array.
    within_landing_px : ndarray (n, 2)
        By how much it moves the landing.
    """

    array_cells: Float
    landing_px: Float
    within_pixel: Float
    within_cells: Float
    within_landing_px: Float


def ray_table(
    rig: Rig, bench: Bench, lattice: Lattice | None, optics: EyeOptics, colour: int, rays: int
) -> RayTable:
    """The table of one eye and colour."""
    at = pupil_points(rig, optics, rays)
    aberration = aberration_at(optics.aberration[colour], at.from_centre_mm)
    phi_mm = bench.array_defocus_factor * at.u_mm + bench.array_per_slope_mm * aberration
    psi_mm = bench.defocus_factor * at.u_mm + bench.panel_per_slope_mm * aberration
    raster_from_mm = RASTER_FLIP / pitch_mm(rig)
    cells, moved = np.zeros_like(phi_mm), np.zeros_like(phi_mm)
    within = at.within_pixel_mm @ raster_from_mm.T
    if lattice is not None:
        cells = phi_mm @ lattice.cell_from_panel.T
        moved = bench.array_from_retina * within @ cells_per_pixel(rig, lattice).T
    return RayTable(
        array_cells=cells,
        landing_px=psi_mm @ raster_from_mm.T,
        within_pixel=within,
        within_cells=moved,
        within_landing_px=bench.panel_from_retina * within,
    )


def ray_tables(rig: Rig, side: Side, rays: int) -> tuple[RayTable, ...]:
    """One table where all colours share their rays, three in a chromatic eye."""
    optics, lattice = eye_optics(rig, side), lattice_of(rig)
    colours = range(3) if optics.is_chromatic else range(1)
    return tuple(
        ray_table(rig, optics.benches[colour], lattice, optics, colour, rays) for colour in colours
    )


def footprint_scale(bench: Bench, lattice: Lattice | None) -> float:
    """kappa: side of a retinal pixel's image on the panel at one pupil point, in pixels.

    m / m_0 - (g / f) a behind one lenslet, m / m_0 without an array. Its absolute value is what
    counts.
    """
    if lattice is None:
        return bench.panel_from_retina
    return bench.panel_from_retina - bench.bend * bench.array_from_retina


def uses_area_means(bench: Bench, lattice: Lattice | None) -> bool:
    """Whether a retinal pixel's image at one pupil point is averaged exactly, not sampled.

    It is without an array, and behind lenslets unless they spread the image over more pixels
    than are worth fetching for one ray. Holes cut the image up.
    """
    if lattice is None:
        return True
    return lattice.kind == "microlens" and footprint_pixels(bench, lattice) <= _MOST_PIXELS


def footprint_pixels(bench: Bench, lattice: Lattice | None) -> int:
    """How many pixels a side may share in a retinal pixel's image at one pupil point."""
    return ceil(abs(footprint_scale(bench, lattice))) + 1
