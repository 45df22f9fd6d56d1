"""Constants and conversions, each with its unit in the name and its source beside it."""

from __future__ import annotations

from math import pi
from typing import Final

MM_PER_M: Final = 1000.0
UM_PER_MM: Final = 1000.0
MM2_PER_CM2: Final = 100.0
NM_PER_UM: Final = 1000.0
NM_PER_MM: Final = 1.0e6

# Slopes count as angles in radians: so does ``pixels_per_degree``.
DEGREES_PER_SLOPE: Final = 180.0 / pi
ARCMIN_PER_DEGREE: Final = 60.0
ARCMIN_PER_SLOPE: Final = ARCMIN_PER_DEGREE * DEGREES_PER_SLOPE

# A prism of one prism dioptre displaces by 1 cm at 1 m (Prentice 1890).
SLOPE_PER_PRISM_DIOPTRE: Final = 0.01

# Fraunhofer's D line, the wavelength at which prescriptions are meant.
REFERENCE_WAVELENGTH_NM: Final = 589.0
