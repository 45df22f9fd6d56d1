"""What ``vrlf lenslet`` says, in words."""

from __future__ import annotations

from vrlf.optics.lenslet.report import FieldNumbers, LensletReport
from vrlf.optics.lenslet.setting import Setting
from vrlf.optics.lenslet.surfaces import Lens, Surface
from vrlf.optics.lenslet.table import Row
from vrlf.units import UM_PER_MM

_PLACES = {
    "axis": "the middle",
    "edge": "the cell's edge",
    "corner": "its corner",
    "viewport": "viewport's end",
}


def report_text(setting: Setting, report: LensletReport, origin: str, focus: str) -> str:
    """The numbers of one lenslet."""
    return "\n".join(
        [
            f"Lenslet ({origin})",
            *(f"  {line}" for line in surface_lines(setting.lens)),
            f"  it images       {_object(report, focus)},",
            f"                  on the panel {report.panel_mm:.3f} mm behind its last surface",
            "",
            *_colours(setting, report),
            "",
            f"RMS radius of spots, um (a pixel is {report.pixel_um:g}, diffraction's first dark "
            f"{report.diffraction_um:.1f}),",
            "and the contrast left of lines one pixel wide",
            *(_field(_PLACES[name], each) for name, each in report.fields.items()),
            "",
            "Field curvature: green's foci from where the middle's is, um",
            *(_foci(_PLACES[n], each) for n, each in report.fields.items() if n != "axis"),
        ]
    )


def _object(report: LensletReport, focus: str) -> str:
    if report.object_mm is None:
        return "infinity"
    way = "before" if report.object_mm > 0.0 else "behind"
    return f"the {focus} eye's plane of focus, {abs(report.object_mm):.2f} mm {way} the array"


def _colours(setting: Setting, report: LensletReport) -> list[str]:
    """Focal lengths, images and the gap that they want."""
    heads = "".join(f"{nm:>8.0f} nm" for nm in setting.wavelengths_nm)
    deep = abs(report.chromatic_um) / 2.0 <= report.depth_of_focus_um
    gap = "none, for its light does not meet behind the lenslet"
    if report.best_gap_mm is not None:
        gap = f"{report.best_gap_mm:.3f} mm"
    return [
        f"{'':<18}{heads}",
        f"  focal length    {_row(report.focal_mm, '.4f')} mm",
        f"  image at        {_row(report.back_focus_mm, '.4f')} mm behind the last surface",
        f"  focus shift     red {report.chromatic_um:+.0f} um behind blue (C "
        f"{report.chromatic_fc_um:+.0f} behind F): {'within' if deep else 'more than'} the depth "
        f"of focus,",
        f"                  {report.depth_of_focus_um:.0f} um either way",
        f"  best gap        {gap}; it is {setting.gap_mm:.3f} mm",
    ]


def _row(values: tuple[float, ...], form: str) -> str:
    return "".join(f"{value:>11{form}}" for value in values)


def _field(place: str, numbers: FieldNumbers) -> str:
    angle = f"{numbers.angle_deg:.1f} deg"
    if numbers.rms_um is None or numbers.mtf is None:
        return f"  {place:<16}{angle:>9}  no light comes through"
    sizes = "".join(f"{value:>8.2f}" for value in numbers.rms_um)
    kept = "".join(f"{value:>7.2f}" for value in numbers.mtf)
    blocked = ""
    if numbers.transmitted < 1.0:
        blocked = f"  ({100.0 * (1.0 - numbers.transmitted):.1f} % blocked)"
    return f"  {place:<16}{angle:>9}{sizes}  {kept}{blocked}"


def _foci(place: str, numbers: FieldNumbers) -> str:
    said = "none"
    if numbers.sagittal_mm is not None and numbers.tangential_mm is not None:
        sagittal, tangential = (
            UM_PER_MM * each for each in (numbers.sagittal_mm, numbers.tangential_mm)
        )
        said = f"sagittal {sagittal:+.0f}, tangential {tangential:+.0f}"
    return f"  {place:<16}{said}"


def surface_lines(lens: Lens) -> list[str]:
    """Each surface and what follows it."""
    lines = []
    for number, each in enumerate(lens.surfaces):
        radius = f"{1.0 / each.curvature_per_mm:.4f} mm" if each.curvature_per_mm else "flat"
        conic = f", conic {each.conic:g}" if each.conic else ""
        behind = (
            ""
            if number == len(lens.surfaces) - 1
            else (f", then {each.thickness_mm:g} mm of {each.medium.name}")
        )
        lines.append(f"radius {radius}{conic}{behind}")
    return lines


def table_text(rows: list[Row], missing: list[str]) -> str:
    """The achromats one under the other, and what is wrong with the thesis's."""
    heads = ("radii, mm", "f, mm", "f_C - f_F", "focus C - F", "spots, um")
    widths = (26, 9, 12, 13, 13)
    lines = [f"{'':<34}" + "".join(f"{h:>{w}}" for h, w in zip(heads, widths, strict=True))]
    for row in rows:
        radii = ", ".join(_radius(each) for each in row.lens.surfaces)
        cells = (
            radii,
            f"{row.focal_mm:.3f}",
            f"{_positive_zero(row.focal_shift_um):.1f} um",
            f"{_positive_zero(row.focus_shift_um):.1f} um",
            f"{row.spot_um[0]:.2f}, {row.spot_um[1]:.2f}",
        )
        lines.append(
            f"{row.name:<34}" + "".join(f"{c:>{w}}" for c, w in zip(cells, widths, strict=True))
        )
    return "\n".join([*lines, *missing, "", *_verdict(*rows[:3])])


def _radius(surface: Surface) -> str:
    return f"{1.0 / surface.curvature_per_mm:.4g}" if surface.curvature_per_mm else "flat"


def _positive_zero(value: float) -> float:
    return round(value, 1) + 0.0


def _verdict(single: Row, printed: Row, exchanged: Row) -> list[str]:
    one, two, three = (
        f"{abs(row.focal_shift_um) / UM_PER_MM / row.focal_mm:.2%}"
        for row in (single, printed, exchanged)
    )
    return [
        "Table 7.1 has its two glasses the wrong way round: its convex lens is of the flint,",
        "1.65/45, its concave one of the crown, 1.52/55. As printed, cemented, it has a focal",
        f"length of {printed.focal_mm:.1f} mm, and C's and F's are {two} apart, where one lens of "
        f"PMMA has {one}.",
        f"With the glasses exchanged they are {three} apart, but at {exchanged.focal_mm:.1f} mm.",
        "It gives no thicknesses: 0.35 and 0.2 mm here.",
    ]
