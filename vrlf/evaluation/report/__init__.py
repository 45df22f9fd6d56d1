"""A report of an evaluation as one HTML file that needs nothing else, and as JSON and CSV.

Data in, text out: nothing here computes a picture, draws a plot or touches a file, but for the
page's own template, style and script, which lie in ``assets/report``.

========== ==============================================================================
file       holds
========== ==============================================================================
model      ``Report`` and what it is made of
numbers    values by name: flat, for tables; nested, for JSON
parts      pieces of HTML: pictures, tables, scales
page       ``report_html``: the whole page
========== ==============================================================================
"""

from vrlf.evaluation.report.model import Eye, Map, Pair, Plot, Report, View
from vrlf.evaluation.report.numbers import columns_of, flat, results_csv, results_json, short_names
from vrlf.evaluation.report.page import report_html

__all__ = [
    "Eye",
    "Map",
    "Pair",
    "Plot",
    "Report",
    "View",
    "columns_of",
    "flat",
    "report_html",
    "results_csv",
    "results_json",
    "short_names",
]
