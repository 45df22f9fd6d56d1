"""Marks for tests of what a checkout may do without."""

from __future__ import annotations

import pytest

from vrlf.evaluation.metrics import missing

needs_cvvdp = pytest.mark.skipif(
    bool(missing(["cvvdp_jod"])),
    reason="found no cvvdp, wanted it for ColorVideoVDP; 'make test CVVDP=1' installs it",
)
