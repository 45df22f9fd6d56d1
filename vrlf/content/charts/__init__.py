"""Test charts, drawn by the program at the panel's exact pixels, in linear light.

======================  =====================================================
``model.py``            what a chart is made from and what it is: Viewport, Chart
``draw.py``             ``draw_chart``: checks what is asked for, picks the chart
``shapes.py``           plane shapes as functions: discs, polygons, their unions
``raster.py``           paints shapes and rectangles by the area they cover
``letters.py``          the Sloan letters and a few signs, as shapes
``digits.py``           a 5 x 7 bitmap of the digits, for labels
``logmar.py``           lines of Sloan letters, as on the ETDRS chart
``usaf1951.py``         three-bar targets, six elements an octave
``siemens.py``          the star of 36 cycles
``grid.py``             lines a degree apart, a centre cross, a circle
``points.py``           single pixels: white, red, green, blue
``marks.py``            which eye, which way up, which corner
======================  =====================================================

A chart knows one viewport (the half panel that one eye sees) and how many of its
pixels make a degree; it needs no font, no file and no GPU.
"""

from __future__ import annotations

from vrlf.content.charts.draw import CHART_NAMES, draw_chart
from vrlf.content.charts.model import Chart, Eye, LetterLine

__all__ = ["CHART_NAMES", "Chart", "Eye", "LetterLine", "draw_chart"]
