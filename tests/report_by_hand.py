"""A report of invented numbers and pictures, for what it looks like and how it behaves."""

from __future__ import annotations

import numpy as np
from files_by_hand import png

from vrlf.evaluation.report import Eye, Map, Pair, Plot, Report, View

SOURCES = ('<b>odd & "quoted".png', "chart:grid")
METHODS = ("none", "forward", "optimal")
SVG = b'<svg xmlns="http://www.w3.org/2000/svg" width="8" height="4"><path d="M0 0h8v4z"/></svg>'


def grey(level: int) -> bytes:
    """A small PNG of one grey but for a light corner."""
    codes = np.full((24, 32, 3), level, np.uint8)
    codes[:6, :8] = 250
    return png(codes)


def view(method: str, place: int) -> View:
    """PSNR falls from eye to eye, so that no order is the table's own."""
    psnr = {"none": 12.5, "forward": 9.25, "optimal": 31.0}[method] - place
    return View(
        method=method,
        seen=grey(60 + 40 * METHODS.index(method)),
        panel=grey(30),
        values={
            "psnr_db": None if (method, place) == ("none", 0) else psnr,
            "ssim": psnr / 40.0,
            "hdr_vdp": {"q_mos": 2.0 * psnr, "q": -psnr},
            "contrast": {"0.5": 0.9, "10": 0.25},
            "gain": 1.0,
        },
        maps=(Map("flip", grey(0)),),
        notes=(f"{method}: a reason",),
    )


def report() -> Report:
    """Two sources before one rig."""
    pairs = tuple(
        Pair(
            source=source,
            rig="folder/rig.toml",
            throughput=0.25,
            facts="A panel.",
            eyes=tuple(
                Eye(side, "-5.00 D", 3, grey(120), tuple(view(m, 2 * n + k) for m in METHODS))
                for k, side in enumerate(("left", "right"))
            ),
        )
        for n, source in enumerate(SOURCES)
    )
    return Report(
        pairs=pairs,
        rays=64,
        rig_texts={"folder/rig.toml": '[panel]\nname = "</pre><script>"\n'},
        versions={"vrlf": "0", "gpu": "<none>"},
        plots=(Plot("PSNR", 'words "quoted"', SVG),),
        notes=("cvvdp_jod: found no pycvvdp",),
        failures=(
            {"source": SOURCES[1], "rig": "rig", "method": "optimal", "reason": "<i>no</i> room"},
        ),
    )
