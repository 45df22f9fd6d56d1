"""What an eye makes of one lit pixel on a bare panel: size, shape, place, evenness, energy.

A lit pixel's image is found from its moments. A point of the panel spreads over the pupil's
image under K = (1 - d F) I + m R / 1000, so the second moments of the spot are those of an even
disc, a^2/16, under K; the lit pixel's and the retinal pixel's squares add 1/12 px^2 each.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from optics_by_hand import PITCH_MM, rig

from vrlf.model import Rig
from vrlf.reference.perceive import perceive

# Of 30 x 30: both left and below of the middle, so that flips show.
LIT_COLUMN, LIT_ROW = 14, 16
SIDE_PX = 30

# The sampling points are even to about 1 / rays: 256 give moments to 1 % of the spot's.
RAYS = 256
MOMENT_ERROR = 0.01


@dataclass(frozen=True)
class Spot:
    """Image of the lit pixel; places in pixels from that pixel, right and up."""

    image: NDArray[np.float64]
    energy: float
    centre_px: NDArray[np.float64]
    moments_px2: NDArray[np.float64]

    @property
    def distance_px(self) -> NDArray[np.float64]:
        """Distance of every retinal pixel's centre from the lit pixel's."""
        rows, columns = np.indices(self.image.shape)
        return np.asarray(np.hypot(columns - LIT_COLUMN, rows - LIT_ROW))

    @property
    def extent_px(self) -> tuple[int, int, int, int]:
        """How far any light reaches: left, right, down, up."""
        rows, columns = np.nonzero(self.image)
        x, y = columns - LIT_COLUMN, LIT_ROW - rows
        return int(x.min()), int(x.max()), int(y.min()), int(y.max())


def spots(given_rig: Rig, rays: int = RAYS, colour: int = 1) -> tuple[Spot, Spot]:
    """Spots of the left and of the right eye."""
    panel = np.zeros((SIDE_PX, 2 * SIDE_PX, 3))
    panel[LIT_ROW, [LIT_COLUMN, SIDE_PX + LIT_COLUMN]] = 1.0
    seen = perceive(panel, given_rig, rays)[..., colour]
    return spot(seen[:, :SIDE_PX]), spot(seen[:, SIDE_PX:])


def spot(image: NDArray[np.float64]) -> Spot:
    rows, columns = np.indices(image.shape)
    place = np.stack([columns - LIT_COLUMN, LIT_ROW - rows]).reshape(2, -1).astype(float)
    weight = image.ravel() / image.sum()
    centre = place @ weight
    from_centre = place - centre[:, None]
    return Spot(image, float(image.sum()), centre, (from_centre * weight) @ from_centre.T)


def moments_px2(pupil_mm: float, spread: NDArray[np.float64]) -> NDArray[np.float64]:
    """Second moments of a spot for the matrix K of the module's first lines."""
    disc_px2 = (pupil_mm / PITCH_MM) ** 2 / 16.0
    return np.asarray(disc_px2 * spread @ spread.T + np.eye(2) / 6.0)


def eye(sphere_d: float = 0.0, **more: Any) -> dict[str, Any]:
    return {"sphere_d": sphere_d, "vertex_mm": 0.0, **more}


@pytest.fixture(scope="module")
def discs() -> tuple[Spot, Spot]:
    """-2 D and -5 D behind 6 mm: discs of 7.08 and 17.69 px."""
    return spots(rig(left=eye(-2.0), right=eye(-5.0)), rays=512)


@pytest.mark.parametrize(("which", "sphere_d"), [(0, -2.0), (1, -5.0)])
def test_blur_disc_has_its_diameter(discs: tuple[Spot, Spot], which: int, sphere_d: float) -> None:
    """F = 1/d and e = 0 leave pupil * m |R| / 1000 = 6 * 46 * |R| / 1000."""
    disc = discs[which]
    diameter_px = 6.0 * 46.0 * abs(sphere_d) / 1000.0 / PITCH_MM
    wanted = moments_px2(6.0, 46.0 * sphere_d / 1000.0 * np.eye(2))
    assert disc.moments_px2 == pytest.approx(wanted, abs=MOMENT_ERROR * wanted[0, 0])
    # Half a pixel of the lit and half of the retinal one, at most along a diagonal.
    reach_px = diameter_px / 2.0 + 2.0**0.5
    assert disc.image[disc.distance_px > reach_px].max() == 0.0
    # The outermost ring that is surely touched: a pixel whose centre lies on the disc's edge.
    assert disc.image[disc.distance_px < diameter_px / 2.0].min() > 0.0


