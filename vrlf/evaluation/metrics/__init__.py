"""How like a picture is to what it should be: every metric under one name, and by itself.

``METRICS`` holds those that two pictures of equal size are enough for; ``vrlf compare`` knows
them all. ``score`` takes several at once and goes on where one cannot be had.

========== ==============================================================================
file       holds
========== ==============================================================================
model      ``Viewing``, ``Metric``, ``Score``, ``Scores``; what a pair of pictures must be
fidelity   RMSE, PSNR, SSIM: the only place of their formulas
flip       FLIP; the only flip_evaluator
cvvdp      ColorVideoVDP; the only pycvvdp and torch
visible    HDR-VDP-2, of ``evaluation.hdrvdp``
table      ``METRICS`` and ``score``
========== ==============================================================================
"""

from vrlf.evaluation.metrics.model import (
    Metric,
    MetricError,
    MissingExtraError,
    Score,
    Scores,
    Viewing,
)
from vrlf.evaluation.metrics.table import METRICS, score

__all__ = [
    "METRICS",
    "Metric",
    "MetricError",
    "MissingExtraError",
    "Score",
    "Scores",
    "Viewing",
    "score",
]
