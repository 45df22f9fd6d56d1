"""The forward prefilter.

A sub-pixel is the mean of k x k samples. Two programs share the work: *footprints* do all
pixels at once, reading each texel once, and are right for those of which the samples of each
sub-pixel do alike; the *cut* ones are listed once for a prescription and done again sample by
sample. Where footprints don't pay (wide images, k = 1) all is done sample by sample.

With a wavefront nothing is done twice: all pixels are sorted and listed, see ``forward_lists``.

Both are exact: on noise they differ from the plain shader (``forward_plain``) by 9e-8 RMS, so no
picture pays for the speed. Measured on software GL, two busy cores, 1334x750, in one process by
turns, the least of 8 runs each in ms (predicted: 4 gathers for 36 fetches, and a quarter of the
pixels again, 8 times faster than plain):

================= ===== ====== ============ ========= ==== ======
rig               plain fast   samples only cut share twin tables
================= ===== ====== ============ ========= ==== ======
matched-microlens 1486  186    221          0.26      9137 123
matched-full      528   113    134          0.38      6688 52
thesis-minus-5d   1593  141    196          0.21      7282 115
pinhole           1534  150    211          0.21      7133 124
two-eyes          1395  205    242          0.20      9629 95
================= ===== ====== ============ ========= ==== ======

Most of what plain loses on software GL are its reads of storage buffers, lane by lane.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu import Block, ComputePass, ComputeVariants, Device, Field, Texture
from vrlf.model import Rig
from vrlf.model.zernike import ZERNIKE_ORDER_LIMIT
from vrlf.optics.bench import bench_of, colour_benches, is_lateral
from vrlf.optics.footprint import Footprints, footprints, pays, sample_grid
from vrlf.optics.lattice import lattice_of
from vrlf.optics.polynomial import Float
from vrlf.optics.raster import cells_per_pixel
from vrlf.optics.subpixels import layout
from vrlf.optics.viewport import SIDES, viewport
from vrlf.passes.fields import (
    LATERAL_FIELDS,
    LATTICE_FIELDS,
    MOST_PLACES,
    VIEWPORT_FIELDS,
    crossing_rasters,
    lateral_values,
    lattice_defines,
    lattice_values,
    padded,
    subpixel_defines,
    viewport_values,
)
from vrlf.passes.forward_lists import PixelList, SortedPixels, sort_pixels
from vrlf.passes.forward_maps import (
    crossing_shifts,
    curves_alike,
    inverse_maps,
    moves_from_lenslets_px,
)
from vrlf.passes.register import REGISTER, RegisterTables

_MAPS = 6  # two eyes by three colours, at most
# Of each place of a layout's period: three sub-pixels, which each map shows its way.
_SAMPLES, _STEPS = 3 * MOST_PLACES, _MAPS * MOST_PLACES
# Of a polynomial of two variables: a slope of a wavefront of the highest order.
_COEFFICIENTS = ZERNIKE_ORDER_LIMIT**2

FORWARD = Block(
    "Forward",
    (
        *VIEWPORT_FIELDS,
        *LATTICE_FIELDS,
        *LATERAL_FIELDS,
        Field("vec4", "pupil_radii_per_cell", "2x2 of each map: pupil radii per cell", _MAPS),
        Field("vec4", "samples", "of each colour: its first sample's place, the step", _SAMPLES),
        Field("vec4", "target_steps", "of each map: that step in the target, across, down", _STEPS),
        Field("vec4", "moves", "xy: coefficients of each map's X - x", _MAPS * _COEFFICIENTS),
    ),
)


class ForwardTables:
    """All that the forward prefilter needs of one rig with an array, made once.

    What is cut is found by a program, so it is ``Forward`` that adds it.
    """

    def __init__(self, device: Device, rig: Rig) -> None:
        lattice = lattice_of(rig)
        if lattice is None:
            raise ValueError("forward: a bare panel needs no tables, its image is the target")
        maps, ray_sets = inverse_maps(rig, lattice)
        grid = rig.prefilter.subpixel_grid
        emission = layout(rig.panel.subpixels)
        samples = [sample_grid(r, grid) for r in emission.rectangles]
        per_px = cells_per_pixel(rig, lattice)
        crossed = [each.array_from_panel * per_px for each in colour_benches(rig)[:ray_sets]]
        moves = moves_from_lenslets_px(maps, crossed * len(SIDES))
        self.is_curved = moves.shape[1] > 2
        # At each place of the period, by each map.
        places = emission.places
        shown = [each for i in range(places) for each in _of_maps(samples, i, ray_sets)]
        self.footprints = footprints(maps * places, crossed * len(SIDES) * places, shown, grid)
        self.defines: dict[str, int | float | str] = {
            "DEGREE": moves.shape[1] - 1,
            "RAY_SETS": ray_sets,
            "ONE_BOX": int(emission.is_shared),
            "ALIKE": int(curves_alike(moves, ray_sets)),
            "GRID": grid,
            # Converging walls cut none of these rays: see the float64 twin.
            "WALLS": int(lattice.barriers == "perpendicular"),
            **subpixel_defines(rig),
            "LATERAL": int(is_lateral(rig)),
            **lattice_defines(lattice),
        }
        self.size_px = (rig.panel.width_px, rig.panel.height_px)
        # The middle column of an odd width is done with the left eye's.
        self.columns_an_eye = viewport(rig, "right").first_column
        benches = colour_benches(rig) if is_lateral(rig) else (bench_of(rig),)
        crossings = [(bench.array_from_panel, crossing_shifts(rig, bench)) for bench in benches]
        self.crossings, self.owners = crossing_rasters(device, rig, lattice, crossings)
        # Footprints do all pixels but these; None until they were looked for, or without any.
        self.cut: PixelList | None = None
        # With wavefronts: all that aren't dark; None until they were looked for.
        self.sorted: SortedPixels | None = None
        self.values: dict[str, Any] = {
            **viewport_values(rig),
            **lattice_values(rig, lattice),
            **lateral_values(rig, [each.retina_from_panel for each in maps[:3]]),
            "pupil_radii_per_cell": padded(
                [each.pupil_radii_per_cell.ravel() for each in maps], _MAPS
            ),
            "samples": padded(samples, _SAMPLES),
            "target_steps": padded(self.footprints.steps_px if self.footprints else (), _STEPS),
            "moves": padded(moves.reshape(-1, 2), _MAPS * _COEFFICIENTS),
        }

    def bind(self) -> None:
        """For the shaders' storage buffers."""
        self.crossings.bind(2)
        self.owners.bind(3)

    def release(self) -> None:
        """Give all tables back."""
        self.crossings.release()
        self.owners.release()
        for lists in (self.cut, self.sorted):
            if lists is not None:
                lists.release()