def test_blur_disc_is_even(discs: tuple[Spot, Spot]) -> None:
    """Inside, every retinal pixel sees pixel area / disc area."""
    disc = discs[0]
    diameter_px = 6.0 * 46.0 * 2.0 / 1000.0 / PITCH_MM
    inside = disc.image[disc.distance_px < diameter_px / 2.0 - 2.0**0.5]
    assert inside.size >= 13
    # 13 rays a pixel: chance would leave 28 %, well-spread points a third of that at most.
    assert inside == pytest.approx(np.full(inside.size, 4.0 / np.pi / diameter_px**2), rel=0.1)


def test_blur_keeps_the_light(discs: tuple[Spot, Spot]) -> None:
    """A bare panel loses nothing as long as the blur stays inside the viewport."""
    assert [disc.energy for disc in discs] == pytest.approx([1.0, 1.0], abs=1e-12)


def test_blur_stays_where_the_pixel_is(discs: tuple[Spot, Spot]) -> None:
    for disc in discs:
        # A thousandth of the larger diameter.
        assert disc.centre_px == pytest.approx([0.0, 0.0], abs=0.02)


def test_blur_with_relief_and_a_lens_of_its_own() -> None:
    """e 14, F 20 D, d 46: 1 - d F = 0.08 and m = 47.12; -4 D: 0.08 - 0.18848 = -0.10848.

    A hyperope of 1000 * 0.08 / 47.12 = 1.698 D less than nothing sees it sharp: R = -1.698 D.
    """
    headset = {"eye_relief_mm": 14.0, "lens_power_d": 20.0}
    blurred, sharp = spots(
        rig(
            headset=headset,
            left=eye(-4.0, pupil_mm=5.0),
            right=eye(-80.0 / 47.12, pupil_mm=5.0),
        )
    )
    wanted = moments_px2(5.0, -0.10848 * np.eye(2))
    assert blurred.moments_px2 == pytest.approx(wanted, abs=MOMENT_ERROR * wanted[0, 0])
    assert sharp.image[LIT_ROW, LIT_COLUMN] == pytest.approx(1.0, abs=1e-9)


def test_ellipses_of_astigmatic_eyes_lean_the_right_way() -> None:
    """-1.00 / -4.00, axis 30 on the left and 140 on the right.

    Along its axis the eye is -1 D off, across it -5 D: the ellipse is long across the axis.
    TABO 30 is (cos 30, sin 30) to the examiner and (-cos 30, sin 30) to the wearer; across it
    lies (sin 30, cos 30) = (0.5, 0.87): steep, leaning to the wearer's upper right.
    TABO 140 is (-0.77, 0.64) to the examiner, (0.77, 0.64) to the wearer; across it lies
    (-0.64, 0.77): leaning to the upper left.
    """
    astigmatic = {"cylinder_d": -4.0, "vertex_mm": 0.0, "sphere_d": -1.0}
    leaning = spots(
        rig(left=astigmatic | {"axis_deg": 30.0}, right=astigmatic | {"axis_deg": 140.0})
    )
    long_axes = ((0.5, 3.0**0.5 / 2.0), (-np.sin(np.radians(40)), np.cos(np.radians(40))))
    for ellipse, long_axis in zip(leaning, long_axes, strict=True):
        values, vectors = np.linalg.eigh(ellipse.moments_px2)
        # a^2/16 (46 * 1 / 78)^2 and 25 times that, and the two squares.
        short = (6.0 * 46.0 * 1e-3 / PITCH_MM) ** 2 / 16.0
        wanted = np.array([short, 25.0 * short]) + 1.0 / 6.0
        assert values == pytest.approx(wanted, rel=0.03)
        # 1 degree; the mirror image leans 60 or 80 degrees away.
        assert abs(vectors[:, 1] @ long_axis) > np.cos(np.radians(1.0))
    assert leaning[0].moments_px2[0, 1] > 1.0
    assert leaning[1].moments_px2[0, 1] < -1.0


