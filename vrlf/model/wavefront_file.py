"""A wavefront's coefficients from a CSV file, as aberrometers' software exports them.

The first line says what the columns are, and so which order and unit is meant::

    n,m,um          osa,um          noll,waves      fringe,waves
    3,-1,0.14       7,0.14          7,0.252         8,0.71

Lines that begin with # are comments.
"""

from __future__ import annotations

import csv
from math import isfinite
from pathlib import Path
from typing import Any, Final

from vrlf.errors import RigError
from vrlf.model.shelf import label
from vrlf.model.toml_file import read_text
from vrlf.model.wording import quoted, shown
from vrlf.model.zernike import (
    ZERNIKE_ORDER_LIMIT,
    Ordering,
    Term,
    first_index,
    is_term,
    listed_term,
    normalised,
)
from vrlf.units import NM_PER_UM

_WANTED: Final = "a first line n,m,um, or osa, noll or fringe with um or waves: noll,waves"
_ORDERINGS: Final[dict[str, Ordering]] = {"osa": "osa", "noll": "noll", "fringe": "fringe"}
_MOST_LINES: Final = 1000


def wavefront_table(path: Path, wavelength_nm: Any) -> dict[str, float]:
    """Normalised OSA/ANSI coefficients in micrometres by their name "n,m".

    Parameters
    ----------
    path : Path
    wavelength_nm : float or None
        What waves are waves of.

    Raises
    ------
    RigError
        Naming the file and the line.
    """
    text = read_text(path, label(path), "CSV of Zernike coefficients")
    numbered = [
        (number, [cell.strip() for cell in next(csv.reader([line]), [])])
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if len(numbered) > _MOST_LINES:
        raise _wrong(path, None, f"{len(numbered)} lines", f"at most {_MOST_LINES}")
    if not numbered:
        raise _wrong(path, None, "nothing", _WANTED)
    columns = [cell.lower() for cell in numbered[0][1]]
    um = _unit_um(path, columns, wavelength_nm)
    table: dict[str, float] = {}
    for number, cells in numbered[1:]:
        term, factor = _term(path, number, columns, cells)
        name = f"{term[0]},{term[1]}"
        if name in table:
            raise _wrong(path, number, f"({name}) again", "each term once")
        table[name] = um * factor * _number(path, number, cells[-1])
    if not table:
        raise _wrong(path, None, "no coefficient", "at least one")
    return table


def _unit_um(path: Path, columns: list[str], wavelength_nm: Any) -> float:
    """Micrometres of the unit in which a file with these columns gives its coefficients."""
    ordered = columns[:-1] == ["n", "m"] or (len(columns) == 2 and columns[0] in _ORDERINGS)
    if not ordered or columns[-1] not in ("um", "waves"):
        raise _wrong(path, None, f"the first line {quoted(','.join(columns))}", _WANTED)
    if columns[-1] == "um":
        return 1.0
    if not isinstance(wavelength_nm, (int, float)) or isinstance(wavelength_nm, bool):
        raise _wrong(
            path, None, "coefficients in waves", "zernike.wavelength_nm beside zernike.file"
        )
    return wavelength_nm / NM_PER_UM


def _term(path: Path, number: int, columns: list[str], cells: list[str]) -> tuple[Term, float]:
    """The term that a line is about, and what makes its coefficient a normalised one."""
    if len(cells) != len(columns):
        raise _wrong(path, number, f"{len(cells)} values", f"{len(columns)}: {','.join(columns)}")
    index = [_whole(path, number, cell) for cell in cells[:-1]]
    if columns[0] == "n":
        n, m = index
        if not is_term(n, m):
            wanted = f"n from 0 to {ZERNIKE_ORDER_LIMIT}, m from -n to n in steps of 2"
            raise _wrong(path, number, f"the term ({n}, {m})", wanted)
        return (n, m), 1.0
    ordering = _ORDERINGS[columns[0]]
    # No number beyond this is a term of order 8 in any of them.
    if not first_index(ordering) <= index[0] <= 100 or not is_term(
        *listed_term(ordering, index[0])
    ):
        wanted = f"{ordering} terms from {first_index(ordering)} up to order {ZERNIKE_ORDER_LIMIT}"
        raise _wrong(path, number, f"the term {index[0]}", wanted)
    term = listed_term(ordering, index[0])
    return term, normalised(ordering, term)


def _whole(path: Path, number: int, cell: str) -> int:
    if not (cell.lstrip("+-").isdecimal() and len(cell) < 9):
        raise _wrong(path, number, shown(cell), "a whole number")
    return int(cell)


def _number(path: Path, number: int, cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = float("nan")
    if not isfinite(value):
        raise _wrong(path, number, shown(cell), "a number")
    return value


def _wrong(path: Path, number: int | None, found: str, wanted: str) -> RigError:
    where = f"line {number}: " if number is not None else ""
    return RigError(label(path), [f"{where}found {found}, wanted {wanted}"])
