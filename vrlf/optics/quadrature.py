"""Perception's rays without waste: lines through lenslets, points under holes.

A retinal pixel's light is a mean over four coordinates, the place u in the pupil and the
place w in the pixel. Blind points spread over all four spend most of their number on what is
known beforehand: which cell a ray passes, where a pixel or a stripe ends, that a mask is dark.

Behind lenslets a line through (u, w) is cut exactly by the cells' borders and by the panel's
pixels. Each *piece* shows one pixel through one lenslet and weighs what it is long; that is
what a line costs: a ray for each piece. All lines lie along one direction, so that only the
line's offset and place in the pixel are left to sample. On its way through the pupil a line
also crosses the pixel from left to right, because stripes do.

Behind holes the open area of each hole that the pupil's image reaches gets its own points;
a point counts if the pupil point that it comes from lies in the pupil. Where the map from
pupil to array is not affine, or turns the pupil into less than a hole or into very many
cells, blind points serve (``vrlf/optics/samples.py``), searched in bins.

Measured: RMS error (of what is seen at ``auto`` exposure, times 10^4) on a photograph and on
white noise, both eyes, 120 x 60 pixels. Each is held against the other's converged picture:
16,384 rays of this, 32,768 to 65,536 of blind sampling let through, which are 5e-4 to 8e-4
apart behind striped lenslets (2e-4 behind full ones) and 2e-2 times a hole's throughput
behind holes. Every visited ray counts, blocked or missing the pupil too; the last rows hold
matched-microlens with -5/-2x35 and -3.5/-1.5x120.

===================  ===========  =============  ===========  =============
rig                  blind rays   error          rays here    error
===================  ===========  =============  ===========  =============
pinhole              1730         862, 1043      147          529, 754
pinhole              6922         395, 472       590          230, 330
pinhole              27,688       151, 192       2360         130, 172
matched-microlens    256          155, 188       85           115, 195
matched-microlens    1024         60, 74         341          44, 66
matched-microlens    4096         25, 31         1365         14, 21
matched-full         256          27, 64         85           24, 100
matched-full         1024         13, 26         341          7, 31
matched-full         4096         4.5, 10        1365         2.2, 7.5
thesis-minus-5d      256          301, 374       85           99, 206
thesis-minus-5d      1024         97, 125        341          40, 87
thesis-minus-5d      4096         25, 37         1365         13, 27
oblique astigmatic   256          156, 190       85           146, 209
oblique astigmatic   1024         63, 77         341          51, 75
oblique astigmatic   4096         27, 34         1365         18, 25
===================  ===========  =============  ===========  =============

So a third of blind rays serves on photographs, a seventh with the thesis's array, from some 250
rays on; with fewer, that is some twenty lines, it takes 1/2.5 on some pictures (the astigmatic
rig, ``matched-full``). On noise ``matched-full`` takes half of 1024 blind rays, less than a
third of 4096. thesis-minus-5d never visits fewer than eight lines, some 110 rays.
"""

from __future__ import annotations

from typing import Literal

from vrlf.model import Rig
from vrlf.optics.eye import eye_optics
from vrlf.optics.holes import suits_holes
from vrlf.optics.lattice import lattice_of
from vrlf.optics.viewport import SIDES, Side

Quadrature = Literal["points", "lines", "holes"]


def quadrature_of(rig: Rig, rays: int) -> Quadrature:
    """Which of the three serves a rig at this number of rays."""
    lattice = lattice_of(rig)
    if lattice is None:
        return "points"
    if lattice.kind == "microlens":
        return "lines"
    eyes = [eye_optics(rig, side) for side in SIDES]
    by_hole = all(
        suits_holes(rig, lattice, optics, colour, rays) for optics in eyes for colour in range(3)
    )
    return "holes" if by_hole else "points"


def colours_of(rig: Rig, side: Side) -> range:
    """The colours whose rays an eye tells apart: the first for all, or three."""
    return range(3 if eye_optics(rig, side).is_chromatic else 1)
