"""What ``vrlf eye`` says and draws: the numbers, which way up, and that units stand by them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from optics_by_hand import rig

from vrlf.errors import InputError
from vrlf.model import Rig, load_rig
from vrlf.optics.inspect import eye_numbers
from vrlf.optics.polynomial import Float
from vrlf.studies.eyeplot import eyes_figure, plot_eyes, summary
from vrlf.studies.eyes import (
    EyeReport,
    eye_report,
    letter_height_arcmin,
    modulation_curves,
    seen_letter,
)

# Coma whose tail points left and up for the wearer; a fan of light, wider than it is high.
COMA = {
    "pupil_mm": 5.0,
    "zernike": {"diameter_mm": 5.0, "coefficients_um": {"3,1": 0.5, "3,-1": 0.2}},
}
CYLINDER = {"pupil_mm": 4.0, "cylinder_d": -1.0, "axis_deg": 90.0}


def given() -> Rig:
    """Coma to the left, a cylinder and a prism to the right."""
    return rig(left=COMA, right=CYLINDER | {"prism_pd": [0.5, -0.25]})


@pytest.fixture(scope="module")
def reports() -> Mapping[str, EyeReport]:
    return {"Left": eye_report(given(), "left"), "Right": eye_report(given(), "right")}


@pytest.fixture(scope="module")
def figure(reports: Mapping[str, EyeReport]) -> Figure:
    return eyes_figure(reports, title="a title", letter_arcmin=30.0)


def centroid(light: Float, half: float) -> tuple[float, float]:
    """Of a picture whose rows go upward."""
    at = (np.arange(len(light)) + 0.5) / len(light) * 2.0 * half - half
    return (
        float(light.sum(axis=0) @ at / light.sum()),
        float(light.sum(axis=1) @ at / light.sum()),
    )


# Numbers


def test_the_error_left_is_that_of_inspect(reports: Mapping[str, EyeReport]) -> None:
    for side, report in zip(("left", "right"), reports.values(), strict=True):
        wanted = eye_numbers(given(), side)  # type: ignore[arg-type]
        found = report.to_json()
        for name in ("sphere_d", "cylinder_d", "axis_deg"):
            assert found[name] == pytest.approx(wanted[name], abs=1e-12)


def test_the_rms_is_that_of_the_coefficients(reports: Mapping[str, EyeReport]) -> None:
    left, right = reports["Left"], reports["Right"]
    assert left.rms_um == pytest.approx(np.hypot(0.5, 0.2))
    assert left.higher_order_rms_um == pytest.approx(left.rms_um)
    # -1 D of cylinder: M = -0.5, J = 0.5; c20 = r^2 M / 4 sqrt(3), c22 = r^2 J / 2 sqrt(6).
    assert right.rms_um == pytest.approx(np.hypot(2.0 / 4.0 / 3**0.5, 2.0 / 2.0 / 6**0.5))
    assert right.higher_order_rms_um == pytest.approx(0.0, abs=1e-12)


def test_the_prism_is_said_and_not_in_the_picture(reports: Mapping[str, EyeReport]) -> None:
    right = reports["Right"].to_json()
    assert right["shift_arcmin"] == pytest.approx([-0.005 * 10800 / np.pi, 0.0025 * 10800 / np.pi])
    assert "seen 17.2 arcmin left and 8.6 up" in summary(reports["Right"])
    assert "seen" not in summary(reports["Left"])
    at = centroid(reports["Right"].geometric[..., 1], 1.0)
    assert at == pytest.approx((0.0, 0.0), abs=1e-3)


def test_a_blur_is_as_wide_by_rays_as_with_diffraction(reports: Mapping[str, EyeReport]) -> None:
    """-1 D over 4 mm along x is 13.8 arcmin: a line that is lit as a disc is wide."""
    right = reports["Right"].to_json()
    rays, light = right["geometric_half_light_arcmin"], right["half_light_arcmin"]
    # |x| < k r holds half of a disc for k = 0.40397.
    assert rays["green"] == pytest.approx(0.40397 * 4.0 * 10.8 / np.pi, rel=2e-3)
    for colour in ("red", "green", "blue"):
        assert rays[colour] == rays["green"]
        # Diffraction adds little to a line that is 30 times as long as it is wide.
        assert light[colour] == pytest.approx(rays[colour], rel=0.05)


def test_chromatic_eyes_have_three_blurs() -> None:
    report = eye_report(rig(left={"chromatic": True, "pupil_mm": 4.0}), "left").to_json()
    red, green, blue = (report["geometric_half_light_arcmin"][c] for c in ("red", "green", "blue"))
    assert red < green < blue
    assert report["strehl"]["red"] > report["strehl"]["green"] > report["strehl"]["blue"]
    assert report["rms_um"] == pytest.approx(0.0, abs=1e-12)  # at 589 nm, where it is perfect


def test_a_blur_too_wide_names_the_eye() -> None:
    with pytest.raises(InputError, match="right eye: found a blur of"):
        eye_report(rig(right={"sphere_d": 40.0, "pupil_mm": 8.0}), "right")


# Curves and letters


def test_a_cylinder_leaves_the_gratings_along_its_blur(reports: Mapping[str, EyeReport]) -> None:
    """Axis 90, minus: the power's error is along x, so light spreads along x."""
    curves = modulation_curves(reports["Right"], 1)
    at = int(np.argmin(np.abs(curves.cycles_per_degree - 10.0)))
    assert curves.vertical[at] == pytest.approx(curves.perfect[at], abs=0.01)
    assert curves.horizontal[at] < 0.3 * curves.vertical[at]
    assert curves.horizontal[at] < curves.mean[at] < curves.vertical[at]
    assert np.all(curves.mean <= curves.perfect + 0.01)
    assert curves.mean[0] == pytest.approx(1.0, abs=0.02)


