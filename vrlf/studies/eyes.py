"""What an eye makes of a point and of a letter: the numbers and pictures of ``vrlf eye``."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log10
from typing import Any, Final, TypeVar

import numpy as np

from vrlf.content.charts.letters import paint_letter
from vrlf.content.charts.logmar import LETTER_ARCMIN_AT_ZERO, STEPS_PER_UNIT
from vrlf.content.charts.model import BLACK
from vrlf.errors import InputError
from vrlf.model import Rig
from vrlf.optics import psf as spread
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.inspect import residual_matrix_d
from vrlf.optics.polynomial import Float
from vrlf.optics.psf import Cells, PointSpread, Rays
from vrlf.optics.pupil import (
    SPECTACLE_ORDER,
    SeenWavefront,
    rms_um,
    seen_wavefront,
    widest_slope,
    without_order,
)
from vrlf.optics.refraction import SpheroCylinder, sphero_cylinder
from vrlf.optics.viewport import Side, pitch_mm
from vrlf.units import ARCMIN_PER_SLOPE, DEGREES_PER_SLOPE, NM_PER_MM

Item = TypeVar("Item")

COLOURS: Final = ("red", "green", "blue")
# The one Sloan letter that no mirror and no turn leaves as it is.
LETTER: Final = "R"
CYCLES_PER_DEGREE: Final = (0.1, 100.0)
_FREQUENCIES: Final = 121
# Directions from 0 degrees on, over half a turn: the rest is the same by symmetry.
_DIRECTIONS: Final = 8
# Cells a side of a picture of a point; odd, so that one is in the middle.
_SPOT_CELLS: Final = 241
_LETTER_CELLS: Final = 321
# The picture holds the geometric spot with a margin and a few rings of diffraction.
_SPOT_MARGIN: Final = 1.15
_RINGS: Final = 4.0
# A disc of blur hides letters below about four of its half-light widths.
_LETTER_WIDTHS: Final = 4.0


@dataclass(frozen=True)
class EyeReport:
    """One eye's wavefront and what becomes of a point.

    Attributes
    ----------
    seen : SeenWavefront
    residual : SpheroCylinder
        Error left at the pupil, as ``inspect`` says it.
    rms_um, higher_order_rms_um : float
        At the wavelength prescriptions are meant for, without tilt; without sphere and cylinder.
    strehl : tuple of three floats
        For each of the panel's colours.
    half_light_arcmin, geometric_half_light_arcmin : tuple of three floats
        Diameter that holds half of each colour's light, with diffraction and by rays.
    cells : Cells
        The grid of ``geometric`` and ``diffraction``.
    geometric, diffraction : ndarray (n, n, 3)
        The part of each colour's light in each cell; rows y upward, as the wearer sees it.
    spreads : tuple of three PointSpread
    pixel_arcmin : float
        A pixel of the panel, on the axis.
    """

    seen: SeenWavefront
    residual: SpheroCylinder
    rms_um: float
    higher_order_rms_um: float
    strehl: tuple[float, ...]
    half_light_arcmin: tuple[float, ...]
    geometric_half_light_arcmin: tuple[float, ...]
    cells: Cells
    geometric: Float
    diffraction: Float
    spreads: tuple[PointSpread, ...]
    pixel_arcmin: float

    def to_json(self) -> dict[str, Any]:
        """The numbers, by the names that scripts rely on."""
        return {
            "pupil_mm": self.seen.pupil_mm,
            "sphere_d": self.residual.sphere_d,
            "cylinder_d": self.residual.cylinder_d,
            "axis_deg": self.residual.axis_deg,
            "rms_um": self.rms_um,
            "higher_order_rms_um": self.higher_order_rms_um,
            "shift_arcmin": [slope * ARCMIN_PER_SLOPE for slope in self.seen.shift_slope],
            "wavelengths_nm": dict(zip(COLOURS, self.seen.wavelengths_nm, strict=True)),
            "strehl": dict(zip(COLOURS, self.strehl, strict=True)),
            "half_light_arcmin": dict(zip(COLOURS, self.half_light_arcmin, strict=True)),
            "geometric_half_light_arcmin": dict(
                zip(COLOURS, self.geometric_half_light_arcmin, strict=True)
            ),
        }


def eye_report(rig: Rig, side: Side) -> EyeReport:
    """Everything that is said and drawn of one eye.

    Raises
    ------
    InputError
        If its blur is too wide for its diffraction to be computed.
    """
    seen, bench = seen_wavefront(rig, side), bench_of(rig)
    try:
        spreads = tuple(
            spread.fraunhofer(*each, stiles_crawford_per_mm2=seen.stiles_crawford_per_mm2)
            for each in _colours(seen)
        )
    except InputError as error:
        raise InputError(f"{side} eye: {error}") from error
    cells, rays = _spot_cells(seen), _rays(seen)
    half_light = [spread.half_light_slope(each, cells) for each in spreads]
    by_rays = [spread.geometric_half_light_slope(each) for each in rays]
    higher = without_order(seen.reference_um, seen.pupil_mm, SPECTACLE_ORDER)
    return EyeReport(
        seen=seen,
        residual=sphero_cylinder(residual_matrix_d(bench, eye_optics(rig, side))),
        rms_um=rms_um(seen.reference_um, seen.pupil_mm),
        higher_order_rms_um=rms_um(higher, seen.pupil_mm),
        strehl=tuple(spread.strehl_ratio(each) for each in spreads),
        half_light_arcmin=tuple(slope * ARCMIN_PER_SLOPE for slope in half_light),
        geometric_half_light_arcmin=_three([slope * ARCMIN_PER_SLOPE for slope in by_rays]),
        cells=cells,
        geometric=np.stack(
            _three([spread.geometric_shares(each, cells) for each in rays]), axis=-1
        ),
        diffraction=np.stack([spread.cell_shares(each, cells) for each in spreads], axis=-1),
        spreads=spreads,
        pixel_arcmin=pitch_mm(rig) / bench.panel_per_slope_mm * ARCMIN_PER_SLOPE,
    )


def _colours(seen: SeenWavefront) -> list[tuple[Float, float, float]]:
    """Wavefront, pupil and wavelength of each colour."""
    pairs = zip(seen.colours_um, seen.wavelengths_nm, strict=True)
    return [(wavefront_um, seen.pupil_mm, nm) for wavefront_um, nm in pairs]


def _spot_cells(seen: SeenWavefront) -> Cells:
    """A grid that holds the widest of the three colours' spots."""
    widest = max(widest_slope(each, seen.pupil_mm) for each in seen.colours_um)
    ring = max(seen.wavelengths_nm) / NM_PER_MM / seen.pupil_mm
    half_slope = _SPOT_MARGIN * widest + _RINGS * ring
    return Cells(_SPOT_CELLS, 2.0 * half_slope / _SPOT_CELLS)


