"""What one eye sees of a small patch of the panel: a candidate's operator, fast and sampled.

The full operator of ``vrlf/passes/operator.py`` costs seconds on a CPU; a search asks for a
thousand. So each candidate is judged on a patch of some sixty retinal pixels a side in the middle
of one eye's view, with some hundred rays a pixel, all traced at once:

    q = a X + phi(u) in cells,    x = (m / m_0) X + psi(u) - (g / f) (q - cell) in pixels,

phi and psi those of ``vrlf/optics/maps.py``. Each ray that meets an emitting area is an entry of a
sparse matrix. Behind holes rays start in the holes instead, so that none is lost on the mask.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from vrlf.model import Rig
from vrlf.optics import sequence
from vrlf.optics.eye import eye_optics
from vrlf.optics.lattice import Lattice, lattice_of, nearest_cell
from vrlf.optics.maps import RayMaps, ray_maps
from vrlf.optics.polynomial import Float
from vrlf.optics.raster import pixels_per_cell
from vrlf.optics.samples import ray_table
from vrlf.optics.subpixels import Layout, layout
from vrlf.optics.viewport import RASTER_FLIP, Side, panel_points_mm, pitch_mm, viewport

Single = NDArray[np.float32]


@dataclass(frozen=True)
class Patch:
    """Retinal pixels of one eye in the middle of its view, and the panel pixels around them.

    Attributes
    ----------
    size_px : int
        Of the panel's window, each side: all that is solved for.
    margin_px : int
        By which the retinal patch is smaller, on each side.
    """

    size_px: int
    margin_px: int

    @property
    def seen_px(self) -> int:
        """Side of the retinal patch."""
        return self.size_px - 2 * self.margin_px

    @property
    def seen(self) -> slice:
        """The retinal patch's rows and columns, counted in the window."""
        return slice(self.margin_px, self.size_px - self.margin_px)


@dataclass(frozen=True)
class _Rays:
    """Where rays land in the panel's window, right and down, and what each counts.

    ``landing`` is (2, n, pixels), ``weight`` a number or (n, pixels), ``cell`` the cells passed
    where barriers ask for them.
    """

    landing: Single
    weight: Single | float
    cell: Single


def patch_matrices(rig: Rig, side: Side, patch: Patch, rays: int) -> list[csr_array]:
    """P / throughput of a patch, a matrix for each colour.

    Parameters
    ----------
    rig : Rig
        Its panel is the patch's: twice its size wide, as high, the axes in the
        middles of the halves (``vrlf.studies.quality.cropped``).
    rays : int
        Let through, for each retinal pixel.

    Returns
    -------
    list of three csr_array, (size_px^2, size_px^2)
        Rows of retinal pixels outside the patch are empty. One object where colours do not differ.
    """
    optics, emission = eye_optics(rig, side), layout(rig.panel.subpixels)
    first = viewport(rig, side).first_column
    matrices: list[csr_array] = []
    traced: dict[int, _Rays] = {}
    for colour in range(3):
        if emission.is_shared and not optics.is_chromatic and matrices:
            matrices.append(matrices[0])
            continue
        path = colour if optics.is_chromatic else 0
        if path not in traced:
            traced = {path: _traced(rig, side, patch, rays, path)}
        matrices.append(_matrix(traced[path], emission, patch, colour, first))
    return matrices


def _traced(rig: Rig, side: Side, patch: Patch, rays: int, path: int) -> _Rays:
    lattice, optics = lattice_of(rig), eye_optics(rig, side)
    if lattice is None:
        return _bare(rig, side, patch, rays, path)
    maps = ray_maps(rig, lattice, optics, path)
    cells, pixels = _chief_rays(rig, side, patch, maps)
    if lattice.kind == "pinhole":
        found = _through_holes(maps, cells, pixels, rays)
    else:
        found = _through_lenslets(maps, cells, pixels, rays)
    if lattice.barriers == "none":
        return found
    return _Rays(found.landing, found.weight * _is_owned(rig, side, patch, maps, found), found.cell)


