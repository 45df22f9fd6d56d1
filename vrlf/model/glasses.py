"""The catalogue of lens materials: ``assets/glasses.toml``, where their formulas are explained."""

from __future__ import annotations

import tomllib
from functools import cache
from math import sqrt
from typing import Annotated

from pydantic import BaseModel

from vrlf.model.fields import GIVEN, FromList
from vrlf.resources import assets_dir

Pair = Annotated[tuple[float, float], FromList]
Pairs = Annotated[tuple[Pair, ...], FromList]


class Glass(BaseModel):
    """One material.

    Attributes
    ----------
    title, source : str
    range_um : (float, float)
        Wavelengths between which the coefficients hold.
    sellmeier, powers : tuple of pairs
        Coefficients of the formulas; one of the two is empty.
    nd, vd : float or None
        Index and Abbe number as published.
    """

    model_config = GIVEN

    title: str
    source: str
    range_um: Pair
    sellmeier: Pairs = ()
    powers: Pairs = ()
    nd: float | None = None
    vd: float | None = None

    def index(self, wavelength_um: float) -> float:
        """Refractive index in air: Sellmeier 1871; or a series of powers, as Schott's of 1967."""
        if self.powers:
            return sqrt(sum((a * float(wavelength_um**p) for a, p in self.powers), 0.0))
        square = wavelength_um**2
        return sqrt(1.0 + sum(b * square / (square - c) for b, c in self.sellmeier))


@cache
def glasses() -> dict[str, Glass]:
    """All materials by the names that a rig gives."""
    text = (assets_dir() / "glasses.toml").read_text(encoding="utf-8")
    return {name: Glass.model_validate(table) for name, table in tomllib.loads(text).items()}
