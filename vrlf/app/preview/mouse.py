"""The mouse over the pictures: move, zoom, divide, look around."""

from __future__ import annotations

from dataclasses import replace

from imgui_bundle import imgui  # isort: skip

from vrlf.app.preview.layout import Placed, crop_of, tile_under
from vrlf.app.preview.panels import Panels
from vrlf.app.preview.session import Session, looked, zoomed
from vrlf.gpu.window import Window
from vrlf.optics.tile import Place

_LEFT, _RIGHT = 0, 1
# Window pixels beside the divider at which it is taken hold of.
_GRIP_PX = 12.0
_DEGREES_A_PX = 0.1


class Mouse:
    """Remembers what a drag took hold of."""

    def __init__(self) -> None:
        self._holds_divider = False

    def place_px(self, window: Window) -> Place:
        """The cursor's place, in the window's pixels."""
        at, ratio = imgui.get_io().mouse_pos, window.pixels_per_unit
        return at.x * ratio[0], at.y * ratio[1]

    def moved(
        self, session: Session, tiles: tuple[Placed, ...], window: Window, panels: Panels
    ) -> Session:
        """The session after what the mouse did since the last frame."""
        io = imgui.get_io()
        place = self.place_px(window)
        under = tile_under(tiles, place)
        if not io.mouse_down[_LEFT]:
            self._holds_divider = False
        if panels.has_mouse or under is None:
            return session
        if io.mouse_wheel:
            # Several notches may come in one frame, or a part of one from a touch pad.
            steps = round(io.mouse_wheel) or (1 if io.mouse_wheel > 0.0 else -1)
            session = _zoomed_about(session, under, place, steps)
        delta = (io.mouse_delta.x, io.mouse_delta.y)
        ratio = window.pixels_per_unit
        if io.mouse_down[_LEFT]:
            if imgui.is_mouse_clicked(_LEFT):
                near = under.divider_px is not None and abs(place[0] - under.divider_px) <= _GRIP_PX
                self._holds_divider = near
            if self._holds_divider:
                x, _, width, _ = under.tile.window_px
                return replace(session, divider=min(max((place[0] - x) / width, 0.0), 1.0))
            if delta != (0.0, 0.0):
                return _panned(session, under, (delta[0] * ratio[0], delta[1] * ratio[1]))
        elif io.mouse_down[_RIGHT]:
            session = looked(session, delta[0] * _DEGREES_A_PX, -delta[1] * _DEGREES_A_PX)
        return session


def _middle(under: Placed) -> Place:
    x, y, width, height = under.tile.window_px
    return under.tile.place_of((x + width / 2.0, y + height / 2.0))


def _panned(session: Session, under: Placed, delta_px: Place) -> Session:
    """The picture follows the cursor."""
    if session.zoom is None:
        return session
    middle, scale = _middle(under), under.tile.scale
    moved = (middle[0] - delta_px[0] * scale, middle[1] - delta_px[1] * scale)
    return replace(session, middle=_held(session, moved))


def _held(session: Session, place: Place) -> Place:
    """Within the crop, so that a drag beyond its edge need not be dragged back."""
    x, y, width, height = crop_of(session)
    return min(max(place[0], x), x + width), min(max(place[1], y), y + height)


def _zoomed_about(session: Session, under: Placed, place: Place, steps: int) -> Session:
    """What is under the cursor stays under it."""
    fixed, middle = under.tile.place_of(place), _middle(under)
    after = zoomed(session, steps, middle)
    ratio = (1.0 / under.tile.scale) / (after.zoom or 1.0)
    moved = tuple(f + (m - f) * ratio for f, m in zip(fixed, middle, strict=True))
    return replace(after, middle=_held(after, (moved[0], moved[1])))
