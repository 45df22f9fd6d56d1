"""How far the headset's lens takes the panel's colours apart, and how they come together again.

On a bare panel a pixel x is seen through the middle of the pupil, o, at the slope

    alpha = (x - o (1 - d F)) / m

in each colour's own F and m. The pixel of 589 nm that is seen there is
X = m_0 alpha + o (1 - d F_0): what the target has at X is what x should show. Prism moves all
colours alike.
"""

from __future__ import annotations

import numpy as np

from vrlf.model import Rig
from vrlf.optics.bench import bench_of, colour_benches, is_lateral
from vrlf.optics.eye import eye_optics
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import RASTER_FLIP, Side, axis_in_viewport_px, pitch_mm, viewport
from vrlf.units import MM_PER_M


def lateral_reach_px(rig: Rig, side: Side) -> Float:
    """How far right and down any colour of a viewport lands from its pixel, at most; shape (2,)."""
    most = max(abs(bench.panel_from_retina - 1.0) for bench in colour_benches(rig))
    return np.asarray(most * _farthest_px(rig, side))


def _farthest_px(rig: Rig, side: Side) -> Float:
    """The viewport's farthest corner from its axis, right and down."""
    view = viewport(rig, side)
    axis = axis_in_viewport_px(rig, view)
    return np.maximum(np.abs(axis), np.abs(np.array([view.width_px, view.height_px]) - axis))


def lateral_px(rig: Rig, side: Side) -> float:
    """How far apart the outermost colours of one pixel are seen in the farthest corner."""
    scales = [1.0 / bench.panel_from_retina for bench in colour_benches(rig)]
    return float((max(scales) - min(scales)) * np.hypot(*_farthest_px(rig, side)))


def longitudinal_d(rig: Rig) -> float:
    """How much the headset's residual error differs from one colour to another, at most."""
    errors = [
        MM_PER_M * bench.defocus_factor / bench.panel_per_slope_mm for bench in colour_benches(rig)
    ]
    return max(errors) - min(errors)


def forward_changes(rig: Rig) -> bool:
    """Whether the forward prefilter has anything to do: an array, or colours to bring together."""
    return rig.array.kind != "none" or is_lateral(rig)


def registering_maps(rig: Rig, side: Side) -> Float:
    """Where in the target, from its own pixel, each colour of a bare panel's pixel belongs.

    Returns
    -------
    ndarray (3, 3)
        Of each colour: what the place from the axis is multiplied with, then what is added, in
        pixels right and down.
    """
    optics, named = eye_optics(rig, side), bench_of(rig)
    offset_px = np.array(optics.pupil_offset_mm) @ RASTER_FLIP / pitch_mm(rig)
    maps = []
    for bench in optics.benches:
        scale = 1.0 / bench.panel_from_retina
        shift = named.defocus_factor - scale * bench.defocus_factor
        maps.append([scale - 1.0, *(shift * offset_px)])
    return np.array(maps)
