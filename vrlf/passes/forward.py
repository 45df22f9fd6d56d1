"""The forward prefilter."""

from __future__ import annotations

from typing import Any

import numpy as np

from vrlf.gpu import Block, Buffer, ComputeVariants, Device, Field, Texture
from vrlf.model import Rig
from vrlf.optics import polynomial
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.inverse import InverseMap, crossing_shift_mm, inverse_map
from vrlf.optics.lattice import lattice_of
from vrlf.optics.viewport import SIDES
from vrlf.passes.fields import (
    LATTICE_FIELDS,
    SUBPIXEL_FIELDS,
    VIEWPORT_FIELDS,
    lattice_rasters,
    lattice_values,
    subpixel_values,
    viewport_values,
)

FORWARD = Block(
    "Forward",
    (
        *VIEWPORT_FIELDS,
        *SUBPIXEL_FIELDS,
        *LATTICE_FIELDS,
        Field("vec4", "pupil_radii_per_cell", "2x2 of each eye: pupil radii per cell", 2),
        Field("int", "subpixel_grid", "samples along each side of a sub-pixel"),
    ),
)


class ForwardTables:
    """All that the forward prefilter needs of one rig with an array, made once."""

    def __init__(self, device: Device, rig: Rig) -> None:
        lattice, bench = lattice_of(rig), bench_of(rig)
        if lattice is None:
            raise ValueError("forward: a bare panel needs no tables, its image is the target")
        eyes = [eye_optics(rig, side) for side in SIDES]
        shared = rig.panel.subpixels == "full" and not any(eye.is_chromatic for eye in eyes)
        maps = [
            inverse_map(rig, bench, lattice, eye, colour)
            for eye in eyes
            for colour in range(1 if shared else 3)
        ]
        degree = max(polynomial.degree(c) for each in maps for c in each.displacement_px)
        self.defines: dict[str, int | float | str] = {
            "DEGREE": max(degree, 1),
            "RAY_SETS": 1 if shared else 3,
        }
        self.size_px = (rig.panel.width_px, rig.panel.height_px)
        self.displacements = Buffer(
            device, _coefficients(maps, max(degree, 1) + 1), label="displacements"
        )
        shift = {side: crossing_shift_mm(bench, eye) for side, eye in zip(SIDES, eyes, strict=True)}
        self.crossings, self.owners = lattice_rasters(device, rig, lattice, shift)
        self.values: dict[str, Any] = {
            **viewport_values(rig),
            **subpixel_values(rig),
            **lattice_values(rig, lattice),
            # Converging walls cut none of these rays: see the float64 twin.
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


def _coefficients(maps: list[InverseMap], size: int) -> np.ndarray[Any, np.dtype[np.float32]]:
    """Both polynomials of each map interleaved, shape (maps, size, size, 2)."""
    return np.stack(
        [
            np.stack([polynomial.padded(c, size) for c in each.displacement_px], axis=-1)
            for each in maps
        ]
    ).astype(np.float32)


class Forward:
    """Owns the programs of the forward pass, one for each kind of rig met so far."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._programs = ComputeVariants(device, "forward.comp", FORWARD)

    def run(self, tables: ForwardTables, target: Texture, shown: Texture) -> None:
        """Write the panel image for ``target`` into ``shown`` (rgba32f, the panel's size)."""
        program = self._programs.get(tables.defines)
        target.bind_sampler(0)
        shown.bind_image(0, read=False, write=True)
        tables.displacements.bind(0)
        tables.crossings.bind(2)
        tables.owners.bind(3)
        program.set(tables.values)
        program.run(*tables.size_px)
        self._device.check("prefiltering")

    def release(self) -> None:
        """Give the programs back."""
        self._programs.release()
