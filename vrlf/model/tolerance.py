"""What a panel image is to put up with: a wandering pupil, a spread of focus, an array put off."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, Field, ValidationInfo, field_validator

from vrlf.model.fields import GIVEN, FromList, above, between, refusal

_Shift = Annotated[float, between(-10.0, 10.0)]
_Pupil = Annotated[float, above(0.0, 12.0)]


class PupilPlace(BaseModel):
    """One place and size of the pupil, and how much it counts.

    Attributes
    ----------
    offset_mm : (float, float)
        From where the eye's own table puts it, right and up.
    pupil_mm : float or None
        None is the eye's own.
    weight : float
        Against that of the other places.
    """

    model_config = GIVEN

    offset_mm: Annotated[tuple[_Shift, _Shift], FromList] = (0.0, 0.0)
    pupil_mm: _Pupil | None = None
    weight: Annotated[float, above(0.0, 1000.0)] = 1.0


class Tolerance(BaseModel):
    """What the optimal prefilter is to serve at once.

    Attributes
    ----------
    array_um : float
        The array lies up to this much off, along each of the panel's axes, either way.
    pupil_shift_mm : float
        The pupil wanders within this radius.
    pupil_mm : (float, float) or None
        It opens from the first to the second; None is the eye's own.
    focus_d : float
        The eye focuses up to this much nearer or farther than it should.
    pupils : list of PupilPlace or None
        In place of ``pupil_shift_mm`` and ``pupil_mm``: the places themselves.
    draws : int
        How many cases are served, evenly spread over all of this; at least one for each place.
    """

    model_config = GIVEN

    array_um: Annotated[float, between(0.0, 1000.0)] = 0.0
    pupil_shift_mm: Annotated[float, between(0.0, 10.0)] = 0.0
    pupil_mm: Annotated[tuple[_Pupil, _Pupil], FromList] | None = None
    focus_d: Annotated[float, between(0.0, 5.0)] = 0.0
    pupils: Annotated[tuple[PupilPlace, ...], FromList] | None = None
    draws: Annotated[int, between(2, 64)] = Field(default=32)

    @field_validator("pupil_mm", mode="after")
    @classmethod
    def _from_small_to_large(
        cls, pupil_mm: tuple[float, float] | None
    ) -> tuple[float, float] | None:
        if pupil_mm is not None and pupil_mm[0] > pupil_mm[1]:
            raise refusal("the smaller one first")
        return pupil_mm

    @field_validator("pupils", mode="after")
    @classmethod
    def _places_or_spread(
        cls, pupils: tuple[PupilPlace, ...] | None, info: ValidationInfo
    ) -> tuple[PupilPlace, ...] | None:
        if pupils is None:
            return None
        if not 1 <= len(pupils) <= 64:
            raise refusal("1 to 64 places", found=f"{len(pupils)} of them")
        if info.data.get("pupil_shift_mm") or info.data.get("pupil_mm") is not None:
            raise refusal("one of the two", found="them beside pupil_shift_mm or pupil_mm")
        return pupils
