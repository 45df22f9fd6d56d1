"""The smallest letter line that stays legible, as an ideal observer reads it.

The observer knows how the ten Sloan letters look on the raster when nothing is wrong, and where
each stands. Of what an eye perceives it takes the letter whose template correlates best. Letters
and templates are without their mean and templates of length 1, so neither the light that a headset
takes nor a gain counts; and since the observer knows no more than the letters' true looks, false
edges mislead it as they mislead a reader.

White noise limits it, as any reader is limited by what goes on inside (D. G. Pelli: *The quantum
efficiency of vision*, 1990). ``NOISE_DEG2`` is its spectral density, in contrast squared times
square degrees: so much that a sharp picture on a fine raster (120 pixels per degree and more) is
read to logMAR 0, decimal acuity 1, and no further. A result says therefore what a picture leaves of
normal sight, whatever the raster. The letters' scores under this noise are drawn a fixed number of
times with a fixed seed: the same input gives the same result.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, floor
from typing import Final

import numpy as np

from vrlf.content.charts.letters import SLOAN_LETTERS, paint_letter
from vrlf.content.charts.logmar import STEPS_PER_UNIT, letter_height_px
from vrlf.content.charts.model import BLACK, Image
from vrlf.errors import InputError
from vrlf.evaluation.metrics.model import Float, Picture
from vrlf.scene import luminance

See = Callable[[Image], Picture]

NOISE_DEG2: Final = 3e-4
# Three letters of five, by which a line of an ETDRS chart counts as read.
LEGIBLE_SHARE: Final = 0.6
SMALLEST_LOGMAR: Final = -0.3
_LEAST_HEIGHT_PX: Final = 2.0
_DRAWS: Final = 4096
_STRIDE: Final = 3
# A letter and half a letter's height of white to each side.
_CELL_LETTERS: Final = 2.0
# How far all letters together may lie off their place: nobody minds a pixel.
_FARTHEST_PX: Final = 3
_ROUNDING: Final = 1e-9


@dataclass(frozen=True)
class Line:
    """One size of letters: what share of them is read right, guesses included."""

    logmar: float
    letter_height_px: float
    share: float


@dataclass(frozen=True)
class Legibility:
    """How small a reader reads.

    Attributes
    ----------
    lines
        Sizes tried, the largest first.
    logmar, decimal_acuity
        Of the smallest legible line; None where not even the largest is.
    """

    lines: tuple[Line, ...]
    logmar: float | None
    decimal_acuity: float | None


@dataclass(frozen=True)
class _Page:
    """Some letters on white, and the square of pixels that each has to itself."""

    picture: Image
    letters: tuple[int, ...]
    cells: tuple[tuple[slice, slice], ...]


def smallest_line(
    see: See,
    *,
    width_px: int,
    height_px: int,
    pixels_per_degree: float,
    border_px: int = 0,
    noise_deg2: float = NOISE_DEG2,
) -> Legibility:
    """Read ever smaller letters until they are no longer legible.

    Parameters
    ----------
    see : callable
        From a target, linear (height_px, width_px, 3), black letters on white, to what is
        perceived of it, of the same shape. Called about ten times, more often where not all
        ten letters have room on a page.
    width_px, height_px : int
        Of the pages: an eye's viewport.
    pixels_per_degree : float
        Of the raster.
    border_px : int
        Left white at each side.
    noise_deg2 : float
        Spectral density of the reader's noise.

    Raises
    ------
    InputError
        If not even one letter that could be read has room.
    """
    room_px = max(min(width_px, height_px) - 2 * border_px, 0)
    largest = _step(max(room_px / _CELL_LETTERS, 1e-3), pixels_per_degree, floor)
    smallest = max(
        round(SMALLEST_LOGMAR * STEPS_PER_UNIT), _step(_LEAST_HEIGHT_PX, pixels_per_degree, ceil)
    )
    if largest < smallest:
        raise InputError(
            f"letters: found room for {room_px} pixels, wanted a letter of "
            f"{_LEAST_HEIGHT_PX:g} pixels and as much white"
        )
    # The mean of white noise over a pixel's area.
    sigma = noise_deg2**0.5 * pixels_per_degree

    def line(step: int) -> Line:
        height = letter_height_px(step / STEPS_PER_UNIT, pixels_per_degree)
        cells = _cells(see, _pages(width_px, height_px, border_px, height))
        return Line(step / STEPS_PER_UNIT, height, share_read(*cells, sigma))

    return _read_down(line, range(largest, smallest - 1, -1))


def _read_down(line: Callable[[int], Line], steps: range) -> Legibility:
    """Every third size to the first that isn't legible, then those between, the same way."""
    tried: list[Line] = []

    def legible(step: int) -> bool:
        tried.append(line(step))
        return tried[-1].share >= LEGIBLE_SHARE

    read = None
    for step in steps[::_STRIDE]:
        if not legible(step):
            break
        read = step
    if read is not None:
        for step in range(read - 1, max(read - _STRIDE, steps.stop), -1):
            if not legible(step):
                break
            read = step
    lines = tuple(sorted(tried, key=lambda each: -each.logmar))
    if read is None:
        return Legibility(lines, None, None)
    return Legibility(lines, read / STEPS_PER_UNIT, 10.0 ** -(read / STEPS_PER_UNIT))


