"""Wavefronts as they are given: in three orders, in waves, from a CSV, and what is refused."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

import pytest

from vrlf.errors import InputError
from vrlf.model import Zernike, load_rig
from vrlf.model.wavefront_file import wavefront_table
from vrlf.model.zernike import listed_term, normalised

# Noll 1976, table I.
NOLL = [
    (0, 0), (1, 1), (1, -1), (2, 0), (2, -2), (2, 2), (3, -1), (3, 1), (3, -3), (3, 3),
    (4, 0), (4, 2), (4, -2), (4, 4), (4, -4), (5, 1), (5, -1), (5, 3), (5, -3), (5, 5), (5, -5),
    (6, 0),
]  # fmt: skip
# Wyant & Creath 1992, table III, with the sine terms negative.
FRINGE = [
    (0, 0), (1, 1), (1, -1), (2, 0), (2, 2), (2, -2), (3, 1), (3, -1), (4, 0), (3, 3), (3, -3),
    (4, 2), (4, -2), (5, 1), (5, -1), (6, 0), (4, 4), (4, -4), (5, 3), (5, -3), (6, 2), (6, -2),
    (7, 1), (7, -1), (8, 0),
]  # fmt: skip
# ANSI Z80.28, table of single indices.
OSA = [
    (0, 0), (1, -1), (1, 1), (2, -2), (2, 0), (2, 2), (3, -3), (3, -1), (3, 1), (3, 3),
    (4, -4), (4, -2), (4, 0), (4, 2), (4, 4),
]  # fmt: skip


def test_orders_are_those_of_their_tables() -> None:
    assert [listed_term("noll", j) for j in range(1, len(NOLL) + 1)] == NOLL
    assert [listed_term("fringe", j) for j in range(1, len(FRINGE) + 1)] == FRINGE
    assert [listed_term("osa", j) for j in range(len(OSA))] == OSA


def test_every_term_stands_once_in_each_order() -> None:
    terms = {(n, m) for n in range(9) for m in range(-n, n + 1, 2)}
    assert {listed_term("osa", j) for j in range(45)} == terms
    assert {listed_term("noll", j) for j in range(1, 46)} == terms
    assert terms <= {listed_term("fringe", j) for j in range(1, 82)}
    assert len({listed_term("fringe", j) for j in range(1, 82)}) == 81


def test_a_list_in_waves_is_the_wavefront_it_says() -> None:
    # Fringe term 9, 1 at the rim, is sqrt 5 less as a normalised one; half a wave of 633 nm.
    fringe = Zernike(
        diameter_mm=6.0,
        ordering="fringe",
        unit="waves",
        wavelength_nm=633.0,
        coefficients=(0.0,) * 7 + (0.2, 0.5),
    )
    assert fringe.terms == (
        ((3, -1), pytest.approx(0.2 * 0.633 / sqrt(8.0))),
        ((4, 0), pytest.approx(0.5 * 0.633 / sqrt(5.0))),
    )
    noll = Zernike(diameter_mm=6.0, ordering="noll", unit="um", coefficients=(0.0,) * 6 + (0.14,))
    assert noll.terms == (((3, -1), 0.14),)
    assert normalised("osa", (3, 1)) == 1.0


@pytest.mark.parametrize(
    ("text", "wavelength_nm", "found"),
    [
        ("n,m,um\n3,-1,0.14\n4,0,-0.2\n", None, {"3,-1": 0.14, "4,0": -0.2}),
        ("# exported\nN, M, um\n\n 3 , -1 , 1e-1\n", None, {"3,-1": 0.1}),
        ("noll,waves\n7,0.5\n", 840.0, {"3,-1": 0.42}),
        ("osa,um\n7,0.5\n", None, {"3,-1": 0.5}),
        ("fringe,um\n8,1\n", None, {"3,-1": 1.0 / sqrt(8.0)}),
    ],
)
def test_a_csv_says_its_order_and_unit(
    tmp_path: Path, text: str, wavelength_nm: float | None, found: dict[str, float]
) -> None:
    path = tmp_path / "eye.csv"
    path.write_text(text)
    assert wavefront_table(path, wavelength_nm) == pytest.approx(found)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "found nothing, wanted a first line n,m,um"),
        ("3,-1,0.14\n", 'found the first line "3,-1,0.14", wanted a first line'),
        ("zemax,um\n1,2\n", 'found the first line "zemax,um"'),
        ("noll,waves\n7,0.5\n", "found coefficients in waves, wanted zernike.wavelength_nm"),
        ("n,m,um\n3,0,0.1\n", "line 2: found the term (3, 0), wanted n from 0 to 8, m from -n"),
        ("n,m,um\n9,1,0.1\n", "line 2: found the term (9, 1)"),
        ("noll,um\n0,0.1\n", "line 2: found the term 0, wanted noll terms from 1 up to order 8"),
        ("noll,um\n999999,0.1\n", "line 2: found the term 999999"),
        ("fringe,um\n36,0.1\n", "line 2: found the term 36"),  # (10, 0)
        ("n,m,um\n3,1,nan\n", 'line 2: found "nan", wanted a number'),
        ("n,m,um\n3,1\n", "line 2: found 2 values, wanted 3: n,m,um"),
        ("n,m,um\n3,1.5,1\n", 'line 2: found "1.5", wanted a whole number'),
        ("n,m,um\n3,1,1\n3,1,2\n", "line 3: found (3,1) again, wanted each term once"),
        ("n,m,um\n", "found no coefficient, wanted at least one"),
    ],
)
def test_a_wrong_csv_is_one_line(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "eye.csv"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        wavefront_table(path, None)
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_a_rig_reads_a_csv_from_where_it_lies(tmp_path: Path) -> None:
    (tmp_path / "eyes").mkdir()
    (tmp_path / "eyes" / "mine.csv").write_text("noll,waves\n7,0.5\n")
    rig_file = tmp_path / "mine.toml"
    rig_file.write_text(
        'extends = "matched-full"\n[left.zernike]\ndiameter_mm = 6.0\nwavelength_nm = 840.0\n'
        'file = "eyes/mine.csv"\n'
    )
    rig = load_rig(rig_file)
    assert rig.left.zernike is not None
    assert rig.left.zernike.terms == (((3, -1), pytest.approx(0.42)),)
    assert rig.right.zernike is None


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("diameter_mm=6.0", "left.zernike.coefficients_um: found nothing, wanted coefficients"),
        ("coefficients_um={'3,1'=0.1}", "left.zernike.diameter_mm: found nothing"),
        (
            "diameter_mm=6.0, coefficients_um={'3,1'=0.1}, coefficients=[0.1], ordering='noll', "
            "unit='um'",
            'found them beside "coefficients", wanted one of them: names',
        ),
        ("diameter_mm=6.0, ordering='noll', coefficients_um={'3,1'=0.1}", "left.zernike.ordering"),
        ("diameter_mm=6.0, coefficients=[0.1]", "left.zernike.ordering: found nothing, wanted one"),
        ("diameter_mm=6.0, ordering='noll', coefficients=[0.1]", "left.zernike.unit: found noth"),
        (
            "diameter_mm=6.0, ordering='noll', unit='waves', coefficients=[0.1]",
            "left.zernike.wavelength_nm: found nothing, wanted the wavelength",
        ),
        ("diameter_mm=6.0, ordering='zemax', unit='um', coefficients=[0.1]", "zernike.ordering"),
        (
            f"diameter_mm=6.0, ordering='noll', unit='um', coefficients={[0.0] * 45 + [0.1]}",
            "left.zernike.coefficients: found 0.1 for term 46, which is (9, 1), wanted terms up to",
        ),
        ("diameter_mm=6.0, ordering='noll', unit='um', coefficients=[]", "found a list of 0"),
        ("diameter_mm=6.0, coefficients_um={'3,0'=0.1}", "no such coefficient"),
        (
            "diameter_mm=5.0, coefficients_um={'3,1'=0.1}",
            "left.pupil_mm: found 6, wanted at most 5 mm, over which the wavefront was measured",
        ),
        ("diameter_mm=6.0, file='nowhere.csv'", "nowhere.csv: found no such file"),
        (
            "diameter_mm=6.0, file='a.csv', coefficients_um={'3,1'=0.1}",
            'left.zernike.file: found it beside "coefficients_um", wanted one of the two',
        ),
        ("diameter_mm=6.0, file=3", "left.zernike.file: found 3, wanted a path in quotes"),
    ],
)
def test_a_wrong_wavefront_is_one_line(change: str, said: str) -> None:
    with pytest.raises(InputError) as error:
        load_rig("bare", overrides=["left.pupil_mm=6", f"left.zernike={{{change}}}"])
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_a_wavefront_is_continued_only_when_told_to() -> None:
    rig = load_rig(
        "bare",
        overrides=[
            "left.pupil_mm=6",
            "left.zernike={diameter_mm=5.0, extrapolate=true, coefficients_um={'3,1'=0.1}}",
        ],
    )
    assert rig.left.zernike is not None
