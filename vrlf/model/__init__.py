"""What is given: the rig, meaning the panel, the headset, the array and the wearer's two eyes.

Everything here is frozen and checked on construction; what *follows* from it is
computed elsewhere. No numpy, no GPU.

============== ==================================================================
file           holds
============== ==================================================================
fields         configuration and field types that all tables share
zernike        a measured ``Zernike`` wavefront; OSA, Noll's and Fringe order
eye            ``Eye``, or a ``Camera`` in its place
toml_file      TOML files read with one line for what is wrong
layouts        sub-pixel layouts, files of ``assets/layouts``
hardware       ``Panel``, ``Headset``, ``Array`` and the headset lens's power
rig            ``Prefilter`` and the whole ``Rig``; checks between its tables
wording        how messages quote a value
prescription   a prescription as it is written on paper
complaints     a failed validation as lines of ``key: found ..., wanted ...``
shelf          the rigs, eyes and panels that ship with vrlf
wavefront_file a wavefront's coefficients from a CSV file
parts          tables that lean on other files: ``extends`` in an eye, a wavefront's file
overrides      ``table.key=value`` and the merging of tables
reading        rig files, ``extends``, command line changes -> ``Rig``
============== ==================================================================
"""

from __future__ import annotations

from vrlf.model.eye import Camera, Eye
from vrlf.model.hardware import (
    LEAST_PITCH,
    MOST_PITCH,
    Array,
    Headset,
    Panel,
    Primaries,
    lens_power_d,
)
from vrlf.model.layouts import SubpixelLayout, layout_names, subpixel_layout
from vrlf.model.prescription import parse_prescription, prescription_text
from vrlf.model.reading import load_rig, rig_from_tables
from vrlf.model.rig import Prefilter, Rig, rig_json_schema
from vrlf.model.shelf import DEFAULT_RIG, rig_names, rig_summary
from vrlf.model.zernike import Zernike

__all__ = [
    "DEFAULT_RIG",
    "LEAST_PITCH",
    "MOST_PITCH",
    "Array",
    "Camera",
    "Eye",
    "Headset",
    "Panel",
    "Prefilter",
    "Primaries",
    "Rig",
    "SubpixelLayout",
    "Zernike",
    "layout_names",
    "lens_power_d",
    "load_rig",
    "parse_prescription",
    "prescription_text",
    "rig_from_tables",
    "rig_json_schema",
    "rig_names",
    "rig_summary",
    "subpixel_layout",
]
