"""The whole rig, and the checks that concern more than one of its tables."""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator

from vrlf.model.eye import Eye
from vrlf.model.fields import GIVEN, above, between, refusal
from vrlf.model.glasses import glasses
from vrlf.model.hardware import LEAST_PITCH, MOST_PITCH, Array, Headset, Panel, lens_power_d
from vrlf.model.lenslet import faces
from vrlf.model.tolerance import Tolerance
from vrlf.units import MM2_PER_CM2, MM_PER_M, NM_PER_UM, UM_PER_MM

# Slanted rays that meet the panel cross the array up to so far beside it.
_BEYOND_MM: Final = 10.0


class Prefilter(BaseModel):
    """How the panel image is computed from the target.

    Attributes
    ----------
    method : {"forward", "optimal", "none"}
    subpixel_grid : int
        ``forward`` samples every colour sub-pixel at this many points squared.
    brightness, black_level : float
        Linear levels that ``optimal`` maps the target's white and black to.
    iterations : int
        Steps that ``optimal`` takes at most.
    budget_ms : float or None
        Time after which ``optimal`` takes no further step; no limit if left out.
    wiener : bool
        Whether ``forward`` sharpens the target first, against the rig's own blur.
    wiener_noise : float
        Noise-to-signal power beside the array's own that this reckons with: 0.001 sharpens
        hard, so that more is cut off at black and white, 0.1 gently.
    """

    model_config = GIVEN

    method: Literal["forward", "optimal", "none"] = "forward"
    subpixel_grid: Annotated[int, between(1, 16)] = 3
    brightness: Annotated[float, above(0.0, 1.0)] = 1.0
    black_level: Annotated[float, between(0.0, 1.0)] = Field(default=0.0)
    iterations: Annotated[int, between(0, 1000)] = 16
    budget_ms: Annotated[float, above(0.0, 1.0e6)] | None = None
    wiener: bool = False
    wiener_noise: Annotated[float, between(1.0e-6, 100.0)] = 0.03

    @field_validator("black_level", mode="after")
    @classmethod
    def _black_below_white(cls, black_level: float, info: ValidationInfo) -> float:
        brightness = info.data.get("brightness")
        if brightness is not None and black_level >= brightness:
            raise refusal(f"less than the brightness of {brightness:g}")
        return black_level


class Rig(BaseModel):
    """Everything that is given: a panel, a headset, an array and two eyes.

    Attributes
    ----------
    schema_version : int
        ``schema`` in the file.
    panel, headset, array, left, right, prefilter
        The tables of the file. Without an [array] table there is no array.
    tolerance : Tolerance or None
        What ``optimal`` is to put up with; None is nothing.
    """

    model_config = ConfigDict(**GIVEN, serialize_by_alias=True)

    schema_version: Annotated[int, between(1, 1)] = Field(default=1, alias="schema")
    panel: Panel
    headset: Headset
    array: Array = Field(default=Array(kind="none"), validate_default=True)
    left: Eye
    right: Eye
    prefilter: Prefilter = Prefilter()
    tolerance: Tolerance | None = None

    @field_validator("tolerance", mode="after")
    @classmethod
    def _not_behind_walls(
        cls, tolerance: Tolerance | None, info: ValidationInfo
    ) -> Tolerance | None:
        """Behind perpendicular walls and a pitch that varies each pixel has a row of its own.

        There is no room for many rigs' rows.
        """
        array = info.data.get("array")
        if tolerance is None or array is None or array.kind == "none":
            return tolerance
        if array.varies:
            raise _even_pitch_wanted(array, "[tolerance]")
        if array.barriers == "perpendicular":
            raise refusal(
                'barriers "converging" or "none" beside [tolerance]',
                key="array.barriers",
                found='"perpendicular"',
            )
        return tolerance

    @field_validator("headset", mode="after")
    @classmethod
    def _knows_its_colours(cls, headset: Headset, info: ValidationInfo) -> Headset:
        panel = info.data.get("panel")
        if panel is not None and headset.glass is not None:
            _check_known_colours(panel, headset.glass, "headset.glass")
        return headset

    @field_validator("array", mode="after")
    @classmethod
    def _fits_the_headset(cls, array: Array, info: ValidationInfo) -> Array:
        headset = info.data.get("headset")
        if headset is not None:
            _check_array_between_lens_and_panel(headset, array)
            _check_relief(headset, array)
            if headset.glass is not None and headset.eye_relief_mm > 0.0 and array.varies:
                raise _even_pitch_wanted(array, "headset.glass with an eye relief")
        panel = info.data.get("panel")
        if panel is not None:
            _check_pitches(panel, array)
        if panel is not None and array.kind == "microlens" and array.lenslet is not None:
            names = [face.glass for face in faces(array.lenslet) if face.glass in glasses()]
            for name in dict.fromkeys(names):
                _check_known_colours(panel, str(name), "array.lenslet's")
        return array


