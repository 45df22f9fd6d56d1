"""Targets that are drawn on the GPU: one shipped stereo scene, a garden behind a book.

========== =====================================================================
file       holds
========== =====================================================================
camera     ``HeadPose``, each eye's frustum and matrix; the only pyrr
glyphs     a 5 x 7 face, text set into pages, the table that filters print
pages      the sheets of the scene and what is printed on them
solids     surfaces with a material
foliage    leaves, grass and petals
garden     where everything stands
stereo     from what was drawn for an eye to its viewport of the target
drawing    ``Scene`` and ``render_stereo``
panorama   the world all around, from a picture
gltf       3D scenes from files; the only trimesh
animation  how their nodes move
model      ``ModelScene``: such a scene on the GPU
path       where a head goes, from a file
spectrum   how the amplitude of a picture falls with frequency
========== =====================================================================
"""

from __future__ import annotations

from vrlf.scene.camera import HeadPose, walked
from vrlf.scene.drawing import Scene, render_stereo
from vrlf.scene.gltf import MODEL_ENDINGS
from vrlf.scene.model import ModelScene
from vrlf.scene.panorama import Panorama
from vrlf.scene.spectrum import luminance, spectrum_slope
from vrlf.scene.stereo import SAMPLES

__all__ = [
    "MODEL_ENDINGS",
    "SAMPLES",
    "HeadPose",
    "ModelScene",
    "Panorama",
    "Scene",
    "luminance",
    "render_stereo",
    "spectrum_slope",
    "walked",
]
