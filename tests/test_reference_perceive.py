"""The perception twin: identities, throughput, landings by hand."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from optics_by_hand import rig

from vrlf.model import Rig, layout_names
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import aberration_at, eye_optics
from vrlf.optics.lattice import lattice_of
from vrlf.optics.subpixels import layout
from vrlf.optics.viewport import viewport
from vrlf.reference.perceive import landing_points, perceive, trace

Image = NDArray[np.float64]

LENSES = {"kind": "microlens", "pitch_um": 390.0, "gap_mm": 3.0, "focal_mm": 1.95}


def random_panel(given_rig: Rig, seed: int = 3) -> Image:
    shape = (given_rig.panel.height_px, given_rig.panel.width_px, 3)
    return np.random.default_rng(seed).random(shape)


def emission_of(shape: tuple[int, ...], subpixels: str) -> Image:
    """The mean emission of each pixel at full drive: 1, or 0 and 2 by turns."""
    rows, columns = np.indices(shape[:2])
    emission = layout(subpixels)
    boxes = emission.at(columns, rows)
    return np.asarray(np.prod(boxes[..., 2:] - boxes[..., :2], axis=-1) * emission.gain)


@pytest.mark.parametrize("subpixels", layout_names())
def test_perfect_eye_perceives_exactly_the_panel(subpixels: str) -> None:
    """And nothing in the middle column of an odd width.

    What a pixel lacks is dark, and its neighbours give the light of two for it.
    """
    bare = rig(
        panel={"width_px": 31, "height_px": 17, "subpixels": subpixels},
        headset={"lens_separation_mm": 1.3, "lens_height_mm": 0.31},
        left={"pupil_offset_mm": [0.5, 0.2]},
    )
    panel = random_panel(bare)
    wanted = panel * emission_of(panel.shape, subpixels)
    wanted[:, 15] = 0.0
    # Single rays are exact, so few serve.
    assert perceive(panel, bare, 3) == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize("subpixels", layout_names())
def test_bare_panel_keeps_the_light_of_every_colour(subpixels: str) -> None:
    """What is lit far enough inside is seen whole, through blur, stripes and relief."""
    eye = {"sphere_d": -3.0, "cylinder_d": 1.0, "axis_deg": 25.0, "prism_pd": [0.1, -0.1]}
    blurred = rig(
        panel={"subpixels": subpixels},
        headset={"eye_relief_mm": 12.0},
        left=eye,
        right=eye,
    )
    panel = random_panel(blurred)
    # 6 * 46 * 3 / 1000 is 10.6 px across: 9 px are more than its half and the prism.
    panel[:9], panel[-9:] = 0.0, 0.0
    panel[:, [*range(9), *range(21, 39), *range(51, 60)]] = 0.0
    seen = perceive(panel, blurred, 32)
    panel *= emission_of(panel.shape, subpixels)
    assert seen.sum(axis=(0, 1)) == pytest.approx(panel.sum(axis=(0, 1)), rel=1e-12)


def test_stripes_blur_from_where_they_stand() -> None:
    """A blurred white pixel's red is seen a third of a pixel left of its green, blue right."""
    eye = {"sphere_d": -2.0, "vertex_mm": 0.0}
    centres = {}
    for name in ("rgb-stripe", "bgr-stripe"):
        striped = rig(panel={"subpixels": name}, left=eye)
        panel = np.zeros((30, 60, 3))
        panel[15, 15] = 1.0
        seen = perceive(panel, striped, 128)[:, :30]
        columns = np.arange(30)[None, :, None]
        centres[name] = (seen * columns).sum(axis=(0, 1)) / seen.sum(axis=(0, 1))
    # 128 rays place a 7 px disc to a hundredth of a pixel; a bar a third wide adds its own.
    assert np.diff(centres["rgb-stripe"]) == pytest.approx([1 / 3, 1 / 3], abs=0.03)
    assert np.diff(centres["bgr-stripe"]) == pytest.approx([-1 / 3, -1 / 3], abs=0.03)


@pytest.mark.parametrize(
    ("shape", "throughput"), [("square", 0.25), ("circle", 0.25 * np.pi / 4.0)]
)
def test_white_panel_through_holes_is_as_bright_as_the_open_fraction(
    shape: str, throughput: float
) -> None:
    """Holes half a pitch wide. At F = 1/d a perfect eye's rays all land on their own pixel.

    The array's pattern repeats on the retina every 390 * 46 / 40 = 448.5 um, 5.75 px: 23 px
    hold four cells, so the mean over 23 x 23 pixels has no cut cells in it.
    """
    array = {"kind": "pinhole", "pitch_um": 390.0, "gap_mm": 6.0, "aperture_um": 195.0}
    masked = rig(
        panel={"width_px": 46, "height_px": 23},
        array=array | {"aperture_shape": shape},
        right={"pupil_mm": 4.0},
    )
    seen = perceive(np.ones((23, 46, 3)), masked, 50)
    # 200 points for each of 529 pixels: chance alone would leave 0.13 % of 0.25.
    assert seen[:, :23].mean() == pytest.approx(throughput, abs=2e-3)
    assert seen[:, 23:].mean() == pytest.approx(throughput, abs=2e-3)


