"""How much is lost where a number of the best comes out otherwise: curves, one at a time.

The panel image is computed for what came out (a rig that was measured after it was built).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np

from vrlf.model import Array, Rig, focal_mm
from vrlf.studies.design.score import Judging
from vrlf.studies.design.scorer import NEVER_DB, Scorer

# Loss within which a number serves.
_SERVES_DB: Final = 0.5
_POINTS: Final = 9


@dataclass(frozen=True)
class Curve:
    """Decibels against one key of the rig, all others as they are.

    Attributes
    ----------
    key : str
        As in a rig file.
    at : float
        The best's own.
    values, db : tuple of float
    """

    key: str
    at: float
    values: tuple[float, ...]
    db: tuple[float, ...]

    @property
    def serves(self) -> tuple[float, float]:
        """The stretch about the best's own value on which at most 0.5 dB is lost.

        Ends where the curve is no longer known, too.
        """
        own = float(np.interp(self.at, self.values, self.db))
        return self._until(own, -1), self._until(own, 1)

    @property
    def slope_db(self) -> float:
        """Central difference at the best's own value, dB per unit of the key."""
        index = int(np.argmin(np.abs(np.array(self.values) - self.at)))
        low, high = max(index - 1, 0), min(index + 1, len(self.values) - 1)
        return (self.db[high] - self.db[low]) / (self.values[high] - self.values[low])

    def _until(self, own: float, way: int) -> float:
        pairs = sorted(zip(self.values, self.db, strict=True), key=lambda pair: way * pair[0])
        last, last_db = self.at, own
        for value, db in pairs:
            if way * (value - self.at) <= 0.0:
                continue
            if db < own - _SERVES_DB:
                share = (last_db - own + _SERVES_DB) / (last_db - db)
                return last + share * (value - last)
            last, last_db = value, db
        return last

    def sentence(self) -> str:
        """For a rig file's comments."""
        low, high = self.serves
        return f"{self.key} {self.at:.5g}: at most 0.5 dB is lost from {low:.5g} to {high:.5g}."

    def to_json(self) -> dict[str, Any]:
        """With the stretch that serves and the slope."""
        return {**asdict(self), "serves": self.serves, "slope_db": self.slope_db}


Change = Callable[[Rig, float], Rig]


def curves(rig: Rig, judging: Judging, scorer: Scorer) -> tuple[Curve, ...]:
    """A curve for each number that a maker or a wearer may miss."""
    asked = _asked(rig)
    spans = [np.linspace(-1.0, 1.0, _POINTS) * reach + at for _, at, reach, _ in asked]
    rigs = [
        change(rig, float(v)) for (*_, change), span in zip(asked, spans, strict=True) for v in span
    ]
    found = scorer.scores_db(rigs, judging)
    made = []
    for number, ((key, at, _, _), span) in enumerate(zip(asked, spans, strict=True)):
        db = found[number * _POINTS : (number + 1) * _POINTS]
        made.append(Curve(key, at, tuple(float(v) for v in span), tuple(db)))
    return tuple(made)


def _asked(rig: Rig) -> list[tuple[str, float, float, Change]]:
    """Key, the best's own value, how far to each side, and what changes it."""
    array = rig.array
    asked: list[tuple[str, float, float, Change]] = [
        ("array.pitch_um", array.pitch_um, 0.08 * array.pitch_um, _of_array("pitch_um")),
        ("array.gap_mm", array.gap_mm, 0.08 * array.gap_mm, _of_array("gap_mm")),
    ]
    if array.kind == "microlens":
        focal = focal_mm(array)
        asked.append(("array.focal_mm", focal, 0.08 * focal, _of_array("focal_mm")))
    else:
        hole_um = array.aperture_um
        asked.append(("array.aperture_um", hole_um, 0.3 * hole_um, _of_array("aperture_um")))
    asked += [
        ("array.rotation_deg", array.rotation_deg, 3.0, _of_array("rotation_deg")),
        ("left.pupil_mm", rig.left.pupil_mm, 0.25 * rig.left.pupil_mm, _of_eyes("pupil_mm")),
        ("left.sphere_d", rig.left.sphere_d, 0.75, _of_eyes("sphere_d")),
    ]
    return asked


def _of_array(key: str) -> Change:
    def change(rig: Rig, value: float) -> Rig:
        tables = rig.array.model_dump(mode="json", exclude_none=True) | {key: value}
        if tables["kind"] == "pinhole":
            tables["aperture_um"] = min(tables["aperture_um"], 0.7 * tables["pitch_um"])
        return rig.model_copy(update={"array": Array.model_validate(tables)})

    return change


def _of_eyes(key: str) -> Change:
    """Both eyes by as much as the left one."""

    def change(rig: Rig, value: float) -> Rig:
        moved = value - getattr(rig.left, key)
        eyes = {
            side: eye.model_copy(update={key: getattr(eye, key) + moved})
            for side, eye in (("left", rig.left), ("right", rig.right))
        }
        return rig.model_copy(update=eyes)

    return change


def brightness_curve(
    rig: Rig, ends: tuple[float, float], judging: Judging, scorer: Scorer
) -> Curve | None:
    """Decibels against ``prefilter.brightness``; None where there is nothing to choose."""
    if ends[0] == ends[1]:
        return None
    values = tuple(float(v) for v in np.linspace(ends[0], ends[1], 5))
    rigs = [with_brightness(rig, each) for each in values]
    db = tuple(scorer.scores_db(rigs, judging))
    return Curve("prefilter.brightness", ends[1], values, db)


def brightest_that_serves(curve: Curve, loss_db: float) -> float:
    """The highest brightness that loses at most that against the best of the curve."""
    most = max(curve.db, default=NEVER_DB)
    pairs = zip(curve.values, curve.db, strict=True)
    return max(value for value, db in pairs if db >= most - loss_db)


def with_brightness(rig: Rig, brightness: float) -> Rig:
    """The rig with another brightness, its black level kept below it."""
    given = rig.prefilter
    black = min(given.black_level, 0.9 * brightness)
    changed = given.model_copy(update={"brightness": brightness, "black_level": black})
    return rig.model_copy(update={"prefilter": changed})