def _check_known_colours(panel: Panel, name: str, whose: str) -> None:
    """Refuse colours at which the lenses' material was not measured."""
    low, high = (NM_PER_UM * end for end in glasses()[name].range_um)
    if not all(low <= nm <= high for nm in panel.wavelengths_nm):
        raise refusal(
            f'wavelengths from {low:g} to {high:g} nm, where {whose} "{name}" is known',
            key="panel.wavelengths_nm",
        )


def _check_array_between_lens_and_panel(headset: Headset, array: Array) -> None:
    if array.kind != "none" and array.gap_mm >= headset.lens_to_panel_mm:
        raise refusal(
            f"less than headset.lens_to_panel_mm, {headset.lens_to_panel_mm:g}",
            key="array.gap_mm",
        )


def pitch_shares(panel: Panel, array: Array) -> tuple[float, float]:
    """The least and the widest pitch anywhere over the panel, in pitches of the lattice's middle.

    ``_BEYOND_MM`` farther out too, for rays that come in from beside the panel.
    """
    shares = [1.0]
    sizes = panel.width_px, panel.height_px
    for growth, size_px, offset_um in zip(
        array.pitch_growth_per_cm2, sizes, array.offset_um, strict=True
    ):
        half_mm = size_px * panel.pixel_pitch_um / UM_PER_MM / 2.0
        reach_mm = half_mm + abs(offset_um) / UM_PER_MM + _BEYOND_MM
        pitch = 1.0 + growth / MM2_PER_CM2 * _before_growth_mm(growth, reach_mm) ** 2
        shares.append(max(pitch, 0.0))
    return min(shares), max(shares)


def _before_growth_mm(growth_per_cm2: float, place_mm: float) -> float:
    """t of t (1 + G t^2 / 3) = place, as far as the pitch does not fall below none."""
    growth, t_mm = growth_per_cm2 / MM2_PER_CM2, place_mm
    for _ in range(60):
        slope = 1.0 + growth * t_mm**2
        if slope <= 0.0:
            return t_mm
        t_mm -= (t_mm * (1.0 + growth * t_mm**2 / 3.0) - place_mm) / slope
    return t_mm


def _check_pitches(panel: Panel, array: Array) -> None:
    """Refuse pitches that vary by more than rays can be followed through."""
    if not array.varies:
        return
    least, most = pitch_shares(panel, array)
    if least < LEAST_PITCH or most > MOST_PITCH:
        raise refusal(
            f"pitches from {LEAST_PITCH:g} to {MOST_PITCH:g} times the middle one, up to "
            f"{_BEYOND_MM:g} mm beside the panel",
            key="array.pitch_growth_per_cm2",
            found=f"{list(array.pitch_growth_per_cm2)}, with pitches from {least:.3g} to "
            f"{most:.3g} times the middle one",
        )
    if array.kind == "pinhole" and array.aperture_um > least * array.pitch_um:
        raise refusal(
            f"at most the least pitch of {least * array.pitch_um:.4g} um", key="array.aperture_um"
        )


def _even_pitch_wanted(array: Array, beside: str) -> Exception:
    return refusal(
        f"[0, 0] beside {beside}",
        key="array.pitch_growth_per_cm2",
        found=str(list(array.pitch_growth_per_cm2)),
    )


def _check_relief(headset: Headset, array: Array) -> None:
    """Refuse a lens so strong that the eye stands behind its image of the panel.

    The chief ray from the panel point X enters the eye with the slope X / m,
    m = e + d - d e F; where m <= 0 the picture has no upright image.
    """
    distance_mm = headset.lens_to_panel_mm
    if array.kind != "none":
        distance_mm += array.gap_mm / array.gap_index - array.gap_mm
    excess = distance_mm * lens_power_d(headset) / MM_PER_M - 1.0
    if distance_mm - headset.eye_relief_mm * excess <= 0.0:
        raise refusal(
            f"less than {distance_mm / excess:.4g} mm behind lenses of "
            f"{lens_power_d(headset):g} D, where an upright image ends",
            key="headset.eye_relief_mm",
        )


def rig_json_schema() -> dict[str, Any]:
    """JSON schema of the rig file, for editors and scripts."""
    return Rig.model_json_schema(by_alias=True)