def test_a_perfect_eye_sees_the_letter_upright_and_sharp() -> None:
    report = eye_report(rig(left={"pupil_mm": 6.0}), "left")
    letter = seen_letter(report, 60.0)
    ink = 1.0 - letter.light[..., 1]
    half, side = letter.half_arcmin, np.linspace(-1.0, 1.0, len(ink)) * letter.half_arcmin
    x, y = np.meshgrid(side, side)

    def inked(left: float, right: float, bottom: float, top: float) -> float:
        return float(ink[(x > left) & (x < right) & (y > bottom) & (y < top)].mean())

    assert half > 30.0
    assert inked(-29.0, -19.0, -29.0, 29.0) > 0.98  # the stem, twelve arcmin wide, on the left
    assert inked(-10.0, 5.0, 8.0, 16.0) < 0.02  # within the bowl, which is above
    assert inked(-15.0, -5.0, -28.0, -10.0) < 0.02  # between stem and leg, below
    assert inked(-40.0, 40.0, 32.0, 40.0) < 0.02
    assert letter.logmar == pytest.approx(np.log10(12.0))


def test_a_letter_is_smeared_the_way_a_point_is(reports: Mapping[str, EyeReport]) -> None:
    report = reports["Left"]
    letter = seen_letter(report, 30.0)
    still = seen_letter(eye_report(rig(left={"pupil_mm": 5.0}), "left"), 30.0)
    moved = np.subtract(
        centroid(1.0 - letter.light[..., 1], letter.half_arcmin),
        centroid(1.0 - still.light[..., 1], still.half_arcmin),
    )
    half = report.cells.half_slope * 10800 / np.pi
    point = centroid(report.geometric[..., 1], half)
    assert np.hypot(*point) > 0.5
    # What a sharp rim throws far is cut off differently by the two pictures.
    assert moved == pytest.approx(point, rel=0.1, abs=0.05)


def test_the_letter_grows_with_the_blur(reports: Mapping[str, EyeReport]) -> None:
    assert letter_height_arcmin(eye_report(rig(left={"pupil_mm": 3.0}), "left")) == 5.0
    height = letter_height_arcmin(reports["Right"])
    widest = max(reports["Right"].half_light_arcmin)
    assert 4.0 * widest <= height < 4.0 * widest * 10.0**0.1


# The picture


