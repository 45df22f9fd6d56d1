"""What stands over the pictures: sliders, help, frame times, messages. Dear ImGui's own backend."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

# First, because it names the glfw that the window then loads too.
from imgui_bundle import imgui  # isort: skip

from vrlf.app.preview.keys import ALIGNMENT, EVERY_GROUP, help_lines
from vrlf.app.preview.layout import Placed
from vrlf.app.preview.session import (
    ARRAYS,
    BARRIERS,
    METHODS,
    VIEW_WORDS,
    VIEWS,
    Session,
    attempted,
    typed,
)
from vrlf.app.preview.steps import BOTH, Side, altered, written
from vrlf.gpu.window import Window
from vrlf.model.eye import CYLINDER_LIMIT_D, SPHERE_LIMIT_D
from vrlf.resources import assets_dir

_FONT_PX = 16.0
_PANEL_WIDTH = 340.0
_CHORD_WIDTH = 175.0
_MODULE_PX = 5.0
_FIXED = (
    imgui.WindowFlags_.no_collapse
    | imgui.WindowFlags_.no_saved_settings
    | imgui.WindowFlags_.no_nav
    | imgui.WindowFlags_.always_auto_resize
)
_BARE = _FIXED | imgui.WindowFlags_.no_decoration | imgui.WindowFlags_.no_inputs


@dataclass(frozen=True)
class Phone:
    """What the window says of a phone that shows the panel image.

    Attributes
    ----------
    modules : rows of bool
        The address's QR code; True is dark.
    words : str
        How many there are, and how fast.
    """

    modules: tuple[tuple[bool, ...], ...]
    words: str


@dataclass(frozen=True)
class Status:
    """What the panels say of the frames.

    Attributes
    ----------
    rig : str
        Its name or file.
    notes : sequence of str
        What is coarse, what stands in for what.
    intervals_ms : ndarray
        Of the last frames.
    period_ms : float
        The display's.
    timing : sequence of str
        Frame times in words.
    phone : Phone or None
        Where a phone is served.
    """

    rig: str
    notes: Sequence[str]
    intervals_ms: Any
    period_ms: float
    timing: Sequence[str]
    phone: Phone | None = None


class Panels:
    """Owns ImGui's context and its hold on a window."""

    def __init__(self, window: Window) -> None:
        self._window = window
        self._text = ""
        self._is_field_new = False
        self._context = imgui.create_context()
        io = imgui.get_io()
        io.set_ini_filename("")
        io.fonts.add_font_from_file_ttf(str(assets_dir() / "fonts" / "DejaVuSans.ttf"), _FONT_PX)
        imgui.style_colors_dark()
        address = ctypes.cast(window.handle, ctypes.c_void_p).value
        imgui.backends.glfw_init_for_opengl(address or 0, True)
        imgui.backends.opengl3_init("#version 430")

    @property
    def has_keyboard(self) -> bool:
        """Whether keys are meant for a text field."""
        return bool(imgui.get_io().want_text_input)

    @property
    def has_mouse(self) -> bool:
        """Whether the mouse is over a panel."""
        return bool(imgui.get_io().want_capture_mouse)

    def begin(self) -> None:
        """Begin a frame's panels."""
        imgui.backends.opengl3_new_frame()
        imgui.backends.glfw_new_frame()
        imgui.new_frame()

    def build(self, session: Session, status: Status, tiles: Sequence[Placed]) -> Session:
        """Lay the panels out; the session as they leave it."""
        self._labels(tiles)
        if session.has_panels:
            session = _main_panel(session)
        if session.is_typing:
            session = self._typing(session)
        else:
            self._is_field_new = True
        if session.has_timing:
            _timing_panel(status)
        if session.has_phone:
            _phone_panel(status.phone)
        if session.has_help:
            _help_panel()
        _status_line(session, status)
        return session

    def end(self) -> None:
        """Draw them into the window."""
        imgui.render()
        drawn = imgui.get_draw_data()
        if drawn.total_vtx_count > 0:  # its backend makes a vertex array for each frame
            imgui.backends.opengl3_render_draw_data(drawn)

    def _labels(self, tiles: Sequence[Placed]) -> None:
        """The wall's tiles have their names in a corner."""
        if len(tiles) < 2:
            return
        draw, ratio = imgui.get_background_draw_list(), self._window.pixels_per_unit
        for each in tiles:
            x, y = (each.tile.window_px[k] / ratio[k] + 6 for k in (0, 1))
            text = VIEW_WORDS[each.view]
            size = imgui.calc_text_size(text)
            draw.add_rect_filled(
                imgui.ImVec2(x - 3, y - 2), imgui.ImVec2(x + size.x + 3, y + size.y + 2), 0xB0000000
            )
            draw.add_text(imgui.ImVec2(x, y), 0xFFFFFFFF, text)

    def _typing(self, session: Session) -> Session:
        """The field for a prescription as it is written on paper."""
        view = imgui.get_main_viewport()
        centre = imgui.ImVec2(view.size.x / 2, view.size.y / 2)
        imgui.set_next_window_pos(centre, imgui.Cond_.always, imgui.ImVec2(0.5, 0.5))
        imgui.begin(f"Prescription: {session.chosen}", None, _FIXED)
        if self._is_field_new:
            eye = getattr(session.rig, session.sides[0])
            self._text, self._is_field_new = written(eye), False
            imgui.set_keyboard_focus_here()
        flags = imgui.InputTextFlags_.enter_returns_true | imgui.InputTextFlags_.auto_select_all
        entered, self._text = imgui.input_text("##rx", self._text, flags)
        imgui.text_disabled("-5.00 / -1.25 x 170    Enter takes it, Escape leaves")
        if entered:
            session = typed(session, self._text)
            self._is_field_new = self._is_field_new or session.is_typing
        imgui.end()
        return session

    def release(self) -> None:
        """Let the window go."""
        imgui.backends.opengl3_shutdown()
        imgui.backends.glfw_shutdown()
        imgui.destroy_context(self._context)


