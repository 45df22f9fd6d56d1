"""What is searched: points of a unit cube, and the arrays that they stand for.

Focal lengths are not searched by themselves. Lenslets that image the panel onto the plane where
the eye focuses have g / f = 1 + g / (s_a - d_f), the matched-focus rule; what is searched is by
how much g / f is to differ from that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from vrlf.errors import InputError
from vrlf.model import Array, Eye, Rig, focal_mm
from vrlf.model.catalogue import array_on_sale, spacer_on_sale
from vrlf.model.searching import SearchLimits
from vrlf.optics.bench import bench_of
from vrlf.optics.eye import eye_optics
from vrlf.optics.limits import signed_focus_mm
from vrlf.optics.viewport import SIDES

# By how much g / f may differ from the matched one, and how large it may be at all.
_MOST_OFF: Final = 0.6
_LEAST_BEND: Final = 0.05
_MOST_BEND: Final = 6.0
_LEAST_APART: Final = 1e-6

Point = tuple[float, ...]


@dataclass(frozen=True)
class Axis:
    """One thing that is searched: a range, or a choice of so many."""

    name: str
    low: float
    high: float
    choices: int = 0

    def value(self, place: float) -> float:
        """What a place within 0 and 1 stands for; of a choice, its number."""
        if self.choices:
            return float(min(int(place * self.choices), self.choices - 1))
        return self.low + place * (self.high - self.low)

    def place(self, value: float) -> float:
        """The reverse, kept within 0 and 1."""
        if self.choices:
            return (value + 0.5) / self.choices
        span = self.high - self.low
        return float(np.clip((value - self.low) / span, 0.0, 1.0)) if span > 0.0 else 0.5

    @property
    def is_fixed(self) -> bool:
        """Whether there is nothing to search."""
        return self.choices == 1 or (not self.choices and self.low == self.high)


class Space:
    """The rig's own panel, headset and eyes, and the arrays that limits allow before them."""

    def __init__(self, rig: Rig, kind: str, limits: SearchLimits) -> None:
        if kind == "pinhole" and limits.arrays:
            raise InputError(
                "--arrays: found lenslets beside --kind pinhole, wanted one of the two"
            )
        self.rig, self.kind, self.limits = rig, kind, limits
        self._arrays = [array_on_sale(name) for name in limits.arrays]
        self._spacers = [spacer_on_sale(text) for text in limits.spacers]
        self.lattice = rig.array.lattice if rig.array.kind != "none" else "square"
        self._index = rig.array.gap_index if rig.array.kind != "none" else 1.0
        self._check_gaps()
        self.axes: tuple[Axis, ...] = tuple(self._axes())

    def _check_gaps(self) -> None:
        most = max([each.thickness_mm for each in self._spacers] or [self.limits.gap_mm[1]])
        if most >= self.rig.headset.lens_to_panel_mm:
            raise InputError(
                f"gap_mm: found {most:g}, wanted less than headset.lens_to_panel_mm of "
                f"{self.rig.headset.lens_to_panel_mm:g}"
            )

    def _axes(self) -> list[Axis]:
        given = self.limits
        axes = []
        if self._arrays:
            axes.append(Axis("part", 0.0, 1.0, len(self._arrays)))
        else:
            axes.append(Axis("pitch_um", *given.pitch_um))
        if self._spacers:
            axes.append(Axis("spacer", 0.0, 1.0, len(self._spacers)))
        else:
            axes.append(Axis("gap_mm", *given.gap_mm))
        if self.kind == "pinhole":
            axes.append(Axis("aperture_um", *given.aperture_um))
        elif not self._arrays:
            axes.append(Axis("off_focus", -_MOST_OFF, _MOST_OFF))
        axes.append(Axis("rotation_deg", *(given.rotation_deg or self._turns())))
        if len(given.barriers) > 1:
            axes.append(Axis("barriers", 0.0, 1.0, len(given.barriers)))
        return axes

    def _turns(self) -> tuple[float, float]:
        """Turns that differ: a mirrored lattice before a mirrored eye shows a mirrored picture."""
        period = 90.0 if self.lattice == "square" else 60.0
        mirrored = all(_is_mirrored(eye) for eye in (self.rig.left, self.rig.right))
        return (0.0, period / 2.0) if mirrored else (0.0, period)

    def index_of(self, name: str) -> int | None:
        """Where an axis stands."""
        names = [axis.name for axis in self.axes]
        return names.index(name) if name in names else None

    def values(self, point: Point) -> dict[str, float]:
        """What a point's places stand for."""
        pairs = zip(self.axes, point, strict=True)
        return {axis.name: axis.value(place) for axis, place in pairs}

    def point(self, values: dict[str, float]) -> Point:
        """The reverse."""
        return tuple(axis.place(values[axis.name]) for axis in self.axes)

    def array(self, point: Point) -> Array | None:
        """The array at a point; None where the limits allow none there."""
        values, given = self.values(point), self.limits
        gap_mm, index = self._gap(values)
        part = self._arrays[int(values["part"])] if "part" in values else None
        pitch_um = values["pitch_um"] if part is None else part.pitch_um
        focal = 0.0
        if self.kind == "microlens":
            focal = part.focal_mm if part else self._focal(gap_mm, index, values["off_focus"])
            if given.focal_mm and not given.focal_mm[0] <= focal <= given.focal_mm[1]:
                return None
        aperture_um = min(values.get("aperture_um", 75.0), _widest_hole(pitch_um, self.lattice))
        return Array.model_validate(
            {
                "kind": self.kind,
                "pitch_um": _rounded(pitch_um, 0.1),
                "lattice": self.lattice if part is None else part.lattice,
                "gap_mm": _rounded(gap_mm, 0.001),
                "gap_index": index,
                "focal_mm": _rounded(focal, 0.0001),
                "aperture_um": _rounded(aperture_um, 0.1),
                "aperture_shape": self.rig.array.aperture_shape,
                "offset_um": self.rig.array.offset_um,
                "rotation_deg": _rounded(values["rotation_deg"], 0.01),
                "barriers": given.barriers[int(values.get("barriers", 0.0))],
            }
        )

    def rig_at(self, point: Point) -> Rig | None:
        """The rig with that array."""
        array = self.array(point)
        return None if array is None else self.rig.model_copy(update={"array": array})

    def part_at(self, point: Point) -> str:
        """What on sale an array is made of."""
        values = self.values(point)
        parts = []
        if "part" in values:
            parts.append(self._arrays[int(values["part"])].title)
        if "spacer" in values:
            parts.append(self._spacers[int(values["spacer"])].title)
        return "; ".join(parts)

    def _gap(self, values: dict[str, float]) -> tuple[float, float]:
        if "spacer" in values:
            spacer = self._spacers[int(values["spacer"])]
            return spacer.thickness_mm, spacer.index
        return values["gap_mm"], self._index

    def gaps_mm(self) -> list[float]:
        """Thicknesses on sale; empty where any will do."""
        return [each.thickness_mm for each in self._spacers]

    def pitches_um(self) -> list[float]:
        """Pitches on sale; empty where any will do."""
        return [each.pitch_um for each in self._arrays]

    @property
    def widest_um(self) -> float:
        """No cell is wider."""
        return max(self.pitches_um() or [self.limits.pitch_um[1]])

    def _focal(self, gap_mm: float, index: float, off: float) -> float:
        bend = matched_bend(self.rig, gap_mm, index) + off
        return gap_mm / index / float(np.clip(bend, _LEAST_BEND, _MOST_BEND))

    def place_of(self, array: Array) -> Point | None:
        """Where an array of the same kind lies, as near as the limits let it."""
        if array.kind != self.kind or array.varies or self._arrays or self._spacers:
            return None
        reduced = array.gap_mm / array.gap_index
        values = {
            "pitch_um": array.pitch_um,
            "gap_mm": array.gap_mm,
            "aperture_um": array.aperture_um,
            "rotation_deg": array.rotation_deg,
            "barriers": 0.0,
        }
        if self.kind == "microlens":
            matched = matched_bend(self.rig, array.gap_mm, array.gap_index)
            values["off_focus"] = reduced / focal_mm(array) - matched
        return self.point(values)


