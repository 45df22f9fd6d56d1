"""The cases that a tolerant panel image serves: rigs that are each a little off.

Where all is off at once the whole picture moves, too: an array put off by delta moves it by

    m (d alpha / dc - R d u / dc) delta,    d beta / dc = -1 / g, as in the design's inverse,

and a pupil that stands o off its place by m R o. Nobody sees that the whole picture lies a few
pixels elsewhere, so no sharpness is spent on it: each case's eye is given the prism that moves it
back (signs as T's: a prism p adds p to T).

A turned array is not among the cases. Turned by theta about the panel's middle it lies theta r off
at the distance r from there, and moves the picture by another amount at each place: no whole
picture's shift, and no one row for a phase, which all tables of the solver rest on. An ``array_um``
of theta r (0.2 degrees, 10 mm: 35 um) serves what it does to a pixel's own lenslet.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vrlf.model import Eye, PupilPlace, Rig, Tolerance, Zernike
from vrlf.optics import sequence
from vrlf.optics.bench import Bench, bench_of
from vrlf.optics.eye import eye_optics, viewer
from vrlf.optics.polynomial import Float
from vrlf.optics.viewport import SIDES, Side
from vrlf.optics.wavefront import zernike_of_power_vector_um
from vrlf.units import MM_PER_M, SLOPE_PER_PRISM_DIOPTRE, UM_PER_MM

# Root of x^7 = x + 1: its powers step evenly through six dimensions (Roberts 2018, "The
# unreasonable effectiveness of quasirandom sequences").
_SIX_DIMENSIONS = 1.1127756842787055


@dataclass(frozen=True)
class Case:
    """A rig that is a little off, and how much it counts; the weights of all sum to 1."""

    rig: Rig
    weight: float


@dataclass(frozen=True)
class _Off:
    """What is off in one case; of the pupil None is its own size."""

    array_mm: Float
    pupil_shift_mm: Float
    pupil_mm: float | None
    focus_d: float
    weight: float


def cases_of(rig: Rig, *, first: int = 1) -> list[Case]:
    """The cases that a rig's tolerance asks for; the rig itself where it asks for none.

    Parameters
    ----------
    first : int
        Where in the endless sequence of cases to begin: another number gives others, as evenly
        spread.
    """
    given = rig.tolerance
    if given is None:
        return [Case(rig, 1.0)]
    places = given.pupils or (None,)
    count = max(given.draws, len(places))
    drawn = [
        _drawn(given, places[index % len(places)], _spread(first + index)) for index in range(count)
    ]
    total = sum(each.weight for each in drawn)
    return [Case(_off_by(rig, each), each.weight / total) for each in drawn]


def _spread(index: int) -> Float:
    """The point of that number in the unit cube of six dimensions."""
    steps = 1.0 / _SIX_DIMENSIONS ** np.arange(1, 7)
    return np.asarray((0.5 + index * steps) % 1.0)


def _drawn(given: Tolerance, place: PupilPlace | None, at: Float) -> _Off:
    size = given.pupil_mm
    if place is not None:
        shift, pupil_mm = np.array(place.offset_mm), place.pupil_mm
    else:
        shift = given.pupil_shift_mm * sequence.to_disc(at[2:4])
        pupil_mm = None if size is None else float(size[0] + at[4] * (size[1] - size[0]))
    return _Off(
        array_mm=given.array_um / UM_PER_MM * (2.0 * at[:2] - 1.0),
        pupil_shift_mm=shift,
        pupil_mm=pupil_mm,
        focus_d=given.focus_d * float(2.0 * at[5] - 1.0),
        weight=1.0 if place is None else place.weight,
    )


def _off_by(rig: Rig, off: _Off) -> Rig:
    moved_um = tuple(
        float(before + UM_PER_MM * step)
        for before, step in zip(rig.array.offset_um, off.array_mm, strict=True)
    )
    changes: dict[str, Any] = {side: _eye_off_by(rig, side, off) for side in SIDES}
    changes["array"] = rig.array.model_copy(update={"offset_um": moved_um})
    return rig.model_copy(update={**changes, "tolerance": None})


def _eye_off_by(rig: Rig, side: Side, off: _Off) -> Eye:
    """One eye of a case: what it accommodates by is fixed, its focus and pupil are off."""
    eye, optics, bench = viewer(rig, side), eye_optics(rig, side), bench_of(rig)
    moved = moves_mm(bench, optics.matrix_d, off.array_mm, off.pupil_shift_mm)
    prism = moved / bench.panel_per_slope_mm / SLOPE_PER_PRISM_DIOPTRE
    pupil_mm = eye.pupil_mm if off.pupil_mm is None else off.pupil_mm
    return eye.model_copy(
        update={
            "pupil_mm": pupil_mm,
            "pupil_offset_mm": _pair(np.array(eye.pupil_offset_mm) + off.pupil_shift_mm),
            "prism_pd": _pair(np.array(eye.prism_pd) + prism),
            "accommodation": "relaxed",
            "luminance_cd_m2": None,
            "zernike": _focused(eye, pupil_mm, off.focus_d - optics.accommodation_d),
        }
    )


def moves_mm(bench: Bench, matrix_d: Float, array_mm: Float, pupil_shift_mm: Float) -> Float:
    """How far the picture moves when array and pupil do; ndarray (2,), panel frame's axes."""
    power_per_mm = np.asarray(matrix_d) / MM_PER_M
    moved = bench.panel_per_slope_mm * power_per_mm @ pupil_shift_mm
    if bench.has_array:
        slope = -1.0 / bench.reduced_gap_mm
        height = 1.0 - bench.lens_to_array_mm * slope
        outside = slope + bench.lens_power_per_mm * height
        in_pupil = height - bench.relief_mm * outside
        by_array = outside * np.eye(2) - in_pupil * power_per_mm
        moved = moved + bench.panel_per_slope_mm * by_array @ array_mm
    return np.asarray(moved)


def _focused(eye: Eye, pupil_mm: float, added_d: float) -> Zernike | None:
    """The eye's wavefront with ``added_d`` of mean refraction more."""
    if added_d == 0.0:
        return eye.zernike
    diameter_mm = pupil_mm if eye.zernike is None else eye.zernike.diameter_mm
    terms = {} if eye.zernike is None else dict(eye.zernike.terms)
    for term, value in zernike_of_power_vector_um(added_d, 0.0, 0.0, diameter_mm).items():
        terms[term] = terms.get(term, 0.0) + value
    named = {f"{n},{m}": value for (n, m), value in terms.items()}
    return Zernike(diameter_mm=diameter_mm, coefficients_um=named, extrapolate=True)


def _pair(values: Float) -> tuple[float, float]:
    return float(values[0]), float(values[1])
