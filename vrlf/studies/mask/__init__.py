"""Drawings that a maker can work from: masks at true scale, tables of lenslets.

============= ==================================================================
file          holds
============= ==================================================================
plan          what is drawn, in millimetres of the panel's frame
vector        the plan as PDF and SVG
dxf           the plan as DXF, on layers; the only ezdxf
table         lenslets: centres and surfaces, as CSV
============= ==================================================================
"""
