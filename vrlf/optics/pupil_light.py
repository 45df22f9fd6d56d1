"""How wide a pupil is, and how much its parts count."""

from __future__ import annotations

import numpy as np

from vrlf.optics.polynomial import Float

# Stands in where a rig gives no age.
DEFAULT_AGE_YEARS = 30.0


def natural_pupil_mm(luminance_cd_m2: float, field_deg2: float, age_years: float | None) -> float:
    """Pupil diameter of both eyes adapted to a field of light.

    Parameters
    ----------
    luminance_cd_m2 : float
    field_deg2 : float
        Area of the field.
    age_years : float or None
        Taken as 20 below and 83 above, between which the formula holds; None is 30.

    Notes
    -----
    Watson & Yellott 2012, equation 21, the unified formula: Stanley & Davies 1995 for the
    reference age of 28.58 years, and an effect of age that is linear in it.
    """
    age = float(np.clip(DEFAULT_AGE_YEARS if age_years is None else age_years, 20.0, 83.0))
    flux: float = (luminance_cd_m2 * field_deg2 / 846.0) ** 0.41
    at_reference_mm = 7.75 - 5.75 * flux / (flux + 2.0)
    return at_reference_mm + (age - 28.58) * (0.02132 - 0.009562 * at_reference_mm)


def weighed_mm(even_mm: Float, pupil_mm: float, rho_per_mm2: float) -> Float:
    """Pupil points whose density is the Stiles-Crawford effect's, from evenly spread ones.

    Parameters
    ----------
    even_mm : ndarray (..., 2)
        From the centre of a pupil of diameter ``pupil_mm``.
    rho_per_mm2 : float
        Above 0: light that enters at r counts 10^(-rho r^2) (Stiles & Crawford 1933; Applegate
        & Lakshminarayanan 1993).

    Returns
    -------
    ndarray (..., 2), mm
        Moved inward, each standing for as much of what is seen as the next: the share of the
        light within r is (1 - 10^(-rho r^2)) / (1 - 10^(-rho R^2)), that of even points
        r^2 / R^2.
    """
    rate = np.log(10.0) * rho_per_mm2
    radius_mm = pupil_mm / 2.0
    lost = -np.expm1(-rate * radius_mm**2)
    share = np.sum(even_mm**2, axis=-1, keepdims=True) / radius_mm**2
    squared_mm2 = -np.log1p(-share * lost) / rate
    # At the centre both vanish; their quotient has a limit.
    limit = np.full_like(share, lost / (rate * radius_mm**2))
    ratio = np.divide(squared_mm2, share * radius_mm**2, out=limit, where=share > 1e-12)
    return np.asarray(even_mm * np.sqrt(ratio))