def matched_bend(rig: Rig, gap_mm: float, index: float) -> float:
    """g / f of lenslets that image the panel onto the eyes' plane of focus: 1 + g / (s_a - d_f).

    The mean over both eyes.
    """
    placed = Array(kind="pinhole", pitch_um=100.0, gap_mm=gap_mm, gap_index=index)
    bench = bench_of(rig.model_copy(update={"array": placed}))
    bends = []
    for side in SIDES:
        away = bench.lens_to_array_mm - signed_focus_mm(bench, eye_optics(rig, side))
        away = away if abs(away) > _LEAST_APART else _LEAST_APART
        bends.append(1.0 + bench.reduced_gap_mm / away)
    return float(np.clip(np.mean(bends), -_MOST_BEND, _MOST_BEND))


def _is_mirrored(eye: Eye) -> bool:
    """Whether left and right of an eye are alike."""
    upright = eye.cylinder_d == 0.0 or eye.axis_deg % 90.0 == 0.0
    centred = eye.pupil_offset_mm[0] == 0.0 and eye.prism_pd[0] == 0.0
    return upright and centred and eye.zernike is None


def _widest_hole(pitch_um: float, lattice: str) -> float:
    return pitch_um * (0.7 if lattice == "hexagonal" else 0.95)


def _rounded(value: float, step: float) -> float:
    """To what can be made and is pleasant to read."""
    return round(round(value / step) * step, 6)


def clipped(point: Sequence[float]) -> Point:
    """Places kept within 0 and 1."""
    return tuple(float(min(max(each, 0.0), 1.0)) for each in point)
