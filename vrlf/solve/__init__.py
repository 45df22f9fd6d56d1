"""The optimal prefilter: operator, adjoint and projection put together.

========== ======================================================================
file       holds
========== ======================================================================
optimal    ``Optimal``: bounded least squares by accelerated projected gradient
========== ======================================================================
"""

from __future__ import annotations

from vrlf.solve.optimal import Optimal, OptimalTables

__all__ = ["Optimal", "OptimalTables"]
