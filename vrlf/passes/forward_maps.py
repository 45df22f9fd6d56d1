"""The inverse maps of both eyes and all colours, as the forward prefilter's shaders take them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from vrlf.model import Rig
from vrlf.optics import polynomial
from vrlf.optics.bench import Bench
from vrlf.optics.eye import eye_optics
from vrlf.optics.inverse import InverseMap, crossing_shift_mm, inverse_map
from vrlf.optics.lattice import Lattice
from vrlf.optics.polynomial import Float
from vrlf.optics.subpixels import layout
from vrlf.optics.viewport import SIDES, Side


def crossing_shifts(rig: Rig, bench: Bench) -> dict[Side, Float]:
    """What each eye's pupil adds to where its chief rays cross the array."""
    return {side: crossing_shift_mm(bench, eye_optics(rig, side)) for side in SIDES}


def inverse_maps(rig: Rig, lattice: Lattice) -> tuple[list[InverseMap], int]:
    """The maps of both eyes, colour by colour, and how many each has: 1 shared by all, or 3."""
    eyes = [eye_optics(rig, side) for side in SIDES]
    is_shared = layout(rig.panel.subpixels).is_shared
    shared = is_shared and not any(eye.is_chromatic for eye in eyes)
    ray_sets = 1 if shared else 3
    maps = [
        inverse_map(rig, eye.benches[c], lattice, eye, c) for eye in eyes for c in range(ray_sets)
    ]
    return maps, ray_sets


def moves_from_lenslets_px(
    maps: list[InverseMap], crossed_per_px: list[Float]
) -> NDArray[np.float32]:
    """As ``moves_px``; with a wavefront of places in pixels, see ``through_of`` in the shaders."""
    if all(polynomial.degree(c) <= 1 for each in maps for c in each.displacement_px):
        return moves_px(maps)
    turned = []
    for each, crossed in zip(maps, crossed_per_px, strict=True):
        right, down = (polynomial.compose_linear(c, crossed) for c in each.displacement_px)
        turned.append(replace(each, displacement_px=(right, down)))
    return moves_px(turned)


def curves_alike(moves: NDArray[np.float32], ray_sets: int) -> bool:
    """Whether an eye's colours differ in no term above the linear ones."""
    powers = np.add.outer(*[np.arange(moves.shape[1])] * 2)
    curved = moves[:, powers > 1].reshape(len(SIDES), ray_sets, -1)
    return bool(np.all(curved == curved[:, :1]))


def moves_px(maps: list[InverseMap]) -> NDArray[np.float32]:
    """Both polynomials of each map interleaved, shape (maps, size, size, 2), size at least 2."""
    size = 1 + max(1, *(polynomial.degree(c) for each in maps for c in each.displacement_px))
    return np.stack(
        [
            np.stack([polynomial.padded(c, size) for c in each.displacement_px], axis=-1)
            for each in maps
        ]
    ).astype(np.float32)
