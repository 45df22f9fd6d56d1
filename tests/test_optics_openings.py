"""How sharp single openings are: against the closed form, and where higher orders spoil it."""

from __future__ import annotations

from typing import Any

import numpy as np
import optics_by_hand as by_hand
import pytest

from vrlf.model import load_rig
from vrlf.optics import limits
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.inspect import inspect_rig
from vrlf.optics.lattice import lattice_of
from vrlf.optics.openings import served_pupil
from vrlf.optics.viewport import pitch_mm

FINE = {"kind": "microlens", "pitch_um": 200.0, "gap_mm": 4.0, "focal_mm": 2.5}
EYE = {"sphere_d": -5.0, "vertex_mm": 0.0, "pupil_mm": 6.0, "pupil_offset_mm": [0.4, -0.2]}


def served(array: dict[str, Any], **eye: Any) -> Any:
    given = by_hand.rig(array=array, left=EYE | eye)
    return served_pupil(given, eye_optics(given, "left"))


@pytest.mark.parametrize("kind", ["microlens", "pinhole"])
def test_a_spherical_error_blurs_as_the_closed_form_says(kind: str) -> None:
    array = FINE | {"kind": kind, "aperture_um": 120.0}
    given = by_hand.rig(array=array, left=EYE)
    optics, lattice = eye_optics(given, "left"), lattice_of(given)
    assert lattice is not None
    side_px = limits.opening_blur_mm(bench_of(given), lattice, optics) / pitch_mm(given)
    # A square of side s has a mean square radius of s^2 / 6, an even disc of diameter w w^2 / 8.
    wide = side_px * np.sqrt(8.0 / 6.0)
    found = served_pupil(given, optics)
    assert found is not None
    # Openings at the pupil's rim are cut; the others hold some fifty of 2048 points.
    assert found.most_px == pytest.approx(wide, rel=0.12)
    assert found.share == (1.0 if found.most_px <= 3.0 else found.share)


def test_an_array_in_focus_serves_the_whole_pupil() -> None:
    # 1/f = 1/g + 1/(s_a - d_f), d_f = 46 / 1.23.
    focal_mm = 1.0 / (1.0 / 4.0 + 1.0 / (42.0 - 46.0 / 1.23))
    found = served(FINE | {"focal_mm": focal_mm})
    assert found.share == 1.0
    assert found.most_px < 1e-6


def test_higher_orders_leave_parts_of_the_pupil_unserved() -> None:
    focal_mm = 1.0 / (1.0 / 4.0 + 1.0 / (42.0 - 46.0 / 1.23))
    shares = [
        served(
            FINE | {"focal_mm": focal_mm},
            zernike={"diameter_mm": 6.0, "coefficients_um": {"4,0": c40, "3,-1": c40}},
        ).share
        for c40 in (0.0, 0.8, 2.0)
    ]
    assert shares[0] == 1.0
    assert shares[0] > shares[1] > shares[2]


def test_the_report_says_where_a_keratoconic_eye_cannot_be_helped() -> None:
    rig = load_rig("matched-wide", overrides=["left.extends=keratoconus-like"])
    said = [text for text in inspect_rig(rig)["warnings"] if "higher orders" in text]
    assert len(said) == 1
    assert said[0].startswith("left eye: ")
    assert "optimal only in part" in said[0]
    assert inspect_rig(rig)["right"]["served_pupil"] == 1.0
    assert served_pupil(load_rig("bare"), eye_optics(load_rig("bare"), "left")) is None
