"""The one table of keys. F1 shows it, the README holds it, the window obeys it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Key:
    """A key and what it does.

    Attributes
    ----------
    chord : str
        Such as ``"up"`` or ``"ctrl+shift+z"``; the modifiers in this order.
    action : str
        The name that the session or the window knows.
    amount : float
        Steps, for an action that takes some.
    says : str
        What it does, in words; without any it stands in the line of the key before it.
    finer : bool
        With shift the step is finer.
    """

    chord: str
    action: str
    says: str
    amount: float = 0.0
    finer: bool = False


@dataclass(frozen=True)
class Group:
    """Keys that belong together."""

    title: str
    keys: tuple[Key, ...]


def _pair(less: str, more: str, action: str, says: str) -> tuple[Key, Key]:
    return (Key(less, action, says, -1.0, finer=True), Key(more, action, "", 1.0, finer=True))


GROUPS: tuple[Group, ...] = (
    Group(
        "Which eye",
        (
            Key("1", "choose_left", "the keys below change the left eye"),
            Key("2", "choose_right", "the right eye"),
            Key("3", "choose_both", "both eyes"),
        ),
    ),
    Group(
        "Prescription (finer with shift)",
        (
            *_pair("down", "up", "sphere", "sphere by 0.25 D (0.05 D)"),
            *_pair("left", "right", "cylinder", "cylinder by 0.25 D (0.05 D)"),
            *_pair("[", "]", "axis", "axis by 5 degrees (1 degree)"),
            *_pair(",", ".", "pupil", "pupil by 0.5 mm (0.1 mm)"),
            *_pair("j", "l", "prism_x", "prism left, right by 0.5 (0.1) prism dioptres"),
            *_pair("k", "i", "prism_y", "prism down, up"),
            Key("enter", "type", "type a prescription as on paper: -5.00 / -1.25 x 170"),
            Key("c", "copy", "copy the chosen eye to the other"),
            Key("backspace", "reset", "reset the chosen eye to the rig as it was loaded"),
            Key("ctrl+z", "undo", "undo"),
            Key("ctrl+y", "redo", "redo"),
            Key("ctrl+shift+z", "redo", ""),
        ),
    ),
    Group(
        "Hardware and method",
        (
            Key("m", "method", "next prefilter: forward, optimal, none"),
            Key("n", "array", "next array: microlens, pinhole, none"),
            Key("b", "barriers", "next barriers: none, perpendicular, converging"),
            *_pair("-", "=", "brightness", "brightness of optimal by 0.05 (0.01)"),
        ),
    ),
    Group(
        "Files and window",
        (
            Key("f1", "help", "this list"),
            Key("f5", "shaders", "reload the shaders; a faulty one changes nothing"),
            Key("f11", "fullscreen", "fullscreen, or a window again"),
            Key("p", "phone", "show or hide the QR code for a phone (vrlf preview --phone)"),
            Key("ctrl+m", "monitor", "the next monitor"),
            Key("f12", "screenshot", "save what is shown, the rig in the file"),
            Key("shift+f12", "screenshot_all", "the same with the panels"),
            Key("ctrl+s", "save", "save the rig"),
            Key("ctrl+r", "reload", "read the rig's file again"),
            Key("escape", "leave", "leave"),
        ),
    ),
    Group(
        "Views",
        (
            Key("4", "view_panel", "the panel image"),
            Key("5", "view_perceived", "perceived with correction"),
            Key("6", "view_uncorrected", "perceived without"),
            Key("7", "view_target", "the target"),
            Key("8", "view_difference", "the difference of perceived and target"),
            Key("9", "view_compare", "two views and a divider (drag it); again: the next two"),
            Key("0", "view_wall", "a wall of all"),
            Key("e", "eyes", "show both eyes, the left, the right"),
            Key("z", "zoom", "all of it, or one to one"),
            Key("ctrl+=", "zoom_in", "zoom in (wheel)"),
            Key("ctrl+-", "zoom_out", "zoom out (drag to move)"),
            Key("x", "loupe", "loupe under the cursor, with sub-pixels"),
            Key("tab", "panels", "hide or show the panels"),
            Key("t", "timing", "frame times"),
        ),
    ),
    Group(
        "Looking around and playing",
        (
            Key("w", "walk_ahead", "walk ahead, left, back, right (right button and drag: look)"),
            Key("a", "walk_left", ""),
            Key("s", "walk_back", ""),
            Key("d", "walk_right", ""),
            Key("h", "home", "look straight ahead again"),
            Key("space", "play", "pause, go on"),
            Key("pageup", "seek", "5 seconds back", -5.0),
            Key("pagedown", "seek", "5 seconds on", 5.0),
            Key("home", "rewind", "from the beginning"),
        ),
    ),
    Group(
        "Alignment (arrows, brackets, comma and point then move the array)",
        (Key("g", "alignment", "next alignment screen: fringes (2), pitch, separation, off"),),
    ),
)

# While an alignment screen is shown these go first.
ALIGNMENT = Group(
    "While aligning (finer with shift)",
    (
        *_pair("left", "right", "align_x", "array left, right by 10 um (1 um)"),
        *_pair("down", "up", "align_y", "array down, up"),
        *_pair("[", "]", "align_turn", "turn the array by 0.1 degrees (0.01)"),
        *_pair(",", ".", "align_scale", "array pitch by 0.1 um (0.01 um)"),
        *_pair("k", "i", "align_pixel", "pixel pitch by 0.1 um (0.01 um): pitch screen"),
        *_pair("j", "l", "align_separation", "lens separation by 0.5 mm (0.1 mm)"),
        *_pair("-", "=", "align_height", "lens height by 0.5 mm (0.1 mm)"),
    ),
)

EVERY_GROUP = (*GROUPS, ALIGNMENT)


@dataclass(frozen=True)
class Press:
    """A key that was pressed: its row, and whether shift asked for the finer step."""

    key: Key
    fine: bool


def _rows(group: Group) -> dict[str, Press]:
    found = {}
    for key in group.keys:
        found[key.chord] = Press(key, False)
        if key.finer:
            found[f"shift+{key.chord}"] = Press(key, True)
    return found


_PRESSES: dict[str, Press] = {
    chord: press for group in GROUPS for chord, press in _rows(group).items()
}
_ALIGNING: dict[str, Press] = {**_PRESSES, **_rows(ALIGNMENT)}


def press_of(chord: str, *, aligning: bool) -> Press | None:
    """What a chord means; None if nothing."""
    return (_ALIGNING if aligning else _PRESSES).get(chord)


def chord_label(key: Key, group: Group) -> str:
    """The chord as a person reads it, with those of the wordless keys behind it."""
    chords = [key.chord]
    for later in group.keys[group.keys.index(key) + 1 :]:
        if later.says:
            break
        chords.append(later.chord)
    return " ".join(_label(chord) for chord in chords)


def _label(chord: str) -> str:
    return "+".join(part.capitalize() for part in chord.split("+"))


def help_lines(group: Group) -> list[tuple[str, str]]:
    """Chord and meaning of a group's keys, line by line."""
    return [(chord_label(key, group), key.says) for key in group.keys if key.says]


def markdown() -> str:
    """The whole table for the README."""
    lines = ["| key | does |", "| --- | --- |"]
    for group in EVERY_GROUP:
        lines.append(f"| **{group.title}** | |")
        lines += [f"| `{chord}` | {says} |" for chord, says in help_lines(group)]
    return "\n".join(lines) + "\n"
