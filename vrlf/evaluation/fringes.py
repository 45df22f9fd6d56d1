"""Colour fringes: colour that is seen where none was meant.

Red, green and blue stand at different places of a panel's pixel, so an array shows each to the
eye at a place of its own; what the prefilter doesn't make up for is seen as coloured edges. With p
what is perceived, t the target, both linear, and g the least-squares gain of ``measure``, the error
is d = g p - t. Its luminance Y(d) (ITU-R BT.709-6) is what a change of grey alone could have done;
the rest

    c = d - Y(d) (1, 1, 1),        fringe = RMS of c over pixels and colours / mean of Y(t),

is a colour that was not meant, of luminance 0. An error that is the same in all three colours has
no fringe, however large it is; on a grey target c is all the colour that is seen.

Thesis 5.3 takes ever more samples of a pixel against fringes. Measured: grey targets, left eye,
440x220 pixels of ``rgb-stripe``, ``forward``; fringe in percent on letters, a star of spokes and a
face. ``subpixel_grid`` 1 is a sample at each sub-pixel's centre, which is the thesis's three a
pixel, and 3 is nine of each sub-pixel. One and nine a pixel, that all three colours share, are what
``forward`` does for ``full`` sub-pixels, shown on stripes:

===============================  =================  ==================
samples                          thesis-minus-5d    matched-microlens
===============================  =================  ==================
one a pixel                      0.75  2.10  1.13   12.8  22.6  14.3
one a sub-pixel (grid 1)         0.93  2.99  1.40   13.3  18.6  15.3
nine a pixel                     0.73  2.03  1.11   10.6  19.4  11.9
nine a sub-pixel (grid 3)        0.84  2.60  1.25   11.4  15.8  13.2
25 a sub-pixel (grid 5)          0.65  1.97  0.98   11.1  15.4  12.8
``optimal`` (16 steps)           0.54  1.70  0.87    7.9  12.0   3.0
===============================  =================  ==================

Nine samples of each sub-pixel in place of one take a tenth to a seventh of the fringes away, 25 a
sixth to a third. In the thesis's headset, whose eyebox is half the pupil, every pixel is seen
through several lenslets, so fringes are small; there, and but for the finest detail with
matched-microlens too, as few samples leave less colour where all three share them, for then all
three err alike. The judge took 2048 rays a pixel, 512 in the second column.
"""

from __future__ import annotations

import numpy as np

from vrlf.evaluation.measure import border_px, likeness
from vrlf.evaluation.metrics.colour import fringe_share
from vrlf.model import Rig
from vrlf.optics.viewport import Side, viewport
from vrlf.renderer import Image


def fringe(seen: Image, target: Image, rig: Rig, side: Side) -> float | None:
    """How strongly coloured the edges are that one eye perceives, inside the border.

    Parameters
    ----------
    seen, target : ndarray (H, W, 3)
        Linear light on the panel's raster.

    Returns
    -------
    float or None
        0 without fringes; None where the target is dark, of which nothing is a share.

    Raises
    ------
    InputError
        As ``measure.likeness``.
    """
    gain = likeness(seen, target, rig, side).gain
    view, border = viewport(rig, side), border_px(rig, side)
    inner = (slice(border, view.height_px - border), slice(border, view.width_px - border))
    a, b = (picture[:, view.columns][inner].astype(np.float64) for picture in (seen, target))
    return fringe_share(gain * a, b)
