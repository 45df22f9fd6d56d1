"""The GPU, and the only room that knows moderngl. Knows no optics.

============ =====================================================================
file         holds
============ =====================================================================
device       ``Device``: the context, its owner thread, its live objects
memory       ``Texture`` and ``Buffer``
blocks       uniform blocks declared once for numpy and GLSL
sources      shader sources: includes, defines, honest line numbers
compute      ``ComputePass``: a compute program and its uniform block; its variants
draw         ``DrawPass``, ``Mesh`` and ``Canvas``: what the scene is drawn with
timing       GPU timer queries
screen       the window's own framebuffer
window       ``Window``: a window whose context a device can use
============ =====================================================================

Each object has one owner, which releases it; ``Device.live_objects`` counts what is left.
"""

from __future__ import annotations

from vrlf.gpu.blocks import Block, Field, Struct
from vrlf.gpu.compute import GROUP_PX, ComputePass, ComputeVariants
from vrlf.gpu.device import Device, DeviceInfo
from vrlf.gpu.draw import Canvas, DrawPass, Mesh
from vrlf.gpu.memory import Buffer, Texture
from vrlf.gpu.timing import FrameTimers, GpuTimer

__all__ = [
    "GROUP_PX",
    "Block",
    "Buffer",
    "Canvas",
    "ComputePass",
    "ComputeVariants",
    "Device",
    "DeviceInfo",
    "DrawPass",
    "Field",
    "FrameTimers",
    "GpuTimer",
    "Mesh",
    "Struct",
    "Texture",
]
