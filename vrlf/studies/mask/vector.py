"""A plan as PDF and SVG: paths alone, in millimetres, so that nothing is rounded to dots.

The PDF is written by hand: one page, one content stream whose first operator makes a unit one
millimetre, so that the numbers in it are those of the plan (ISO 32000-1, 8.3 and 8.5).
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from html import escape
from typing import Final

import numpy as np

from vrlf.studies.mask.plan import RULER_BELOW_MM, Line, Plan

_POINTS_PER_MM: Final = 72.0 / 25.4
_LINE_MM: Final = 0.1
_OUTLINE_MM: Final = 0.01
_TEXT_MM: Final = 3.0
# Of a quarter of a circle drawn as a cubic Bezier curve: off by 3e-4 of the radius at most.
_KAPPA: Final = 0.5522847498
# A path of all holes would keep viewers busy.
_HOLES_A_PATH: Final = 500


def pdf_bytes(plan: Plan) -> bytes:
    """The plan as a PDF file."""
    left, lower, right, upper = plan.page_mm
    size = f"{(right - left) * _POINTS_PER_MM:.4f} {(upper - lower) * _POINTS_PER_MM:.4f}"
    stream = zlib.compress("\n".join(_content(plan)).encode("ascii"), 9)
    objects = [
        b"<< /Type /Catalog /Pages 2 0 R >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {size}] /Contents 4 0 R "
        "/Resources << /Font << /F1 5 0 R >> >> >>".encode("ascii"),
        f"<< /Length {len(stream)} /Filter /FlateDecode >>\nstream\n".encode("ascii")
        + stream
        + b"\nendstream",
        b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>",
    ]
    # Viewers then print at 100 % unless they are told otherwise.
    objects[0] = objects[0][:-3] + b" /ViewerPreferences << /PrintScaling /None >> >>"
    return _file(objects)


def _file(objects: list[bytes]) -> bytes:
    """Objects, the table of where they begin, and the trailer."""
    out, starts = bytearray(b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n"), []
    for number, body in enumerate(objects, 1):
        starts.append(len(out))
        out += f"{number} 0 obj\n".encode("ascii") + body + b"\nendobj\n"
    table = len(out)
    out += f"xref\n0 {len(objects) + 1}\n0000000000 65535 f \n".encode("ascii")
    for start in starts:
        out += f"{start:010d} 00000 n \n".encode("ascii")
    out += f"trailer\n<< /Size {len(objects) + 1} /Root 1 0 R >>\n".encode("ascii")
    out += f"startxref\n{table}\n%%EOF\n".encode("ascii")
    return bytes(out)


def _content(plan: Plan) -> Iterator[str]:
    """Operators, in the panel's own millimetres."""
    left, lower, _, _ = plan.page_mm
    scale = _POINTS_PER_MM
    yield f"{scale:.9f} 0 0 {scale:.9f} {-left * scale:.6f} {-lower * scale:.6f} cm"
    width, height = plan.panel_mm
    yield f"{_LINE_MM} w 0 G"
    box = f"{-width / 2.0:.5f} {-height / 2.0:.5f} {width:.5f} {height:.5f} re"
    if plan.is_mask:
        yield f"0 g {box} f"
        yield "1 g"
    else:
        yield f"{box} S {_OUTLINE_MM} w"
    paint = "f" if plan.is_mask else "S"
    for start in range(0, len(plan.centres_mm), _HOLES_A_PATH):
        for x, y in plan.centres_mm[start : start + _HOLES_A_PATH]:
            yield _hole(plan, float(x), float(y))
        yield paint
    yield f"0 g {_LINE_MM} w"
    for line in (*plan.crosses, *plan.axes, *plan.ruler):
        yield _pdf_line(line)
    for x, y, text in _texts(plan):
        told = text.replace("\\", r"\\").replace("(", r"\(").replace(")", r"\)")
        plain = told.encode("ascii", "replace").decode("ascii")
        yield f"BT /F1 {_TEXT_MM} Tf {x:.4f} {y:.4f} Td ({plain}) Tj ET"


def _pdf_line(line: Line) -> str:
    (x0, y0), (x1, y1) = line
    return f"{x0:.5f} {y0:.5f} m {x1:.5f} {y1:.5f} l S"


