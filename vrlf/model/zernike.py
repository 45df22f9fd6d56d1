"""A measured wavefront, and the three orders in which its coefficients are listed.

======== ======== ================== =====================================================
ordering begins   normalised         source
======== ======== ================== =====================================================
osa      j = 0    yes                ANSI Z80.28; j = (n (n + 2) + m) / 2
noll     j = 1    yes                Noll 1976; even j are the cosines
fringe   j = 1    no: +-1 at the rim University of Arizona, Wyant & Creath 1992
======== ======== ================== =====================================================

All three measure the angle from the examiner's x axis.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isqrt, sqrt
from typing import Annotated, Final, Literal

from pydantic import AfterValidator, BaseModel, Field, ValidationInfo, field_validator

from vrlf.model.fields import GIVEN, FromList, beside, between, refusal
from vrlf.units import NM_PER_UM

ZERNIKE_ORDER_LIMIT: Final = 8
# (8, -8) is the 66th term of Fringe, which goes by n + |m|; zeros may fill its next row.
_LONGEST_LIST: Final = 81

Ordering = Literal["osa", "noll", "fringe"]
Unit = Literal["um", "waves"]
Term = tuple[int, int]


def term_of(name: str) -> Term | None:
    """Order and frequency of a coefficient's name "n,m", None where it is not one.

    Only the plain spelling counts, so that no two keys mean one coefficient.
    """
    try:
        n, m = (int(part) for part in name.split(","))
    except ValueError:
        return None
    return (n, m) if is_term(n, m) and name == f"{n},{m}" else None


def is_term(n: int, m: int) -> bool:
    """Whether there is a Zernike polynomial of that order and frequency, up to order 8."""
    return 0 <= n <= ZERNIKE_ORDER_LIMIT and abs(m) <= n and (n - m) % 2 == 0


def first_index(ordering: Ordering) -> int:
    """The number of an ordering's first term."""
    return 0 if ordering == "osa" else 1


def listed_term(ordering: Ordering, index: int) -> Term:
    """Order and signed frequency (negative: sine) of the term with that number."""
    return {"osa": _osa, "noll": _noll, "fringe": _fringe}[ordering](index)


def _osa(j: int) -> Term:
    n = (isqrt(8 * j + 1) - 1) // 2
    return n, 2 * j - n * (n + 2)


