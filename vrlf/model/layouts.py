"""Sub-pixel layouts that ship with vrlf: where each colour emits, as files of ``assets/layouts``.

A layout is a period of 1 or 2 columns and rows of pixels that repeats over the panel, from its
upper left pixel on, and for each pixel of it, by rows, the rectangle of each colour that it has.
"""

from __future__ import annotations

import functools
from typing import Annotated, Any, Final, Self

from pydantic import BaseModel, Field, ValidationError, field_validator, model_validator

from vrlf.errors import InputError, RigError
from vrlf.model.fields import GIVEN, FromList, between, refusal
from vrlf.model.toml_file import read_tables
from vrlf.model.wording import shown
from vrlf.resources import assets_dir

COLOURS: Final = ("red", "green", "blue")
# The design's own; the others follow by name.
_FIRST: Final = ("full", "rgb-stripe", "bgr-stripe")
# Shaders find a pixel's place in the period by its last bit.
_MOST_A_SIDE: Final = 2

_Place = Annotated[float, between(0.0, 1.0)]
Rectangle = Annotated[tuple[_Place, _Place, _Place, _Place], FromList]


class LayoutPixel(BaseModel):
    """Where one pixel emits red, green and blue: left, top, right, bottom in pixels.

    From the pixel's upper left corner, x to the right and y downward; None for a colour that
    the pixel lacks.
    """

    model_config = GIVEN

    red: Rectangle | None = None
    green: Rectangle | None = None
    blue: Rectangle | None = None

    @field_validator(*COLOURS, mode="after")
    @classmethod
    def _has_an_area(cls, box: Rectangle | None) -> Rectangle | None:
        if box is not None and not (box[0] < box[2] and box[1] < box[3]):
            raise refusal("left < right and top < bottom in [left, top, right, bottom]")
        return box


class SubpixelLayout(BaseModel):
    """A layout of sub-pixels.

    Attributes
    ----------
    source : str
        Where it comes from.
    columns, rows : int
        Of the period.
    pixels : tuple of LayoutPixel
        Of the period, by rows.
    """

    model_config = GIVEN

    source: Annotated[str, Field(min_length=1)]
    columns: Annotated[int, between(1, _MOST_A_SIDE)]
    rows: Annotated[int, between(1, _MOST_A_SIDE)]
    pixels: Annotated[tuple[LayoutPixel, ...], FromList]

    @model_validator(mode="after")
    def _whole(self) -> Self:
        count = self.columns * self.rows
        if len(self.pixels) != count:
            wanted = f"{count} of them, a period of {self.columns}x{self.rows} by rows"
            raise refusal(wanted, key="pixels", found=f"{len(self.pixels)} pixels")
        for colour in COLOURS:
            if all(getattr(pixel, colour) is None for pixel in self.pixels):
                raise refusal(f"{colour} in one at least", key="pixels", found=f"no {colour}")
        return self


def layout_names() -> tuple[str, ...]:
    """Names of the shipped layouts."""
    names = {path.stem for path in (assets_dir() / "layouts").glob("*.toml")}
    first = [name for name in _FIRST if name in names]
    return (*first, *sorted(names.difference(_FIRST)))


def names_wanted() -> str:
    """What a message says is wanted where a layout is not known."""
    return "one of " + ", ".join(map(shown, layout_names()))


@functools.cache
def subpixel_layout(name: str) -> SubpixelLayout:
    """The shipped layout of that name, read once.

    Raises
    ------
    InputError
        If there is no such layout.
    RigError
        If its file is not one.
    """
    if name not in layout_names():
        raise InputError(f"panel.subpixels: found {shown(name)}, wanted {names_wanted()}")
    label = f"layouts/{name}.toml"
    tables = read_tables(assets_dir() / "layouts" / f"{name}.toml", label, "layout of sub-pixels")
    return layout_from_tables(tables, source=label)


def layout_from_tables(tables: dict[str, Any], *, source: str) -> SubpixelLayout:
    """Validate what a layout's file holds.

    Raises
    ------
    RigError
        Naming ``source`` and every wrong key.
    """
    try:
        return SubpixelLayout.model_validate(tables)
    except ValidationError as error:
        details = error.errors(include_url=False)
    raise RigError(source, list(dict.fromkeys(_line(tables, detail) for detail in details)))


def _line(tables: Any, detail: Any) -> str:
    """One wrong key: ``pixels[1].green: found ..., wanted ...``."""
    context = detail.get("ctx", {})
    place = [context["key"]] if "key" in context else list(detail["loc"])
    if detail["type"] == "extra_forbidden":
        known = (*COLOURS,) if len(place) > 1 else tuple(SubpixelLayout.model_fields)
        return f"{_dotted(place)}: found an unknown key, wanted one of {', '.join(known)}"
    if "pixels" in place and len(place) > 3:  # an item of a rectangle: the whole is shown
        place = place[:3]
    value: Any = tables
    for part in place:
        try:
            value = value[part]
        except (KeyError, IndexError, TypeError):
            value = None
            break
    found = context.get("found", "nothing" if value is None else shown(value))
    return f"{_dotted(place)}: found {found}, wanted {context.get('wanted') or _wanted(place)}"


def _wanted(place: list[Any]) -> str:
    match place:
        case ["source"]:
            return "a text that says where the layout comes from"
        case ["columns" | "rows"]:
            return f"a whole number from 1 to {_MOST_A_SIDE}"
        case ["pixels", int(), str()]:
            return "[left, top, right, bottom] from 0 to 1, within the pixel"
        case _:
            return "a table [[pixels]] for each pixel of the period"


def _dotted(place: list[Any]) -> str:
    text = ""
    for part in place:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text
