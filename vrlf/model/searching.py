"""Within which limits an array is searched for: options of ``vrlf design``, or a small file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ValidationError, field_validator

from vrlf.errors import RigError
from vrlf.model.fields import GIVEN, FromList, between, refusal
from vrlf.model.toml_file import read_tables
from vrlf.model.wording import shown

Barriers = Literal["none", "perpendicular", "converging"]
_Pitch = Annotated[float, between(20.0, 5000.0)]
_Length = Annotated[float, between(0.05, 100.0)]
_Hole = Annotated[float, between(5.0, 5000.0)]
_Angle = Annotated[float, between(-90.0, 90.0)]
_Share = Annotated[float, between(0.05, 1.0)]


class SearchLimits(BaseModel):
    """What may be chosen.

    Attributes
    ----------
    pitch_um, gap_mm, aperture_um : (float, float)
        From, to.
    focal_mm, rotation_deg : (float, float) or None
        None: whatever serves; all turns that differ.
    brightness : (float, float)
        The brightest within 0.2 dB of the best is taken.
    barriers : tuple of str
        Which may stand.
    arrays : tuple of str
        Names of the catalogue's arrays, in place of pitch and focal length.
    spacers : tuple of str
        Names of the catalogue's spacers, or millimetres of air, in place of ``gap_mm``.
    """

    model_config = GIVEN

    pitch_um: Annotated[tuple[_Pitch, _Pitch], FromList] = (300.0, 1000.0)
    gap_mm: Annotated[tuple[_Length, _Length], FromList] = (1.5, 7.0)
    focal_mm: Annotated[tuple[_Length, _Length], FromList] | None = None
    aperture_um: Annotated[tuple[_Hole, _Hole], FromList] = (40.0, 250.0)
    rotation_deg: Annotated[tuple[_Angle, _Angle], FromList] | None = None
    brightness: Annotated[tuple[_Share, _Share], FromList] = (0.8, 1.0)
    barriers: Annotated[tuple[Barriers, ...], FromList] = ("none",)
    arrays: Annotated[tuple[str, ...], FromList] = ()
    spacers: Annotated[tuple[str, ...], FromList] = ()

    @field_validator(
        "pitch_um", "gap_mm", "focal_mm", "aperture_um", "rotation_deg", "brightness", mode="after"
    )
    @classmethod
    def _from_low_to_high(cls, ends: tuple[float, float] | None) -> tuple[float, float] | None:
        if ends is not None and ends[0] > ends[1]:
            raise refusal("the smaller one first")
        return ends

    @field_validator("barriers", mode="after")
    @classmethod
    def _some(cls, barriers: tuple[Barriers, ...]) -> tuple[Barriers, ...]:
        if not barriers:
            raise refusal('some of "none", "converging", "perpendicular"')
        return barriers


def search_limits(path: str | None, given: Mapping[str, Any]) -> SearchLimits:
    """The limits of a file, if any, and what options say over them.

    Raises
    ------
    RigError
        Naming each wrong key.
    """
    source = "limits" if path is None else path
    tables = {} if path is None else read_tables(Path(path), path, "file of limits")
    try:
        return SearchLimits.model_validate({**tables, **given})
    except ValidationError as error:
        lines = [_line(detail) for detail in error.errors(include_url=False)[:10]]
        raise RigError(source, list(dict.fromkeys(lines))) from None


def _line(detail: Any) -> str:
    """``key: found ..., wanted ...`` of one of pydantic's complaints."""
    key = str(detail["loc"][0])
    if detail["type"] in ("extra_forbidden", "invalid_key"):
        return f"{key}: found an unknown key, wanted one of {', '.join(SearchLimits.model_fields)}"
    context = detail.get("ctx", {})
    if "wanted" in context:
        wanted = context["wanted"]
    elif "ge" in context or "le" in context:
        field = SearchLimits.model_json_schema()["properties"][key]
        wanted = f"two numbers {_bounds(field)}"
    elif key in ("barriers", "arrays", "spacers"):
        wanted = "a list of names"
    else:
        wanted = "a list of two numbers, from and to"
    return f"{key}: found {shown(detail['input'])}, wanted {wanted}"


def _bounds(field: Any) -> str:
    node = field
    if "anyOf" in node:
        node = next(each for each in node["anyOf"] if each.get("type") == "array")
    item = node["prefixItems"][0]
    return f"from {item['minimum']:g} to {item['maximum']:g}"
