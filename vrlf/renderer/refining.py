"""What is costly a piece at a time: coarse at once, then finer, in the end every pixel.

A pixel's value does not depend on the patch that it was computed in, so the finished picture
has the very bytes of one that was computed whole.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from math import ceil

from vrlf.passes.perceive import Patch

COARSEST = 16
# Of the whole work: what one of the further pieces has, about.
_SHARE = 64


def refining_patches(view_px: tuple[int, int]) -> Iterator[tuple[int, Patch]]:
    """Patches that fill a viewport, and the stride at which it is whole before each.

    The first patch is the coarsest grid, 1/256 of the pixels. Each further level adds the three
    grids between (Adam 7's order, PNG third edition 8.2), in bands of some 1/64.
    """
    stride = COARSEST
    yield 0, Patch((0, 0), stride)
    while stride > 1:
        half = stride // 2
        for first in ((half, 0), (0, half), (half, half)):
            for band in _bands(view_px, first, stride):
                yield stride, band
        stride = half


def _bands(view_px: tuple[int, int], first: tuple[int, int], stride: int) -> Iterator[Patch]:
    """A grid in bands of rows, each of some 1/64 of the viewport's pixels."""
    rows = ceil((view_px[1] - first[1]) / stride)
    each = max(1, ceil(rows * stride * stride / _SHARE))
    for row in range(0, rows, each):
        yield Patch((first[0], first[1] + stride * row), stride, min(each, rows - row))


class Refining:
    """How far a picture has come since it was last begun anew.

    Attributes
    ----------
    stride : int
        Of the finest grid that is whole: 1 when every pixel is there, 0 when none is.
    """

    def __init__(self) -> None:
        self._rest: Iterator[tuple[int, Patch]] = iter(())
        self._next: tuple[int, Patch] | None = None
        self.stride = 0

    def restart(self, view_px: tuple[int, int]) -> None:
        """Begin anew: nothing is there yet."""
        self._rest = refining_patches(view_px)
        self._next = next(self._rest)
        self.stride = 0

    @property
    def is_done(self) -> bool:
        """Whether every pixel is there."""
        return self.stride == 1

    def advance(self, compute: Callable[[Patch], None], budget_ms: float) -> None:
        """Compute patches until the time is used up; at least the coarsest grid."""
        began = time.perf_counter()
        while self._next is not None:
            compute(self._next[1])
            self._next = next(self._rest, None)
            self.stride = 1 if self._next is None else self._next[0]
            if 1e3 * (time.perf_counter() - began) >= budget_ms:
                return

    def whole(self, compute: Callable[[Patch], None]) -> None:
        """Compute every pixel at once."""
        compute(Patch())
        self._next, self.stride = None, 1
