"""A plan as DXF for a maker's own program: millimetres, a layer for each kind of thing."""

from __future__ import annotations

import io
from importlib.util import find_spec

from vrlf.errors import InputError
from vrlf.studies.mask.plan import RULER_BELOW_MM, Plan

# ezdxf's number for millimetres in $INSUNITS.
_MILLIMETRES = 4


def require_ezdxf() -> None:
    """Refuse where the extra is missing.

    Raises
    ------
    InputError
    """
    if find_spec("ezdxf") is None:
        raise InputError(
            "-o: found no ezdxf for .dxf, wanted it installed; pip install 'vrlf[design]'"
        )


def dxf_text(plan: Plan) -> str:
    """The plan as a DXF file of AutoCAD 2010."""
    from ezdxf.filemanagement import new

    document = new("R2010")
    document.header["$INSUNITS"] = _MILLIMETRES
    document.header["$MEASUREMENT"] = 1
    for layer in ("PANEL", "OPENINGS", "CROSSES", "AXES", "RULER", "NOTES"):
        document.layers.add(layer)
    space = document.modelspace()
    half_width, half_height = plan.panel_mm[0] / 2.0, plan.panel_mm[1] / 2.0
    corners = [(x * half_width, y * half_height) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    space.add_lwpolyline(corners, close=True, dxfattribs={"layer": "PANEL"})
    attributes = {"layer": "OPENINGS"}
    for x, y in plan.centres_mm:
        if plan.diameter_mm is not None:
            space.add_circle((x, y), plan.diameter_mm / 2.0, dxfattribs=attributes)
        else:
            assert plan.outline_mm is not None
            outline = [(x + dx, y + dy) for dx, dy in plan.outline_mm]
            space.add_lwpolyline(outline, close=True, dxfattribs=attributes)
    for layer, lines in (("CROSSES", plan.crosses), ("AXES", plan.axes), ("RULER", plan.ruler)):
        for start, end in lines:
            space.add_line(start, end, dxfattribs={"layer": layer})
    for row, note in enumerate(plan.notes):
        at = (-50.0, -half_height - RULER_BELOW_MM - 8.5 - 4.0 * row)
        space.add_text(note, height=2.0, dxfattribs={"layer": "NOTES", "insert": at})
    written = io.StringIO()
    document.write(written)
    return written.getvalue()
