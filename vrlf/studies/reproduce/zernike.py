"""Fig. 3.4: the Zernike polynomials up to the 6th order."""

from __future__ import annotations

from typing import Final

import numpy as np

from vrlf.model import Eye, Zernike
from vrlf.optics import polynomial
from vrlf.optics.eye import refraction_matrix_d
from vrlf.optics.pupil import disc_mean
from vrlf.optics.refraction import sphero_cylinder
from vrlf.optics.wavefront import zernike_polynomial
from vrlf.studies.reproduce.drawing import blank_figure, figure_png
from vrlf.studies.reproduce.item import Item, Number, Picture, Workbench

ORDER: Final = 6
_POINTS: Final = 101
_NAMES: Final = {
    (2, -2): "astigmatism, oblique",
    (2, 0): "defocus",
    (2, 2): "astigmatism",
    (3, -3): "trefoil",
    (3, -1): "coma, vertical",
    (3, 1): "coma, horizontal",
    (3, 3): "trefoil",
    (4, 0): "spherical aberration",
}
TERMS: Final = tuple((n, m) for n in range(ORDER + 1) for m in range(-n, n + 1, 2))


def orthonormality_error() -> float:
    """The largest |<Z_i Z_j> - (i = j)| of all pairs, exact means over the disc."""
    found = [zernike_polynomial(*term) for term in TERMS]
    worst = 0.0
    for i, a in enumerate(found):
        for j, b in enumerate(found[: i + 1]):
            mean = disc_mean(polynomial.multiply(a, b), 2.0)
            worst = max(worst, abs(mean - (i == j)))
    return worst


def astigmatism_axis_deg(term: str) -> float:
    """The axis of the minus cylinder that a second-order term is, TABO."""
    zernike = Zernike(diameter_mm=5.0, coefficients_um={term: 0.5})
    eye = Eye(pupil_mm=5.0, vertex_mm=0.0, zernike=zernike)
    return sphero_cylinder(refraction_matrix_d(eye)).axis_deg


def make(bench: Workbench) -> Item:  # noqa: ARG001  every item is made with one
    """The item."""
    apart = (astigmatism_axis_deg("2,-2") - astigmatism_axis_deg("2,2")) % 90.0
    spherical = _order_of_spherical()
    numbers = (
        Number("polynomials up to the 6th order", "", len(TERMS), 28, "(n + 1)(n + 2) / 2, n = 6."),
        Number(
            "largest error of orthonormality",
            "",
            orthonormality_error(),
            None,
            "Exact means over the disc of all 406 products; what is left is rounding.",
        ),
        Number(
            "radial order of primary spherical aberration",
            "",
            spherical,
            6,
            "The lowest round term beyond defocus is Z(4,0); Z(6,0) is the secondary one.",
        ),
        Number(
            "angle between the axes of Z(2,-2) and Z(2,2)",
            "deg",
            apart,
            90.0,
            "Crossed cylinders repeat after 90 degrees: turned by 90 one is its own negative.",
        ),
    )
    return Item(
        "fig-3-4",
        "Fig. 3.4: Zernike polynomials up to the 6th order",
        "Terms up to the 6th order describe an eye: Z(2,0) defocus, Z(2,-2) and Z(2,2) astigmatism "
        "with axes 90 degrees apart, Z(3,-1) and Z(3,1) coma, Z(6,0) spherical aberration.",
        "The same 28 terms, orthonormal to rounding. Two slips: primary spherical aberration is "
        "Z(4,0), and the axes of the two astigmatisms stand 45 degrees apart.",
        numbers,
        (Picture("fig-3-4.png", "As the examiner sees them (ANSI Z80.28).", _draw()),),
    )


def _order_of_spherical() -> int:
    """The lowest order above 2 whose polynomial does not change when turned."""
    return next(n for n, m in TERMS if n > 2 and m == 0)


def _draw() -> bytes:
    figure = blank_figure(12.0, 11.5)
    grid = figure.add_gridspec(ORDER + 1, 2 * (ORDER + 1))
    at = np.linspace(-1.0, 1.0, _POINTS)
    inside = np.hypot(at[None, :], at[:, None]) <= 1.0
    for n, m in TERMS:
        left = ORDER + m
        axes = figure.add_subplot(grid[n, left : left + 2])
        height = polynomial.on_grid(zernike_polynomial(n, m), at, at)
        most = max(2.0, float(np.abs(height[inside]).max()))
        axes.imshow(
            np.where(inside, height, np.nan), origin="lower", cmap="RdBu_r", vmin=-most, vmax=most
        )
        axes.set_axis_off()
        name = _NAMES.get((n, m), "")
        axes.set_title(f"Z({n},{m})" + (f"\n{name}" if name else ""), fontsize=8)
    figure.suptitle(
        "Zernike polynomials, order 0 to 6: blue below 0, red above, each to its largest"
    )
    return figure_png(figure)
