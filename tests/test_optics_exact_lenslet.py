"""Lenslets as they are made, against a tracer of its own and third-order theory."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pass_rigs
import pytest

from vrlf.errors import InputError
from vrlf.model import Rig
from vrlf.optics.beams import shadow_scale
from vrlf.optics.bench import bench_of
from vrlf.optics.exact_lenslet import ExactLenslet, exact_lenslet, landing_mm
from vrlf.optics.eye import aberration_at, eye_optics
from vrlf.optics.lattice import lattice_of
from vrlf.optics.viewport import viewport
from vrlf.reference.perceive import trace

FOCAL_MM = 1.95
GAP_MM = 3.0


def lenslets(**array: Any) -> Rig:
    """Gap 3 mm, focal length 1.95 mm, pitch 0.39 mm."""
    return pass_rigs.rig(44, 30, array=pass_rigs.LENSLETS | array)


def by_hand(lens: ExactLenslet, place: Any, slope: Any, n: float) -> Any:
    """A ray by bisection to the surface and Snell's law as angles in the plane of incidence."""
    radius, t = lens.radius_mm, lens.thickness_mm
    eye_side = lens.curved == "eye"
    centre = np.array([0.0, 0.0, radius if eye_side else t - radius])
    p = np.array([*(np.array(place) - lens.to_plane_mm * np.array(slope)), 0.0])
    d = np.array([*slope, 1.0])
    d = d / np.linalg.norm(d)
    surfaces = (("sphere", 1.0, n), ("plane", n, lens.gap_index))
    if not eye_side:
        surfaces = (("plane", 1.0, n), ("sphere", n, lens.gap_index))
    for index, (kind, before, behind) in enumerate(surfaces):
        if kind == "plane":
            p = p + (t * index - p[2]) / d[2] * d
            normal = np.array([0.0, 0.0, 1.0])
        else:
            # Outside is before an eye-side sphere, behind the other.
            sign = 1.0 if eye_side else -1.0
            low, high = -radius / 2.0, radius / 2.0
            start = p if eye_side else p + (t - p[2]) / d[2] * d
            for _ in range(200):
                middle = (low + high) / 2.0
                if sign * (np.linalg.norm(start + middle * d - centre) - radius) > 0.0:
                    low = middle
                else:
                    high = middle
            p = start + low * d
            normal = sign * (centre - p) / radius
        angle = np.arccos(np.clip(normal @ d, -1.0, 1.0))
        across = d - (normal @ d) * normal
        length = np.linalg.norm(across)
        turned = np.arcsin(before / behind * np.sin(angle))
        across = across / length if length > 0.0 else across
        d = np.cos(turned) * normal + np.sin(turned) * across
    end = t + lens.to_panel_mm
    return (p + (end - p[2]) / d[2] * d)[:2]


@pytest.mark.parametrize(
    ("curved", "gap_index"), [("eye", 1.0), ("eye", 1.49), ("panel", 1.0), ("panel", 1.2)]
)
def test_spots_are_those_of_a_tracer_by_itself(curved: Any, gap_index: float) -> None:
    lens = exact_lenslet(
        lenslets(gap_index=gap_index), curved=curved, index=(1.485, 1.49, 1.5), thickness_mm=0.3
    )
    random = np.random.default_rng(4)
    for _ in range(12):
        place, slope = random.uniform(-0.19, 0.19, 2), random.uniform(-0.3, 0.3, 2)
        for colour in range(3):
            got, passes = landing_mm(lens, place, slope, colour)
            assert passes
            # arccos near 1 is good to 1e-8.
            wanted = by_hand(lens, place, slope, lens.index[colour])
            assert got == pytest.approx(wanted, abs=1e-7)


@pytest.mark.parametrize("curved", ["eye", "panel"])
@pytest.mark.parametrize("gap_index", [1.0, 1.3])
def test_small_rays_are_paraxial(curved: Any, gap_index: float) -> None:
    lens = exact_lenslet(lenslets(gap_index=gap_index), curved=curved)
    place, slope = np.array([0.19, -0.11]), np.array([0.05, 0.3])
    errors = []
    for small in (1e-1, 1e-2):
        got, _ = landing_mm(lens, small * place, small * slope, 1)
        thin = place + GAP_MM / gap_index * (slope - place / FOCAL_MM)
        errors.append(np.abs(got - small * thin).max())
    # What is left is of the third order.
    assert errors[0] / errors[1] == pytest.approx(1000.0, rel=0.03)


