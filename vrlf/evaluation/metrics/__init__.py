"""How like a picture is to what it should be: every metric under one name, and by itself.

``METRICS`` holds those that two pictures of equal size are enough for; ``vrlf compare`` knows
them all. ``score`` takes several at once and goes on where one cannot be had. Those that need an
eye to show something to stand outside: ``edge`` (an MTF) and ``letters`` (an acuity).

========== ==============================================================================
file       holds
========== ==============================================================================
model      ``Viewing``, ``Metric``, ``Score``, ``Scores``; what a pair of pictures must be
fidelity   RMSE, PSNR, SSIM: the only place of their formulas
flip       FLIP; the only flip_evaluator
cvvdp      ColorVideoVDP; the only pycvvdp and torch
visible    HDR-VDP-2, of ``evaluation.hdrvdp``
contrast   how much is left of it at each spatial frequency
colour     colour fringes, and how much light is left
edge       MTF from a slanted edge, ISO 12233
letters    the smallest line that stays legible, by an ideal observer
table      ``METRICS`` and ``score``
colours    a map as false colours
========== ==============================================================================
"""

from vrlf.evaluation.metrics.colours import false_colour
from vrlf.evaluation.metrics.model import (
    Metric,
    MetricError,
    MissingExtraError,
    Score,
    Scores,
    Viewing,
)
from vrlf.evaluation.metrics.table import METRICS, missing, score

__all__ = [
    "METRICS",
    "Metric",
    "MetricError",
    "MissingExtraError",
    "Score",
    "Scores",
    "Viewing",
    "false_colour",
    "missing",
    "score",
]
