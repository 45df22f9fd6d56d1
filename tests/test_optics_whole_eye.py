"""The whole eye in numbers: power vectors, pupils, reach, light, cameras, named eyes."""

from __future__ import annotations

from math import log, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from optics_by_hand import rig, unhurried

from vrlf.errors import InputError
from vrlf.model import Camera, Eye, Zernike, load_rig
from vrlf.model.shelf import names_on
from vrlf.optics import refraction
from vrlf.optics.eye import (
    chromatic_difference_d,
    clear_zone_mm,
    eye_optics,
    higher_order_rms_um,
    viewer,
)
from vrlf.optics.inspect import inspect_rig
from vrlf.optics.pupil_light import natural_pupil_mm, weighed_mm
from vrlf.optics.refraction import SpheroCylinder
from vrlf.optics.samples import pupil_points
from vrlf.optics.sequence import points, to_disc
from vrlf.optics.wavefront import (
    power_vector_of_zernike_d,
    rescaled_um,
    zernike_coefficients_um,
    zernike_of_power_vector_um,
    zernike_wavefront_um,
)

TERMS = [(n, m) for n in range(9) for m in range(-n, n + 1, 2)]
_wavefronts = st.dictionaries(st.sampled_from(TERMS), st.floats(-2.0, 2.0), min_size=1)


# Power vectors.


def test_power_vectors_are_those_of_the_published_formulas() -> None:
    # Thibos, Hong, Bradley & Applegate 2004, equations 2 to 4, over a 6 mm pupil.
    c = {(2, 0): 1.25, (4, 0): 0.21, (6, 0): -0.05, (2, 2): -0.4, (4, 2): 0.11, (6, 2): 0.03}
    c |= {(2, -2): 0.7, (4, -2): -0.09, (6, -2): 0.02, (3, 1): 0.3, (5, -1): 0.1}
    m = (-4 * sqrt(3) * 1.25 + 12 * sqrt(5) * 0.21 + 24 * sqrt(7) * 0.05) / 9
    j0 = (2 * sqrt(6) * 0.4 + 6 * sqrt(10) * 0.11 - 12 * sqrt(14) * 0.03) / 9
    j45 = (-2 * sqrt(6) * 0.7 - 6 * sqrt(10) * 0.09 - 12 * sqrt(14) * 0.02) / 9
    found = power_vector_of_zernike_d(c, 6.0, higher_orders=True)
    assert found == pytest.approx((m, j0, j45), rel=1e-14)
    second = power_vector_of_zernike_d(c, 6.0, higher_orders=False)
    assert second == pytest.approx(
        (-4 * sqrt(3) * 1.25 / 9, 2 * sqrt(6) * 0.4 / 9, -2 * sqrt(6) * 0.7 / 9), rel=1e-14
    )


@unhurried
@given(_wavefronts, st.floats(2.0, 9.0))
def test_power_vectors_are_the_curvature_in_the_pupils_centre(
    terms: dict[tuple[int, int], float], diameter_mm: float
) -> None:
    matrix = refraction.curvature_matrix_d(zernike_wavefront_um(terms, diameter_mm))
    m, j0, j45 = power_vector_of_zernike_d(terms, diameter_mm, higher_orders=True)
    # Sums of terms of up to some thousand dioptres, in doubles.
    assert matrix == pytest.approx(np.array([[m + j0, j45], [j45, m - j0]]), abs=1e-9)


@unhurried
@given(st.tuples(*[st.floats(-9.0, 9.0)] * 3), st.floats(2.0, 9.0))
def test_power_vectors_have_a_way_back(
    vector: tuple[float, float, float], diameter_mm: float
) -> None:
    terms = zernike_of_power_vector_um(*vector, diameter_mm)
    for higher in (False, True):
        back = power_vector_of_zernike_d(terms, diameter_mm, higher_orders=higher)
        assert back == pytest.approx(vector, abs=1e-12)


# Other pupils.


def test_a_smaller_pupil_follows_schwiegerlings_formulas() -> None:
    # Schwiegerling 2002, "Scaling Zernike expansion coefficients to different pupil sizes", by
    # the ratio s: c20' = s^2 (c20 + sqrt15 (s^2 - 1) c40), c31' = s^3 c31 and c40' = s^4 c40.
    s = 4.0 / 6.0
    found = rescaled_um({(2, 0): 0.8, (4, 0): 0.3, (3, 1): -0.2}, 6.0, 4.0)
    assert found[2, 0] == pytest.approx(s**2 * (0.8 + sqrt(15.0) * (s**2 - 1.0) * 0.3))
    assert found[4, 0] == pytest.approx(s**4 * 0.3)
    assert found[3, 1] == pytest.approx(s**3 * -0.2)
    # What coma over the larger pupil tilts the smaller by.
    assert found[1, 1] == pytest.approx(s * sqrt(8.0) * (s**2 - 1.0) * -0.2)


