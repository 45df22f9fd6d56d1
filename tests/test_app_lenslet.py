"""``vrlf lenslet``: its numbers against closed forms, its words, its picture, its refusals."""

from __future__ import annotations

from math import atan, degrees, inf
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_runs import call, left_in, require_done, require_one_line

from vrlf.model import load_rig
from vrlf.optics.glass import index_at
from vrlf.optics.lenslet.paraxial import cardinal
from vrlf.optics.lenslet.report import lenslet_report
from vrlf.optics.lenslet.setting import object_mm_of, setting_of
from vrlf.optics.lenslet.spots import spot
from vrlf.studies import plots

THESIS = ("-r", "thesis-minus-5d")
FAR = (*THESIS, "--focus", "infinity")
T_7_2 = ("--radius-mm", "2.961", "--thickness-mm", "0.5", "--glass", "pmma")
COLOURS = (610.0, 545.0, 465.0)


def numbers(*arguments: str) -> dict[str, Any]:
    found: dict[str, Any] = require_done(call("lenslet", *arguments, "--json")).json()
    return found


def test_the_thesis_lens_by_closed_forms() -> None:
    """T 7.2: 2.961 mm and 0.5 mm of PMMA, 0.39 mm wide, 6 mm before the panel."""
    found = numbers(*FAR, *T_7_2)
    n = np.array([index_at("pmma", nm) for nm in COLOURS])
    assert found["focal_mm"] == pytest.approx(2.961 / (n - 1.0), rel=1e-12)
    assert found["back_focus_mm"] == pytest.approx(2.961 / (n - 1.0) - 0.5 / n, rel=1e-12)
    assert found["given"] == "given"
    assert found["object_mm"] is None
    # The second principal plane stands 6 mm before the panel.
    assert found["panel_mm"] == pytest.approx(6.0 - 0.5 / index_at("pmma", 587.56), rel=1e-12)
    assert found["chromatic_um"] == pytest.approx(
        1000.0 * (found["back_focus_mm"][0] - found["back_focus_mm"][2]), rel=1e-12
    )
    # Green's: lambda N, 2 lambda N^2 at N = 6 / 0.39; its own principal plane is 0.5 um off.
    assert found["diffraction_um"] == pytest.approx(0.545 * 6.0 / 0.39, rel=2e-4)
    assert found["depth_of_focus_um"] == pytest.approx(2.0 * 0.545 * (6.0 / 0.39) ** 2, rel=4e-4)
    assert found["fields"]["edge"]["angle_deg"] == pytest.approx(degrees(atan(0.39 / 12.0)))
    assert found["lenslet"]["radii_mm"] == pytest.approx([2.961, 0.0])


def test_that_lens_is_as_good_as_diffraction_and_its_colours_within_the_depth_of_focus() -> None:
    """T Fig. 7.2: spots within diffraction, MTF near its limit; colours do not matter."""
    found = numbers(*FAR, *T_7_2)
    for field in ("axis", "edge", "corner"):
        assert max(found["fields"][field]["rms_um"]) < found["diffraction_um"] / 2.0
        # The limit at the pixel's frequency: 1 - lambda N / (2 p), 0.94 to 0.95.
        for kept, nm in zip(found["fields"][field]["mtf"], COLOURS, strict=True):
            assert kept == pytest.approx(1.0 - nm * 1e-6 * 6.0 / 0.39 / 0.156, abs=0.01)
    assert found["chromatic_um"] / 2.0 < found["depth_of_focus_um"]
    # Where the viewport ends the same lens is looked through at 43 degrees: three pixels.
    assert min(found["fields"]["viewport"]["rms_um"]) > 2.0 * found["pixel_um"]


def test_the_object_is_what_the_eye_focuses_on() -> None:
    """A -5 D eye behind 46 mm focuses at 46 / 1.23 = 37.4 mm (T 8.4): 5.0 mm before the array."""
    found = numbers()
    assert found["object_mm"] == pytest.approx(42.4 - 46.0 / 1.23, rel=1e-12)
    rig = load_rig("matched-microlens")
    assert object_mm_of(rig, "infinity") == inf
    # An eye without error focuses on the panel itself, 3.6 mm behind the array.
    plano = load_rig("matched-microlens", both="plano")
    assert object_mm_of(plano, "right") == pytest.approx(-3.6, rel=1e-9)


def test_at_the_best_gap_the_spots_are_least() -> None:
    rig = load_rig("matched-microlens")
    setting = setting_of(rig, None, "left")
    report = lenslet_report(setting)
    assert report.best_gap_mm is not None
    back_mm = cardinal(setting.lens, 587.56).back_principal_mm

    def size(gap_mm: float) -> float:
        beams = [setting.beam(c, field) for c in range(3) for field in ("axis", "edge")]
        return sum(spot(setting.lens, beam, gap_mm + back_mm).rms_mm ** 2 for beam in beams)

    best = size(report.best_gap_mm)
    assert best < min(size(report.best_gap_mm + step) for step in (-0.01, 0.01, 3.6 - 3.873))
    assert setting.gap_mm == pytest.approx(3.6, rel=1e-12)


def test_a_spacer_counts_reduced() -> None:
    """Behind plano-convex lenslets a spacer of index n and n times the gap changes no focus."""
    plain = numbers(*FAR, *T_7_2)
    solid = numbers(*FAR, *T_7_2, "--set", "array.gap_mm=9.0", "--set", "array.gap_index=1.5")
    assert solid["focal_mm"] == pytest.approx(plain["focal_mm"], rel=1e-12)
    assert solid["panel_mm"] == pytest.approx(1.5 * plain["panel_mm"], rel=1e-12)
    assert solid["chromatic_um"] == pytest.approx(1.5 * plain["chromatic_um"], rel=1e-9)
    assert solid["best_gap_mm"] == pytest.approx(1.5 * plain["best_gap_mm"], rel=1e-3)
    assert solid["diffraction_um"] == pytest.approx(plain["diffraction_um"], rel=1e-12)