def test_coma_points_the_right_way() -> None:
    """A lit pixel is seen at X = x - m T = x + m grad W / 1000.

    Vertical coma, W = c sqrt(8) (3 rho^2 - 2) y/r for both views: the spot's y is
    m c sqrt(8) / (1000 r) times 9 y^2 + 3 x^2 - 2, from -2 to 7, 1 on average: a tail upward.
    Horizontal coma is W = -c sqrt(8) (3 rho^2 - 2) x/r to the wearer: a tail to the left.
    """
    c = 0.85
    vertical, horizontal = spots(
        rig(
            left=eye(zernike={"diameter_mm": 6.0, "coefficients_um": {"3,-1": c}}),
            right=eye(zernike={"diameter_mm": 6.0, "coefficients_um": {"3,1": c}}),
        )
    )
    unit_px = 46.0 * c * 8.0**0.5 / 3.0 / 1000.0 / PITCH_MM  # 0.473
    assert vertical.centre_px == pytest.approx([0.0, unit_px], abs=0.01)
    assert horizontal.centre_px == pytest.approx([-unit_px, 0.0], abs=0.01)
    # From -0.95 to 3.31 px, and less than a pixel of the two squares beyond.
    assert vertical.extent_px[2:] == (-1, 4)
    assert horizontal.extent_px[:2] == (-4, 1)


def test_prism_moves_the_panel_image() -> None:
    """T = p/100: x = X + m p/100, so a pixel is seen m p/100 the other way, here whole pixels."""
    px = 100.0 * PITCH_MM / 46.0
    left, right = spots(
        rig(left=eye(prism_pd=[3 * px, 0.0]), right=eye(prism_pd=[-2 * px, 4 * px])), rays=4
    )
    assert left.image[LIT_ROW, LIT_COLUMN - 3] == pytest.approx(1.0, abs=1e-9)
    # Seen to the right and down; rows count downward.
    assert right.image[LIT_ROW + 4, LIT_COLUMN + 2] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("sphere_d", [0.0, -5.0])
def test_moved_pupil_shifts_a_panel_out_of_focus(sphere_d: float) -> None:
    """x = X + o (1 - d F), with 1 - d F = 0.08 and o = (1.95, -0.975): 2 px right, 1 px down.

    The pixel is seen as far the other way. The eye moves with its pupil: T at the pupil's
    centre is 0 whatever the eye's error. The pupil is a point here.
    """
    moved = eye(sphere_d, pupil_mm=0.001, pupil_offset_mm=[1.95, -0.975])
    plain = eye(sphere_d, pupil_mm=0.001)
    seen, unmoved = spots(rig(headset={"lens_power_d": 20.0}, left=moved, right=plain), rays=4)
    # 0.5 um of spread at most is 0.6 % of a pixel.
    assert seen.image[LIT_ROW - 1, LIT_COLUMN - 2] == pytest.approx(1.0, abs=0.01)
    assert unmoved.image[LIT_ROW, LIT_COLUMN] == pytest.approx(1.0, abs=0.01)


def test_moved_pupil_changes_nothing_at_the_focus() -> None:
    seen, _ = spots(rig(left=eye(pupil_offset_mm=[1.95, -0.975])), rays=4)
    assert seen.image[LIT_ROW, LIT_COLUMN] == pytest.approx(1.0, abs=1e-9)


def test_accommodation_takes_the_blur_away() -> None:
    young, old = spots(
        rig(
            left=eye(3.0, accommodation="best", age_years=20.0),
            right=eye(3.0, accommodation="best", age_years=60.0),
        )
    )
    assert young.image[LIT_ROW, LIT_COLUMN] == pytest.approx(1.0, abs=1e-9)
    # 0.5 of 3 D are left at 60.
    wanted = moments_px2(6.0, 46.0 * 2.5 / 1000.0 * np.eye(2))
    assert old.moments_px2 == pytest.approx(wanted, abs=MOMENT_ERROR * wanted[0, 0])


def test_colours_of_a_chromatic_eye_blur_apart() -> None:
    """-2 D at 589 nm is -1.910 in red (610) and -2.835 D in blue (465 nm)."""
    panel = np.zeros((SIDE_PX, 2 * SIDE_PX, 3))
    panel[LIT_ROW, LIT_COLUMN] = 1.0
    seen = perceive(panel, rig(left=eye(-2.0, chromatic=True)), RAYS)
    for colour, error_d in ((0, -1.91037), (2, -2.83507)):
        wanted = moments_px2(6.0, 46.0 * error_d / 1000.0 * np.eye(2))
        found = spot(seen[:, :SIDE_PX, colour]).moments_px2
        assert found == pytest.approx(wanted, abs=MOMENT_ERROR * wanted[0, 0])