def test_lenslets_waste_nothing() -> None:
    array = rig(array=LENSES, left={"sphere_d": -5.0}, right={"sphere_d": -5.0})
    seen = perceive(np.ones((30, 60, 3)), array, 16)
    # The 13 px of blur and a cell from the border.
    assert seen[14:16, 14:16] == pytest.approx(np.ones((2, 2, 3)), abs=1e-12)


def test_septum_keeps_the_other_half_out() -> None:
    eye = {"sphere_d": -8.0, "vertex_mm": 0.0}
    bare = rig(left=eye, right=eye)
    panel = np.zeros((30, 60, 3))
    panel[:, 30:] = 1.0
    seen = perceive(panel, bare, 16)
    assert not seen[:, :30].any()
    # And the right eye misses beside the septum what the left half does not give.
    assert seen[15, 30, 0] < 0.7


def test_same_bytes_again() -> None:
    array = rig(array=LENSES, left={"sphere_d": -5.0})
    panel = random_panel(array)
    assert perceive(panel, array, 5).tobytes() == perceive(panel, array, 5).tobytes()


def test_light_adds_up() -> None:
    array = rig(array=LENSES, left={"sphere_d": -5.0, "chromatic": True})
    a, b = random_panel(array, 1), random_panel(array, 2)
    apart = 0.3 * perceive(a, array, 4) + 0.7 * perceive(b, array, 4)
    assert perceive(0.3 * a + 0.7 * b, array, 4) == pytest.approx(apart, abs=1e-12)


def test_point_through_one_lenslet() -> None:
    """All by hand; d = 50, F = 1/50, s_a = 45, g = 5, pitch 0.4, f 4, axis at x = +3, R = -4 D.

    X = (2, 0), u = (1, -0.5): T = (-4, 2) / 1000, alpha = (0.036, 0.002), h = u,
    beta = (0.016, 0.012), y = (1.72, 0.04). On the panel y is (4.72, 0.04), 11.8 cells right:
    cell 12 at 4.8, from the axis 1.8. y - c = (-0.08, 0.04).
    x = y + 5 (beta - (y - c)/4) = (1.72 + 0.08 + 0.10, 0.04 + 0.06 - 0.05) = (1.9, 0.05).
    """
    array = {"kind": "microlens", "pitch_um": 400.0, "gap_mm": 5.0, "focal_mm": 4.0}
    lens = rig(
        headset={"lens_to_panel_mm": 50.0, "lens_separation_mm": 6.0},
        array=array,
        right={"sphere_d": -4.0, "vertex_mm": 0.0},
    )
    u = np.array([1.0, -0.5])
    slope = aberration_at(eye_optics(lens, "right").aberration[0], u)
    assert slope == pytest.approx([-0.004, 0.002], abs=1e-15)
    landing = trace(
        bench_of(lens), lattice_of(lens), viewport(lens, "right"), np.array([2.0, 0.0]), u, slope
    )
    assert landing.array_mm == pytest.approx([1.72, 0.04], abs=1e-12)
    assert landing.cell.tolist() == [12.0, 0.0]
    assert landing.in_cell == pytest.approx([-0.2, 0.1], abs=1e-12)
    assert landing.panel_mm == pytest.approx([1.9, 0.05], abs=1e-12)


def test_point_through_one_lenslet_with_relief() -> None:
    """e = 10, F = 0.01, d = 20 + 4/1.6 = 22.5: m = 10 + 22.5 - 2.25 = 30.25; R = 0, o = 0.

    X = (3.025, -6.05), u = (0.5, 1): alpha = (0.1, -0.2), h = (1.5, -1), beta = (0.085, -0.19),
    y = (1.5 + 1.7, -1 - 3.8) = (3.2, -4.8). The axis is the middle (separation 0); pitch 0.5:
    (6.4, -9.6) cells, c = (3, -5), y - c = (0.2, 0.2), f = 5:
    x = y + 2.5 (beta - 0.04) = (3.2 + 0.1125, -4.8 - 0.575) = (3.3125, -5.375).
    """
    array = {"kind": "microlens", "pitch_um": 500.0, "gap_mm": 4.0, "gap_index": 1.6}
    lens = rig(
        headset={
            "lens_to_panel_mm": 24.0,
            "lens_separation_mm": 0.0,
            "lens_power_d": 10.0,
            "eye_relief_mm": 10.0,
        },
        array=array | {"focal_mm": 5.0},
    )
    X, u = np.array([3.025, -6.05]), np.array([0.5, 1.0])
    view = viewport(lens, "left")
    landing = trace(bench_of(lens), lattice_of(lens), view, X, u, np.zeros(2))
    assert landing.array_mm == pytest.approx([3.2, -4.8], abs=1e-12)
    assert landing.panel_mm == pytest.approx([3.3125, -5.375], abs=1e-12)
    # A hole lets the same ray go straight: y + 2.5 beta.
    hole = lens.array.model_copy(update={"kind": "pinhole", "aperture_um": 100.0})
    holes = lens.model_copy(update={"array": hole})
    straight = trace(bench_of(holes), lattice_of(holes), view, X, u, np.zeros(2))
    assert straight.panel_mm == pytest.approx([3.4125, -5.275], abs=1e-12)


def test_landing_points_are_those_of_the_pixels_centres() -> None:
    array = rig(array=LENSES, left={"sphere_d": -5.0})
    landing = landing_points(array, "left", 8, 3)
    assert landing.panel_mm.shape == (30, 30, 2)
    assert landing.cell.shape == (30, 30, 2)
