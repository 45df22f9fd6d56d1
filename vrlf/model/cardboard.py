"""Cardboard viewer profiles: what the code on a viewer's box says of its lenses.

A profile is Google's ``DeviceParams`` (googlevr/cardboard, ``proto/cardboard_device.proto``), a
protocol buffer: as base64 in a web address, which is the text of the printed code, or as bytes in
the file that Android keeps, behind a mark and their count (``CardboardParamsUtils.java`` there).

Its distortion coefficients map "from position on real screen to virtual screen", p' = p (1 + k1
r^2 + k2 r^4) with r in units of the screen's distance: the same way as ``headset.distortion``,
so they are taken as they are. That r is |X| / lens_to_panel_mm, which is our |X| / m as long as
the panel stands at the lens's focus.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any, Final, Literal

from vrlf.errors import InputError
from vrlf.model.cardboard_source import profile_bytes
from vrlf.model.protobuf import Wire, WireError, WireField, fields_of
from vrlf.units import MM_PER_M

Alignment = Literal["bottom", "center", "top"]
Button = Literal["none", "magnet", "touch", "indirect-touch"]
# The enumerations' names by their numbers.
_ALIGNMENTS: Final[tuple[Alignment, ...]] = ("bottom", "center", "top")
_BUTTONS: Final[tuple[Button, ...]] = ("none", "magnet", "touch", "indirect-touch")

# Field numbers of DeviceParams, and how each is written.
_NAMES: Final = {
    1: ("vendor", Wire.BYTES),
    2: ("model", Wire.BYTES),
    3: ("screen_to_lens_distance", Wire.FIXED32),
    4: ("inter_lens_distance", Wire.FIXED32),
    5: ("left_eye_field_of_view_angles", Wire.BYTES),
    6: ("tray_to_lens_distance", Wire.FIXED32),
    7: ("distortion_coefficients", Wire.BYTES),
    11: ("vertical_alignment", Wire.VARINT),
    12: ("primary_button", Wire.VARINT),
}
# Packed numbers may also come one by one, which readers must take.
_REPEATED: Final = frozenset({"left_eye_field_of_view_angles", "distortion_coefficients"})

# What a viewer held before the eyes can be: least and most.
_LENGTHS_MM: Final = {
    "screen_to_lens_distance": (5.0, 500.0),
    "inter_lens_distance": (10.0, 200.0),
    "tray_to_lens_distance": (0.0, 300.0),
}
_ANGLE_DEG: Final = (0.0, 90.0)
_COEFFICIENT: Final = (-100.0, 100.0)
_MOST_COEFFICIENTS: Final = 2


@dataclass(frozen=True)
class FieldOfView:
    """How far the left eye sees, in degrees from the lens's axis; the right eye's is mirrored."""

    outer: float
    inner: float
    bottom: float
    top: float


@dataclass(frozen=True)
class ViewerProfile:
    """What a profile says.

    Attributes
    ----------
    vendor, model : str
    screen_to_lens_mm, inter_lens_mm : float
    vertical_alignment : "bottom", "center" or "top"
        Which of its edges the phone rests on, or that it is held in the middle.
    tray_to_lens_mm : float or None
        That edge's distance from the height of the lenses; None where it is held in the middle.
    field_of_view_deg : FieldOfView or None
    distortion : (k1, k2)
    primary_button : "none", "magnet", "touch" or "indirect-touch"
    """

    vendor: str
    model: str
    screen_to_lens_mm: float
    inter_lens_mm: float
    vertical_alignment: Alignment
    tray_to_lens_mm: float | None
    field_of_view_deg: FieldOfView | None
    distortion: tuple[float, float]
    primary_button: Button


def read_profile(source: str, folder: Path = Path()) -> ViewerProfile:
    """The profile in a web address, in its text alone, or in a file.

    Parameters
    ----------
    source : str
    folder : Path
        From where a file's path counts.

    Raises
    ------
    InputError
        If the source is none of them, or what it holds is no profile or describes no viewer.
    """
    return decoded_profile(profile_bytes(source, folder))


def decoded_profile(message: bytes) -> ViewerProfile:
    """The profile that the bytes of a ``DeviceParams`` message hold.

    Raises
    ------
    InputError
    """
    found = _values(message)
    alignment = _named(found, "vertical_alignment", _ALIGNMENTS, 0)
    centred = alignment == "center"
    return ViewerProfile(
        vendor=str(found.get("vendor", "")),
        model=str(found.get("model", "")),
        screen_to_lens_mm=_length_mm(found, "screen_to_lens_distance"),
        inter_lens_mm=_length_mm(found, "inter_lens_distance"),
        vertical_alignment=alignment,
        tray_to_lens_mm=None if centred else _length_mm(found, "tray_to_lens_distance"),
        field_of_view_deg=_field_of_view(found.get("left_eye_field_of_view_angles", [])),
        distortion=_distortion(found.get("distortion_coefficients", [])),
        primary_button=_named(found, "primary_button", _BUTTONS, 1),
    )


def _values(message: bytes) -> dict[str, Any]:
    """The known fields by name, of those given twice the last, as the format has it."""
    found: dict[str, Any] = {}
    try:
        for each in fields_of(message):
            name, wire = _NAMES.get(each.number, ("", each.wire))
            if name in _REPEATED:
                found.setdefault(name, []).extend(_floats(each, name))
            elif name:
                found[name] = _value(each, name, wire)
    except WireError as error:
        raise refused(str(error)) from None
    return found


def _value(each: WireField, name: str, wire: Wire) -> Any:
    if each.wire is not wire:
        raise WireError(f"{name} of the wire type {each.wire.value}")
    if isinstance(each.value, int):
        return each.value
    if wire is Wire.FIXED32:
        return _floats(each, name)[0]
    try:
        return each.value.decode("utf-8")
    except UnicodeDecodeError:
        raise WireError(f"a {name} that is not UTF-8") from None


def _floats(each: WireField, name: str) -> list[float]:
    """Numbers of single precision, as short as they can be written."""
    if isinstance(each.value, int) or each.wire is Wire.FIXED64 or len(each.value) % 4:
        raise WireError(f"{name} that is no row of 32-bit numbers")
    numbers = [number for (number,) in struct.iter_unpack("<f", each.value)]
    if not all(map(isfinite, numbers)):
        raise WireError(f"{name} that is not finite")
    return [_shortest(number) for number in numbers]


def _shortest(number: float) -> float:
    """The shortest decimal that single precision takes for the same number."""
    for digits in range(1, 9):
        short = float(f"{number:.{digits}g}")  # 0.039, not 0.0390000008
        if abs(short) < 3.0e38 and struct.unpack("<f", struct.pack("<f", short))[0] == number:
            return short
    return number


def _length_mm(found: dict[str, Any], name: str) -> float:
    low, high = _LENGTHS_MM[name]
    if name not in found:
        raise refused(f"no {name}")
    length_mm: float = round(found[name] * MM_PER_M, 6)
    if not low <= length_mm <= high:
        raise refused(f"{name} of {length_mm:g} mm", f"{low:g} to {high:g} mm")
    return length_mm


def _named(found: dict[str, Any], name: str, names: tuple[Any, ...], default: int) -> Any:
    number = found.get(name, default)
    if number >= len(names):
        raise refused(f"{name} {number}", f"0 to {len(names) - 1}")
    return names[number]


def _field_of_view(angles_deg: list[float]) -> FieldOfView | None:
    if not angles_deg:
        return None
    low, high = _ANGLE_DEG
    if len(angles_deg) != 4:
        raise refused(f"{len(angles_deg)} angles of the field of view", "four")
    wrong = [angle for angle in angles_deg if not low <= angle < high]
    if wrong:
        raise refused(
            f"a field of view of {wrong[0]:g} degrees", f"{low:g} to less than {high:g} degrees"
        )
    return FieldOfView(*angles_deg)


def _distortion(coefficients: list[float]) -> tuple[float, float]:
    low, high = _COEFFICIENT
    if any(coefficients[_MOST_COEFFICIENTS:]):
        raise refused(f"{len(coefficients)} distortion coefficients", "at most two, k1 and k2")
    for number in coefficients:
        if not low <= number <= high:
            raise refused(f"a distortion coefficient of {number:g}", f"{low:g} to {high:g}")
    k1, k2 = (*coefficients, 0.0, 0.0)[:_MOST_COEFFICIENTS]
    return k1, k2


def refused(found: str, wanted: str = "a Cardboard viewer profile") -> InputError:
    return InputError(f"profile: found {found}, wanted {wanted}")
