"""Filtering in the plane of visual frequencies, and resizing from band to band.

Source: Mantiuk, Kim, Rempel & Heidrich 2011, section 3.1 (the optics are a gain over radial
frequency). The resampling is the cubic convolution of Keys 1981 with a = -1/2, its kernel
widened where a picture shrinks, which release 2.2 leaves to Matlab.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.sparse import csr_array

Plane: TypeAlias = NDArray[np.float64]


def radial_frequency(shape: tuple[int, int], samples_per_degree: float) -> Plane:
    """Cycles per degree of each coefficient that ``rfft2`` gives for ``shape``, (h, w//2 + 1)."""
    down = fft.fftfreq(shape[0], 1.0 / samples_per_degree)
    across = fft.rfftfreq(shape[1], 1.0 / samples_per_degree)
    return np.asarray(np.hypot(down[:, np.newaxis], across[np.newaxis, :]))


def filter_padded(picture: Plane, gain: Plane, surround: float) -> Plane:
    """``picture`` filtered in a plane of twice its height and width.

    Parameters
    ----------
    picture : (h, w)
    gain : (2 h, w + 1)
        Of each coefficient of ``rfft2`` of the plane, see ``radial_frequency``.
    surround : float
        What stands in the plane below and to the right of the picture.
    """
    height, width = picture.shape
    plane = np.full((2 * height, 2 * width), surround)
    plane[:height, :width] = picture
    filtered = fft.irfft2(fft.rfft2(plane) * gain, s=plane.shape)
    return np.asarray(filtered[:height, :width])


def keys_cubic(distance: Plane) -> Plane:
    """The interpolation kernel of Keys 1981 with a = -1/2, 1 at 0, 0 from 2 on."""
    x = np.abs(distance)
    near = (1.5 * x - 2.5) * x * x + 1.0
    far = ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0
    return np.where(x <= 1.0, near, np.where(x < 2.0, far, 0.0))


def resizing_matrix(size: int, wanted: int) -> csr_array:
    """Cubic resampling of ``size`` samples to ``wanted``, (wanted, size); each row sums to 1.

    Both rows of samples cover the same stretch, end to end. Beyond it the samples are mirrored
    with the edge sample twice.
    """
    scale = wanted / size
    narrow = min(scale, 1.0)
    centre = (np.arange(wanted)[:, np.newaxis] + 0.5) / scale - 0.5
    reach = int(np.ceil(2.0 / narrow)) + 1
    index = np.floor(centre).astype(np.intp) + np.arange(-reach, reach + 1)
    weight = keys_cubic((centre - index) * narrow)
    weight /= weight.sum(axis=1, keepdims=True)
    folded = index % (2 * size)
    column = np.where(folded < size, folded, 2 * size - 1 - folded)
    row = np.broadcast_to(np.arange(wanted)[:, np.newaxis], column.shape)
    place = (row.ravel(), column.ravel())
    return csr_array((weight.ravel(), place), shape=(wanted, size))


def resize(picture: Plane, shape: tuple[int, int]) -> Plane:
    """``picture`` at ``shape``, cubic, without aliasing where it shrinks."""
    if picture.shape == shape:
        return picture
    rows = resizing_matrix(picture.shape[0], shape[0]) @ picture
    return np.asarray((resizing_matrix(picture.shape[1], shape[1]) @ rows.T).T)