def forward_tables(device: Device, rig: Rig) -> ForwardTables | RegisterTables:
    """The tables of a rig for which ``forward_changes`` anything."""
    return RegisterTables(rig) if rig.array.kind == "none" else ForwardTables(device, rig)


def _of_maps(samples: list[Float], place: int, ray_sets: int) -> list[Float]:
    """The sub-pixel that each map shows at one place of the period, the left eye's first."""
    return samples[3 * place : 3 * place + ray_sets] * len(SIDES)


class Forward:
    """Owns the programs of the forward pass, those of each kind of rig met so far."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._samples = ComputeVariants(device, "forward.comp", FORWARD)
        self._footprints = ComputeVariants(device, "forward_footprints.comp", FORWARD)
        self._cut = ComputeVariants(device, "forward_cut.comp", FORWARD)
        self._kinds = ComputeVariants(device, "forward_kinds.comp", FORWARD)
        self._dark = ComputeVariants(device, "forward_dark.comp", FORWARD)
        self._register = ComputeVariants(device, "register.comp", REGISTER)

    def run(self, tables: ForwardTables | RegisterTables, target: Texture, shown: Texture) -> None:
        """Write the panel image for ``target`` into ``shown`` (rgba32f, the panel's size)."""
        self.complete(tables)
        target.bind_sampler(0)
        shown.bind_image(0, read=False, write=True)
        if isinstance(tables, RegisterTables):
            program = self._register.get({})
            program.set(tables.values)
            program.run(*tables.size_px)
            self._device.check("bringing the colours together")
            return
        tables.bind()
        if tables.sorted is not None:
            self._run_sorted(tables, tables.sorted)
        else:
            _run_raster(self._of_all(tables), tables)
        if tables.cut is not None:
            _run_list(self._by_samples(tables, listed=True), tables, tables.cut)
        self._device.check("prefiltering")

    def complete(self, tables: ForwardTables | RegisterTables) -> None:
        """Compile what these tables need and list pixels; does nothing the second time.

        ``run`` sees to it. Called when tables are made, it keeps that work out of a frame.
        """
        if isinstance(tables, RegisterTables):
            self._register.get({})
            return
        if tables.is_curved:
            if tables.sorted is None:
                self._sort(tables)
            return
        if tables.footprints is not None and tables.cut is None:
            self._list_cut(tables, tables.footprints)
        self._of_all(tables)
        if tables.cut is not None:
            self._by_samples(tables, listed=True)

    def _list_cut(self, tables: ForwardTables, made: Footprints) -> None:
        """List the cut pixels, or give footprints up where there are too many of them."""
        is_cut = self._flags(self._cut, tables) != 0
        if pays(made, float(is_cut.mean()), int(tables.defines["GRID"])):
            tables.cut = PixelList(self._device, is_cut, tables.columns_an_eye, label="cut pixels")
        else:
            tables.footprints = None

    def _sort(self, tables: ForwardTables) -> None:
        """List all pixels that aren't dark, by how they are done, and compile that."""
        kinds, grid = self._flags(self._kinds, tables), int(tables.defines["GRID"])
        view_px, right = tables.values["view_px"], tables.columns_an_eye
        tables.sorted = sort_pixels(self._device, kinds, grid, view_px, right)
        self._dark.get({})
        self._by_samples(tables, listed=True)
        if tables.sorted.window is not None:
            self._by_footprints(tables, tables.sorted.window, listed=True)

    def _flags(self, programs: ComputeVariants, tables: ForwardTables) -> NDArray[np.uint8]:
        """What a program writes of each pixel, shape (H, W)."""
        flags = Texture(self._device, tables.size_px, components=1, kind="u1", label="cut pixels")
        try:
            flags.bind_image(0, read=False, write=True)
            tables.bind()
            _run_raster(programs.get(tables.defines), tables)
            return np.asarray(flags.read()[..., 0], np.uint8)
        finally:
            flags.release()

    def _run_sorted(self, tables: ForwardTables, made: SortedPixels) -> None:
        _run_list(self._dark.get({}), tables, made.dark)
        if made.window is not None:
            program = self._by_footprints(tables, made.window, listed=True)
            _run_list(program, tables, made.by_footprints)
        _run_list(self._by_samples(tables, listed=True), tables, made.by_samples)

    def _of_all(self, tables: ForwardTables) -> ComputePass:
        made = tables.footprints
        if made is None:
            return self._by_samples(tables, listed=False)
        return self._by_footprints(tables, made.window, aligned=made.aligned, listed=False)

    def _by_footprints(
        self,
        tables: ForwardTables,
        window: tuple[int, int],
        *,
        aligned: bool = False,
        listed: bool,
    ) -> ComputePass:
        shape = {"WINDOW_X": window[0], "WINDOW_Y": window[1], "ALIGNED": int(aligned)}
        return self._footprints.get(tables.defines | shape | {"LISTED": int(listed)})

    def _by_samples(self, tables: ForwardTables, *, listed: bool) -> ComputePass:
        return self._samples.get(tables.defines | {"LISTED": int(listed)})

    def release(self) -> None:
        """Give the programs back."""
        for programs in (
            self._samples,
            self._footprints,
            self._cut,
            self._kinds,
            self._dark,
            self._register,
        ):
            programs.release()


def _run_raster(program: ComputePass, tables: ForwardTables) -> None:
    program.set(tables.values)
    program.run(tables.columns_an_eye, tables.size_px[1], len(SIDES))


def _run_list(program: ComputePass, tables: ForwardTables, listed: PixelList) -> None:
    program.set(tables.values)
    listed.run(program)
