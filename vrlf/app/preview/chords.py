"""From glfw's keys to the chords of the table."""

from __future__ import annotations

import glfw

_NAMED = {
    glfw.KEY_UP: "up",
    glfw.KEY_DOWN: "down",
    glfw.KEY_LEFT: "left",
    glfw.KEY_RIGHT: "right",
    glfw.KEY_ENTER: "enter",
    glfw.KEY_KP_ENTER: "enter",
    glfw.KEY_BACKSPACE: "backspace",
    glfw.KEY_TAB: "tab",
    glfw.KEY_SPACE: "space",
    glfw.KEY_PAGE_UP: "pageup",
    glfw.KEY_PAGE_DOWN: "pagedown",
    glfw.KEY_HOME: "home",
    glfw.KEY_ESCAPE: "escape",
    **{glfw.KEY_F1 + k: f"f{k + 1}" for k in range(12)},
}
# Where a layout has another letter, or none of ours, the key's place on a US keyboard counts.
_PRINTABLE = {
    **{glfw.KEY_A + k: chr(ord("a") + k) for k in range(26)},
    **{glfw.KEY_0 + k: str(k) for k in range(10)},
    **{glfw.KEY_KP_0 + k: str(k) for k in range(10)},
    glfw.KEY_LEFT_BRACKET: "[",
    glfw.KEY_RIGHT_BRACKET: "]",
    glfw.KEY_COMMA: ",",
    glfw.KEY_PERIOD: ".",
    glfw.KEY_MINUS: "-",
    glfw.KEY_EQUAL: "=",
    glfw.KEY_KP_SUBTRACT: "-",
    glfw.KEY_KP_ADD: "=",
}
_OURS = frozenset(_PRINTABLE.values())
WALKING = {"walk_ahead": "w", "walk_left": "a", "walk_back": "s", "walk_right": "d"}


def chord_of(key: int, code: int, mods: int) -> str | None:
    """The chord of a key that was pressed; None for one without a name here.

    Parameters
    ----------
    key, code, mods : int
        glfw's key, scancode and modifiers.
    """
    name = _NAMED.get(key) or _letter(key, code)
    if name is None:
        return None
    parts = [
        word for bit, word in ((glfw.MOD_CONTROL, "ctrl"), (glfw.MOD_SHIFT, "shift")) if mods & bit
    ]
    return "+".join([*parts, name])


def _letter(key: int, code: int) -> str | None:
    """What the layout writes with the key, if that is one of ours."""
    if key not in _PRINTABLE:
        return None
    written = glfw.get_key_name(key, code)
    return written.lower() if written and written.lower() in _OURS else _PRINTABLE[key]
