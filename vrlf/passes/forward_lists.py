"""Which pixels the forward prefilter does, and how, where that is listed for a prescription.

With a wavefront a sample costs more, so nothing is done twice or in vain: once for a prescription
all pixels are sorted (``forward_kinds.comp``) into dark ones, ones by footprints and the rest, by
samples; a frame does the three lists. They take 4 bytes a pixel: 4 MB at 1334x750, 33 MB at
3840x2160.

A whole eye (wavefront to order 8, chromatic, prism, Stiles-Crawford) against a sphero-cylinder,
pupils of 6 mm, 1334x750, milliseconds of both cores together, the least of 7 frames by turns;
making tables takes 360 (predicted: 0.9 to 1.4 times, from what parts cost):

================= ===== ===== ===== ============ ========== =======
rig               plain whole times all by loops footprints samples
================= ===== ===== ===== ============ ========== =======
matched-microlens 144   154   1.07  1428         0.27       0.29
thesis-minus-5d   122   168   1.37  1319         0.79       0.21
matched-wide      83    89    1.08  1462         0.22       0.21
matched-full      104   178   1.71  1358         0.37       0.56
================= ===== ===== ===== ============ ========== =======

(The last columns: shares of the pixels.) On full sub-pixels most of it is chromatic: its colours
land apart, where a plain eye reads all three at one place, and alone that takes 142. A polynomial
in loops reads its coefficients for every sample, each a branch in software GL; written out, they
are read once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu import Buffer, ComputePass, Device
from vrlf.gpu.compute import GROUP_PX
from vrlf.optics.footprint import fitting, window_for
from vrlf.optics.viewport import SIDES

_GROUPS_A_ROW = 1024  # far below the 65,535 that a side of a dispatch may have


class PixelList:
    """Owns a list of pixels, the left eye's, then the right eye's, each by rows."""

    def __init__(
        self, device: Device, is_in: NDArray[np.bool_], first_right_column: int, *, label: str
    ) -> None:
        rows, columns = np.nonzero(is_in)
        places = (columns + 65536 * rows).astype(np.uint32)
        of_left = columns < first_right_column
        self.counts = (int(of_left.sum()), int((~of_left).sum()))
        head = np.array(self.counts, np.uint32)
        data = np.concatenate([head, places[of_left], places[~of_left]])
        self._buffer = Buffer(device, data, label=label)

    def places(self) -> NDArray[np.uint32]:
        """Column + 65536 row of each, shape (sum of the counts,)."""
        return np.asarray(self._buffer.read(np.uint32)[2:], np.uint32)

    def run(self, program: ComputePass) -> None:
        """Dispatch a program over the list, a layer for each eye."""
        if not any(self.counts):
            return
        self._buffer.bind(4)
        groups = -(-max(self.counts) // GROUP_PX**2)
        rows = -(-groups // _GROUPS_A_ROW)
        program.run(GROUP_PX * -(-groups // rows), GROUP_PX * rows, len(SIDES))

    def release(self) -> None:
        """Give the list back."""
        self._buffer.release()


@dataclass(frozen=True)
class SortedPixels:
    """All pixels behind wavefronts, each in one list.

    Attributes
    ----------
    window : (columns, rows) or None
        Texels that hold the footprints; None where no pixel is done by those.
    dark, by_footprints, by_samples : PixelList
    """

    window: tuple[int, int] | None
    dark: PixelList
    by_footprints: PixelList
    by_samples: PixelList

    def release(self) -> None:
        """Give the lists back."""
        self.dark.release()
        self.by_footprints.release()
        self.by_samples.release()


def sort_pixels(
    device: Device,
    kinds: NDArray[np.uint8],
    grid: int,
    view_px: tuple[int, int],
    first_right_column: int,
) -> SortedPixels:
    """Sort pixels by what ``shaders/forward_kinds.comp`` found of them."""
    window = window_for(kinds, grid, view_px)
    fits = np.zeros(kinds.shape, bool) if window is None else fitting(kinds, window)
    rest = (kinds != 0) & ~fits
    return SortedPixels(
        window,
        PixelList(device, kinds == 0, first_right_column, label="dark pixels"),
        PixelList(device, fits, first_right_column, label="pixels by footprints"),
        PixelList(device, rest, first_right_column, label="pixels by samples"),
    )