def _main_panel(session: Session) -> Session:
    imgui.set_next_window_pos(imgui.ImVec2(8, 8), imgui.Cond_.first_use_ever)
    imgui.set_next_window_bg_alpha(0.82)
    imgui.begin("vrlf", None, _FIXED)
    imgui.push_item_width(_PANEL_WIDTH * 0.55)
    for side in BOTH:
        session = _eye_panel(session, side)
    session = _method_panel(session)
    imgui.pop_item_width()
    imgui.text_disabled("F1: all keys")
    imgui.end()
    return session


def _eye_panel(session: Session, side: Side) -> Session:
    eye = getattr(session.rig, side)
    mark = ">" if side in session.sides else " "
    imgui.separator_text(f"{mark} {side}  {written(eye)}")
    imgui.push_id(side)
    sliders: tuple[tuple[str, str, float, float, str], ...] = (
        ("sphere", "sphere_d", -SPHERE_LIMIT_D / 2, SPHERE_LIMIT_D / 2, "%.2f D"),
        ("cylinder", "cylinder_d", -CYLINDER_LIMIT_D / 2, CYLINDER_LIMIT_D / 2, "%.2f D"),
        ("axis", "axis_deg", 0.0, 180.0, "%.0f deg"),
        ("pupil", "pupil_mm", 1.0, 9.0, "%.1f mm"),
    )
    for label, key, least, most, form in sliders:
        change = _changer(side, key)
        session = _slider(session, label, getattr(eye, key), (least, most), form, change)
    for axis, label in enumerate(("prism right", "prism up")):
        change = _prism_changer(side, axis)
        session = _slider(session, label, eye.prism_pd[axis], (-10.0, 10.0), "%.1f pd", change)
    imgui.pop_id()
    return session


_Change = Callable[[float], dict[str, Any]]
_DECIMALS = {"sphere_d": 2, "cylinder_d": 2, "axis_deg": 0, "pupil_mm": 1}


def _changer(side: Side, key: str) -> _Change:
    return lambda value: {side: {key: round(value, _DECIMALS[key]) + 0.0}}


def _prism_changer(side: Side, axis: int) -> _Change:
    # The other component is filled in when the change is made.
    return lambda value: {side: {"prism_pd": (axis, round(value, 1) + 0.0)}}


def _slider(
    session: Session,
    label: str,
    value: float,
    limits: tuple[float, float],
    form: str,
    change: _Change,
) -> Session:
    """A slider; all of a drag is one step for undo."""
    moved, chosen = imgui.slider_float(label, value, *limits, form)
    if moved:
        session = _taken(session, change(float(np.clip(chosen, *limits))), label)
    if imgui.is_item_deactivated():
        session = replace(session, holding="")
    return session


def _taken(session: Session, change: dict[str, Any], label: str) -> Session:
    side, table = next(iter(change.items()))
    if isinstance(table, dict) and "prism_pd" in table:
        axis, value = table["prism_pd"]
        prism = list(getattr(session.rig, side).prism_pd)
        prism[axis] = value
        change = {side: {"prism_pd": prism}}
    return attempted(session, lambda rig: altered(rig, change), holding=f"{side} {label}")


def _method_panel(session: Session) -> Session:
    rig = session.rig
    imgui.separator_text("method and array")
    for label, table, key, choices in (
        ("method", "prefilter", "method", METHODS),
        ("array", "array", "kind", ARRAYS),
        ("barriers", "array", "barriers", BARRIERS),
    ):
        now = choices.index(getattr(getattr(rig, table), key))
        chose, index = imgui.combo(label, now, list(choices))
        if chose:
            change = {table: {key: choices[index]}}
            session = attempted(session, partial(altered, change=change))
    session = _slider(
        session,
        "brightness",
        rig.prefilter.brightness,
        (rig.prefilter.black_level + 0.01, 1.0),
        "%.2f",
        lambda value: {"prefilter": {"brightness": round(value, 3)}},
    )
    chose, index = imgui.combo("view", VIEWS.index(session.view), [VIEW_WORDS[v] for v in VIEWS])
    return replace(session, view=VIEWS[index]) if chose else session