def test_spherical_aberration_is_the_third_orders() -> None:
    """1/s'(h) - 1/s'(0) = h^2 / (8 f^3) 1/(n (n-1)) [(n+2)/(n-1) q^2 + 4 (n+1) p q
    + (3n+2)(n-1) p^2 + n^3/(n-1)], thin lens, p = -1 for light from afar, q = 1 with the curved
    side toward it, -1 away from it (Jenkins & White 1976, equation 9m).
    """
    n, f = 1.49, 40.0
    rig = lenslets(gap_mm=40.0, focal_mm=f)
    rig = rig.model_copy(
        update={"headset": rig.headset.model_copy(update={"lens_to_panel_mm": 90.0})}
    )
    for curved, q in (("eye", 1.0), ("panel", -1.0)):
        lens = exact_lenslet(rig, curved=curved)  # type: ignore[arg-type]
        h = 2.0
        off, _ = landing_mm(lens, np.array([h, 0.0]), np.zeros(2), 1)
        bracket = (
            (n + 2) / (n - 1) * q**2 - 4 * (n + 1) * q + (3 * n + 2) * (n - 1) + n**3 / (n - 1)
        )
        per_mm = h**2 / (8.0 * f**3) / (n * (n - 1)) * bracket
        # At the focus a ray that comes too steep by h dP lands f h dP beyond the axis.
        # Of the fifth order (h/f)^2 is left, of the thickness t/f.
        assert off[0] == pytest.approx(-f * h * per_mm, rel=0.02)


def test_what_no_sphere_makes_is_one_line() -> None:
    with pytest.raises(InputError, match=r"array.focal_mm: found 0.3, .*wanted more than 0.276"):
        exact_lenslet(lenslets(focal_mm=0.3))
    with pytest.raises(InputError, match=r"array.gap_mm: found 3, wanted more than 3.36"):
        exact_lenslet(lenslets(), thickness_mm=5.0)
    with pytest.raises(InputError, match=r"found an index of 1.49 in a medium of 1.6"):
        exact_lenslet(lenslets(gap_index=1.6), curved="panel")


def test_rays_that_miss_or_are_reflected_do_not_pass() -> None:
    lens = exact_lenslet(lenslets())
    places = np.array([[0.1, 0.0], [1.0, 0.0]])
    assert landing_mm(lens, places, np.zeros((2, 2)), 1)[1].tolist() == [True, False]
    steep = replace(exact_lenslet(lenslets(), curved="panel"), radius_mm=0.2)
    # sin i = 0.19 / 0.2, above 1 / 1.49.
    assert not landing_mm(steep, np.array([0.19, 0.0]), np.zeros(2), 1)[1]


@pytest.mark.parametrize("name", ["coma-lenslets", "rgb-walls-turned", "own-lens-relief"])
def test_shadows_scale_as_traced_rays_do(name: str) -> None:
    """dx = M dy between neighbouring pupil points, for one retinal point."""
    rig = (
        pass_rigs.SMALL[name]
        if name in pass_rigs.SMALL
        else pass_rigs.rig(
            44,
            30,
            headset={"lens_power_d": 19.0, "eye_relief_mm": 8.0},
            array=pass_rigs.HOLES | {"gap_index": 1.3},
            left={"cylinder_d": -2.0, "axis_deg": 35.0},
        )
    )
    for side in ("left", "right"):
        optics, bench, lattice = eye_optics(rig, side), bench_of(rig), lattice_of(rig)
        assert lattice is not None
        v = np.array([0.7, -0.4])
        scale = shadow_scale(bench, optics.aberration[0], v)
        landed = []
        for step in ([0.0, 0.0], [1e-6, 0.0], [0.0, 1e-6]):
            slope = aberration_at(optics.aberration[0], v + step)
            # Close to the axis of a cell, so that none of the three crosses a border.
            at = trace(bench, lattice, viewport(rig, side), np.array([0.3, 0.2]), v + step, slope)
            bent = bench.bend * at.in_cell @ lattice.panel_from_cell.T
            landed.append((at.array_mm, at.panel_mm + bent - bench.bend * at.array_mm))
        for array_mm, panel_mm in landed[1:]:
            moved = scale @ (array_mm - landed[0][0])
            assert panel_mm - landed[0][1] == pytest.approx(moved, rel=1e-5, abs=1e-12)
