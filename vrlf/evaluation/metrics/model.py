"""What a metric is, what it is told and what it says."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import isfinite
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from vrlf.errors import InputError, VrlfError
from vrlf.scene import luminance

Float = NDArray[np.float64]
Picture = NDArray[np.floating[Any]]
Value = float | dict[str, float] | None

MOST_PIXELS_PER_DEGREE: Final = 1e4
MOST_NIT: Final = 1e6


class MetricError(VrlfError):
    """A metric has no answer to these pictures; the others may."""


class MissingExtraError(InputError):
    """A metric's library is not installed, or does not load.

    Parameters
    ----------
    metric, library, extra : str
        The metric's name, what it needs, and the extra of this package that holds it.
    """

    def __init__(self, metric: str, library: str, extra: str, fault: str = "") -> None:
        reason = f"no {library}" if not fault else f"a {library} that does not load ({fault})"
        super().__init__(
            f"{metric}: found {reason}, wanted it installed; pip install 'vrlf[{extra}]'"
        )


@dataclass(frozen=True)
class Viewing:
    """How a picture meets the eye.

    A picture's luminance is black_nit + peak_nit times its linear value, colour by colour, so
    that white stands at black_nit + peak_nit.

    Attributes
    ----------
    pixels_per_degree
        On the axis.
    peak_nit
        What full drive adds, cd/m2.
    black_nit
        What an undriven panel gives, cd/m2.

    Raises
    ------
    InputError
        A number that no panel has.
    """

    pixels_per_degree: float
    peak_nit: float
    black_nit: float = 0.0

    def __post_init__(self) -> None:
        for name, least, most in (
            ("pixels_per_degree", 0.0, MOST_PIXELS_PER_DEGREE),
            ("peak_nit", 0.0, MOST_NIT),
        ):
            found = getattr(self, name)
            if not (isfinite(found) and least < found <= most):
                raise InputError(f"{name}: found {found}, wanted above 0, at most {most:g}")
        if not (isfinite(self.black_nit) and 0.0 <= self.black_nit <= MOST_NIT):
            raise InputError(f"black_nit: found {self.black_nit}, wanted 0 to {MOST_NIT:g}")

    def colours_nit(self, picture: Picture) -> Float:
        """Luminance that each colour would have by itself as white, shape (H, W, 3), cd/m2."""
        return self.black_nit + self.peak_nit * np.maximum(picture.astype(np.float64), 0.0)

    def luminance_nit(self, picture: Picture) -> Float:
        """Luminance, shape (H, W), cd/m2 (ITU-R BT.709-6)."""
        return luminance(self.colours_nit(picture))


@dataclass(frozen=True)
class Score:
    """What one metric says.

    Attributes
    ----------
    value
        A number, several by name, or None where it has none.
    reason
        Why there is none.
    maps
        Where the pictures differ, each (H, W), by name.
    """

    value: Value
    reason: str | None = None
    maps: Mapping[str, Float] = field(default_factory=dict)


@dataclass(frozen=True)
class Metric:
    """One way to compare two pictures.

    Attributes
    ----------
    name
        In JSON and on the command line.
    title, unit
        For people; the unit is empty for a bare number.
    better
        Which way is better.
    extra
        The extra of this package that brings its library; None if it needs none.
    needs_viewing
        Whether pixels per degree and luminance change the value.
    map_names
        The maps that its score has.
    compute
        From reference, test (linear RGB, (H, W, 3)) and viewing to the score. Raises a
        `VrlfError` where it cannot.
    """

    name: str
    title: str
    unit: str
    better: Literal["higher", "lower"]
    extra: str | None
    needs_viewing: bool
    map_names: tuple[str, ...]
    compute: Callable[[Picture, Picture, Viewing], Score]


@dataclass(frozen=True)
class Scores:
    """What several metrics say of the same two pictures.

    Attributes
    ----------
    values
        By metric; ready for JSON, None where a value isn't defined.
    reasons
        Why not, for those.
    maps
        By metric, then by the map's name.
    failed
        Metrics that could not be had, each with the reason in one line.
    """

    values: dict[str, Value]
    reasons: dict[str, str]
    maps: dict[str, Mapping[str, Float]]
    failed: dict[str, str]


def check_pair(reference: Picture, test: Picture) -> None:
    """Refuse what no metric can compare.

    Raises
    ------
    InputError
        Pictures of unequal size, no pictures, or numbers that are not finite.
    """
    for name, picture in (("reference", reference), ("test", test)):
        if picture.ndim != 3 or picture.shape[2] != 3 or 0 in picture.shape:
            raise InputError(f"{name}: found an array {picture.shape}, wanted (H, W, 3)")
        bad = picture.size - int(np.count_nonzero(np.isfinite(picture)))
        if bad:
            raise InputError(
                f"{name}: found {bad} of {picture.size} values NaN or infinite, wanted finite ones"
            )
    if reference.shape != test.shape:
        raise InputError(
            f"test: found {test.shape[1]}x{test.shape[0]} pixels, wanted "
            f"{reference.shape[1]}x{reference.shape[0]} like the reference"
        )
