"""What a search has found: the best ten, the numbers, the best as a rig file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from rich import box
from rich.table import Table

from vrlf import __version__
from vrlf.model import Array, Rig, focal_mm
from vrlf.model.saving import rig_text
from vrlf.studies.design.search import Stage
from vrlf.studies.design.sensitivity import Curve


@dataclass(frozen=True)
class Checked:
    """What the whole chain made of a picture that was not searched with; the worse eye's."""

    psnr_db: float | None
    ssim: float | None


@dataclass(frozen=True)
class Ranked:
    """One of the best.

    Attributes
    ----------
    rig : Rig
    part : str
        What on sale it is made of; empty where nothing is.
    patch_db : float
        On the patch that was searched with.
    fine_db : float
        On a larger one, by other targets and more rays; these rank.
    checked : Checked or None
    """

    rig: Rig
    part: str
    patch_db: float
    fine_db: float
    checked: Checked | None = None

    def to_json(self) -> dict[str, Any]:
        """Without the eyes."""
        return {
            "array": array_json(self.rig.array),
            "brightness": self.rig.prefilter.brightness,
            "part": self.part or None,
            "patch_db": self.patch_db,
            "fine_db": self.fine_db,
            "checked": None if self.checked is None else asdict(self.checked),
        }


@dataclass(frozen=True)
class Maps:
    """Best decibels of the grid for each pitch and gap; None where the limits allow nothing."""

    pitches_um: tuple[float, ...]
    gaps_mm: tuple[float, ...]
    best_db: tuple[tuple[float | None, ...], ...]


@dataclass(frozen=True)
class DesignReport:
    """All of a search."""

    method: str
    seed: int
    robust: str
    picture: str | None
    stages: tuple[Stage, ...]
    best: tuple[Ranked, ...]
    before: Mapping[str, Ranked]
    maps: Maps
    curves: tuple[Curve, ...]
    brightness: Curve | None
    rank_correlation: float | None
    wall_s: float
    cpu_s: float

    @property
    def candidates(self) -> int:
        """How many were scored in all."""
        return sum(each.candidates for each in self.stages)

    def to_json(self) -> dict[str, Any]:
        """For ``vrlf design --json``."""
        return {
            "vrlf": __version__,
            "method": self.method,
            "seed": self.seed,
            "robust": self.robust,
            "picture": self.picture,
            "candidates": self.candidates,
            "wall_s": self.wall_s,
            "cpu_s": self.cpu_s,
            "stages": [asdict(each) for each in self.stages],
            "best": [each.to_json() for each in self.best],
            "before": {name: each.to_json() for name, each in self.before.items()},
            "map": asdict(self.maps),
            "sensitivity": [each.to_json() for each in self.curves],
            "brightness": None if self.brightness is None else self.brightness.to_json(),
            "rank_correlation": self.rank_correlation,
        }


def array_json(array: Array) -> dict[str, Any]:
    """What of an array the search chose."""
    if array.kind == "none":
        return {"kind": "none"}
    told: dict[str, Any] = {
        "kind": array.kind,
        "pitch_um": array.pitch_um,
        "lattice": array.lattice,
        "gap_mm": array.gap_mm,
        "gap_index": array.gap_index,
        "rotation_deg": array.rotation_deg,
        "barriers": array.barriers,
    }
    if array.kind == "microlens":
        return told | {"focal_mm": focal_mm(array)}
    return told | {"aperture_um": array.aperture_um, "aperture_shape": array.aperture_shape}


def best_text(report: DesignReport, source: str) -> str:
    """The best as a whole rig file, with lines on how it was found."""
    best = report.best[0]
    lines = [
        f"Found by vrlf {__version__}: vrlf design -r {source} --seed {report.seed}, for the "
        f"method {report.method}.",
        f"{report.candidates} candidates; {best.fine_db:.1f} dB on dead leaves"
        + _compared(report, "fine_db"),
    ]
    if best.checked is not None and best.checked.psnr_db is not None:
        lines.append(
            f"{best.checked.psnr_db:.1f} dB on {report.picture}, which was not searched with"
            + _compared(report, "checked")
        )
    if report.robust != "none":
        lines.append(f"Robust: the {report.robust} over cases that are a little off.")
    if best.part:
        lines.append(f"On sale: {best.part}.")
    lines += [each.sentence() for each in report.curves]
    comment = "".join(f"# {' '.join(line.split())}\n" for line in lines)
    return f"{comment}\nschema = 1\n\n{rig_text(best.rig)}"


def _compared(report: DesignReport, what: str) -> str:
    told = []
    for name, each in report.before.items():
        if what == "fine_db":
            told.append(f"{name}: {each.fine_db:.1f}")
        elif each.checked is not None and each.checked.psnr_db is not None:
            told.append(f"{name}: {each.checked.psnr_db:.1f}")
    return f" ({', '.join(told)})." if told else "."


def design_table(report: DesignReport) -> Table:
    """The best ten, and what they are to be better than."""
    lenslets = report.best[0].rig.array.kind == "microlens"
    caption = (
        f"PSNR in dB, linear light, the worse eye; {report.method}. 'patch' was searched with, "
        "'fine' ranks. "
        + (f"'picture': the whole chain on {report.picture}. " if report.picture else "")
        + f"{report.candidates} candidates, {report.wall_s:.0f} s ({report.cpu_s:.0f} s of CPU)."
    )
    table = Table(caption=caption, box=box.SIMPLE_HEAD, show_edge=False)
    for column in ("", "pitch um", "gap mm", "focal mm" if lenslets else "hole um", "turn deg"):
        table.add_column(column, justify="right", no_wrap=True)
    for column in ("walls", "patch", "fine", "picture"):
        table.add_column(column, justify="right", no_wrap=True)
    if any(each.part for each in report.best):
        table.add_column("on sale")
    for number, each in enumerate(report.best, 1):
        table.add_row(str(number), *_cells(each))
    for name, each in report.before.items():
        table.add_row(name, *_cells(each), style="dim")
    return table


def _cells(each: Ranked) -> list[str]:
    array, picture = each.rig.array, "-"
    if each.checked is not None:
        psnr_db = each.checked.psnr_db
        picture = "equal" if psnr_db is None else f"{psnr_db:.1f}"
    numbers = [f"{each.patch_db:.1f}", f"{each.fine_db:.1f}", picture]
    part = [each.part] if each.part else []
    if array.kind == "none":
        return [*("-" for _ in range(5)), *numbers, *part]
    size = f"{focal_mm(array):.3f}" if array.kind == "microlens" else f"{array.aperture_um:.1f}"
    turn = f"{array.rotation_deg:.1f}"
    return [
        *(f"{array.pitch_um:.1f}", f"{array.gap_mm:.3f}", size, turn, array.barriers),
        *numbers,
        *part,
    ]
