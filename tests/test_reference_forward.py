"""The forward prefilter's twin: identities, prism, edges, and every sample by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from numpy.typing import NDArray
from optics_by_hand import (
    PITCH_MM,
    aberration,
    axis_mm,
    cell_centre_mm,
    chief,
    inverse,
    rig,
    rigs,
    slope_distance_mm,
)

from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.lattice import lattice_of
from vrlf.optics.viewport import SIDES, Side, viewport
from vrlf.reference.forward import forward, read_target, retinal_points

Image = NDArray[np.float64]

HOLES = {"kind": "pinhole", "pitch_um": 390.0, "gap_mm": 6.0, "aperture_um": 75.0}
LENSES = {"kind": "microlens", "pitch_um": 390.0, "gap_mm": 3.0, "focal_mm": 1.95}


def target_of(given_rig: Rig) -> Image:
    shape = (given_rig.panel.height_px, given_rig.panel.width_px, 3)
    return np.random.default_rng(5).random(shape)


def test_without_an_array_the_panel_shows_the_target() -> None:
    bare = rig(left={"sphere_d": -5.0})
    target = target_of(bare)
    shown = forward(target, bare)
    assert (shown == target).all()
    assert shown is not target


def test_perfect_eye_is_shown_the_target() -> None:
    """At F = 1/d every lenslet shows x at X = x; single samples stand on pixel centres."""
    holes = rig(array=HOLES, prefilter={"subpixel_grid": 1}, headset={"lens_height_mm": 0.2})
    target = target_of(holes)
    assert forward(target, holes) == pytest.approx(target, abs=1e-10)


def test_prism_moves_the_panel_image_right_and_up() -> None:
    """X = x - m p/100: for p of 3 and 2 pixels what was at a pixel is shown 3 right, 2 up."""
    px = 100.0 * PITCH_MM / 46.0
    holes = rig(
        array=HOLES, prefilter={"subpixel_grid": 1}, right={"prism_pd": [3.0 * px, 2.0 * px]}
    )
    target = target_of(holes)
    shown = forward(target, holes)[:, 30:]
    # Row 0 is the highest: up is to lower rows.
    assert shown[:28, 3:] == pytest.approx(target[2:, 30:57], abs=1e-9)
    # What comes from beyond the viewport is black.
    assert not shown[:, :3].any()
    assert not shown[28:].any()


def test_unlit_where_no_sample_meets_the_pupil() -> None:
    """Behind holes 6 mm off, a pupil of 2 mm sees 2 * 6 / 46 = 0.261 of each 0.39 mm cell."""
    holes = rig(array=HOLES, left={"pupil_mm": 2.0}, right={"pupil_mm": 6.0})
    shown = forward(np.ones((30, 60, 3)), holes)
    # A disc of 0.261 mm in a 0.39 * 46/40 mm square is 27 %; with nine samples a pixel more
    # are touched. 6 mm meets them all.
    lit = (shown > 0.0).mean(axis=(0, 2))
    assert lit[30:].min() == 1.0
    assert 0.27 < lit[:30].mean() < 0.6
    # The mean is over the samples that met: white stays white.
    assert set(np.unique(shown)) == {0.0, 1.0}


def test_point_through_one_hole_by_hand() -> None:
    """d 50, F 1/50, s_a 45, g 5, pitch 0.4, axis at +3, R -4 D, o = (0.5, 0).

    x = (2, 0.1). Chief ray: y = (x s_a + g o) / m = (1.85, 0.09); on the panel (4.85, 0.09)
    lies in cell (12, 0), centre 4.8, from the axis c = (1.8, 0).
    beta = (x - c)/5 = (0.04, 0.02), h = u = c - 45 beta = (0, -0.9), u - o = (-0.5, -0.9),
    alpha = beta + u/50 = (0.04, 0.002), T = -4 (u - o)/1000 = (0.002, 0.0036),
    X = 50 (alpha - T) = (1.9, -0.08). |u - o| = 1.03: inside 1.1 mm of radius, outside 1 mm.
    """
    eye = {"sphere_d": -4.0, "vertex_mm": 0.0, "pupil_offset_mm": [0.5, 0.0]}
    array = {"kind": "pinhole", "pitch_um": 400.0, "gap_mm": 5.0, "aperture_um": 50.0}
    headset = {"lens_to_panel_mm": 50.0, "lens_separation_mm": 6.0}
    for pupil_mm, meets in ((2.2, 1.0), (2.0, 0.0)):
        holes = rig(headset=headset, array=array, right=eye | {"pupil_mm": pupil_mm})
        lattice = lattice_of(holes)
        assert lattice is not None
        view, optics = viewport(holes, "right"), eye_optics(holes, "right")
        x = np.array([2.0, 0.1])
        seen, met = retinal_points(x, bench_of(holes), lattice, view, optics, 0)
        assert seen == pytest.approx([1.9, -0.08], abs=1e-12)
        assert met == meets


def test_reading_at_the_edges() -> None:
    """Between centres bilinear, from the last centre to the border the pixel, then black."""
    small = rig(panel={"width_px": 4, "height_px": 2}, headset={"lens_separation_mm": 0.156})
    half = np.array([[1.0, 2.0], [4.0, 8.0]])
    view = viewport(small, "right")
    # The axis is the middle of the viewport: places in pixels from there, right and up.
    places = {
        (-0.5, 0.5): 1.0,
        (0.0, 0.5): 1.5,
        (0.25, 0.0): (1.0 + 3 * 2.0 + 4.0 + 3 * 8.0) / 8.0,
        (0.99, -0.99): 8.0,
        (-0.99, 0.0): 2.5,
        (1.01, 0.0): 0.0,
        (0.0, 1.01): 0.0,
        (-1.01, -0.5): 0.0,
        (0.5, -1.01): 0.0,
    }
    x_mm = np.array(list(places)) * PITCH_MM
    assert read_target(half, x_mm, small, view) == pytest.approx(list(places.values()))


def test_only_perpendicular_barriers_cut() -> None:
    """Converging walls follow the chief rays, by which the lenslets are chosen anyway."""
    eye = {"sphere_d": -5.0, "pupil_offset_mm": [0.9, -0.6]}
    plain = rig(array=LENSES, left=eye)
    target = target_of(plain)
    by_barrier = {
        name: forward(target, rig(array=LENSES | {"barriers": name}, left=eye))
        for name in ("none", "converging", "perpendicular")
    }
    assert (by_barrier["none"] == by_barrier["converging"]).all()
    # Away from the axis the perpendicular walls leave the chief ray's lenslet no panel.
    assert (by_barrier["perpendicular"] == 0.0).sum() > (by_barrier["none"] == 0.0).sum()


def test_levels_act_on_optimal_alone() -> None:
    lenses = rig(array=LENSES, left={"sphere_d": -5.0})
    levels = rig(
        array=LENSES,
        left={"sphere_d": -5.0},
        prefilter={"brightness": 0.6, "black_level": 0.1},
    )
    target = target_of(lenses)
    assert (forward(target, lenses) == forward(target, levels)).all()


def test_colours_of_a_chromatic_eye_are_traced_apart() -> None:
    eye = {"sphere_d": -4.0, "vertex_mm": 0.0}
    plain = rig(array=LENSES, left=eye)
    chromatic = rig(array=LENSES, left=eye | {"chromatic": True})
    bluer = rig(array=LENSES, left=eye | {"sphere_d": -4.83507})
    target = target_of(plain)
    shown = forward(target, chromatic)
    # The blue of an eye of -4 D is that of one of -4.835 D; the number is rounded at 1e-5 D.
    assert shown[:, :30, 2] == pytest.approx(forward(target, bluer)[:, :30, 2], abs=1e-4)
    assert np.abs(shown[:, :30] - forward(target, plain)[:, :30]).max(axis=(0, 1)).min() > 0.01


# Emitting part of a pixel's width, by colour.
STRIPES = {
    "full": [(0.0, 1.0)] * 3,
    "rgb-stripe": [(0.0, 1 / 3), (1 / 3, 2 / 3), (2 / 3, 1.0)],
    "bgr-stripe": [(2 / 3, 1.0), (1 / 3, 2 / 3), (0.0, 1 / 3)],
}


def read(half: Image, place_px: Image) -> Image:
    """Bilinear, by a border of repeated pixels; place from the upper left corner, right, down."""
    height, width = half.shape
    wide = np.pad(half, 1, mode="edge")
    beyond = np.abs(place_px - np.array([width, height]) / 2.0) - np.array([width, height]) / 2.0
    inside = beyond.max(axis=-1) <= 0.0
    at = np.where(inside[..., None], place_px, 0.0) + 0.5
    first = np.minimum(np.floor(at).astype(int), [width, height])
    (fx, fy), (i, j) = np.moveaxis(at - first, -1, 0), np.moveaxis(first, -1, 0)
    top = wide[j, i] * (1 - fx) + wide[j, i + 1] * fx
    bottom = wide[j + 1, i] * (1 - fx) + wide[j + 1, i + 1] * fx
    return np.asarray((top * (1 - fy) + bottom * fy) * inside)


def shown_by_hand(target: Image, given_rig: Rig, side: Side, colour: int) -> tuple[Image, Image]:
    """One colour of a viewport, and whether rounding could decide a sample of a pixel."""
    width, height = given_rig.panel.width_px, given_rig.panel.height_px
    eye = given_rig.left if side == "left" else given_rig.right
    offset, axis = np.array(eye.pupil_offset_mm), axis_mm(given_rig, side)
    first = 0 if side == "left" else width - width // 2
    half = target[:, first : first + width // 2, colour]
    low, high = STRIPES[given_rig.panel.subpixels][colour]
    total, met, close = np.zeros((3, *half.shape))
    for across in (1 / 6, 1 / 2, 5 / 6):
        for down in (1 / 6, 1 / 2, 5 / 6):
            rows, columns = np.mgrid[0:height, first : first + width // 2].astype(float)
            right = columns + low + across * (high - low) - width / 2.0
            up = height / 2.0 - rows - down
            x = np.stack([right, up], axis=-1) * PITCH_MM - axis
            y = chief(given_rig, side, x, offset).array_mm
            c = cell_centre_mm(given_rig, side, y)
            u, alpha = inverse(given_rig, x, c)
            X = slope_distance_mm(given_rig) * (alpha - aberration(eye, u - offset))
            place = (X + axis) / PITCH_MM * [1, -1] + [width / 2.0 - first, height / 2.0]
            beyond = np.hypot(*np.moveaxis(u - offset, -1, 0)) - eye.pupil_mm / 2.0
            meets = beyond <= 0.0
            total += read(half, place) * meets
            met += meets
            size = np.array([half.shape[1], half.shape[0]])
            edge = np.minimum(abs(place), abs(place - size)).min(axis=-1)
            # A cell's border lies where another cell's centre is as near.
            turn = np.radians(given_rig.array.rotation_deg)
            frame = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
            border = given_rig.array.pitch_um / 2000.0 - abs((y - c) @ frame).max(axis=-1)
            close += (abs(beyond) < 1e-6) | (edge < 1e-4) | (border < 1e-6)
    return np.divide(total, met, out=np.zeros_like(total), where=met > 0), close > 0


@settings(max_examples=20, deadline=None)
@given(rigs())
def test_every_sample_by_hand(given_rig: Rig) -> None:
    """Both viewports of 41 x 20 pixels, all colours, whatever the rig."""
    layouts = sorted(STRIPES)
    # Any number of the rig picks the layout: hypothesis shrinks one thing less.
    name = layouts[int(given_rig.left.axis_deg) % 3]
    changed = {"width_px": 41, "height_px": 20, "subpixels": name}
    panel = given_rig.panel.model_copy(update=changed)
    small = given_rig.model_copy(update={"panel": panel})
    target = target_of(small)
    shown = forward(target, small)
    assert not shown[:, 20].any()
    for side in SIDES:
        columns = slice(0, 20) if side == "left" else slice(21, 41)
        for colour in range(3):
            wanted, close = shown_by_hand(target, small, side, colour)
            # Places are good to 1e-6 mm (the wavefront's differences), 1e-5 px, in a target
            # that changes by up to 1 a pixel.
            assert np.where(close, 0.0, shown[:, columns, colour] - wanted) == pytest.approx(
                np.zeros_like(wanted), abs=1e-4
            )
