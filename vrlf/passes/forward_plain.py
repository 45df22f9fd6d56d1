"""The forward prefilter as one would write it first: what ``Forward`` is timed against.

Each sample of each sub-pixel finds its lenslet, evaluates the map's polynomial from a storage
buffer and fetches four whole texels. It shows the same picture to float32's rounding.
"""

from __future__ import annotations

from typing import Any

from vrlf.gpu import Block, Buffer, ComputeVariants, Device, Field, Texture
from vrlf.model import Rig
from vrlf.optics.bench import bench_of, is_lateral
from vrlf.optics.eye import eye_optics
from vrlf.optics.inverse import crossing_shift_mm
from vrlf.optics.lattice import lattice_of
from vrlf.optics.viewport import SIDES
from vrlf.passes.fields import (
    LATTICE_FIELDS,
    SUBPIXEL_FIELDS,
    VIEWPORT_FIELDS,
    lattice_defines,
    lattice_rasters,
    lattice_values,
    subpixel_defines,
    subpixel_values,
    viewport_values,
)
from vrlf.passes.forward_maps import inverse_maps, moves_px

FORWARD_PLAIN = Block(
    "ForwardPlain",
    (
        *VIEWPORT_FIELDS,
        *SUBPIXEL_FIELDS,
        *LATTICE_FIELDS,
        Field("vec4", "pupil_radii_per_cell", "2x2 of each eye: pupil radii per cell", 2),
        Field("int", "subpixel_grid", "samples along each side of a sub-pixel"),
    ),
)


class PlainForwardTables:
    """All that the plain forward prefilter needs of one rig with an array, made once."""

    def __init__(self, device: Device, rig: Rig) -> None:
        lattice, bench = lattice_of(rig), bench_of(rig)
        if lattice is None:
            raise ValueError("forward: a bare panel needs no tables, its image is the target")
        if is_lateral(rig):
            raise ValueError("forward, plain: all colours must be magnified alike")
        maps, ray_sets = inverse_maps(rig, lattice)
        moves = moves_px(maps)
        self.defines = {
            "DEGREE": moves.shape[1] - 1,
            "RAY_SETS": ray_sets,
            **subpixel_defines(rig),
            **lattice_defines(lattice),
        }
        self.size_px = (rig.panel.width_px, rig.panel.height_px)
        self.displacements = Buffer(device, moves, label="displacements")
        shift = {side: crossing_shift_mm(bench, eye_optics(rig, side)) for side in SIDES}
        self.crossings, self.owners = lattice_rasters(device, rig, lattice, shift)
        self.values: dict[str, Any] = {
            **viewport_values(rig),
            **subpixel_values(rig),
            **lattice_values(rig, lattice),
            "barriers": int(lattice.barriers == "perpendicular"),
            "pupil_radii_per_cell": [
                maps[0].pupil_radii_per_cell.ravel(),
                maps[-1].pupil_radii_per_cell.ravel(),
            ],
            "subpixel_grid": rig.prefilter.subpixel_grid,
        }

    def release(self) -> None:
        """Give all tables back."""
        for buffer in (self.displacements, self.crossings, self.owners):
            buffer.release()


class PlainForward:
    """Owns the programs of the plain forward pass, one for each kind of rig met so far."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._programs = ComputeVariants(device, "forward_plain.comp", FORWARD_PLAIN)

    def run(self, tables: PlainForwardTables, target: Texture, shown: Texture) -> None:
        """Write the panel image for ``target`` into ``shown`` (rgba32f, the panel's size)."""
        program = self._programs.get(tables.defines)
        target.bind_sampler(0)
        shown.bind_image(0, read=False, write=True)
        tables.displacements.bind(0)
        tables.crossings.bind(2)
        tables.owners.bind(3)
        program.set(tables.values)
        program.run(*tables.size_px)
        self._device.check("prefiltering plainly")

    def release(self) -> None:
        """Give the programs back."""
        self._programs.release()