@unhurried
@given(_wavefronts, st.floats(3.0, 8.0), st.floats(0.5, 1.5))
def test_a_wavefront_is_the_same_over_any_pupil(
    terms: dict[tuple[int, int], float], diameter_mm: float, ratio: float
) -> None:
    there = rescaled_um(terms, diameter_mm, ratio * diameter_mm)
    back = rescaled_um(there, ratio * diameter_mm, diameter_mm)
    for term, value in back.items():
        # 1.5^8 of the largest coefficients of order 8, some hundreds, in doubles.
        assert value == pytest.approx(terms.get(term, 0.0), abs=1e-9)


def test_a_polynomial_comes_apart_into_its_terms() -> None:
    random = np.random.default_rng(3)
    terms = {term: float(value) for term, value in zip(TERMS, random.normal(size=45), strict=True)}
    found = zernike_coefficients_um(zernike_wavefront_um(terms, 5.2), 5.2)
    assert found == pytest.approx(terms, abs=1e-11)


def test_higher_orders_are_counted_over_the_eyes_own_pupil() -> None:
    zernike = Zernike(diameter_mm=6.0, coefficients_um={"2,0": 3.0, "3,1": 0.3, "3,-3": -0.4})
    assert higher_order_rms_um(Eye(pupil_mm=6.0, zernike=zernike)) == pytest.approx(0.5)
    # Third order alone: it shrinks with the cube.
    smaller = higher_order_rms_um(Eye(pupil_mm=3.0, zernike=zernike))
    assert smaller == pytest.approx(0.5 / 8.0)


# Prescriptions.


def test_prescriptions_change_form_and_vertex() -> None:
    plus = SpheroCylinder(-2.0, 1.5, 90.0)
    assert refraction.transposed(plus) == SpheroCylinder(-0.5, -1.5, 0.0)
    matrices = [refraction.examiner_matrix_d(each) for each in (plus, refraction.transposed(plus))]
    assert matrices[0] == pytest.approx(matrices[1], abs=1e-15)
    # An axis of 0 is the 180 of the optician's paper.
    assert refraction.transposed(SpheroCylinder(-0.5, -1.5, 180.0)).axis_deg == 90.0
    assert refraction.at_pupil(SpheroCylinder(-12.0, 0.0, 0.0), 12.0).sphere_d == pytest.approx(
        -10.49, abs=0.005
    )
    assert refraction.at_pupil(SpheroCylinder(10.0, 0.0, 0.0), 12.0).sphere_d == pytest.approx(
        11.36, abs=0.005
    )
    assert chromatic_difference_d(486.0) == pytest.approx(-0.64, abs=0.005)


@pytest.mark.parametrize(
    ("sphere_d", "age_years", "near_mm", "far_mm"),
    [
        (0.0, 35.0, 125.0, None),  # T 3.3: 8 D to add
        (-5.0, 35.0, 1000.0 / 13.0, 200.0),  # T says 70 to 162
        (5.0, 35.0, 1000.0 / 3.0, None),  # T says 239
        (-2.0, 80.0, 500.0, 500.0),
        (0.0, 80.0, None, None),
    ],
)
def test_the_clear_zone_of_an_eye(
    sphere_d: float, age_years: float, near_mm: float | None, far_mm: float | None
) -> None:
    zone = clear_zone_mm(Eye(sphere_d=sphere_d, vertex_mm=0.0, age_years=age_years))
    assert zone is not None
    assert zone == (
        None if near_mm is None else pytest.approx(near_mm),
        None if far_mm is None else pytest.approx(far_mm),
    )


def test_a_far_sighted_presbyope_sees_nothing_sharp() -> None:
    assert clear_zone_mm(Eye(sphere_d=2.0, age_years=70.0)) is None


# Light.


@pytest.mark.parametrize("luminance", [0.01, 1.0, 100.0, 4000.0])
@pytest.mark.parametrize("age", [20.0, 28.58, 55.0, 83.0])
def test_the_natural_pupil_is_the_unified_formulas(luminance: float, age: float) -> None:
    # The closed form that Watson & Yellott 2012 give besides, equation 27, in f = (L a)^0.41;
    # its six-digit constants leave 1e-4 mm.
    area = 900.0
    f = (luminance * area) ** 0.41
    closed = (18.5172 + 0.122165 * f - 0.105569 * age + 0.000138645 * f * age) / (
        2.0 + 0.0630635 * f
    )
    assert natural_pupil_mm(luminance, area, age) == pytest.approx(closed, abs=2e-3)


