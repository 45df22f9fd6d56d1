"""The order of the steps for a frame, on the GPU or by the float64 twins; no maths of its own.

========== ======================================================================
file       holds
========== ======================================================================
steps      ``Renderer``, the protocol; what it takes and gives, and the checks
gpu        ``GpuRenderer``: picture by picture
textures   what a step keeps on the GPU while it runs
reference  ``ReferenceRenderer``: the twins
stream     ``Stream``: frame after frame, prescriptions that change while they run
live       what can be shown frame after frame: pictures, charts, scenes, films
refining   what is costly, coarse first and finer from frame to frame
making     tables made a piece at a time
========== ======================================================================
"""

from __future__ import annotations

from vrlf.renderer.gpu import GpuRenderer
from vrlf.renderer.reference import ReferenceRenderer
from vrlf.renderer.steps import (
    DEFAULT_RAYS,
    PLAIN,
    Exposure,
    Image,
    Renderer,
    bare_rig,
    check_rays,
    checked_image,
    exposure_factor,
    fitted,
)
from vrlf.renderer.stream import Stream

__all__ = [
    "DEFAULT_RAYS",
    "PLAIN",
    "Exposure",
    "GpuRenderer",
    "Image",
    "ReferenceRenderer",
    "Renderer",
    "Stream",
    "bare_rig",
    "check_rays",
    "checked_image",
    "exposure_factor",
    "fitted",
]
