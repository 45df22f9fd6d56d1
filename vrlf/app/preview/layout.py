"""Where in the window which view stands."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

from vrlf.app.preview.session import COMPARISONS, Session, View
from vrlf.model import Rig
from vrlf.optics.tile import Box, Place, Tile, tile_at
from vrlf.optics.viewport import viewport

# What is computed, of which views are made.
PICTURES = ("panel", "perceived", "uncorrected", "target")
_WALL: tuple[View, ...] = ("target", "panel", "difference", "uncorrected", "perceived")
_GUTTER_PX = 6
_LOUPE_PX, _LOUPE_ZOOM = 288, 24.0


@dataclass(frozen=True)
class Placed:
    """A tile and the pictures in it.

    Attributes
    ----------
    view : View
    tile : Tile
    first, second : str
        Of ``PICTURES``; ``second`` is None where one picture is shown alone.
    divider_px : int or None
        Window column of the divider; None with a ``second`` shows the difference.
    """

    view: View
    tile: Tile
    first: str
    second: str | None = None
    divider_px: int | None = None
    has_subpixels: bool = False


def placed(session: Session, window_px: tuple[int, int]) -> tuple[Placed, ...]:
    """Every tile of the window, the wall's side by side."""
    if min(window_px) < 1:
        return ()
    whole: Box = (0, 0, *window_px)
    if session.view != "wall":
        return (_single(session, session.view, whole),)
    columns = 3 if window_px[0] >= window_px[1] else 2
    rows = ceil(len(_WALL) / columns)
    boxes = [_cell(window_px, k % columns, columns, k // columns, rows) for k in range(len(_WALL))]
    return tuple(
        _single(session, view, box)
        for view, box in zip(_WALL, boxes, strict=True)
        if min(box[2:]) > 0
    )


def needed(tiles: tuple[Placed, ...]) -> frozenset[str]:
    """The pictures that the tiles show."""
    return frozenset(name for each in tiles for name in (each.first, each.second) if name)


def _cell(window_px: tuple[int, int], column: int, columns: int, row: int, rows: int) -> Box:
    width, height = (
        (length - _GUTTER_PX * (count - 1)) // count
        for length, count in zip(window_px, (columns, rows), strict=True)
    )
    return column * (width + _GUTTER_PX), row * (height + _GUTTER_PX), width, height


def _single(session: Session, view: View, box: Box) -> Placed:
    tile = tile_at(box, crop_of(session), session.zoom, session.middle)
    if view == "compare":
        first, second = COMPARISONS[session.comparison]
        divider = box[0] + round(session.divider * box[2])
        return Placed(view, tile, first, second, divider)
    if view == "difference":
        return Placed(view, tile, "perceived", "target")
    return Placed(view, tile, view)


def crop_of(session: Session) -> Box:
    """The part of the panel's raster that belongs to the eyes that are shown."""
    return eyes_box(session.rig, session.eyes)


def eyes_box(rig: Rig, eyes: str) -> Box:
    """The panel, or one eye's viewport of it."""
    if eyes == "both":
        return 0, 0, rig.panel.width_px, rig.panel.height_px
    view = viewport(rig, "left" if eyes == "left" else "right")
    return view.first_column, 0, view.width_px, view.height_px


def tile_under(tiles: tuple[Placed, ...], place: Place) -> Placed | None:
    """The tile under a place of the window."""
    for each in tiles:
        x, y, width, height = each.tile.window_px
        if x <= place[0] < x + width and y <= place[1] < y + height:
            return each
    return None


def loupe(under: Placed, place: Place, window_px: tuple[int, int]) -> Placed | None:
    """An enlarged piece about the cursor; the panel's with its sub-pixels."""
    pixel = under.tile.pixel_of(place)
    if pixel is None:
        return None
    side = min(_LOUPE_PX, *window_px)
    left, top = (
        min(max(round(at) - side // 2, 0), length - side)
        for at, length in zip(place, window_px, strict=True)
    )
    middle = (pixel[0] + 0.5, pixel[1] + 0.5)
    start = tuple(at - side / 2.0 / _LOUPE_ZOOM for at in middle)
    tile = Tile((left, top, side, side), under.tile.crop_px, (start[0], start[1]), 1 / _LOUPE_ZOOM)
    first = under.first
    if under.divider_px is not None and under.second and place[0] >= under.divider_px:
        first = under.second
    second = under.second if under.divider_px is None else None
    return Placed(under.view, tile, first, second, None, first == "panel" and second is None)