def pictures_of(figure: Figure) -> list[list[Axes]]:
    """The five axes of each row, without colour bars."""
    return [[axes for axes in row.axes if axes.get_title()] for row in figure.subfigs]


def test_there_is_a_row_for_each_eye_and_units_on_all_axes(figure: Figure) -> None:
    rows = pictures_of(figure)
    assert [len(row) for row in rows] == [5, 5]
    units = ("mm", "arcmin", "arcmin", "cycles per degree", "arcmin")
    for row in rows:
        for axes, unit in zip(row, units, strict=True):
            assert unit in axes.get_xlabel()
            assert axes.get_ylabel()
    texts = [row.get_suptitle() for row in figure.subfigs]
    assert "Left eye:" in texts[0]
    assert "RMS 0.539 um" in texts[0]
    assert "+0.00 / -1.00 x 90 left over" in texts[1]
    assert figure.get_suptitle() == "a title"
    assert any("Strehl" in text.get_text() for text in rows[0][2].texts)
    assert "30 arcmin (logMAR 0.8)" in rows[0][4].get_title()


def test_points_are_drawn_as_the_wearer_sees_them(
    figure: Figure, reports: Mapping[str, EyeReport]
) -> None:
    """Light that the picture shows on the right is on the right: by the axes' own numbers."""
    for column, wanted in ((1, reports["Left"].geometric), (2, reports["Left"].diffraction)):
        axes = pictures_of(figure)[0][column]
        (picture,) = axes.images
        left, right, bottom, top = picture.get_extent()
        assert picture.origin == "lower"
        assert left == -right < 0.0
        assert bottom == -top < 0.0
        drawn = np.asarray(picture.get_array())[..., 1].astype(float)
        half = reports["Left"].cells.half_slope * 10800 / np.pi
        assert right == pytest.approx(half)
        shown, true = centroid(drawn, right), centroid(wanted[..., 1], half)
        # sRGB weighs faint light more, which leaves the direction.
        assert np.sign(shown) == pytest.approx(np.sign(true))
        assert np.abs(true).min() > 0.1


def test_the_wavefront_is_drawn_over_its_pupil(figure: Figure) -> None:
    """Wearer's frame: the standard's coma 3,1 rises towards its own right, our left."""
    (picture,) = pictures_of(figure)[0][0].images
    height = np.ma.filled(np.ma.masked_invalid(picture.get_array()), np.nan)
    assert np.isnan(height[0, 0])
    middle = len(height) // 2
    assert height[middle, 1] > 0.5 > -0.5 > height[middle, -2]
    assert picture.get_extent() == [-2.5, 2.5, -2.5, 2.5]


def test_it_is_written_whole(
    tmp_path: Path, reports: Mapping[str, EyeReport], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "eye.svg"
    one: dict[str, Any] = {"Left": reports["Left"]}
    plot_eyes(one, path, title="one eye", letter_arcmin=None)
    assert b"<svg" in path.read_bytes()[:1000]
    before = path.read_bytes()

    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("vrlf.files._write_through", full)
    with pytest.raises(Exception, match="No space left"):
        plot_eyes(one, path, title="another", letter_arcmin=None)
    assert path.read_bytes() == before
    assert [each.name for each in tmp_path.iterdir()] == ["eye.svg"]


def test_stiles_and_crawford_narrow_a_spot() -> None:
    plain = eye_report(load_rig("bare", overrides=["left.sphere_d=-2"]), "left")
    changes = ["left.sphere_d=-2", "left.stiles_crawford_per_mm2=0.1"]
    narrowed = eye_report(load_rig("bare", overrides=changes), "left")
    for name in ("half_light_arcmin", "geometric_half_light_arcmin"):
        assert getattr(narrowed, name)[1] < 0.9 * getattr(plain, name)[1]


def test_a_camera_has_a_point_spread_too() -> None:
    changes = ["left.camera={focal_mm=6.0, f_number=2.0, focus_mm=2000}"]
    report = eye_report(load_rig("bare", overrides=changes), "left")
    assert report.seen.pupil_mm == 3.0
    assert report.residual.sphere_d == pytest.approx(-0.5)
