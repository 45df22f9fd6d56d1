"""Alignment screens: the panel image itself, past every prefilter."""

from __future__ import annotations

from typing import Any

from vrlf.errors import InputError
from vrlf.gpu import Block, ComputeVariants, Device, Field, Texture
from vrlf.model import Rig
from vrlf.optics.alignment import (
    ALIGNMENT_SCREENS,
    CARD_LINE_MM,
    CARD_MM,
    FRAME_MM,
    NONIUS_MM,
    TICK_MM,
    TICKS_MM,
    AlignmentScreen,
    fringe_cells,
    middle_cell,
    pupil_shift_mm,
)
from vrlf.optics.lattice import lattice_of
from vrlf.optics.viewport import SIDES, pitch_mm, viewport
from vrlf.passes.fields import (
    VIEWPORT_FIELDS,
    lattice_defines,
    lattice_rasters,
    viewport_values,
)

ALIGNMENT = Block(
    "Alignment",
    (
        *VIEWPORT_FIELDS,
        Field("float", "pixel_mm", "pixel pitch"),
        Field("float", "fringe_cells", "cells from fringe to fringe"),
        Field("vec4", "middle_cells", "of each eye: the cell at which its fringes meet", 2),
        Field("vec4", "axes_mm", "of each eye: its axis on the panel, right and up", 2),
    ),
)
_SIZES: dict[str, int | float | str] = {
    "CARD_X_MM": repr(CARD_MM[0]),
    "CARD_Y_MM": repr(CARD_MM[1]),
    "CARD_LINE_MM": repr(CARD_LINE_MM),
    "TICK_MM": repr(TICK_MM),
    "TICK_ONE_MM": repr(TICKS_MM[0]),
    "TICK_FIVE_MM": repr(TICKS_MM[1]),
    "TICK_TEN_MM": repr(TICKS_MM[2]),
    "FRAME_MM": repr(FRAME_MM[0]),
    "FRAME_LINE_MM": repr(FRAME_MM[1]),
    "NONIUS_MM": repr(NONIUS_MM[0]),
    "NONIUS_FROM_MM": repr(NONIUS_MM[1]),
    "NONIUS_TO_MM": repr(NONIUS_MM[2]),
}


class Alignment:
    """Owns the programs, one for each screen met so far."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._programs = ComputeVariants(device, "alignment.comp", ALIGNMENT)

    def run(self, rig: Rig, screen: AlignmentScreen, panel: Texture) -> None:
        """Write a screen for the rig as it is thought to be into ``panel`` (rgba32f).

        Raises
        ------
        InputError
            For fringes without an array.
        """
        lattice = lattice_of(rig)
        if lattice is None and screen.startswith("fringes"):
            raise InputError("alignment: found no array, wanted one whose fringes can be seen")
        number = ALIGNMENT_SCREENS.index(screen)
        program = self._programs.get({**_SIZES, **lattice_defines(lattice), "SCREEN": number})
        crossings, owners = lattice_rasters(self._device, rig, lattice, pupil_shift_mm(rig))
        try:
            crossings.bind(2)
            panel.bind_image(0, read=False, write=True)
            program.set(_values(rig))
            program.run(*panel.size_px)
            self._device.check("drawing the alignment screen")
        finally:
            crossings.release()
            owners.release()

    def release(self) -> None:
        """Give the programs back."""
        self._programs.release()


def _values(rig: Rig) -> dict[str, Any]:
    lattice = lattice_of(rig)
    cells = [(0.0, 0.0) if lattice is None else middle_cell(rig, lattice, side) for side in SIDES]
    return {
        **viewport_values(rig),
        "pixel_mm": pitch_mm(rig),
        "fringe_cells": 1.0 if lattice is None else fringe_cells(rig, lattice),
        "middle_cells": [(*cell, 0.0, 0.0) for cell in cells],
        "axes_mm": [(*viewport(rig, side).axis_mm, 0.0, 0.0) for side in SIDES],
    }