def test_pupils_close_with_light_and_age() -> None:
    dark = load_rig("bare", overrides=["left.luminance_cd_m2=0.1", "left.age_years=25"])
    bright = load_rig("bare", overrides=["left.luminance_cd_m2=300", "left.age_years=25"])
    old = load_rig("bare", overrides=["left.luminance_cd_m2=300", "left.age_years=75"])
    found = [eye_optics(each, "left").pupil_mm for each in (dark, bright, old)]
    assert found == sorted(found, reverse=True)
    assert found[0] > 6.0 > 3.0 > found[1] > 2.0
    # Beyond the formula's ages it holds still.
    assert natural_pupil_mm(10.0, 900.0, 5.0) == natural_pupil_mm(10.0, 900.0, 20.0)
    assert natural_pupil_mm(10.0, 900.0, 110.0) == natural_pupil_mm(10.0, 900.0, 83.0)


def test_light_does_not_open_a_pupil_beyond_its_wavefront() -> None:
    given_rig = load_rig(
        "bare",
        overrides=[
            "left.luminance_cd_m2=0.01",
            "left.pupil_mm=4",
            "left.zernike={diameter_mm=4.0, coefficients_um={'3,1'=0.1}}",
        ],
    )
    with pytest.raises(InputError, match=r"left\.luminance_cd_m2: found 0\.01, which opens"):
        eye_optics(given_rig, "left")


def test_points_are_as_dense_as_stiles_and_crawford_found_them() -> None:
    rho, pupil_mm = 0.05, 7.0
    even = to_disc(points(4096)[:, :2]) * pupil_mm / 2.0
    r = np.hypot(*weighed_mm(even, pupil_mm, rho).T)
    rate, edge = log(10.0) * rho, pupil_mm / 2.0
    # The mean of r^2 under exp(-rate r^2) over the disc, by parts.
    lost = 1.0 - np.exp(-rate * edge**2)
    mean = 1.0 / rate - edge**2 * (1.0 - lost) / lost
    assert np.mean(r**2) == pytest.approx(mean, rel=1e-3)
    assert r.max() <= edge
    # Directions stay, and no effect is none.
    moved = weighed_mm(even, pupil_mm, rho)
    assert even[:, 0] * moved[:, 1] == pytest.approx(even[:, 1] * moved[:, 0], abs=1e-12)
    assert weighed_mm(even, pupil_mm, 1e-9) == pytest.approx(even, abs=1e-6)


def test_moved_pupils_are_weighed_about_their_own_centre() -> None:
    changed = rig(left={"pupil_mm": 6.0, "pupil_offset_mm": [1.0, -0.5]})
    eye = changed.left.model_copy(update={"stiles_crawford_per_mm2": 0.05})
    optics = eye_optics(changed.model_copy(update={"left": eye}), "left")
    at = pupil_points(changed, optics, 4096)
    assert at.u_mm.mean(axis=0) == pytest.approx([1.0, -0.5], abs=2e-3)
    assert np.mean(np.sum(at.from_centre_mm**2, axis=1)) < 0.95 * 3.0**2 / 2.0


# Cameras.


def test_a_camera_is_an_eye_with_its_far_point_where_it_is_sharp() -> None:
    camera = Camera(focal_mm=12.0, f_number=2.4, focus_mm=38.0)
    given_rig = rig(left={"sphere_d": -7.0, "cylinder_d": -2.0, "pupil_offset_mm": [0.5, 0.0]})
    eye = given_rig.left.model_copy(update={"camera": camera})
    optics = eye_optics(given_rig.model_copy(update={"left": eye}), "left")
    assert optics.pupil_mm == pytest.approx(5.0)
    assert optics.pupil_offset_mm == (0.5, 0.0)
    assert optics.matrix_d == pytest.approx(np.eye(2) * -1000.0 / 38.0)
    # T 5.2, mended: the sensor at d_i = f s / (s - f) sees a point at distance t as a disc of
    # a d_i |1/s - 1/t|, so of a |1/s - 1/t| in slopes: a |R| / 1000 where the panel is at infinity.
    u = np.array([2.5, 0.0])
    slope = optics.aberration[0][0][1, 0] * u[0]
    assert 2.0 * abs(slope) == pytest.approx(5.0 / 38.0)
    found = inspect_rig(given_rig.model_copy(update={"left": eye}))["left"]
    assert found["clear_zone"] is None
    assert found["amplitude_d"] == 0.0


