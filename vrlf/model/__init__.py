"""What is given: the rig, meaning the panel, the headset, the array and the wearer's two eyes.

Everything here is frozen and checked on construction; what *follows* from it is
computed elsewhere. No numpy, no GPU.

================ ==================================================================
file             holds
================ ==================================================================
fields           configuration and field types that all tables share
zernike          a measured ``Zernike`` wavefront; OSA, Noll's and Fringe order
eye              ``Eye``, or a ``Camera`` in its place
toml_file        TOML files read with one line for what is wrong
layouts          sub-pixel layouts, files of ``assets/layouts``
glasses          the catalogue of lens materials
catalogue        lenslet arrays and spacers on sale
searching        within which limits ``vrlf design`` searches
lenslet          ``Lenslet``: its surfaces
hardware         ``Panel``, ``Headset``, ``Array`` and the headset lens's power
tolerance        what a panel image is to put up with: pupils, focus, an array put off
rig              ``Prefilter`` and the whole ``Rig``; checks between its tables
wording          how messages quote a value
prescription     a prescription as it is written on paper
complaints       a failed validation as lines of ``key: found ..., wanted ...``
shelf            the rigs, eyes and panels that ship with vrlf
wavefront_file   a wavefront's coefficients from a CSV file
cardboard        Cardboard viewer profiles
cardboard_rig    the keys of a rig that they give
cardboard_source where a profile's bytes come from: an address, its text, a file
protobuf         the format that they are written in
parts            tables that lean on other files: ``extends`` in an eye, a wavefront's file
overrides        ``table.key=value`` and the merging of tables
sweep            ``SweepSpec``: which rigs, keys, sources and methods a sweep tries
reading          rig files, ``extends``, command line changes -> ``Rig``
================ ==================================================================
"""

from __future__ import annotations

from vrlf.model.cardboard import FieldOfView, ViewerProfile, read_profile
from vrlf.model.cardboard_rig import headset_table, rig_text_of_profile, viewer_name
from vrlf.model.eye import Camera, Eye
from vrlf.model.hardware import (
    LEAST_PITCH,
    MOST_PITCH,
    Array,
    Headset,
    Panel,
    Primaries,
    focal_mm,
    lens_power_d,
)
from vrlf.model.layouts import SubpixelLayout, layout_names, subpixel_layout
from vrlf.model.lenslet import Lenslet
from vrlf.model.prescription import parse_prescription, prescription_text
from vrlf.model.reading import load_rig, rig_from_tables
from vrlf.model.rig import Prefilter, Rig, rig_json_schema
from vrlf.model.shelf import DEFAULT_RIG, rig_names, rig_summary
from vrlf.model.tolerance import PupilPlace, Tolerance
from vrlf.model.zernike import Zernike

__all__ = [
    "DEFAULT_RIG",
    "LEAST_PITCH",
    "MOST_PITCH",
    "Array",
    "Camera",
    "Eye",
    "FieldOfView",
    "Headset",
    "Lenslet",
    "Panel",
    "Prefilter",
    "Primaries",
    "PupilPlace",
    "Rig",
    "SubpixelLayout",
    "Tolerance",
    "ViewerProfile",
    "Zernike",
    "focal_mm",
    "headset_table",
    "layout_names",
    "lens_power_d",
    "load_rig",
    "parse_prescription",
    "prescription_text",
    "read_profile",
    "rig_from_tables",
    "rig_json_schema",
    "rig_names",
    "rig_summary",
    "rig_text_of_profile",
    "subpixel_layout",
    "viewer_name",
]
