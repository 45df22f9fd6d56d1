"""The steps of a frame: one class and one compute shader each, both eyes in one dispatch.

========== =====================================================================
file       holds
========== =====================================================================
fields     members that several uniform blocks share, and their values for a rig
prepare    ``Prepare``: each eye's picture fitted into its viewport
sharpen    ``Sharpen``: the target sharpened before the forward prefilter
forward    ``Forward``: the forward prefilter, by footprints and sample by sample
           (``forward_maps``: both eyes' inverse maps; ``forward_lists``: which pixels are
           done how; ``forward_plain``: as one would write it first, to be timed against)
perceive   ``Perceive``: what both eyes see of a panel image
rays       ``PerceiveTables``: perception's rays: points, lines, points of holes
bins       the blind rays that holes can pass, sorted by where they cross the mask
traced     ``PerceiveTraced``: the same ray by ray: diffraction, real lenslets
           (``traced_tables``: its points and tables)
operator   ``OperatorTables``: the perception operator and its adjoint, tabulated
tabulate   ``RowBuilder``: the operator's rows, traced a piece at a time
phases     rows of the operator by phase: how fine, turned about, packed
tolerant   rows of the normal equations of many rigs at once, each a little off
pixels     rows of single pixels: perpendicular walls, lateral colour, varying pitch
encode     ``Encode``: linear light to 8-bit sRGB
register   what ``Forward`` does to a bare panel: colours brought together
alignment  ``Alignment``: screens that show how array, panel and lenses stand
show       ``Show``: pictures as a window shows them
squares    ``Squares``: how far what is perceived is from the target, as sums
========== =====================================================================

A pass is split in two: the class owns the programs, and its *tables* own what follows from
one prescription. Tables are made once for a rig and swapped whole.
"""

from __future__ import annotations

from vrlf.passes.encode import Encode
from vrlf.passes.forward import Forward, ForwardTables, forward_tables
from vrlf.passes.perceive import Perceive
from vrlf.passes.prepare import EyePicture, Prepare
from vrlf.passes.rays import PerceiveTables
from vrlf.passes.sharpen import Sharpen, SharpenTables
from vrlf.passes.traced import PerceiveTraced
from vrlf.passes.traced_tables import TracedTables

__all__ = [
    "Encode",
    "EyePicture",
    "Forward",
    "ForwardTables",
    "Perceive",
    "PerceiveTables",
    "PerceiveTraced",
    "Prepare",
    "Sharpen",
    "SharpenTables",
    "TracedTables",
    "forward_tables",
]
