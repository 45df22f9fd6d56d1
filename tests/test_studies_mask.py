"""Masks at true scale: what a file holds is the rig's lattice, to a micrometre."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
import zlib
from pathlib import Path

import numpy as np
import pytest
from command_runs import call, left_in, require_done, require_one_line
from numpy.typing import NDArray

from vrlf.model import Rig, load_rig
from vrlf.optics.lattice import cell_coordinates, lattice_of
from vrlf.studies.mask.plan import plan_of
from vrlf.studies.mask.table import surfaces_of
from vrlf.studies.mask.vector import pdf_bytes

SMALL = ("panel.width_px=96", "panel.height_px=64", "headset.lens_separation_mm=3.0")
SQUARE = (*SMALL, "array.rotation_deg=17", "array.offset_um=[30.0, -50.0]")
ROUND = (*SQUARE, 'array.lattice="hexagonal"', 'array.aperture_shape="circle"')
NUMBER = r"(-?\d+\.?\d*)"
Points = NDArray[np.float64]


def pdf_page(data: bytes) -> tuple[Points, float, str]:
    """The page's size in points, points in a unit, and what is drawn."""
    size = re.search(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", data)
    stream = re.search(rb"stream\n(.*)\nendstream", data, re.DOTALL)
    assert size is not None
    assert stream is not None
    content = zlib.decompress(stream[1]).decode("ascii")
    unit = re.match(rf"{NUMBER} 0 0 {NUMBER}", content)
    assert unit is not None
    assert unit[1] == unit[2]
    return np.array([float(size[1]), float(size[2])]), float(unit[1]), content


def numbers(text: str) -> list[float]:
    return [float(each) for each in re.findall(NUMBER, text)]


def pdf_centres(content: str) -> Points:
    """Of all closed paths: the mean of their corners, or of a circle's four ends."""
    centres = []
    for path in re.findall(r"^(.*) h$", content, re.MULTILINE):
        points = np.array(numbers(path)).reshape(-1, 2)
        if " c" in path:  # move, then three points a quarter, the last of which lies on the circle
            points = points[3::3]
        centres.append(points.mean(axis=0))
    return np.array(centres)


def svg_centres(text: str) -> Points:
    space = "{http://www.w3.org/2000/svg}"
    root = ElementTree.fromstring(text)
    circles = root.iter(space + "circle")
    round_ones = [(float(each.attrib["cx"]), -float(each.attrib["cy"])) for each in circles]
    square = []
    for polygon in root.iter(space + "polygon"):
        corners = np.array(numbers(polygon.attrib["points"])).reshape(-1, 2) * [1.0, -1.0]
        square.append(tuple(corners.mean(axis=0)))
    return np.array(round_ones or square)


def wanted_centres(rig: Rig) -> Points:
    """All cells whose whole opening lies on the panel, of far more than lie on it."""
    lattice, array = lattice_of(rig), rig.array
    assert lattice is not None
    half = np.array([rig.panel.width_px, rig.panel.height_px]) * rig.panel.pixel_pitch_um / 2000.0
    turn = np.radians(array.rotation_deg)
    reach = 1.0 if lattice.round_holes else abs(np.cos(turn)) + abs(np.sin(turn))
    many = np.stack(np.meshgrid(np.arange(-60.0, 61.0), np.arange(-60.0, 61.0)), -1).reshape(-1, 2)
    # The design's rule, written out: cells turned about the panel's centre, then moved.
    step = np.array([[1.0, 0.5], [0.0, np.sqrt(0.75)]]) if lattice.is_hexagonal else np.eye(2)
    turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ step
    centres = (many @ turned.T * array.pitch_um + np.array(array.offset_um)) / 1000.0
    edge = half - reach * array.aperture_um / 2000.0
    return np.asarray(centres[np.all(np.abs(centres) < edge, axis=1)])


def sorted_rows(points: Points) -> Points:
    return points[np.lexsort(np.round(points, 3).T)]


@pytest.mark.parametrize("changes", [SQUARE, ROUND])
@pytest.mark.parametrize("ending", [".pdf", ".svg", ".dxf"])
def test_holes_lie_where_the_lattice_says(
    changes: tuple[str, ...], ending: str, tmp_path: Path
) -> None:
    rig = load_rig("pinhole", overrides=changes)
    options = [part for change in changes for part in ("--set", change)]
    path = tmp_path / f"mask{ending}"
    told = require_done(call("mask", "-r", "pinhole", *options, "-o", path, "--json")).json()
    if ending == ".pdf":
        found = pdf_centres(pdf_page(path.read_bytes())[2])
    elif ending == ".svg":
        found = svg_centres(path.read_text(encoding="utf-8"))
    else:
        found = dxf_centres(path)
    wanted = wanted_centres(rig)
    assert len(found) == len(wanted) == told["holes"] > 150
    np.testing.assert_allclose(sorted_rows(found), sorted_rows(wanted), atol=1e-3)


def dxf_centres(path: Path) -> Points:
    ezdxf = pytest.importorskip("ezdxf", reason="needs the extra 'design'")
    document = ezdxf.readfile(path)
    assert document.header["$INSUNITS"] == 4  # millimetres
    space = document.modelspace()
    ruler = space.query('LINE[layer=="RULER"]')
    lengths = [(each.dxf.end - each.dxf.start).magnitude for each in ruler]
    assert max(lengths) == pytest.approx(100.0, abs=1e-9)
    circles = space.query('CIRCLE[layer=="OPENINGS"]')
    if circles:
        return np.array([(each.dxf.center.x, each.dxf.center.y) for each in circles])
    squares = space.query('LWPOLYLINE[layer=="OPENINGS"]')
    return np.array([np.mean([point[:2] for point in each], axis=0) for each in squares])


def test_the_pdf_is_to_scale() -> None:
    """Ruler 100.00 mm on paper, crosses on the panel's corners, holes of their size."""
    rig = load_rig("pinhole", overrides=SQUARE)
    plan = plan_of(rig, "pinhole")
    size, unit, content = pdf_page(pdf_bytes(plan))
    assert unit == pytest.approx(72.0 / 25.4, rel=1e-9)
    left, lower, right, upper = plan.page_mm
    np.testing.assert_allclose(size / 72.0 * 25.4, [right - left, upper - lower], atol=1e-3)
    lines = np.array(
        [numbers(each) for each in re.findall(r"^(.* l) S$", content, re.MULTILINE)]
    ).reshape(-1, 2, 2)
    lengths = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
    assert lengths.max() * unit / 72.0 * 25.4 == pytest.approx(100.0, abs=1e-5)
    half = np.array([96.0, 64.0]) * 0.078 / 2.0
    for corner in half * [[1, 1], [1, -1], [-1, 1], [-1, -1]]:
        through = np.abs(lines.mean(axis=1) - corner).max(axis=1) < 1e-4
        assert through.sum() == 2
    first = re.search(r"^(.*) h$", content, re.MULTILINE)
    assert first is not None
    corners = np.array(numbers(first[1])).reshape(-1, 2)
    sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    np.testing.assert_allclose(sides, 0.075, atol=2e-5)
    along = corners[1] - corners[0]
    turn = np.degrees(np.arctan2(along[1], along[0])) % 90.0
    assert turn == pytest.approx(17.0, abs=0.05)


def test_lenslets_are_tabled(tmp_path: Path) -> None:
    options = [part for change in SQUARE for part in ("--set", change)]
    given = ("-r", "matched-microlens", *options)
    require_done(call("mask", *given, "-o", tmp_path / "lenslets.svg"))
    assert left_in(tmp_path) == ["lenslets.csv", "lenslets.svg"]
    lines = (tmp_path / "lenslets.csv").read_text(encoding="utf-8").splitlines()
    rows = [line.split(",") for line in lines if not line.startswith("#")]
    assert rows[0] == ["column", "row", "x_mm", "y_mm"]
    table = np.array(rows[1:], float)
    lattice = lattice_of(load_rig("matched-microlens", overrides=SQUARE))
    assert lattice is not None
    np.testing.assert_allclose(cell_coordinates(lattice, table[:, 2:]), table[:, :2], atol=1e-4)
    front = next(line for line in lines if "surface 1" in line)
    assert "radius 1.13" in front  # f (n - 1) = 2.3 mm of acrylic's 0.4925
    assert "pmma (n = 1.49" in front


def test_sag_is_that_of_the_face() -> None:
    lenslet = '{radius_mm=1.4,thickness_mm=1.2,glass="n-bk7"}'
    rig = load_rig(
        "matched-microlens", overrides=(*SMALL, f"array.lenslet={lenslet}", "array.focal_mm=0")
    )
    front, back = surfaces_of(rig)
    reach = 0.635 / np.sqrt(2.0)
    assert front.sag_mm == pytest.approx(1.4 - np.sqrt(1.4**2 - reach**2))
    assert front.index == pytest.approx(1.5168, abs=1e-4)
    assert (back.radius_mm, back.sag_mm, back.thickness_mm) == (0.0, 0.0, None)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("-r", "bare", "-o", "mask.pdf"), ("bare", '"none"', "pinhole or microlens")),
        (("-r", "pinhole", "-o", "mask.png"), ("mask.png", "'.png'", ".pdf, .svg, .dxf")),
        (("-r", "pinhole", "-o", "mask.csv"), ("pinhole", "wanted lenslets")),
        (("-r", "pinhole", "-o", "nowhere/mask.pdf"), ("nowhere", "found no folder")),
        (("-r", "pinhole"), ("--output", "vrlf mask --help")),
        (
            (
                *("-r", "pinhole", "--set", "array.pitch_um=10", "--set", "array.aperture_um=5"),
                *("-o", "mask.svg"),
            ),
            ("array.pitch_um", "cells over the panel"),
        ),
        (
            ("-r", "matched-microlens", "--set", "array.focal_mm=0.5", "-o", "lenslets.csv"),
            ("radius", "wanted a longer focal length"),
        ),
    ],
)
def test_a_wrong_input_is_one_line(
    arguments: tuple[str, ...],
    named: tuple[str, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    require_one_line(call("mask", *arguments), 2, *named)
    assert left_in(tmp_path) == []
