"""Refractive indices of lens materials, and how the power of a thin lens follows them.

A thin lens has the power (n - 1) times what its two surfaces' curvatures make of it, whatever
the wavelength; so F(lambda) = F (n(lambda) - 1) / (n(589 nm) - 1), F the power at 589 nm, where
prescriptions are meant.
"""

from __future__ import annotations

from vrlf.errors import InputError
from vrlf.model.glasses import glasses
from vrlf.model.lenslet import DESIGN_WAVELENGTH_NM
from vrlf.units import NM_PER_UM, REFERENCE_WAVELENGTH_NM

# Fraunhofer's lines of the Abbe number: helium's d, hydrogen's F and C.
D_LINE_NM, F_LINE_NM, C_LINE_NM = DESIGN_WAVELENGTH_NM, 486.13, 656.28


def index_at(name: str, wavelength_nm: float) -> float:
    """The refractive index of a catalogued material in air.

    Raises
    ------
    InputError
        If there is no such material, or it was not measured there.
    """
    glass = glasses().get(name)
    if glass is None:
        raise InputError(f"glass: found {name!r}, wanted one of {', '.join(glasses())}")
    wavelength_um = wavelength_nm / NM_PER_UM
    low, high = glass.range_um
    if not low <= wavelength_um <= high:
        raise InputError(
            f"glass: found {wavelength_nm:g} nm for {name}, wanted {NM_PER_UM * low:g} to "
            f"{NM_PER_UM * high:g} nm, where its index is known"
        )
    return glass.index(wavelength_um)


def abbe_number(name: str) -> float:
    """(n_d - 1) / (n_F - n_C): the larger, the less the colours are told apart."""
    at_d, at_f, at_c = (index_at(name, nm) for nm in (D_LINE_NM, F_LINE_NM, C_LINE_NM))
    return (at_d - 1.0) / (at_f - at_c)


def relative_power(name: str, wavelength_nm: float) -> float:
    """Power of a thin lens of this material, over its power at 589 nm."""
    return (index_at(name, wavelength_nm) - 1.0) / (index_at(name, REFERENCE_WAVELENGTH_NM) - 1.0)


def cauchy_index(index: float, abbe: float | None, wavelength_nm: float) -> float:
    """The index at a wavelength of a material of which n_d and the Abbe number V are known.

    Cauchy 1836, two terms: n = A + B / lambda^2, through n_d and with n_F - n_C = (n_d - 1) / V.
    Between F and C that is right to about 0.0005 for glasses; without V there is no dispersion.
    """
    if abbe is None:
        return index
    spread = (index - 1.0) / abbe / (F_LINE_NM**-2 - C_LINE_NM**-2)
    return index + spread * (wavelength_nm**-2 - D_LINE_NM**-2)
