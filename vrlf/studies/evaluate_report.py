"""What an evaluation found as files: the report, its numbers, the rigs; and as a short table."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Final

from rich import box
from rich.table import Table

from vrlf import __version__
from vrlf.evaluation.measure import border_px
from vrlf.evaluation.report import (
    Eye,
    Map,
    Pair,
    Report,
    View,
    columns_of,
    flat,
    report_html,
    results_csv,
    results_json,
    short_names,
)
from vrlf.evaluation.report.parts import number_text
from vrlf.files import atomic_write_text, check_target, make_folder
from vrlf.gpu import DeviceInfo
from vrlf.model import Rig, focal_mm, prescription_text
from vrlf.model.saving import rig_text
from vrlf.optics.inspect import inspect_rig
from vrlf.optics.viewport import SIDES, Side
from vrlf.studies.evaluate import Evaluation
from vrlf.studies.evaluate_plots import NO_MATPLOTLIB, evaluation_plots, eye_plots, have_matplotlib
from vrlf.studies.evaluate_store import CaseFound, case_folder, slug

REPORT: Final = "report.html"
NUMBERS: Final = ("results.json", "results.csv")
_RIGS: Final = "rigs"
# The numbers that a terminal has room for, and their headings.
_SHORT: Final = {
    "psnr_db": "PSNR dB",
    "ssim": "SSIM",
    "flip": "FLIP",
    "cvvdp_jod": "JOD",
    "acuity.decimal": "acuity",
}
_NUMBER_WIDTH: Final = 7
# What the numbers depend on, by the name that it is installed under.
_LIBRARIES: Final = ("numpy", "scipy", "scikit-image", "flip-evaluator", "cvvdp", "torch")


def versions_of(info: DeviceInfo) -> dict[str, str]:
    """Of everything that the numbers depend on; what is not installed is left out."""
    found = {
        "vrlf": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "gpu": info.renderer,
        "opengl": info.version,
    }
    for library in _LIBRARIES:
        try:
            found[library] = version(library)
        except PackageNotFoundError:
            continue
    return found


def check_places(folder: Path) -> None:
    """Make sure that all results can be put into the folder, before anything is computed."""
    for name in (REPORT, *NUMBERS):
        check_target(folder / name)


def notes_of(found: Evaluation) -> list[str]:
    """What could not be had of the metrics: each reason once, and where, if not everywhere."""
    places: dict[str, list[str]] = {}
    for case in (*found.cases, *found.charts):
        for side in SIDES:
            place = f"{case.source}, {case.rig}, {side}, {case.method}"
            for reason in dict.fromkeys(case.eye(side).failed.values()):
                places.setdefault(reason, []).append(place)
    everywhere = {len(SIDES) * len(cases) for cases in (found.cases, found.charts)}
    return [
        reason if len(where) in everywhere else f"{reason} ({_counted(where)})"
        for reason, where in places.items()
    ]


def _counted(places: Sequence[str]) -> str:
    """The first place, and how many more there are."""
    more = len(places) - 1
    return places[0] if not more else f"{places[0]}, and {more} more"


def report_of(
    found: Evaluation,
    sources: Sequence[str],
    rigs: Mapping[str, Rig],
    folder: Path,
    *,
    rays: int,
    versions: Mapping[str, str],
) -> Report:
    """All of an evaluation, its pictures read from the folder."""
    pairs = tuple(
        _pair(source, name, rig, found, folder) for source in sources for name, rig in rigs.items()
    )
    notes = notes_of(found)
    if not have_matplotlib():
        notes.append(NO_MATPLOTLIB)
    report = Report(
        pairs=pairs,
        rays=rays,
        rig_texts={name: rig_text(rig) for name, rig in rigs.items()},
        versions=versions,
        notes=tuple(notes),
        failures=tuple(vars(each) for each in found.failures),
    )
    if not have_matplotlib():
        return report
    return Report(**{**vars(report), "plots": evaluation_plots(report)})


def write_report(report: Report, folder: Path) -> dict[str, Any]:
    """Write numbers, rigs and the report; the numbers."""
    numbers = results_json(report)
    rigs = make_folder(folder / _RIGS)
    for name, text in zip(_rig_files(report.rig_texts), report.rig_texts.values(), strict=True):
        atomic_write_text(rigs / name, text)
    text = json.dumps(numbers, indent=2, allow_nan=False)
    atomic_write_text(folder / NUMBERS[0], text + "\n")
    atomic_write_text(folder / NUMBERS[1], results_csv(report))
    atomic_write_text(folder / REPORT, report_html(report))
    return numbers


def _rig_files(names: Mapping[str, str]) -> list[str]:
    """A file's name for each rig, all different."""
    files: list[str] = []
    for name in names:
        stem = slug(name).removesuffix(".toml")
        file, count = f"{stem}.toml", 2
        while file.lower() in (each.lower() for each in files):
            file, count = f"{stem}-{count}.toml", count + 1
        files.append(file)
    return files


