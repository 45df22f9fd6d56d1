"""A sparse operator with a row for each pixel: walls, lateral colour, a pitch that varies.

Perpendicular walls divide the panel by another measure than the chief rays do, so that no two
cells are alike: what a pixel sees depends on where its ray crosses the array and on where it
stands itself. So it does where a lens magnifies the colours differently; where the pitch varies no
two cells are alike anyhow. The adjoint is the true transpose.
"""

from __future__ import annotations

import numpy as np

from vrlf.passes.phases import Rows


def turned(rows: Rows, size_px: tuple[int, int], band: range) -> Rows:
    """The adjoint's rows of some lines of a viewport: each entry at the pixel that it reads.

    What lies outside the viewport is nobody's.

    Parameters
    ----------
    size_px : (columns, rows)
        Of the viewport.
    """
    width, height = size_px
    above, below = rows.offsets[:, 1].max(initial=0), rows.offsets[:, 1].min(initial=0)
    lines = np.clip([band.start - above, band.stop - below], 0, height)
    near = rows.take(slice(*np.searchsorted(rows.row, lines * width)))
    column = near.row % width + near.offsets[:, 0]
    line = near.row // width + near.offsets[:, 1]
    kept = (line >= band.start) & (line < band.stop) & (column >= 0) & (column < width)
    here = Rows((line * width + column)[kept], -near.offsets[kept], near.weights[kept])
    return here.take(np.argsort(here.row, kind="stable"))
