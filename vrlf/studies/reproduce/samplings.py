"""One sample a pixel, one of each sub-pixel, nine, twenty-five, and all light of ``optimal``.

One and nine a pixel, which all three colours share, are what ``forward`` does for ``full``
sub-pixels, shown on the rig's stripes.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from vrlf.model import Rig
from vrlf.renderer import GpuRenderer, Image
from vrlf.studies.quality import with_method

OPTIMAL_STEPS: Final = 16


@dataclass(frozen=True)
class Sampling:
    """A way to make a panel image.

    Attributes
    ----------
    name : str
    samples : int or None
        Of each pixel, over its three sub-pixels; None for all light that the eye sees.
    grid : int
        ``subpixel_grid``; 0 is ``optimal``.
    shared : bool
        Whether all three colours take the same samples.
    """

    name: str
    samples: int | None
    grid: int
    shared: bool = False


SAMPLINGS: Final = (
    Sampling("one a pixel", 1, 1, shared=True),
    Sampling("one a sub-pixel", 3, 1),
    Sampling("nine a pixel", 9, 3, shared=True),
    Sampling("nine a sub-pixel", 27, 3),
    Sampling("25 a sub-pixel", 75, 5),
    Sampling("optimal", None, 0),
)


def sampling_rig(rig: Rig, sampling: Sampling) -> Rig:
    """The rig that the prefilter is told of."""
    if not sampling.grid:
        return with_method(rig, "optimal", OPTIMAL_STEPS)
    found = with_method(rig, "forward")
    prefilter = found.prefilter.model_copy(update={"subpixel_grid": sampling.grid})
    found = found.model_copy(update={"prefilter": prefilter})
    if sampling.shared:
        panel = rig.panel.model_copy(update={"subpixels": "full"})
        found = found.model_copy(update={"panel": panel})
    return found


def panels(
    renderer: GpuRenderer, rig: Rig, target: Image, samplings: tuple[Sampling, ...] = SAMPLINGS
) -> Iterator[tuple[Sampling, Image, float]]:
    """Each sampling's panel image, and the seconds that it took once its tables were made."""
    for sampling in samplings:
        told = sampling_rig(rig, sampling)
        renderer.prefilter(target, told)
        began = time.perf_counter()
        panel = renderer.prefilter(target, told)
        yield sampling, panel, time.perf_counter() - began
