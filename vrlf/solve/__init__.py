"""The optimal prefilter: operator, adjoint and projection put together.

========== ======================================================================
file       holds
========== ======================================================================
optimal    ``Optimal``: bounded least squares by accelerated projected gradient
memory     ``Memory``: what one stream's next frame starts from
tables     ``OptimalTables``: what the solver needs of one prescription
products   the tabulated operator and its adjoint, applied to pictures
spread     what is perceived of single points, measured
wiener     what sharpens a target before ``forward``, from the rig's own point spread
========== ======================================================================
"""

from __future__ import annotations

from vrlf.solve.memory import Memory
from vrlf.solve.optimal import Optimal
from vrlf.solve.products import Products
from vrlf.solve.tables import OptimalTables, TableBuilder

__all__ = ["Memory", "Optimal", "OptimalTables", "Products", "TableBuilder"]
