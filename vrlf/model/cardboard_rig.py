"""The keys of a rig that a viewer profile gives."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import tomlkit

from vrlf.model.cardboard import ViewerProfile, read_profile, refused
from vrlf.model.wording import quoted, shown
from vrlf.units import UM_PER_MM

# Limits far beyond a rig's own: what is no length of a panel must not be reckoned with.
_UNTHINKABLE: Final = 1_000_000


def lens_height_mm(profile: ViewerProfile, panel_height_mm: float, bezel_mm: float = 0.0) -> float:
    """Height of the lenses' axes above the panel's middle.

    Parameters
    ----------
    bezel_mm : float
        From the edge that the phone rests on to where its panel begins.
    """
    if profile.tray_to_lens_mm is None:
        return 0.0
    above_edge_mm = profile.tray_to_lens_mm - bezel_mm - panel_height_mm / 2.0
    # Rounded: the lengths are floats of single precision.
    return round(above_edge_mm if profile.vertical_alignment == "bottom" else -above_edge_mm, 6)


def headset_table(
    profile: ViewerProfile, panel_height_mm: float, bezel_mm: float = 0.0
) -> dict[str, Any]:
    """The keys of a rig's [headset] table that a profile gives."""
    return {
        "lens_to_panel_mm": profile.screen_to_lens_mm,
        "lens_separation_mm": profile.inter_lens_mm,
        "lens_height_mm": lens_height_mm(profile, panel_height_mm, bezel_mm),
        "distortion": list(profile.distortion),
    }


def with_profile(
    tables: Mapping[str, Any], panel: Mapping[str, Any], folder: Path
) -> Mapping[str, Any]:
    """A rig's tables with the keys that ``headset.profile`` stands for in its place.

    Keys that the same tables give themselves win.

    Parameters
    ----------
    tables : mapping
        As TOML yields them, of one file.
    panel : mapping
        The whole rig's [panel].
    folder : Path
        Where that file lies.

    Raises
    ------
    InputError
    """
    headset = tables.get("headset")
    if not isinstance(headset, Mapping) or "profile" not in headset:
        return tables
    source = headset["profile"]
    if not isinstance(source, str):
        raise refused(shown(source), "an address or a path in quotes")
    given = headset_table(read_profile(source, folder), _panel_height_mm(panel))
    own = {key: value for key, value in headset.items() if key != "profile"}
    return {**tables, "headset": {**given, **own}}


def _panel_height_mm(panel: Mapping[str, Any]) -> float:
    """0 for a panel that is none: the rig's own check complains of it."""
    rows, pitch_um = panel.get("height_px"), panel.get("pixel_pitch_um")
    if not isinstance(rows, int) or not isinstance(pitch_um, int | float):
        return 0.0
    is_sane = 0 < rows < _UNTHINKABLE and 0.0 < pitch_um < _UNTHINKABLE
    return rows * pitch_um / UM_PER_MM if is_sane else 0.0


def viewer_name(profile: ViewerProfile) -> str:
    """Vendor and model in quotes, as it can be printed; nothing in it acts on a screen."""
    name = " ".join(f"{profile.vendor} {profile.model}".split())
    return quoted(name) if name else "a nameless viewer"


def rig_text_of_profile(profile: ViewerProfile, headset: dict[str, Any], extends: str) -> str:
    """A rig file that changes another's headset to the profile's."""
    document = tomlkit.document()
    document.add(tomlkit.comment(f"The headset of {viewer_name(profile)}, from its profile."))
    document.add("extends", tomlkit.item(extends))
    table = tomlkit.table()
    for key, value in headset.items():
        table.add(key, value)
    document.add("headset", table)
    return tomlkit.dumps(document)