def _help_panel() -> None:
    view = imgui.get_main_viewport()
    centre = imgui.ImVec2(view.size.x / 2, view.size.y / 2)
    imgui.set_next_window_pos(centre, imgui.Cond_.always, imgui.ImVec2(0.5, 0.5))
    imgui.set_next_window_bg_alpha(0.95)
    imgui.begin("Keys (F1 closes)", None, _FIXED)
    # Two columns of groups, equally long, so that a window of 720 rows holds all.
    if imgui.begin_table("groups", 2):
        half = len(EVERY_GROUP) // 2
        for part in (EVERY_GROUP[:half], EVERY_GROUP[half:]):
            imgui.table_next_column()
            for group in part:
                imgui.separator_text(group.title)
                for chord, says in help_lines(group):
                    imgui.text_colored(imgui.ImVec4(0.6, 0.85, 1.0, 1.0), chord)
                    imgui.same_line(_CHORD_WIDTH)
                    imgui.text_unformatted(says)
        imgui.end_table()
    imgui.end()


def _timing_panel(status: Status) -> None:
    view = imgui.get_main_viewport()
    corner = imgui.ImVec2(view.size.x - 8, 8)
    imgui.set_next_window_pos(corner, imgui.Cond_.always, imgui.ImVec2(1.0, 0.0))
    imgui.set_next_window_bg_alpha(0.82)
    imgui.begin("Frame times", None, _FIXED | imgui.WindowFlags_.no_inputs)
    values = np.asarray(status.intervals_ms, np.float32)
    if len(values):
        most = max(2.0 * status.period_ms, float(values.max()))
        size = imgui.ImVec2(_PANEL_WIDTH, 80)
        imgui.plot_lines("##frames", values, 0, f"0 to {most:.0f} ms", 0.0, most, size)
    for line in status.timing:
        imgui.text_unformatted(line)
    imgui.end()


def _phone_panel(phone: Phone | None) -> None:
    view = imgui.get_main_viewport()
    corner = imgui.ImVec2(view.size.x - 8, view.size.y - 8)
    imgui.set_next_window_pos(corner, imgui.Cond_.always, imgui.ImVec2(1.0, 1.0))
    imgui.begin("Phone (P closes)", None, _FIXED | imgui.WindowFlags_.no_inputs)
    if phone is None:
        imgui.text_unformatted("vrlf preview --phone serves one")
    else:
        _qr_code(phone.modules)
        imgui.text_unformatted(phone.words)
    imgui.end()


def _qr_code(modules: tuple[tuple[bool, ...], ...]) -> None:
    """Dark on light, whatever the style: cameras want it so."""
    draw, corner = imgui.get_window_draw_list(), imgui.get_cursor_screen_pos()
    side = _MODULE_PX * len(modules)
    end = imgui.ImVec2(corner.x + side, corner.y + side)
    draw.add_rect_filled(corner, end, 0xFFFFFFFF)
    for row, line in enumerate(modules):
        y = corner.y + _MODULE_PX * row
        for column, is_dark in enumerate(line):
            if is_dark:
                x = corner.x + _MODULE_PX * column
                far = imgui.ImVec2(x + _MODULE_PX, y + _MODULE_PX)
                draw.add_rect_filled(imgui.ImVec2(x, y), far, 0xFF000000)
    imgui.dummy(imgui.ImVec2(side, side))


def _status_line(session: Session, status: Status) -> None:
    """At the lower edge: the rig, the view, what is not yet as it will be, the last message."""
    if not session.has_panels and not session.message:
        return
    view = imgui.get_main_viewport()
    corner = imgui.ImVec2(8, view.size.y - 8)
    imgui.set_next_window_pos(corner, imgui.Cond_.always, imgui.ImVec2(0.0, 1.0))
    imgui.set_next_window_bg_alpha(0.7)
    imgui.begin("status", None, _BARE)
    if session.has_panels:
        unsaved = "" if session.is_saved else "*"
        shown = f"alignment: {session.is_aligning}" if session.is_aligning else ""
        parts = (f"{status.rig}{unsaved}", VIEW_WORDS[session.view], shown, *status.notes)
        imgui.text_unformatted("   ".join(part for part in parts if part))
    if session.is_aligning:
        imgui.text_disabled("   ".join(f"{c}: {s}" for c, s in help_lines(ALIGNMENT)[:4]))
    if session.message:
        imgui.text_unformatted(session.message)
    imgui.end()