def test_a_camera_sharp_at_infinity_is_a_perfect_eye() -> None:
    eye = viewer(load_rig("bare", overrides=["left.camera={focal_mm=4.2, f_number=1.8}"]), "left")
    assert eye.sphere_d == 0.0
    assert eye.pupil_mm == pytest.approx(4.2 / 1.8)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            "focal_mm=12, f_number=2, focus_mm=12",
            "left.camera.focus_mm: found 12, wanted more than",
        ),
        ("focal_mm=12", "left.camera.f_number: found nothing, wanted a number from 0.5 to 64"),
        ("focal_mm=0, f_number=2", "left.camera.focal_mm: found 0, wanted a number from 0.5"),
    ],
)
def test_a_wrong_camera_is_one_line(change: str, said: str) -> None:
    with pytest.raises(InputError) as error:
        load_rig("bare", overrides=[f"left.camera={{{change}}}"])
    assert said in str(error.value)


# Numbers and named eyes.


def test_inspect_tells_second_order_and_all_orders_apart() -> None:
    # 0.3 um of spherical aberration over 6 mm: +12 sqrt5 0.3 / 9 D in the middle of the pupil.
    given_rig = load_rig(
        "bare",
        overrides=[
            "left.sphere_d=-2",
            "left.vertex_mm=0",
            "left.pupil_mm=6",
            "left.zernike={diameter_mm=6.0, coefficients_um={'4,0'=0.3, '4,2'=0.2}}",
        ],
    )
    found = inspect_rig(given_rig)["left"]
    assert found["sphere_d"] == pytest.approx(-2.0)
    assert found["cylinder_d"] == pytest.approx(0.0, abs=1e-12)
    assert found["paraxial_mean_error_d"] == pytest.approx(-2.0 + 12 * sqrt(5) * 0.3 / 9)
    # J0 = 6 sqrt10 0.2 / 9 in the examiner's frame: half of the cylinder, its axis at 0 or 90.
    assert found["paraxial_cylinder_d"] == pytest.approx(-2.0 * 6 * sqrt(10) * 0.2 / 9)
    assert found["paraxial_axis_deg"] == pytest.approx(0.0, abs=1e-9)
    assert found["higher_order_rms_um"] == pytest.approx(sqrt(0.3**2 + 0.2**2))


def test_a_spots_radius_is_that_of_its_disc() -> None:
    found = inspect_rig(load_rig("bare", overrides=["left.sphere_d=-4", "left.vertex_mm=0"]))
    left = found["left"]
    # 1024 points; 2 sqrt2 of an even disc's radius of spread are its width.
    assert 2.0 * sqrt(2.0) * left["spot_rms_px"] == pytest.approx(left["blur_px"], rel=2e-3)


@pytest.mark.parametrize("name", names_on("eyes"))
def test_every_named_eye_serves_and_says_its_source(name: str) -> None:
    given_rig = load_rig("matched-full", overrides=[f"left.extends={name}"])
    numbers = inspect_rig(given_rig)["left"]
    assert np.isfinite(numbers["spot_rms_px"])
    assert given_rig.right == load_rig("matched-full").right


def test_named_eyes_are_as_bad_as_was_published() -> None:
    def rms(name: str) -> float:
        return higher_order_rms_um(load_rig("bare", overrides=[f"left.extends={name}"]).left)

    assert rms("keratoconus-like") == pytest.approx(2.14, abs=0.005)
    assert rms("hyperope-typical") == 0.0


def test_a_named_eye_takes_the_place_of_the_rigs_own_whole() -> None:
    changes = ["left.prism_pd=[1, 2]", "left.zernike={diameter_mm=6.0, coefficients_um={'5,1'=1}}"]
    given_rig = load_rig(
        "bare", overrides=[*changes, "left={extends='keratoconus-like', pupil_mm=4.5}"]
    )
    assert given_rig.left.prism_pd == (0.0, 0.0)
    assert given_rig.left.zernike is not None
    assert (5, 1) not in dict(given_rig.left.zernike.terms)
    assert given_rig.left.pupil_mm == 4.5


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("left.extends=keratocone", 'left.extends: found the unknown name "keratocone" (did'),
        ("left.extends=3", "left.extends: found 3, wanted a path to a .toml file or one of after-"),
        ("left.extends=nowhere/eye.toml", "nowhere/eye.toml: found no such file"),
        ("left.age_years=400", "left.age_years: found 400, wanted a number from 0 to 120"),
    ],
)
def test_a_wrong_eye_is_one_line(change: str, said: str) -> None:
    with pytest.raises(InputError) as error:
        load_rig("bare", overrides=[change])
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_the_pupils_area_is_what_it_was_without_the_effect() -> None:
    # A guard on the limit at the centre, where 0 / 0 stands.
    assert weighed_mm(np.zeros((1, 2)), 6.0, 0.05) == pytest.approx(np.zeros((1, 2)))
    near = weighed_mm(np.array([[1e-7, 0.0]]), 6.0, 0.05)
    rate = log(10.0) * 0.05
    limit = sqrt((1.0 - np.exp(-rate * 9.0)) / (rate * 9.0))
    assert near[0, 0] == pytest.approx(1e-7 * limit, rel=1e-6)