def share_read(wanted: Float, found: Float, sigma: float) -> float:
    """Share of the letters that the observer names right.

    Parameters
    ----------
    wanted, found : ndarray (10, n, n)
        Each letter as it should look and as it is perceived, of contrast 1 to the white.
    sigma : float
        Deviation of the noise in each pixel.
    """
    flat = wanted.reshape(len(wanted), -1)
    flat = flat - flat.mean(axis=1, keepdims=True)
    length = np.linalg.norm(flat, axis=1, keepdims=True)
    if np.any(length == 0.0):
        return 1.0 / len(wanted)
    templates = flat / length
    scores = found.reshape(len(found), -1) @ templates.T  # letter shown, template
    # The templates' scores of pure noise have the covariance sigma^2 T T'.
    values, vectors = np.linalg.eigh(templates @ templates.T)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    draws = np.random.default_rng(5).standard_normal((_DRAWS, len(wanted))) @ root.T
    named = np.argmax(scores[:, None, :] + sigma * draws[None], axis=2)
    return float(np.mean(named == np.arange(len(wanted))[:, None]))


def _step(height_px: float, pixels_per_degree: float, rounded: Callable[[float], int]) -> int:
    """The step of the chart whose letters are as high, rounded one way."""
    logmar = float(np.log10(height_px / letter_height_px(0.0, pixels_per_degree)))
    sign = -1.0 if rounded is ceil else 1.0
    return rounded(logmar * STEPS_PER_UNIT + sign * _ROUNDING)


def _pages(width_px: int, height_px: int, border_px: int, letter_px: float) -> list[_Page]:
    """All ten letters, a letter apart, on as few pages as they have room on, in the middle."""
    cell = ceil(_CELL_LETTERS * letter_px)
    columns = min(max((width_px - 2 * border_px) // cell, 1), len(SLOAN_LETTERS))
    rows = max((height_px - 2 * border_px) // cell, 1)
    pages = []
    for first in range(0, len(SLOAN_LETTERS), columns * rows):
        letters = tuple(range(first, min(first + columns * rows, len(SLOAN_LETTERS))))
        used = ceil(len(letters) / columns)
        left, top = (width_px - columns * cell) // 2, (height_px - used * cell) // 2
        picture = np.ones((height_px, width_px, 3), np.float32)
        cells = []
        for place, letter in enumerate(letters):
            y, x = top + (place // columns) * cell, left + (place % columns) * cell
            cells.append((slice(max(y, 0), y + cell), slice(max(x, 0), x + cell)))
            inset = floor((cell - letter_px) / 2.0)  # on whole pixels, as on the chart
            paint_letter(
                picture,
                SLOAN_LETTERS[letter],
                left_px=x + inset,
                top_px=y + inset,
                height_px=letter_px,
                colour=BLACK,
            )
        pages.append(_Page(picture, letters, tuple(cells)))
    return pages


def _cells(see: See, pages: list[_Page]) -> tuple[Float, Float]:
    """Every letter as it should look and as it is perceived, on the same few pixels."""
    targets = [luminance(page.picture) for page in pages]
    seen = [luminance(see(page.picture)) for page in pages]
    for target, picture in zip(targets, seen, strict=True):
        if picture.shape != target.shape or not np.all(np.isfinite(picture)):
            raise InputError(
                f"letters: found a perceived page {picture.shape}, wanted {target.shape}, finite"
            )
    seen = _in_place(_as_bright(seen, targets), targets)
    wanted, found = (
        np.stack([one[cell] for page, one in zip(pages, many, strict=True) for cell in page.cells])
        for many in (targets, seen)
    )
    return wanted, found


def _as_bright(seen: list[Float], targets: list[Float]) -> list[Float]:
    """What is perceived, of the targets' mean: noise is told in contrast."""
    light = sum(float(each.sum()) for each in seen)
    gain = sum(float(each.sum()) for each in targets) / light if light > 0.0 else 0.0
    return [gain * each for each in seen]


def _in_place(seen: list[Float], targets: list[Float]) -> list[Float]:
    """Everything that is perceived, moved by the whole pixels that bring it nearest."""
    steps = range(-_FARTHEST_PX, _FARTHEST_PX + 1)
    shifts = sorted(((y, x) for y in steps for x in steps), key=lambda s: s[0] ** 2 + s[1] ** 2)

    def likeness(shift: tuple[int, int]) -> float:
        moved = [np.roll(each, shift, axis=(0, 1)) for each in seen]
        # Black is -1 and white 0, so the best place has the least light where letters should be.
        return sum(float(np.sum(m * (t - 1.0))) for m, t in zip(moved, targets, strict=True))

    best = max(shifts, key=likeness)
    return [np.roll(each, best, axis=(0, 1)) for each in seen]
