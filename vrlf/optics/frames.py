"""The one place where the examiner's view becomes the wearer's.

TABO axes and OSA/ANSI Z80.28 wavefronts look *at* the patient; vrlf looks out of the
eye. The two views differ by the sign of x. Nothing else in the code knows of it.
"""

from __future__ import annotations

import numpy as np

from vrlf.optics import polynomial
from vrlf.optics.polynomial import Float

_MIRROR = np.diag([-1.0, 1.0])


def swap_wavefront_view(wavefront: Float) -> Float:
    """A wavefront polynomial seen from the other side; its own inverse."""
    return polynomial.mirror_x(wavefront)


def swap_matrix_view(matrix: Float) -> Float:
    """A symmetric (..., 2, 2) matrix seen from the other side; its own inverse."""
    return np.asarray(_MIRROR @ matrix @ _MIRROR)
