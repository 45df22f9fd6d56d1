"""HDR-VDP-2.2: which differences of two pictures an eye sees, and how much they spoil.

========== ==========================================================
file       holds
========== ==========================================================
filtering  gains over visual frequency, resizing from band to band
eye        optics, receptors, response in just noticeable differences
taps       the pyramid's filters
pyramid    the steerable pyramid: taking apart and putting together
csf        neural contrast sensitivity
masking    differences among what masks them
pooling    maps of visibility, quality
metric     the order of the stages, ``hdr_vdp``
========== ==========================================================

Mantiuk, Kim, Rempel & Heidrich 2011, "HDR-VDP-2: A calibrated visual metric for visibility and
quality predictions in all luminance conditions", ACM Trans. Graph. 30(4), with the calibration
of release 2.2: Narwaria, Mantiuk, Perreira Da Silva & Le Callet 2015, "HDR-VDP-2.2: A calibrated
method for objective quality prediction of high-dynamic range and standard images", J. Electron.
Imaging 24(1). Each file says where the release differs from the paper. Float64 throughout.
"""

from __future__ import annotations

from vrlf.evaluation.hdrvdp.metric import HdrVdp, hdr_vdp

__all__ = ["HdrVdp", "hdr_vdp"]
