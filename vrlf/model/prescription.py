"""A prescription as it is written on paper."""

from __future__ import annotations

import re
from typing import Final

from vrlf.errors import InputError
from vrlf.model.eye import AXIS_LIMIT_DEG, CYLINDER_LIMIT_D, SPHERE_LIMIT_D
from vrlf.model.wording import quoted

_WANTED: Final = 'sphere / cylinder x axis such as "-5.00 / -1.25 x 170", or "plano"'
_LONGEST: Final = 100

# Signs and crosses that word processors and opticians' printers put in place
# of the plain ones.
_PLAIN: Final = str.maketrans(
    {"\N{MINUS SIGN}": "-", "\N{EN DASH}": "-", "\N{FIGURE DASH}": "-", "\N{HYPHEN}": "-"}
    | {"\N{SMALL HYPHEN-MINUS}": "-", "\N{FULLWIDTH HYPHEN-MINUS}": "-"}
    | {"\N{FULLWIDTH PLUS SIGN}": "+", "\N{MULTIPLICATION SIGN}": "x", "\N{NO-BREAK SPACE}": " "}
)
_NUMBER: Final = r"[+-]?\s*(?:[0-9]+\.?[0-9]*|\.[0-9]+)"
_FORM: Final = re.compile(
    rf"""\s*
    (?P<sphere>{_NUMBER}|pl(?:ano)?)
    (?:\s*/?\s*(?:ds|sph|dpt|d)\b)?                           # -5.00 DS
    (?:
        (?:\s*[/,]\s*|\s+|(?=[+-]))                           # "/", a blank, or the next sign
        (?P<cylinder>{_NUMBER})
        (?:\s*(?:dc|cyl|dpt|d)(?![a-z]))?
        (?:\s*(?:x|axis|ax)\s*(?P<axis>{_NUMBER})\s*(?:°|deg)?)?
    )?
    \s*""",
    re.VERBOSE | re.IGNORECASE,
)


def parse_prescription(text: str) -> tuple[float, float, float]:
    """Sphere, cylinder and axis of a prescription as it is written on paper.

    Parameters
    ----------
    text : str
        Such as ``"-5.00 / -1.25 x 170"``, ``"-5"``, ``"pl / -0.75 x 90"``,
        ``"+2.50 DS"``. Decimal commas and typographic signs are understood.

    Returns
    -------
    (float, float, float)
        Sphere and cylinder in dioptres as written, axis in degrees (TABO), 0
        without a cylinder.

    Raises
    ------
    InputError
        If it reads as nothing of the kind, lacks the axis of its cylinder, or
        lies outside of what eyes need.
    """
    plain = re.sub(r"(?<=[0-9]),(?=[0-9])", ".", text.translate(_PLAIN))
    form = _FORM.fullmatch(plain) if len(plain) <= _LONGEST else None
    if form is None:
        raise _unreadable(text, "", _WANTED)
    sphere_d = 0.0 if form["sphere"].lower().startswith("pl") else _value(form["sphere"])
    cylinder_d = _value(form["cylinder"] or "0")
    if form["axis"] is None and cylinder_d != 0.0:
        raise _unreadable(text, "a cylinder without its axis in ", _WANTED)
    axis_deg = _value(form["axis"] or "0")
    if abs(sphere_d) > SPHERE_LIMIT_D:
        raise _unreadable(text, "sphere in ", f"at most {SPHERE_LIMIT_D:g} D either way")
    if abs(cylinder_d) > CYLINDER_LIMIT_D:
        raise _unreadable(text, "cylinder in ", f"at most {CYLINDER_LIMIT_D:g} D either way")
    if not 0.0 <= axis_deg <= AXIS_LIMIT_DEG:
        raise _unreadable(text, "axis in ", f"0 to {AXIS_LIMIT_DEG:g} degrees")
    return sphere_d, cylinder_d, axis_deg if cylinder_d else 0.0


def prescription_text(sphere_d: float, cylinder_d: float, axis_deg: float) -> str:
    """A prescription as it is written on paper, to hundredths of a dioptre."""
    if round(cylinder_d, 2) == 0.0:
        return f"{sphere_d:+.2f} D"
    return f"{sphere_d:+.2f} / {cylinder_d:+.2f} x {axis_deg:.0f}"


def _value(number: str) -> float:
    # Adding 0 turns the -0 of "-0.00" into 0.
    return float("".join(number.split())) + 0.0


def _unreadable(text: str, what: str, wanted: str) -> InputError:
    return InputError(f"prescription: found {what}{quoted(text)}, wanted {wanted}")
