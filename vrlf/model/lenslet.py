"""A lenslet by its surfaces, from which its focal length of each colour follows."""

from __future__ import annotations

import re
from typing import Annotated, Final, Literal, NamedTuple

from pydantic import AfterValidator, BaseModel, ConfigDict, ValidationInfo, field_validator

from vrlf.model.fields import GIVEN, FromList, above, between, refusal
from vrlf.model.glasses import glasses
from vrlf.units import NM_PER_UM

# Helium's d line, at which lenses are designed.
DESIGN_WAVELENGTH_NM: Final = 587.56
_MOST_SURFACES: Final = 9
_LEAST_ABBE: Final = 5.0
# nd/V as optical glasses are written, 1.52/55; the index alone has no dispersion.
_NUMBERS: Final = re.compile(r"(\d+(?:\.\d+)?)(?:/(\d+(?:\.\d+)?))?")


class GlassNumbers(NamedTuple):
    """An index at the d line and an Abbe number (None: no dispersion)."""

    n_d: float
    abbe: float | None


def glass_numbers(text: str) -> GlassNumbers | None:
    """What ``1.52/55`` or ``1.52`` says; None for anything else, as a catalogued name."""
    found = _NUMBERS.fullmatch(text)
    if found is None:
        return None
    return GlassNumbers(float(found[1]), None if found[2] is None else float(found[2]))


def is_glass(text: str) -> bool:
    """Whether a text names a catalogued glass, or an index and Abbe number as glass has."""
    numbers = glass_numbers(text)
    if numbers is None:
        return text in glasses()
    abbe = _LEAST_ABBE if numbers.abbe is None else numbers.abbe
    return 1.0 < numbers.n_d <= 3.0 and _LEAST_ABBE <= abbe <= 200.0


def wanted_glass() -> str:
    """What a glass may be, for messages."""
    return ", ".join(f'"{name}"' for name in glasses()) + ', or index and Abbe number as "1.52/55"'


def _known_glass(text: str) -> str:
    if not is_glass(text):
        raise refusal(wanted_glass())
    return text


def design_index(glass: str) -> float:
    """Index at the d line."""
    numbers = glass_numbers(glass)
    if numbers is not None:
        return numbers.n_d
    return glasses()[glass].index(DESIGN_WAVELENGTH_NM / NM_PER_UM)


_Radius = Annotated[float, between(-10_000.0, 10_000.0)]
_Thickness = Annotated[float, above(0.0, 1000.0)]
_Conic = Annotated[float, between(-1000.0, 1000.0)]
_GlassName = Annotated[str, AfterValidator(_known_glass)]


class Lenslet(BaseModel):
    """One lenslet: a plano-convex lens, or surfaces one behind the other.

    Attributes
    ----------
    radius_mm, thickness_mm, glass, facing, conic
        Of a plano-convex lens: its curved face's radius, the middle's thickness, what it is made
        of (a name of assets/glasses.toml, or index and Abbe number as "1.52/55"), and where the
        curved face looks: "eye" or "panel".
    radii_mm, thicknesses_mm, glasses
        Instead of those: all surfaces from the eye's side on. A radius is positive where its
        centre lies on the panel's side, 0 for a flat face.
    """

    # Defaults too: which keys are given together is checked with the last one.
    model_config = ConfigDict(**GIVEN, validate_default=True)

    radius_mm: _Radius | None = None
    thickness_mm: _Thickness | None = None
    glass: _GlassName | None = None
    facing: Literal["eye", "panel"] = "eye"
    conic: _Conic = 0.0
    thicknesses_mm: Annotated[tuple[_Thickness, ...], FromList] | None = None
    glasses: Annotated[tuple[_GlassName, ...], FromList] | None = None
    # Last, because its check asks for the others.
    radii_mm: Annotated[tuple[_Radius, ...] | None, FromList] = None

    @field_validator("radii_mm", mode="after")
    @classmethod
    def _one_way_of_saying_it(
        cls, radii_mm: tuple[float, ...] | None, info: ValidationInfo
    ) -> tuple[float, ...] | None:
        given = info.data
        if any(name not in given for name in (*_PLAIN, *_LISTS)):
            return radii_mm  # one of them is wrong by itself, and is named
        plain = [name for name in _PLAIN if given[name] is not None]
        if radii_mm is None:
            _check_plain(plain, [name for name in _LISTS if given[name] is not None])
            return None
        if plain:
            raise refusal(f"no {plain[0]} beside radii_mm", key=_key(plain[0]))
        counts = {name: len(given[name] or ()) for name in _LISTS}
        if not 2 <= len(radii_mm) <= _MOST_SURFACES:
            raise refusal(f"a list of 2 to {_MOST_SURFACES} radii")
        for name, count in counts.items():
            if count != len(radii_mm) - 1:
                raise refusal(f"one less than radii_mm, {len(radii_mm) - 1}", key=_key(name))
        return radii_mm


_PLAIN: Final = ("radius_mm", "thickness_mm", "glass")
_LISTS: Final = ("thicknesses_mm", "glasses")


def _key(name: str) -> str:
    return f"array.lenslet.{name}"


def _check_plain(plain: list[str], lists: list[str]) -> None:
    if lists:
        raise refusal("the radii of all surfaces", key=_key("radii_mm"))
    for name in _PLAIN:
        if name not in plain:
            raise refusal("it beside the other two of " + ", ".join(_PLAIN), key=_key(name))


class Face(NamedTuple):
    """A surface and what follows it: what a lenslet's keys come to.

    ``glass`` is None behind the last one.
    """

    radius_mm: float
    conic: float
    thickness_mm: float
    glass: str | None


def faces(lenslet: Lenslet) -> tuple[Face, ...]:
    """The surfaces of a lenslet from the eye's side on."""
    if lenslet.radii_mm is not None:
        inner = zip(lenslet.thicknesses_mm or (), lenslet.glasses or (), strict=True)
        rows = [(thickness, glass) for thickness, glass in inner]
        return tuple(
            Face(radius, 0.0, *row)
            for radius, row in zip(lenslet.radii_mm, [*rows, (0.0, None)], strict=True)
        )
    assert lenslet.radius_mm is not None
    assert lenslet.thickness_mm is not None
    if lenslet.facing == "eye":
        return (
            Face(lenslet.radius_mm, lenslet.conic, lenslet.thickness_mm, lenslet.glass),
            Face(0.0, 0.0, 0.0, None),
        )
    return (
        Face(0.0, 0.0, lenslet.thickness_mm, lenslet.glass),
        Face(-lenslet.radius_mm, lenslet.conic, 0.0, None),
    )


def design_power_per_mm(lenslet: Lenslet, index_behind: float) -> float:
    """1 / focal length at the d line, with a medium of ``index_behind`` between it and the panel.

    Paraxial: a ray from infinity of height 1 keeps n u from surface to surface but for y c
    (n' - n), and y but for u t.
    """
    height, slope, before = 1.0, 0.0, 1.0
    for face in faces(lenslet):
        behind = index_behind if face.glass is None else design_index(face.glass)
        if face.radius_mm != 0.0:
            slope -= height * (behind - before) / face.radius_mm
        height += slope * face.thickness_mm / behind
        before = behind
    return -slope