def _bare(rig: Rig, side: Side, patch: Patch, rays: int, path: int) -> _Rays:
    """The same without an array."""
    optics, view = eye_optics(rig, side), viewport(rig, side)
    table = ray_table(rig, optics.benches[path], None, optics, path, rays)
    x_mm = panel_points_mm(rig, view)[patch.seen, patch.seen].reshape(-1, 2)
    scale = optics.benches[path].panel_from_retina / pitch_mm(rig)
    pixels = (x_mm @ RASTER_FLIP * scale + patch.size_px / 2.0).T
    landing = _all_sums(table.landing_px + table.within_landing_px, pixels)
    return _Rays(landing, 1.0 / rays, np.zeros_like(landing))


def _chief_rays(rig: Rig, side: Side, patch: Patch, maps: RayMaps) -> tuple[Float, Float]:
    """Cell coordinates and panel places of the retinal pixels' own rays; (2, pixels) each."""
    view, lattice, bench = viewport(rig, side), maps.lattice, maps.bench
    x_mm = panel_points_mm(rig, view)[patch.seen, patch.seen].reshape(-1, 2)
    at_mm = bench.array_from_retina * x_mm + np.array(view.axis_mm) - lattice.origin_mm
    px = x_mm @ RASTER_FLIP * (bench.panel_from_retina / pitch_mm(rig)) + patch.size_px / 2.0
    return (at_mm @ lattice.cell_from_panel.T).T, px.T


def _through_lenslets(maps: RayMaps, cells: Float, pixels: Float, rays: int) -> _Rays:
    """Rays spread evenly over pupil and pixel; the place in the cell bends them."""
    square = sequence.points(rays)
    phi, psi = maps(sequence.to_disc(square[:, :2]) * maps.optics.pupil_mm / 2.0)
    within = square[:, 2:] - 0.5
    q = _all_sums(phi + maps.crossed_by_px(within), cells)
    cell = _nearest(maps.lattice, q)
    q -= cell
    landing = _all_sums(psi + maps.landed_by_px(within), pixels)
    bend = (maps.bench.bend * pixels_per_cell(maps.rig, maps.lattice)).astype(np.float32)
    for axis in range(2):
        landing[axis] -= bend[axis, 0] * q[0] + bend[axis, 1] * q[1]
    return _Rays(landing, 1.0 / rays, cell)


def _all_sums(of_rays: Float, of_pixels: Float) -> Single:
    """Rays (n, 2) and pixels (2, k) to (2, n, k)."""
    return np.asarray(of_rays.T[:, :, None] + of_pixels[:, None, :], np.float32)


def _nearest(lattice: Lattice, q: Single) -> Single:
    if not lattice.is_hexagonal:
        return np.asarray(np.floor(q + np.float32(0.5)), np.float32)
    nearest = nearest_cell(lattice, np.moveaxis(q, 0, -1).astype(np.float64))
    return np.moveaxis(nearest, -1, 0).astype(np.float32)


