"""Rig and prescription in the clinic's steps. Each result is a rig that passed every check."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from vrlf.model import Eye, Rig, parse_prescription, rig_from_tables
from vrlf.model.eye import CYLINDER_LIMIT_D, SPHERE_LIMIT_D
from vrlf.model.overrides import merged

Side = Literal["left", "right"]
BOTH: tuple[Side, Side] = ("left", "right")


@dataclass(frozen=True)
class Step:
    """How a quantity of an eye is stepped.

    Attributes
    ----------
    coarse, fine : float
        In the quantity's own unit.
    least, most : float
        Where stepping ends; an axis goes round instead.
    """

    coarse: float
    fine: float
    least: float
    most: float

    def moved(self, value: float, steps: float, *, fine: bool) -> float:
        """The value some steps on, without the dust of binary fractions."""
        size = self.fine if fine else self.coarse
        return min(max(round(value + steps * size, 6), self.least), self.most) + 0.0


STEPS: Mapping[str, Step] = {
    "sphere": Step(0.25, 0.05, -SPHERE_LIMIT_D, SPHERE_LIMIT_D),
    "cylinder": Step(0.25, 0.05, -CYLINDER_LIMIT_D, CYLINDER_LIMIT_D),
    "axis": Step(5.0, 1.0, -1e9, 1e9),
    "pupil": Step(0.5, 0.1, 0.5, 12.0),
    "prism_x": Step(0.5, 0.1, -100.0, 100.0),
    "prism_y": Step(0.5, 0.1, -100.0, 100.0),
    "brightness": Step(0.05, 0.01, 0.01, 1.0),
}
HALF_TURN_DEG = 180.0


def altered(rig: Rig, change: Mapping[str, Any]) -> Rig:
    """The rig with some keys changed.

    Raises
    ------
    RigError
        If that makes no rig.
    """
    tables = rig.model_dump(by_alias=True, exclude_none=True)
    return rig_from_tables(merged(tables, change), source="rig")


def with_eye(rig: Rig, side: Side, eye: Eye) -> Rig:
    """The rig with another eye, taken whole."""
    return rig.model_copy(update={side: eye})


def stepped_eye(rig: Rig, sides: tuple[Side, ...], what: str, steps: float, *, fine: bool) -> Rig:
    """Sphere, cylinder, axis, pupil or prism of some eyes, some steps on."""
    change: dict[str, Any] = {
        side: _eye_change(getattr(rig, side), what, steps, fine) for side in sides
    }
    return altered(rig, change)


def _eye_change(eye: Eye, what: str, steps: float, fine: bool) -> dict[str, Any]:
    step = STEPS[what]
    match what:
        case "sphere":
            return {"sphere_d": step.moved(eye.sphere_d, steps, fine=fine)}
        case "cylinder":
            return {"cylinder_d": step.moved(eye.cylinder_d, steps, fine=fine)}
        case "axis":
            return {"axis_deg": step.moved(eye.axis_deg, steps, fine=fine) % HALF_TURN_DEG}
        case "pupil":
            return {"pupil_mm": step.moved(eye.pupil_mm, steps, fine=fine)}
        case _:
            axis = 0 if what == "prism_x" else 1
            prism = list(eye.prism_pd)
            prism[axis] = step.moved(prism[axis], steps, fine=fine)
            return {"prism_pd": prism}


def prescribed(rig: Rig, sides: tuple[Side, ...], text: str) -> Rig:
    """The rig with a prescription as it is written on paper.

    Raises
    ------
    InputError
        If it reads as none.
    """
    sphere_d, cylinder_d, axis_deg = parse_prescription(text)
    eye = {"sphere_d": sphere_d, "cylinder_d": cylinder_d, "axis_deg": axis_deg}
    return altered(rig, dict.fromkeys(sides, eye))


def written(eye: Eye) -> str:
    """A prescription as it is written on paper, so that ``prescribed`` reads the same."""
    sphere = "plano" if eye.sphere_d == 0.0 else _signed(eye.sphere_d)
    if eye.cylinder_d == 0.0:
        return sphere
    return f"{sphere} / {_signed(eye.cylinder_d)} x {eye.axis_deg:g}"


def _signed(value: float) -> str:
    """With at least two decimals, more where it has more."""
    text = f"{value:+.6f}".rstrip("0")
    whole, fraction = text.split(".")
    return f"{whole}.{fraction.ljust(2, '0')}"


def brightened(rig: Rig, steps: float, *, fine: bool) -> Rig:
    """Brightness some steps on, never down to the black level."""
    given = rig.prefilter
    value = STEPS["brightness"].moved(given.brightness, steps, fine=fine)
    if value <= given.black_level:
        return rig
    return altered(rig, {"prefilter": {"brightness": value}})


def cycled(rig: Rig, table: str, key: str, choices: tuple[str, ...]) -> Rig:
    """The next of some choices that makes a rig; the rig itself if none does."""
    now = choices.index(getattr(getattr(rig, table), key))
    failure: Exception | None = None
    for further in range(1, len(choices)):
        try:
            return altered(rig, {table: {key: choices[(now + further) % len(choices)]}})
        except Exception as error:
            failure = failure or error
    if failure is not None:
        raise failure
    return rig


# Table and key of what alignment moves, which of two numbers where there are two, and how far.
NUDGES: Mapping[str, tuple[str, str, int | None, Step]] = {
    "align_x": ("array", "offset_um", 0, Step(10.0, 1.0, -1e6, 1e6)),
    "align_y": ("array", "offset_um", 1, Step(10.0, 1.0, -1e6, 1e6)),
    "align_turn": ("array", "rotation_deg", None, Step(0.1, 0.01, -360.0, 360.0)),
    "align_scale": ("array", "pitch_um", None, Step(0.1, 0.01, 1.0, 1e5)),
    "align_pixel": ("panel", "pixel_pitch_um", None, Step(0.1, 0.01, 0.5, 1e4)),
    "align_separation": ("headset", "lens_separation_mm", None, Step(0.5, 0.1, 0.0, 1000.0)),
    "align_height": ("headset", "lens_height_mm", None, Step(0.5, 0.1, -1000.0, 1000.0)),
}


def nudged(rig: Rig, what: str, steps: float, *, fine: bool) -> Rig:
    """The rig with panel, array or lenses some steps on from where they were thought to be."""
    table, key, part, step = NUDGES[what]
    value = getattr(getattr(rig, table), key)
    if part is None:
        return altered(rig, {table: {key: step.moved(value, steps, fine=fine)}})
    both = list(value)
    both[part] = step.moved(both[part], steps, fine=fine)
    return altered(rig, {table: {key: both}})


def alignment_words(rig: Rig) -> str:
    """All that alignment moves, in one line."""
    array, headset = rig.array, rig.headset
    x, y = array.offset_um
    return (
        f"array at {x:g}, {y:g} um, turned {array.rotation_deg:g} deg, "
        f"pitch {array.pitch_um:g} um; "
        f"pixels {rig.panel.pixel_pitch_um:g} um; lenses {headset.lens_separation_mm:g} mm apart, "
        f"{headset.lens_height_mm:g} mm up"
    )