def _rays(seen: SeenWavefront) -> list[Rays]:
    """Rays of each colour, or of all where the colours do not differ."""
    differ = any(other is not seen.colours_um[0] for other in seen.colours_um)
    wavefronts = seen.colours_um if differ else seen.colours_um[:1]
    rho = seen.stiles_crawford_per_mm2
    return [
        spread.rays_through(each, seen.pupil_mm, stiles_crawford_per_mm2=rho) for each in wavefronts
    ]


def _three(found: list[Item]) -> tuple[Item, ...]:
    """One for each colour."""
    return tuple(found if len(found) > 1 else found * len(COLOURS))


@dataclass(frozen=True)
class Curves:
    """Modulation transfer against cycles per degree; arrays of one shape (K,).

    ``horizontal`` and ``vertical`` are gratings that vary along x and along y.
    """

    cycles_per_degree: Float
    horizontal: Float
    vertical: Float
    mean: Float
    perfect: Float


def modulation_curves(report: EyeReport, colour: int) -> Curves:
    """Modulation transfer of one colour: two directions, the mean over all, and the limit."""
    cycles = np.geomspace(*CYCLES_PER_DEGREE, _FREQUENCIES)
    angle = np.arange(_DIRECTIONS) * np.pi / _DIRECTIONS
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    vectors = cycles[None, :, None] * DEGREES_PER_SLOPE * direction[:, None, :]
    found = spread.modulation(report.spreads[colour], vectors.reshape(-1, 2))
    turned = found.reshape(_DIRECTIONS, _FREQUENCIES)
    seen = report.seen
    return Curves(
        cycles_per_degree=cycles,
        horizontal=turned[0],
        vertical=turned[_DIRECTIONS // 2],
        mean=turned.mean(axis=0),
        perfect=spread.perfect_modulation(
            cycles * DEGREES_PER_SLOPE, seen.pupil_mm, seen.wavelengths_nm[colour]
        ),
    )


@dataclass(frozen=True)
class SeenLetter:
    """A black letter on white as the eye sees it.

    Attributes
    ----------
    light : ndarray (n, n, 3)
        Linear; rows y upward.
    height_arcmin, half_arcmin : float
        The letter's height, half the picture's side.
    """

    light: Float
    height_arcmin: float
    half_arcmin: float

    @property
    def logmar(self) -> float:
        """Its size on an acuity chart."""
        return log10(self.height_arcmin / LETTER_ARCMIN_AT_ZERO)


def letter_height_arcmin(report: EyeReport) -> float:
    """The line of an acuity chart, from logMAR 0 up, at the limit of what this blur leaves."""
    wanted = _LETTER_WIDTHS * max(report.half_light_arcmin) / LETTER_ARCMIN_AT_ZERO
    steps = ceil(STEPS_PER_UNIT * log10(max(1.0, wanted)))
    return float(LETTER_ARCMIN_AT_ZERO * 10.0 ** (steps / STEPS_PER_UNIT))


def seen_letter(report: EyeReport, height_arcmin: float) -> SeenLetter:
    """A letter blurred by each colour's diffraction point spread.

    The panel's pixels are not in it. What diffraction throws beyond the picture is left out,
    so that white stays white.
    """
    height_slope = height_arcmin / ARCMIN_PER_SLOPE
    side_slope = 1.25 * height_slope + 2.0 * report.cells.half_slope
    cells = Cells(_LETTER_CELLS, side_slope / _LETTER_CELLS)
    sharp = np.ones((_LETTER_CELLS, _LETTER_CELLS, 3), np.float32)
    height = height_slope / cells.step_slope
    corner = (_LETTER_CELLS - height) / 2.0
    paint_letter(sharp, LETTER, left_px=corner, top_px=corner, height_px=height, colour=BLACK)
    ink = 1.0 - sharp[::-1, :, 0].astype(np.float64)
    blurred = [_convolved(ink, spread.cell_shares(each, cells)) for each in report.spreads]
    light = np.clip(1.0 - np.stack(blurred, axis=-1), 0.0, 1.0)
    return SeenLetter(light, height_arcmin, cells.half_slope * ARCMIN_PER_SLOPE)


def _convolved(ink: Float, shares: Float) -> Float:
    """``ink`` with each point spread out as ``shares``, whose middle cell is its origin."""
    count = len(ink)
    size = (2 * count, 2 * count)
    product = np.fft.rfft2(ink, size) * np.fft.rfft2(shares / shares.sum(), size)
    middle = slice(count // 2, count // 2 + count)
    return np.asarray(np.fft.irfft2(product, size)[middle, middle])
