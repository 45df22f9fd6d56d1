"""Pictures as a window shows them: zoomed, cropped, compared, encoded."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

from vrlf.gpu import Block, Buffer, ComputeVariants, Device, Field, Texture
from vrlf.model import Rig
from vrlf.optics.tile import BACKGROUND_CODE, GREY_CODE, LINE_CODE, Tile
from vrlf.passes.encode import threshold_table
from vrlf.passes.fields import (
    SUBPIXEL_FIELDS,
    VIEWPORT_FIELDS,
    subpixel_defines,
    subpixel_values,
    viewport_values,
)

SHOW = Block(
    "Show",
    (
        *VIEWPORT_FIELDS,
        *SUBPIXEL_FIELDS,
        Field("ivec4", "window_box", "column, row, width and height of the tile in the window"),
        Field("ivec4", "crop_box", "the same of what may be seen of the picture"),
        Field("vec2", "start_px", "place of the picture at the tile's upper left corner"),
        Field("float", "px_per_window_px", "picture pixels per window pixel"),
        Field("float", "fade", "0 the picture, 1 grey"),
        Field("ivec2", "strides", "pixels from one that is computed to the next, of each picture"),
        Field("int", "divider", "window column from which on the second picture is shown"),
    ),
)
_NO_DIVIDER = 1 << 30
_CODES = {"BACKGROUND": BACKGROUND_CODE, "LINE": LINE_CODE, "GREY": GREY_CODE}


@dataclass(frozen=True)
class Shown:
    """A picture on the panel's raster, and how much of it is there yet.

    Attributes
    ----------
    light : Texture
    stride : int
        Of the grid of pixels, in each viewport, that are there, a power of two; the others take
        the nearest.
    """

    light: Texture
    stride: int = 1


class Show:
    """Owns the programs, one for each way to show that was met, and the table of thresholds."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._programs = ComputeVariants(device, "show.comp", SHOW)
        self._thresholds = Buffer(device, threshold_table(), label="sRGB thresholds")

    def run(
        self,
        rig: Rig,
        tile: Tile,
        first: Shown,
        canvas: Texture,
        *,
        second: Shown | None = None,
        divider_px: int | None = None,
        subpixels: bool = False,
        fade: float = 0.0,
    ) -> None:
        """Draw a tile into ``canvas`` (kind f1, the window's size; row 0 is the *lowest*).

        Parameters
        ----------
        second : Shown, optional
            With ``divider_px``: what is shown from that window column on. Without it: the
            difference between the two is shown.
        subpixels : bool
            Whether enlarged pixels show their colours where the panel emits them.
        fade : float
            From 0, the picture, to 1, grey.
        """
        other = first if second is None else second
        first.light.bind_sampler(0)
        other.light.bind_sampler(1)
        canvas.bind_image(0, read=False, write=True)
        self._thresholds.bind(0)
        is_whole = max(first.stride, other.stride) == 1
        # What is coarse anyway is not averaged where it is shrunk.
        taps = ceil(tile.scale) + 1 if tile.scale > 1.0 and is_whole else 1
        pictures = 1 if second is None else 2 if divider_px is not None else 3
        program = self._programs.get(
            {
                **_CODES,
                "PICTURES": pictures,
                "TAPS": taps,
                "GRIDS": int(not is_whole),
                "SUBPIXELS": int(subpixels),
                **subpixel_defines(rig),
            }
        )
        program.set(
            {
                **viewport_values(rig),
                **subpixel_values(rig),
                "window_box": tile.window_px,
                "crop_box": tile.crop_px,
                "start_px": tile.start_px,
                "px_per_window_px": tile.scale,
                "fade": fade,
                "strides": (first.stride, other.stride),
                "divider": _NO_DIVIDER if divider_px is None else divider_px,
            }
        )
        program.run(tile.window_px[2], tile.window_px[3])
        self._device.check("showing")

    def release(self) -> None:
        """Give program and table back."""
        self._programs.release()
        self._thresholds.release()
