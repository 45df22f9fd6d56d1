"""What is given: the rig, meaning the panel, the headset, the array and the wearer's two eyes.

Everything here is frozen and checked on construction; what *follows* from it is
computed elsewhere. No numpy, no GPU.

================ ==================================================================
file             holds
================ ==================================================================
fields           configuration and field types that all tables share
eye              ``Eye`` and its ``Zernike`` wavefront
glasses          the catalogue of lens materials
lenslet          ``Lenslet``: its surfaces
hardware         ``Panel``, ``Headset``, ``Array`` and the headset lens's power
rig              ``Prefilter`` and the whole ``Rig``; checks between its tables
wording          how messages quote a value
prescription     a prescription as it is written on paper
complaints       a failed validation as lines of ``key: found ..., wanted ...``
shelf            the rigs that ship with vrlf
cardboard        Cardboard viewer profiles
cardboard_rig    the keys of a rig that they give
cardboard_source where a profile's bytes come from: an address, its text, a file
protobuf         the format that they are written in
overrides        ``table.key=value`` and the merging of tables
reading          rig files, ``extends``, command line changes -> ``Rig``
================ ==================================================================
"""

from __future__ import annotations

from vrlf.model.cardboard import FieldOfView, ViewerProfile, read_profile
from vrlf.model.cardboard_rig import headset_table, rig_text_of_profile, viewer_name
from vrlf.model.eye import Eye, Zernike
from vrlf.model.hardware import SUBPIXEL_LAYOUTS, Array, Headset, Panel, focal_mm, lens_power_d
from vrlf.model.lenslet import Lenslet
from vrlf.model.prescription import parse_prescription
from vrlf.model.reading import load_rig, rig_from_tables
from vrlf.model.rig import Prefilter, Rig, rig_json_schema
from vrlf.model.shelf import DEFAULT_RIG, rig_names, rig_summary

__all__ = [
    "DEFAULT_RIG",
    "SUBPIXEL_LAYOUTS",
    "Array",
    "Eye",
    "FieldOfView",
    "Headset",
    "Lenslet",
    "Panel",
    "Prefilter",
    "Rig",
    "ViewerProfile",
    "Zernike",
    "focal_mm",
    "headset_table",
    "lens_power_d",
    "load_rig",
    "parse_prescription",
    "read_profile",
    "rig_from_tables",
    "rig_json_schema",
    "rig_names",
    "rig_summary",
    "rig_text_of_profile",
    "viewer_name",
]