def _hole(plan: Plan, x: float, y: float) -> str:
    if plan.outline_mm is not None:
        corners = plan.outline_mm + np.array([x, y])
        first, *rest = (f"{px:.5f} {py:.5f}" for px, py in corners)
        return f"{first} m " + " ".join(f"{each} l" for each in rest) + " h"
    assert plan.diameter_mm is not None
    r = plan.diameter_mm / 2.0
    k = _KAPPA * r
    quarters = (
        ((x + r, y + k), (x + k, y + r), (x, y + r)),
        ((x - k, y + r), (x - r, y + k), (x - r, y)),
        ((x - r, y - k), (x - k, y - r), (x, y - r)),
        ((x + k, y - r), (x + r, y - k), (x + r, y)),
    )
    curves = (" ".join(f"{a:.5f} {b:.5f}" for a, b in quarter) + " c" for quarter in quarters)
    return f"{x + r:.5f} {y:.5f} m {' '.join(curves)} h"


def _texts(plan: Plan) -> list[tuple[float, float, str]]:
    """Where each note begins."""
    y = -plan.panel_mm[1] / 2.0 - RULER_BELOW_MM
    lines = [(-50.0, y - 8.5 - 1.35 * _TEXT_MM * row, text) for row, text in enumerate(plan.notes)]
    return [(-50.8, y + 1.0, "0"), (46.5, y + 1.0, "100 mm"), *lines]


def svg_text(plan: Plan) -> str:
    """The plan as an SVG file; its unit is a millimetre, y turned down."""
    left, lower, right, upper = plan.page_mm
    width, height = right - left, upper - lower
    panel_width, panel_height = plan.panel_mm
    box = (
        f'<rect id="panel" x="{-panel_width / 2.0:.5f}" y="{-panel_height / 2.0:.5f}" '
        f'width="{panel_width:.5f}" height="{panel_height:.5f}"'
    )
    style = "" if plan.is_mask else f' fill="none" stroke="black" stroke-width="{_LINE_MM}"'
    holes = "white" if plan.is_mask else "none"
    stroke = "" if plan.is_mask else f' stroke="black" stroke-width="{_OUTLINE_MM}"'
    lines = "\n".join(
        f'<g id="{name}">\n' + "\n".join(_svg_line(line) for line in each) + "\n</g>"
        for name, each in (("crosses", plan.crosses), ("axes", plan.axes), ("ruler", plan.ruler))
    )
    texts = "\n".join(
        f'<text x="{x:.4f}" y="{-y:.4f}">{escape(text)}</text>' for x, y, text in _texts(plan)
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.5f}mm" height="{height:.5f}mm" '
        f'viewBox="{left:.5f} {-upper:.5f} {width:.5f} {height:.5f}">\n'
        f"{box}{style}/>\n"
        f'<g id="openings" fill="{holes}"{stroke}>\n' + "\n".join(_svg_holes(plan)) + "\n</g>\n"
        f'<g stroke="black" stroke-width="{_LINE_MM}">\n{lines}\n</g>\n'
        f'<g font-family="Helvetica, Arial, sans-serif" font-size="{_TEXT_MM}">\n{texts}\n</g>\n'
        "</svg>\n"
    )


def _svg_line(line: Line) -> str:
    (x0, y0), (x1, y1) = line
    return f'<line x1="{x0:.5f}" y1="{-y0:.5f}" x2="{x1:.5f}" y2="{-y1:.5f}"/>'


def _svg_holes(plan: Plan) -> Iterator[str]:
    flipped = plan.centres_mm * np.array([1.0, -1.0])
    if plan.diameter_mm is not None:
        for x, y in flipped:
            yield f'<circle cx="{x:.5f}" cy="{y:.5f}" r="{plan.diameter_mm / 2.0:.5f}"/>'
        return
    assert plan.outline_mm is not None
    outline = plan.outline_mm * np.array([1.0, -1.0])
    for centre in flipped:
        corners = " ".join(f"{x:.5f},{y:.5f}" for x, y in outline + centre)
        yield f'<polygon points="{corners}"/>'