def _pair(source: str, name: str, rig: Rig, found: Evaluation, folder: Path) -> Pair:
    cases = [case for case in found.cases if (case.source, case.rig) == (source, name)]
    charts = {case.method: case for case in found.charts if case.rig == name}
    numbers = inspect_rig(rig)
    eyes = []
    for side in SIDES:
        views = tuple(_view(case, charts.get(case.method), side, folder) for case in cases)
        eyes.append(
            Eye(
                side=side,
                paper=_eye_words(rig, side, numbers),
                border_px=border_px(rig, side),
                target=found.targets[source, name][side],
                views=views,
                plots=eye_plots(views) if have_matplotlib() else (),
            )
        )
    return Pair(source, name, numbers["array"]["throughput"], _rig_words(rig, numbers), tuple(eyes))


def _view(case: CaseFound, charts: CaseFound | None, side: Side, folder: Path) -> View:
    place = case_folder(folder, case.source, case.rig, case.method, case.key)
    eye = case.eye(side)
    values, reasons = dict(eye.values), dict(eye.reasons)
    if charts is not None:
        values |= charts.eye(side).values
        reasons |= charts.eye(side).reasons
    return View(
        method=case.method,
        seen=(place / f"{side}-seen.png").read_bytes(),
        panel=(place / f"{side}-panel.png").read_bytes(),
        values=values,
        maps=tuple(Map(title, (place / file).read_bytes()) for title, file in eye.maps.items()),
        notes=tuple(f"{case.method}, {name}: {reason}" for name, reason in reasons.items()),
    )


def _eye_words(rig: Rig, side: Side, numbers: Mapping[str, Any]) -> str:
    eye = rig.left if side == "left" else rig.right
    blur = numbers[side]["blur_px"]
    who = prescription_text(eye.sphere_d, eye.cylinder_d, eye.axis_deg)
    if eye.camera is not None:
        who = "a camera in the eye's place"
    return (
        f"{who}, pupil {numbers[side]['pupil_mm']:g} mm; uncorrected, a point blurs over "
        f"{blur:.1f} pixels."
    )


def _rig_words(rig: Rig, numbers: Mapping[str, Any]) -> str:
    panel, array = rig.panel, rig.array
    words = (
        f"{panel.width_px} x {panel.height_px} pixels of {panel.pixel_pitch_um:g} um "
        f"({panel.subpixels}), {panel.peak_nit:g} cd/m2, {rig.headset.lens_to_panel_mm:g} mm "
        f"behind the lens, {numbers['display']['pixels_per_degree']:.2f} pixels per degree; "
    )
    if array.kind == "none":
        return f"{words}no array."
    what = (
        f"holes of {array.aperture_um:g} um"
        if array.kind == "pinhole"
        else f"lenslets of {focal_mm(array):.4g} mm focus"
    )
    light = 100.0 * numbers["array"]["throughput"]
    return (
        f"{words}{what}, {array.pitch_um:g} um apart, gap {array.gap_mm:g} mm, turned by "
        f"{array.rotation_deg:g} deg, which let {light:.3g} % of the light through."
    )


def evaluation_table(report: Report) -> Table:
    """A line for each source, rig, eye and method, with the metrics' first numbers."""
    table = Table(box=box.SIMPLE_HEAD, show_edge=False)
    several = [len({getattr(p, what) for p in report.pairs}) > 1 for what in ("source", "rig")]
    for shown, what in zip(several, ("source", "rig"), strict=True):
        if shown:
            table.add_column(what, overflow="ellipsis", max_width=24)
    for what in ("eye", "method"):
        table.add_column(what, no_wrap=True)
    shown_columns = [c for c in columns_of(report) if c.name in _SHORT]
    for column in shown_columns:
        heading = _SHORT[column.name]
        table.add_column(heading, justify="right", no_wrap=True, min_width=_NUMBER_WIDTH)
    sources = short_names(pair.source for pair in report.pairs)
    rigs = short_names(pair.rig for pair in report.pairs)
    for pair in report.pairs:
        both = (sources[pair.source], rigs[pair.rig])
        names = [name for name, is_shown in zip(both, several, strict=True) if is_shown]
        for eye in pair.eyes:
            for view in eye.views:
                values = flat(view.values)
                numbers = [number_text(values.get(column.name)) for column in shown_columns]
                table.add_row(*names, eye.side, view.method, *numbers)
    return table
