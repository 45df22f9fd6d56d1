"""Which part of a picture a rectangle of a window shows, and how large.

Rasters run right and down from the upper left corner. A place is a pair of real numbers: pixel
(i, j) covers [i, i + 1) x [j, j + 1).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import floor

Box = tuple[int, int, int, int]  # first column, first row, width, height
Place = tuple[float, float]

# sRGB codes of what lies beside a picture, of a divider, and of what a picture fades to.
BACKGROUND_CODE, LINE_CODE, GREY_CODE = 30, 190, 118


@dataclass(frozen=True)
class Tile:
    """A rectangle of a window and what it shows.

    Attributes
    ----------
    window_px : Box
        Its place in the window.
    crop_px : Box
        The part of the picture that may be seen; beside it lies the background.
    start_px : (x, y)
        The place of the picture at the tile's upper left corner.
    scale : float
        Picture pixels per window pixel: up to 1 each pixel is shown whole and hard, above 1
        window pixels show the mean over their area.
    """

    window_px: Box
    crop_px: Box
    start_px: Place
    scale: float

    def place_of(self, window_place: Place) -> Place:
        """The place of the picture under a place of the window."""
        return (
            self.start_px[0] + (window_place[0] - self.window_px[0]) * self.scale,
            self.start_px[1] + (window_place[1] - self.window_px[1]) * self.scale,
        )

    def pixel_of(self, window_place: Place) -> tuple[int, int] | None:
        """The pixel of the picture there, None beside the crop or the tile."""
        if not inside(self.window_px, window_place):
            return None
        place = self.place_of(window_place)
        return (floor(place[0]), floor(place[1])) if inside(self.crop_px, place) else None


def inside(box: Box, place: Place) -> bool:
    """Whether a place lies in a box."""
    x, y, width, height = box
    return x <= place[0] < x + width and y <= place[1] < y + height


def fitting_zoom(window_px: Box, crop_px: Box) -> float:
    """Window pixels per picture pixel that show all of the crop: a whole number, or below 1."""
    zoom = min(window_px[2] / crop_px[2], window_px[3] / crop_px[3])
    return float(floor(zoom)) if zoom >= 1.0 else zoom


def tile_at(window_px: Box, crop_px: Box, zoom: float | None, middle: Place | None) -> Tile:
    """A tile that shows the crop.

    Parameters
    ----------
    window_px, crop_px : Box
        None of them empty.
    zoom : float or None
        Window pixels per picture pixel; None shows all of the crop.
    middle : (x, y) or None
        The place of the picture in the tile's middle; None is the crop's own middle. It is
        held so that the tile shows as much of the crop as it can.
    """
    shown = fitting_zoom(window_px, crop_px) if zoom is None else zoom
    scale = 1.0 / shown
    start = []
    for axis in (0, 1):
        first, length = crop_px[axis], crop_px[axis + 2]
        seen = window_px[axis + 2] * scale
        wanted = first + length / 2.0 if middle is None else middle[axis]
        start.append(_held(wanted - seen / 2.0, seen, first, length))
    tile = Tile(window_px, crop_px, (start[0], start[1]), scale)
    return _on_whole_pixels(tile) if shown >= 1.0 else tile


def _held(start: float, seen: float, first: float, length: float) -> float:
    """The start of an interval of ``seen`` that lies in the crop, or has the crop in its middle."""
    if seen >= length:
        return first + (length - seen) / 2.0
    return min(max(start, float(first)), first + length - seen)


def _on_whole_pixels(tile: Tile) -> Tile:
    """Moved by less than a window pixel, so that picture pixels begin where window pixels do."""
    zoom = 1.0 / tile.scale
    x, y = (floor(start * zoom + 0.5) / zoom for start in tile.start_px)
    return replace(tile, start_px=(x, y))
