"""Neural contrast sensitivity: what of the CSF is left to the brain.

Source: Mantiuk, Kim, Rempel & Heidrich 2011, section 3.3 (neural noise): the measured CSF is
this one times the eye's MTF and the peak sensitivity of the receptors, both of which the
response already holds. The parameters are those of release 2.2, at six luminances.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from vrlf.evaluation.hdrvdp.filtering import Plane

LUMINANCES_CD_M2: Final = (0.002, 0.02, 0.2, 2.0, 20.0, 150.0)
# One row a luminance: p1 to p4.
PARAMETERS: Final = (
    (0.991265, 3.74038, 0.50722, 4.46044),
    (0.800889, 3.54104, 0.682505, 4.94958),
    (0.476505, 4.37453, 0.750315, 5.28678),
    (0.405782, 4.40602, 0.935314, 5.61425),
    (0.334278, 3.79542, 1.07327, 6.4635),
    (0.394533, 2.7755, 1.16577, 7.45665),
)
LOG_LUMINANCES: Final = np.linspace(-5.0, 5.0, 256)


def neural_csf(rho: Plane | float, cd_m2: Plane | float) -> Plane:
    """Sensitivity at ``rho`` cycles per degree to an eye adapted to ``cd_m2``; they broadcast.

    p4 sqrt((1 - exp(-(rho / 7)^2))^p3 / (1 + (p1 rho)^p2)), 0 at rho = 0. The parameters run
    linearly over log luminance and stay as they are below 0.002 and above 150 cd/m2.
    """
    log_l, fitted = np.log10(cd_m2), np.log10(LUMINANCES_CD_M2)
    p1, p2, p3, p4 = (np.interp(log_l, fitted, column) for column in np.transpose(PARAMETERS))
    rho = np.asarray(rho, dtype=np.float64)
    low = (-np.expm1(-((rho / 7.0) ** 2))) ** p3
    return np.asarray(p4 * np.sqrt(low / (1.0 + (p1 * rho) ** p2)))


def sensitivity_map(rho: float, log_adaptation: Plane) -> Plane:
    """Sensitivity at ``rho`` for each pixel's log10 luminance, from a table of 256 points."""
    table = neural_csf(rho, 10.0**LOG_LUMINANCES)
    return np.interp(log_adaptation, LOG_LUMINANCES, table)