def _through_holes(maps: RayMaps, cells: Float, pixels: Float, rays: int) -> _Rays:
    """Points of the holes about each pixel, led back to the pupil; those that meet it count.

    As ``vrlf/reference/quadrature.py`` does it: the way back is that of the sphero-cylinder.
    """
    lattice = maps.lattice
    to_edge, _ = maps.linear()
    pupil_cells = abs(float(np.linalg.det(to_edge))) * np.pi
    square = sequence.points(max(4, round(rays / max(pupil_cells, 1.0))))
    within = square[:, 2:] - 0.5
    moved, landed = maps.crossed_by_px(within), maps.landed_by_px(within)
    back, middle = np.linalg.inv(to_edge), maps(np.zeros((1, 2)))[0][0]
    reach = np.ceil(np.linalg.norm(to_edge, axis=1) + 1.0).astype(int)
    landings, weights, passed = [], [], []
    for in_hole, off, land in zip(_hole_places(lattice, square), moved, landed, strict=True):
        chief = cells.T + off + middle
        nearest = nearest_cell(lattice, chief)
        for step in np.ndindex(*(2 * reach + 1)):
            cell = nearest + step - reach
            disc = (cell + in_hole - chief) @ back.T
            meets = np.sum(disc**2, axis=-1) <= 1.0
            if meets.any():
                even_mm = np.where(meets[:, None], disc, 0.0) * maps.optics.pupil_mm / 2.0
                landings.append((maps(even_mm)[1] + land).T + pixels)
                weights.append(meets)
                passed.append(cell.T)
    share = 1.0 / (pupil_cells * len(square))
    shape = (2, 0, cells.shape[1])
    landing = np.stack(landings, axis=1) if landings else np.zeros(shape)
    cell = np.stack(passed, axis=1) if passed else np.zeros(shape)
    weight = np.array(weights, np.float32).reshape(landing.shape[1:]) * share
    return _Rays(landing.astype(np.float32), weight.astype(np.float32), cell.astype(np.float32))


def _hole_places(lattice: Lattice, square: Float) -> Float:
    """Points of a hole, in cells from its centre; (n, 2)."""
    unit = square[:, :2]
    spread = sequence.to_disc(unit) if lattice.round_holes else 2.0 * unit - 1.0
    upright = lattice.half_aperture * spread
    return np.asarray(upright @ np.linalg.inv(lattice.upright_from_cell).T)


def _is_owned(rig: Rig, side: Side, patch: Patch, maps: RayMaps, rays: _Rays) -> Single:
    """1 where no barrier stands between a cell and the panel point reached through it."""
    lattice, axis = maps.lattice, np.array(viewport(rig, side).axis_mm)
    from_axis_mm = (rays.landing - patch.size_px / 2.0) * pitch_mm(rig)
    from_axis_mm[1] *= -1.0
    at_mm = lattice.barrier_scale * from_axis_mm + (axis - lattice.origin_mm)[:, None, None]
    coordinates = np.einsum("ij,jnk->ink", lattice.cell_from_panel, at_mm).astype(np.float32)
    owner = _nearest(lattice, coordinates)
    return np.asarray(np.all(owner == rays.cell, axis=0), np.float32)


def _matrix(rays: _Rays, emission: Layout, patch: Patch, colour: int, first: int) -> csr_array:
    """Each ray that meets one of the colour's emitting areas is an entry; ``first`` column."""
    column, row = (np.floor(each).astype(np.int32) for each in rays.landing)
    boxes = emission.rectangles.reshape(-1, 3, 4)[:, colour]
    if emission.places == 1:
        box = boxes[0]
    else:
        columns, rows = emission.period
        box = boxes[row % rows * columns + (column + first) % columns].transpose(2, 0, 1)
    size = patch.size_px
    hit = (column >= 0) & (column < size) & (row >= 0) & (row < size)
    for axis, at in enumerate((column, row)):
        if not _is_whole(box[axis], box[axis + 2]):
            place = rays.landing[axis] - at
            hit &= (place >= box[axis]) & (place < box[axis + 2])
    own = np.arange(size**2, dtype=np.int32).reshape(size, size)[patch.seen, patch.seen].ravel()
    pixel = np.broadcast_to(own, hit.shape)[hit]
    at_panel = row[hit] * size + column[hit]
    weight = rays.weight if isinstance(rays.weight, float) else rays.weight[hit].astype(np.float64)
    values = np.broadcast_to(float(emission.gain[colour]) * weight, pixel.shape)
    return coo_array((values, (pixel, at_panel)), shape=(size**2, size**2)).tocsr()


def _is_whole(low: Float, high: Float) -> bool:
    return bool(np.all(low <= 0.0) and np.all(high >= 1.0))
