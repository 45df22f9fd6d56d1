"""Arrays and spacers that can be bought: ``assets/catalogue.toml``."""

from __future__ import annotations

import tomllib
from functools import cache
from typing import Annotated, Literal

from pydantic import BaseModel

from vrlf.errors import InputError
from vrlf.model.fields import GIVEN, FromList, above, between
from vrlf.model.wording import quoted
from vrlf.resources import assets_dir

_Side = Annotated[float, above(0.0, 10_000.0)]


class ArrayOnSale(BaseModel):
    """A lenslet array of a maker's catalogue.

    Attributes
    ----------
    title, source, material : str
    pitch_um, focal_mm : float
        In air, curved sides to the eye.
    lattice : {"square", "hexagonal"}
    size_mm : (float, float) or None
        What one piece covers, where the maker says so.
    """

    model_config = GIVEN

    title: str
    source: str
    material: str
    pitch_um: Annotated[float, between(1.0, 100_000.0)]
    focal_mm: Annotated[float, between(0.001, 1_000_000.0)]
    lattice: Literal["square", "hexagonal"] = "square"
    size_mm: Annotated[tuple[_Side, _Side], FromList] | None = None


class Spacer(BaseModel):
    """A sheet that holds an array before the panel."""

    model_config = GIVEN

    title: str
    source: str
    thickness_mm: Annotated[float, above(0.0, 1000.0)]
    index: Annotated[float, between(1.0, 3.0)]


class Catalogue(BaseModel):
    """All that is on sale, by the names that a command line gives."""

    model_config = GIVEN

    arrays: dict[str, ArrayOnSale]
    spacers: dict[str, Spacer]


@cache
def catalogue() -> Catalogue:
    """The shipped one."""
    text = (assets_dir() / "catalogue.toml").read_text(encoding="utf-8")
    return Catalogue.model_validate(tomllib.loads(text))


def array_on_sale(name: str) -> ArrayOnSale:
    """The array of that name.

    Raises
    ------
    InputError
        If the catalogue has none.
    """
    arrays = catalogue().arrays
    if name not in arrays:
        raise InputError(f"--arrays: found {quoted(name)}, wanted some of {', '.join(arrays)}")
    return arrays[name]


def spacer_on_sale(text: str) -> Spacer:
    """The spacer of that name, or one of as many millimetres of air as the text says.

    Raises
    ------
    InputError
        If it is neither.
    """
    spacers = catalogue().spacers
    if text in spacers:
        return spacers[text]
    try:
        thickness_mm = float(text)
        if not 0.001 <= thickness_mm <= 1000.0:
            raise ValueError
    except ValueError:
        raise InputError(
            f"--spacers: found {quoted(text)}, wanted millimetres of air or some of "
            f"{', '.join(spacers)}"
        ) from None
    return Spacer(title=f"{text} mm of air", source="given", thickness_mm=thickness_mm, index=1.0)