def test_an_achromat_takes_the_colours_together() -> None:
    single, pair = numbers(), numbers("--achromat", "pmma+polycarbonate")
    assert pair["given"] == "designed: achromat"
    assert abs(pair["chromatic_um"]) < 0.03 * single["chromatic_um"]
    assert pair["lenslet"]["glasses"] == ["pmma", "polycarbonate"]


def test_the_words() -> None:
    said = require_done(call("lenslet", *FAR)).out
    assert said.startswith("Lenslet (assumed: plano-convex, pmma)\n  radius 2.9552 mm, then 0.5 mm")
    assert "within the depth of focus" in said
    assert "best gap        5.954 mm; it is 6.000 mm" in said
    # Lenslets of 6 mm make no image of what lies 2.6 mm before them.
    assert "none, for its light does not meet" in require_done(call("lenslet", *THESIS)).out
    blocked = require_done(call("lenslet", "--facing", "panel", *_plain(1.13))).out
    assert "% blocked)" in blocked
    assert len([line for line in blocked.splitlines() if len(line) > 100]) == 0


def _plain(radius_mm: float) -> tuple[str, ...]:
    return ("--radius-mm", str(radius_mm), "--thickness-mm", "0.5", "--glass", "1.49/57")


def test_the_table() -> None:
    rows = numbers(*THESIS, "--table")["rows"]
    assert [row["name"] for row in rows][1:3] == ["T 7.1 as printed", "T 7.1, glasses exchanged"]
    # Single, printed, exchanged and two right ones of the thesis's glasses, one of plastics.
    assert [row["focus_shift_um"] for row in rows] == pytest.approx(
        [98.5, 83.7, 4.4, 11.2, 0.0, 0.0], abs=0.06
    )
    assert [row["focal_mm"] for row in rows] == pytest.approx(
        [6.0, 3.298, 10.946, 6.0, 6.0, 6.0], abs=1e-3
    )
    said = require_done(call("lenslet", *THESIS, "--table")).out
    assert "Table 7.1 has its two glasses the wrong way round" in said
    # At 2.3 mm the thesis's glasses, so alike, make no lens.
    assert "its glasses, one focus: achromat: found" in require_done(call("lenslet", "--table")).out


@pytest.mark.parametrize("ending", [".png", ".svg"])
@pytest.mark.parametrize("rig", [FAR, ("--achromat", "pmma+polycarbonate")])
def test_the_picture(tmp_path: Path, ending: str, rig: tuple[str, ...]) -> None:
    path = tmp_path / f"lenslet{ending}"
    outcome = require_done(call("lenslet", *rig, "-o", path))
    assert outcome.err == f"wrote {path}\n"
    head = path.read_bytes()[:5]
    assert head == (b"\x89PNG\r" if ending == ".png" else b"<?xml")
    assert left_in(tmp_path) == [path.name]


@pytest.mark.parametrize(
    ("arguments", "wrong"),
    [
        (("-r", "pinhole"), 'array.kind: found "pinhole", wanted "microlens"'),
        (("-r", "pinhole", "--table"), 'array.kind: found "pinhole", wanted "microlens"'),
        (("-r", "pinhole", "--achromat", "pmma+polycarbonate"), "array.kind: found"),
        (("--radius-mm", "1.13"), "array.lenslet.thickness_mm: found nothing"),
        (("--achromat", "pmma"), "--achromat: found 'pmma', wanted CROWN+FLINT"),
        (("--achromat", "pmma+foo"), "glass: found 'foo', wanted"),
        (("--achromat", "1.0/55+1.6/30"), "glass: found '1.0/55'"),
        (("--achromat", "polycarbonate+pmma"), "achromat: found a crown of Abbe number"),
        (("--achromat", "pmma+polycarbonate", *T_7_2), "--achromat: found --radius-mm beside it"),
        (("--table", "-o", "a.png"), "--table: found -o beside it"),
        (("-o", "lenslet.gif"), "found the ending '.gif', wanted .png or .svg"),
        (("-o", "/no-such-folder/a.png"), "no-such-folder"),
        (_plain(0.3), "found a surface of radius 0.3 mm"),
        (("--radius-mm", "nan", *_plain(1.0)[2:]), "array.lenslet.radius_mm: found"),
        (
            (*_plain(1.13)[:3], "6.0", *_plain(1.13)[4:]),
            "array.gap_mm: found 3.6, wanted more than the 4.03 mm",
        ),
    ],
)
def test_what_is_refused(arguments: tuple[str, ...], wrong: str) -> None:
    require_one_line(call("lenslet", *arguments), 2, wrong)


def test_an_eye_that_focuses_on_the_array() -> None:
    """46 / (1 + 0.046 x) = 42.4 for x = 1.8458: no lenslet images anything there."""
    sphere_d = -1000.0 * (1.0 / 42.4 - 1.0 / 46.0)
    said = call("lenslet", "--set", f"left.sphere_d={sphere_d:.9f}")
    require_one_line(said, 2, "--focus: found that the left eye focuses on the array")


def test_without_matplotlib(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(plots, "find_spec", lambda _: None)
    said = call("lenslet", "-o", tmp_path / "a.png")
    require_one_line(said, 2, "-o: found no matplotlib")
