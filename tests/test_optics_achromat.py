"""Achromats against the thin-lens powers, and the thesis's table as printed and put right."""

from __future__ import annotations

import pytest

from vrlf.errors import InputError
from vrlf.optics.glass import C_LINE_NM, D_LINE_NM, F_LINE_NM
from vrlf.optics.lenslet.achromat import (
    TABLE_7_1,
    abbe_of,
    achromat,
    colour_difference,
    table_7_1,
    thin_powers,
)
from vrlf.optics.lenslet.focus import chromatic_focus_mm
from vrlf.optics.lenslet.paraxial import cardinal, power_per_mm
from vrlf.optics.lenslet.spots import spot
from vrlf.optics.lenslet.surfaces import Lens, Medium, cemented, plano_convex
from vrlf.optics.lenslet.trace import Beam

CROWN, FLINT = TABLE_7_1["concave"][1], TABLE_7_1["convex"][1]
PMMA, PC = Medium("pmma"), Medium("polycarbonate")


def shift_um(lens: Lens) -> float:
    f, c = chromatic_focus_mm(lens, (F_LINE_NM, C_LINE_NM))
    return float(1000.0 * (f - c))


def test_abbe_condition() -> None:
    """p1 / V1 + p2 / V2 = 0 and p1 + p2 = p; two lenses made so, thin, are achromatic."""
    p1, p2 = thin_powers(6.0, CROWN, FLINT)
    assert (p1, p2) == pytest.approx((55.0 / 10.0 / 6.0, -45.0 / 10.0 / 6.0), rel=1e-12)
    assert p1 / 55.0 + p2 / 45.0 == pytest.approx(0.0, abs=1e-15)
    assert abbe_of(CROWN) == pytest.approx(55.0, rel=1e-12)
    c1, c2 = p1 / 0.52, p2 / 0.65
    lens = cemented((0.0, -1 / c1, -1 / (c1 + c2)), (1e-9, 1e-9), (CROWN, FLINT), 0.4)
    assert 1.0 / power_per_mm(lens, D_LINE_NM) == pytest.approx(6.0, rel=1e-7)
    assert abs(colour_difference(lens, "focal length")) < 1e-8
    assert abs(colour_difference(lens, "focus")) < 1e-8


@pytest.mark.parametrize("agreeing", ["focal length", "focus"])
@pytest.mark.parametrize("glasses", [(CROWN, FLINT), (PMMA, PC)])
def test_achromats_are_what_was_asked_for(agreeing: str, glasses: tuple[Medium, Medium]) -> None:
    lens = achromat(6.0, *glasses, 0.39, agreeing=agreeing)  # type: ignore[arg-type]
    lens.check()
    assert cardinal(lens, D_LINE_NM).focal_mm == pytest.approx(6.0, rel=1e-11)
    assert abs(colour_difference(lens, agreeing)) < 1e-11  # type: ignore[arg-type]
    # Neither agrees with the other by more than some percent of a single lens's 1 / V.
    assert abs(shift_um(lens)) < 0.15 * 6000.0 / 57.0
    assert lens.surfaces[0].medium == glasses[0]


def test_the_bending_is_the_least() -> None:
    """Any other bending of the same powers has larger spots over axis and edge."""
    from vrlf.optics.lenslet.achromat import _bent, _solved, _spread

    lens = achromat(6.0, PMMA, PC, 0.39)
    beams = [Beam(D_LINE_NM), Beam(D_LINE_NM, (0.0, 0.39 / 12.0))]
    c = [each.curvature_per_mm for each in lens.surfaces]
    least = _spread(lens, beams)
    for moved in (-0.1, -0.02, 0.02, 0.1):
        blank = _bent(lens, (0.0, 0.0, 0.0))
        other = _solved(blank, (c[0] + moved, c[1] + moved, c[2] + moved), 6.0, "focal length")
        assert _spread(other, beams) > least


def test_the_thesis_table_as_printed_and_put_right() -> None:
    """Printed it has more colour than a single lens; exchanged hardly any, at another focus."""
    single = plano_convex(2.961, 0.5, PMMA, 0.39)
    printed, exchanged = table_7_1(0.39), table_7_1(0.39, exchanged=True)
    # Per focal length, for the three differ in it: F to C.
    focal = {"single": single, "printed": printed, "exchanged": exchanged}
    mm = {name: cardinal(lens, D_LINE_NM).focal_mm for name, lens in focal.items()}
    share = {name: colour_difference(lens, "focal length") for name, lens in focal.items()}
    assert mm["printed"] == pytest.approx(3.298, abs=1e-3)
    assert mm["exchanged"] == pytest.approx(10.946, abs=1e-3)
    assert share["single"] == pytest.approx(-1.0 / abbe_of(PMMA), rel=1e-3)
    assert share["printed"] < 1.4 * share["single"]
    assert abs(share["exchanged"]) < 0.2 * abs(share["single"])
    # Ours: the focal length that was wanted, and no colour.
    ours = achromat(6.0, CROWN, FLINT, 0.39, agreeing="focus")
    assert shift_um(single) == pytest.approx(-98.7, abs=0.1)
    assert shift_um(printed) == pytest.approx(-83.7, abs=0.1)
    assert shift_um(exchanged) == pytest.approx(-4.4, abs=0.1)
    assert shift_um(ours) == pytest.approx(0.0, abs=1e-6)


def test_plastics_of_unlike_dispersion_need_less_curvature() -> None:
    """An Abbe number of 30 beside 58 takes half the power of 45 beside 55."""
    curved = {
        pair: max(abs(s.curvature_per_mm) for s in achromat(6.0, *pair, 0.39).surfaces)
        for pair in ((PMMA, PC), (CROWN, FLINT))
    }
    assert curved[PMMA, PC] < 0.5 * curved[CROWN, FLINT]
    lens = achromat(6.0, PMMA, PC, 0.39)
    focus = cardinal(lens, D_LINE_NM).back_focus_mm
    assert spot(lens, Beam(D_LINE_NM), focus).rms_mm < 5e-4


def test_glasses_that_make_no_achromat() -> None:
    with pytest.raises(InputError, match=r"crown of Abbe number 45 and a flint of 55"):
        achromat(6.0, FLINT, CROWN, 0.39)
    with pytest.raises(InputError, match="crown of Abbe number inf"):
        achromat(6.0, Medium(index=1.5), FLINT, 0.39)
    with pytest.raises(InputError, match="wanted"):
        achromat(0.3, CROWN, FLINT, 0.39)
