"""vrlf corrects a person's vision inside a VR headset by computation alone.

``load_rig``, ``prefilter``, ``perceive``, ``inspect`` and ``Renderer`` are the Python
interface (see ``vrlf.api``). They are imported when first used, so that ``import vrlf``
touches no GPU library.

========== ============================================================
room       what lives there (each imports from those above it only)
========== ============================================================
errors     the one family of errors
units      constants with their sources
resources  where shaders and assets are
files      whole files or none
model      what is given: the rig
images     pictures in and out
optics     what follows from a rig, float64
gpu        the only moderngl
passes     one class and one shader for each step
reference  the float64 twin of each pass
content    pictures and charts
scene      targets drawn on the GPU
solve      the optimal prefilter, Wiener kernels
renderer   the order of the steps
evaluation numbers for what is seen
api        the Python interface
studies    many cases: bench
app        commands
========== ============================================================
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vrlf.api import Renderer, Rig, inspect, load_rig, perceive, prefilter

__all__ = ["Renderer", "Rig", "__version__", "inspect", "load_rig", "perceive", "prefilter"]

try:
    __version__ = version("vrlf")
except PackageNotFoundError:  # a checkout on the path that nobody installed
    __version__ = "0+unknown"


def __getattr__(name: str) -> Any:
    if name in __all__:
        return getattr(import_module("vrlf.api"), name)
    raise AttributeError(f"module 'vrlf' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
