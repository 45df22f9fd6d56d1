"""What the benches' options turn text into: panel sizes, decimal numbers, a place for a plot."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from typing import Any, TypeVar

import click

from vrlf.studies.plots import ENDINGS, check_plot

Command = TypeVar("Command", bound=Callable[..., Any])
SizePx = tuple[int, int]
_MOST_SIDE_PX = 65536


def panel_size(text: str | SizePx) -> SizePx:
    """``WxH`` in pixels."""
    if isinstance(text, tuple):
        return text
    width, _, height = text.strip().lower().partition("x")
    if not (_is_side(width) and _is_side(height)):
        raise click.BadParameter(
            f"found {text[:40]!r}, wanted width and height in pixels, as in 440x220"
        )
    return int(width), int(height)


def _is_side(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) <= 5 and 1 <= int(text) <= _MOST_SIDE_PX


def panel_sizes(text: str | list[SizePx]) -> list[SizePx]:
    """``WxH,WxH,...``."""
    return text if isinstance(text, list) else [panel_size(part) for part in text.split(",")]


def decimal_number(above: float, most: float) -> Callable[[str | float], float]:
    """What click turns an option's text into a finite number of a range with."""

    def convert(text: str | float) -> float:
        try:
            number = float(text)
        except ValueError:
            number = above
        if not isfinite(number) or not above < number <= most:
            raise click.BadParameter(
                f"found {str(text)[:40]!r}, wanted a number above {above:g}, at most {most:g}"
            )
        return number

    return convert


def plot_option(what: str) -> Callable[[Command], Command]:
    """``--plot``."""
    return click.option("--plot", metavar="FILE", help=f"{what}, to {' or '.join(ENDINGS)}.")


def require_plot(plot: str | None) -> None:
    """Make sure that a plot that was asked for can be drawn, before anything is measured."""
    if plot is not None:
        check_plot(plot)
