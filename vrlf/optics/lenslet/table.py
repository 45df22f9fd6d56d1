"""The thesis's doublet beside what it should be: a design table, in numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

from vrlf.errors import InputError
from vrlf.model import Rig, focal_mm
from vrlf.optics.glass import C_LINE_NM, D_LINE_NM, F_LINE_NM
from vrlf.optics.lenslet.achromat import TABLE_7_1, Agreeing, achromat, table_7_1
from vrlf.optics.lenslet.focus import chromatic_focus_mm
from vrlf.optics.lenslet.paraxial import cardinal, power_per_mm
from vrlf.optics.lenslet.setting import usual_lens
from vrlf.optics.lenslet.spots import best_distance_mm, spot
from vrlf.optics.lenslet.surfaces import Lens, Medium
from vrlf.optics.lenslet.trace import Beam
from vrlf.units import UM_PER_MM

# Of crown and flint beside the thesis's own: plastics that arrays are moulded of.
MOULDED = (Medium("pmma"), Medium("polycarbonate"))


@dataclass(frozen=True)
class Row:
    """One lens, for light from infinity.

    Attributes
    ----------
    name : str
    lens : Lens
    focal_mm : float
        At the d line.
    focal_shift_um, focus_shift_um : float
        Of C over F: the focal length, and where the focus lies.
    spot_um : (float, float)
        RMS radius at d on the axis and at the cell's edge, at the gap that is best for both.
    """

    name: str
    lens: Lens
    focal_mm: float
    focal_shift_um: float
    focus_shift_um: float
    spot_um: tuple[float, float]


def achromat_table(rig: Rig) -> tuple[list[Row], list[str]]:
    """Single lens, Table 7.1 as printed and with its glasses exchanged, and right ones.

    All are of the rig's pitch, and but for the printed two of its focal length. With them come
    sentences on those that cannot be made so short or so thin.

    Raises
    ------
    InputError
        If the rig has no lenslets.
    """
    array = rig.array
    if array.kind != "microlens":
        raise InputError(f'array.kind: found "{array.kind}", wanted "microlens"')
    pitch_mm, wanted_mm = array.pitch_um / UM_PER_MM, focal_mm(array)
    thesis = (TABLE_7_1["concave"][1], TABLE_7_1["convex"][1])

    def right(glasses: tuple[Medium, Medium], agreeing: Agreeing) -> Callable[[], Lens]:
        return lambda: achromat(wanted_mm, *glasses, pitch_mm, agreeing=agreeing)

    designs = {
        "its glasses, one focal length": right(thesis, "focal length"),
        "its glasses, one focus": right(thesis, "focus"),
        "PMMA and polycarbonate, one focus": right(MOULDED, "focus"),
    }
    rows, missing = (
        [
            _row("one lens of PMMA", usual_lens(rig)),
            _row("T 7.1 as printed", table_7_1(pitch_mm)),
            _row("T 7.1, glasses exchanged", table_7_1(pitch_mm, exchanged=True)),
        ],
        [],
    )
    for name, design in designs.items():
        try:
            rows.append(_row(name, design()))
        except InputError as error:
            missing.append(f"{name}: {error}")
    return rows, missing


def _row(name: str, lens: Lens) -> Row:
    found = cardinal(lens, D_LINE_NM)
    f_mm, c_mm = (1.0 / power_per_mm(lens, nm) for nm in (F_LINE_NM, C_LINE_NM))
    at_f, at_c = chromatic_focus_mm(lens, (F_LINE_NM, C_LINE_NM))
    edge = lens.aperture_mm / 2.0 / found.focal_mm
    beams = [Beam(D_LINE_NM, (0.0, slope), inf) for slope in (0.0, edge)]
    distance_mm = best_distance_mm(lens, beams)
    axis, off = (UM_PER_MM * spot(lens, beam, distance_mm).rms_mm for beam in beams)
    return Row(
        name=name,
        lens=lens,
        focal_mm=found.focal_mm,
        focal_shift_um=UM_PER_MM * (c_mm - f_mm),
        focus_shift_um=UM_PER_MM * float(at_c - at_f),
        spot_um=(axis, off),
    )