def _noll(j: int) -> Term:
    n = (isqrt(8 * j - 7) - 1) // 2
    within = j - n * (n + 1) // 2 - 1
    # Frequencies come in pairs, from the lowest of the order on.
    k = 2 * ((within + 1) // 2) if n % 2 == 0 else 2 * (within // 2) + 1
    return n, k if j % 2 == 0 else -k


def _fringe(j: int) -> Term:
    half = isqrt(j - 1)  # (n + |m|) / 2
    within = j - 1 - half * half
    k = half - within // 2
    return 2 * half - k, k if within % 2 == 0 else -k


def normalised(ordering: Ordering, term: Term) -> float:
    """What an ordering's coefficient is multiplied with to be one of the normalised term."""
    n, m = term
    return 1.0 / sqrt((2 if m else 1) * (n + 1)) if ordering == "fringe" else 1.0


def _coefficient_name(name: str) -> str:
    if term_of(name) is None:
        raise refusal(
            f'a name "n,m" such as "3,-1", n from 0 to {ZERNIKE_ORDER_LIMIT}, '
            "m from -n to n in steps of 2",
            found="no such coefficient",
        )
    return name


_Coefficient = Annotated[float, between(-1000.0, 1000.0)]


class Zernike(BaseModel):
    """Wavefront error of an eye in Zernike polynomials, as the examiner sees it.

    Either ``coefficients_um`` gives single coefficients by name, or ``coefficients`` lists them
    in a stated order and unit.

    Attributes
    ----------
    diameter_mm : float
        Diameter of the pupil that the coefficients belong to, in mm.
    coefficients_um : mapping of str to float, or None
        Normalised OSA/ANSI Z80.28 coefficients in micrometres by their name ``"n,m"``.
    coefficients : list of float or None
        From the ordering's first term on.
    ordering : {"osa", "noll", "fringe"}
    unit : {"um", "waves"}
        Of ``coefficients``; waves are of ``wavelength_nm``.
    wavelength_nm : float or None
    extrapolate : bool
        Whether a pupil larger than ``diameter_mm`` is allowed: the polynomials are then continued
        beyond what was measured.
    """

    model_config = GIVEN

    diameter_mm: Annotated[float, between(0.1, 20.0)]
    ordering: Ordering | None = None
    unit: Unit | None = None
    wavelength_nm: Annotated[float, between(300.0, 1200.0)] | None = None
    coefficients: Annotated[tuple[_Coefficient, ...], FromList] | None = None
    coefficients_um: (
        Mapping[Annotated[str, AfterValidator(_coefficient_name)], _Coefficient] | None
    ) = Field(default=None, validate_default=True)
    extrapolate: bool = False

    @field_validator("coefficients", mode="after")
    @classmethod
    def _list_says_what_it_is(
        cls, coefficients: tuple[float, ...] | None, info: ValidationInfo
    ) -> tuple[float, ...] | None:
        if coefficients is None:
            return None
        given = info.data
        if given.get("ordering") is None:
            raise refusal('one of "osa", "noll", "fringe"', key=beside("ordering"), found="nothing")
        if given.get("unit") is None:
            raise refusal('one of "um", "waves"', key=beside("unit"), found="nothing")
        if given["unit"] == "waves" and given.get("wavelength_nm") is None:
            raise refusal(
                "the wavelength that the waves are of", key=beside("wavelength_nm"), found="nothing"
            )
        if not 1 <= len(coefficients) <= _LONGEST_LIST:
            raise refusal(
                f"1 to {_LONGEST_LIST} coefficients", found=f"a list of {len(coefficients)}"
            )
        _refuse_high_orders(given["ordering"], coefficients)
        return coefficients

    @field_validator("coefficients_um", mode="after")
    @classmethod
    def _one_way_of_giving(
        cls, names: Mapping[str, float] | None, info: ValidationInfo
    ) -> Mapping[str, float] | None:
        if "coefficients" not in info.data:
            return names  # it is wrong by itself, and said so
        listed = info.data["coefficients"] is not None
        if names is not None and listed:
            raise refusal(
                'one of them: names "n,m", or a list in one order',
                found='them beside "coefficients"',
            )
        if names is not None and info.data.get("ordering") not in (None, "osa"):
            raise refusal(
                'no ordering, or "osa": names "n,m" are that order\'s',
                key=beside("ordering"),
            )
        if names is None and not listed:
            raise refusal('coefficients by name such as { "3,-1" = 0.14 }, or a list')
        return names

    @property
    def terms(self) -> tuple[tuple[Term, float], ...]:
        """Pairs ((n, m), micrometres) of normalised OSA/ANSI terms, sorted by n, then m."""
        if self.coefficients is None:
            pairs = ((term_of(name), um) for name, um in (self.coefficients_um or {}).items())
            return tuple(sorted((nm, um) for nm, um in pairs if nm is not None))
        assert self.ordering is not None
        um = self.wavelength_nm / NM_PER_UM if self.wavelength_nm and self.unit == "waves" else 1.0
        listed = []
        for index, value in enumerate(self.coefficients, start=first_index(self.ordering)):
            term = listed_term(self.ordering, index)
            if value != 0.0:
                listed.append((term, value * um * normalised(self.ordering, term)))
        return tuple(sorted(listed))

    def __hash__(self) -> int:
        # The mapping itself has no hash, and rigs serve as keys of caches.
        return hash((self.diameter_mm, self.terms, self.extrapolate))


def _refuse_high_orders(ordering: Ordering, coefficients: tuple[float, ...]) -> None:
    for index, value in enumerate(coefficients, start=first_index(ordering)):
        if value != 0.0 and not is_term(*listed_term(ordering, index)):
            n, m = listed_term(ordering, index)
            raise refusal(
                f"terms up to order {ZERNIKE_ORDER_LIMIT}",
                found=f"{value:g} for term {index}, which is ({n}, {m})",
            )
