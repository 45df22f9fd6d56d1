"""What the user has chosen so far: frozen, and one pure function for each thing a key does."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from vrlf.app.preview.keys import Press
from vrlf.app.preview.steps import (
    BOTH,
    NUDGES,
    STEPS,
    Side,
    alignment_words,
    brightened,
    cycled,
    nudged,
    prescribed,
    stepped_eye,
    with_eye,
    written,
)
from vrlf.errors import InputError
from vrlf.model import Rig
from vrlf.optics.alignment import ALIGNMENT_SCREENS, AlignmentScreen
from vrlf.scene import HeadPose, walked

View = Literal["panel", "perceived", "uncorrected", "target", "difference", "compare", "wall"]
VIEWS: tuple[View, ...] = (
    "panel", "perceived", "uncorrected", "target", "difference", "compare", "wall"
)  # fmt: skip
VIEW_WORDS: Mapping[View, str] = {
    "panel": "panel image",
    "perceived": "perceived with correction",
    "uncorrected": "perceived without",
    "target": "target",
    "difference": "difference of perceived and target",
    "compare": "two views",
    "wall": "all",
}
COMPARISONS: tuple[tuple[View, View], ...] = (
    ("uncorrected", "perceived"),
    ("perceived", "target"),
    ("target", "panel"),
)
Eyes = Literal["both", "left", "right"]
_EYES: tuple[Eyes, ...] = ("both", "left", "right")
METHODS = ("forward", "optimal", "none")
ARRAYS = ("microlens", "pinhole", "none")
BARRIERS = ("none", "perpendicular", "converging")
ZOOMS = (0.25, 0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0)
_MOST_UNDO = 1000


@dataclass(frozen=True)
class Session:
    """Everything that keys, mouse and panels change.

    Attributes
    ----------
    rig : Rig
        As it is now.
    loaded : Rig
        As it was read or saved last.
    chosen : Eyes
        Which eye the prescription's keys change.
    view : View
    comparison : int
        Which of ``COMPARISONS`` stands on both sides of the divider.
    divider : float
        Its place, a share of the view's width.
    eyes : Eyes
        Which eyes' halves are shown.
    zoom : float or None
        Window pixels per picture pixel; None shows all.
    middle : (x, y) or None
        The place of the panel's raster in the view's middle; None is its own middle.
    head : HeadPose
    is_playing : bool
    is_aligning : AlignmentScreen or None
        The alignment screen that is shown.
    past, future : tuple of Rig
        For undo and redo.
    holding : str
        The slider that is being dragged: its steps are one step for undo.
    message : str
        What the window says last.
    """

    rig: Rig
    loaded: Rig
    chosen: Eyes = "both"
    view: View = "perceived"
    comparison: int = 0
    divider: float = 0.5
    eyes: Eyes = "both"
    zoom: float | None = None
    middle: tuple[float, float] | None = None
    head: HeadPose = field(default_factory=HeadPose)
    is_playing: bool = True
    is_aligning: AlignmentScreen | None = None
    has_loupe: bool = False
    has_help: bool = False
    has_panels: bool = True
    has_timing: bool = False
    has_phone: bool = False
    is_typing: bool = False
    past: tuple[Rig, ...] = ()
    future: tuple[Rig, ...] = ()
    holding: str = ""
    message: str = ""

    @property
    def sides(self) -> tuple[Side, ...]:
        """The eyes that a change of prescription is for."""
        return BOTH if self.chosen == "both" else (self.chosen,)

    @property
    def is_saved(self) -> bool:
        """Whether the rig is as it was read or saved last."""
        return self.rig == self.loaded


def changed(session: Session, rig: Rig, *, holding: str = "", message: str = "") -> Session:
    """Another rig, the old one kept for undo; while a slider is held only the first is kept."""
    if rig == session.rig:
        return replace(session, message=message or session.message)
    past = session.past
    if not holding or holding != session.holding:
        past = (*past, session.rig)[-_MOST_UNDO:]
    return replace(session, rig=rig, past=past, future=(), holding=holding, message=message)


def attempted(session: Session, make: Callable[[Rig], Rig], *, holding: str = "") -> Session:
    """The session with the rig that ``make`` gives, or with its complaint."""
    try:
        return changed(session, make(session.rig), holding=holding)
    except InputError as error:
        return replace(session, message=str(error))


def typed(session: Session, text: str) -> Session:
    """A prescription was typed; one that does not read leaves the field open."""
    try:
        rig = prescribed(session.rig, session.sides, text)
    except InputError as error:
        return replace(session, message=str(error))
    told = f"{session.chosen}: {written(getattr(rig, session.sides[0]))}"
    return replace(changed(session, rig, message=told), is_typing=False)


def act(session: Session, press: Press) -> Session:
    """What a key makes of the session; one that is not the session's leaves it as it is."""
    action = press.key.action
    if action in STEPS and action != "brightness":
        steps, fine = press.key.amount, press.fine
        return attempted(
            session, lambda rig: stepped_eye(rig, session.sides, action, steps, fine=fine)
        )
    found = _ACTIONS.get(action)
    return session if found is None else found(session, press)


def _choose(eyes: Eyes) -> Callable[[Session, Press], Session]:
    return lambda session, _: replace(session, chosen=eyes, message=f"{eyes}: change")


def _show(view: View) -> Callable[[Session, Press], Session]:
    def show(session: Session, _: Press) -> Session:
        comparison = session.comparison
        if view == "compare" and session.view == "compare":
            comparison = (comparison + 1) % len(COMPARISONS)
        words = VIEW_WORDS[view]
        if view == "compare":
            words = " | ".join(VIEW_WORDS[each] for each in COMPARISONS[comparison])
        return replace(session, view=view, comparison=comparison, message=words)

    return show


def _cycle(table: str, key: str, choices: tuple[str, ...]) -> Callable[[Session, Press], Session]:
    def cycle(session: Session, _: Press) -> Session:
        after = attempted(session, lambda rig: cycled(rig, table, key, choices))
        if after.rig == session.rig:
            return after
        return replace(after, message=f"{table}.{key}: {getattr(getattr(after.rig, table), key)}")

    return cycle


def _copy(session: Session, _: Press) -> Session:
    """The chosen eye to the other; of both, the left to the right."""
    source: Side = session.sides[0]
    other: Side = "right" if source == "left" else "left"
    rig = with_eye(session.rig, other, getattr(session.rig, source))
    return changed(session, rig, message=f"{source} copied to {other}")


def _reset(session: Session, _: Press) -> Session:
    rig = session.rig
    for side in session.sides:
        rig = with_eye(rig, side, getattr(session.loaded, side))
    return changed(session, rig, message=f"{session.chosen}: as loaded")


def _undo(session: Session, _: Press) -> Session:
    if not session.past:
        return replace(session, message="nothing to undo")
    return replace(
        session,
        rig=session.past[-1],
        past=session.past[:-1],
        future=(session.rig, *session.future),
        holding="",
        message="undone",
    )


def _redo(session: Session, _: Press) -> Session:
    if not session.future:
        return replace(session, message="nothing to redo")
    return replace(
        session,
        rig=session.future[0],
        past=(*session.past, session.rig),
        future=session.future[1:],
        holding="",
        message="done again",
    )


def _brightness(session: Session, press: Press) -> Session:
    after = attempted(session, lambda rig: brightened(rig, press.key.amount, fine=press.fine))
    bright = after.rig.prefilter
    told = f"brightness {bright.brightness:g}"
    if bright.method != "optimal":
        told += " (acts on optimal alone)"
    return replace(after, message=told)


def _eyes(session: Session, _: Press) -> Session:
    eyes = _EYES[(_EYES.index(session.eyes) + 1) % len(_EYES)]
    return replace(session, eyes=eyes, middle=None, message=f"shown: {eyes}")


def _zoom_all_or_one(session: Session, _: Press) -> Session:
    return replace(session, zoom=1.0 if session.zoom is None else None, middle=None)


def _zoom_by(steps: int) -> Callable[[Session, Press], Session]:
    return lambda session, _: zoomed(session, steps, session.middle)


def zoomed(session: Session, steps: int, middle: tuple[float, float] | None) -> Session:
    """Some zooms on; from all of it to one to one first."""
    now = session.zoom if session.zoom is not None else 1.0
    nearest = min(range(len(ZOOMS)), key=lambda k: abs(ZOOMS[k] - now))
    chosen = min(max(nearest + steps, 0), len(ZOOMS) - 1)
    return replace(session, zoom=ZOOMS[chosen], middle=middle)


def _toggle(name: str) -> Callable[[Session, Press], Session]:
    def toggle(session: Session, _: Press) -> Session:
        change: dict[str, Any] = {name: not getattr(session, name)}
        return replace(session, **change)

    return toggle


def _align(session: Session, _: Press) -> Session:
    order: tuple[AlignmentScreen | None, ...] = (*ALIGNMENT_SCREENS, None)
    now = order.index(session.is_aligning)
    after = order[(now + 1) % len(order)]
    return replace(session, is_aligning=after, message=_SCREEN_WORDS[after])


def _home(session: Session, _: Press) -> Session:
    return replace(session, head=HeadPose(), message="straight ahead")


_SCREEN_WORDS: Mapping[AlignmentScreen | None, str] = {
    None: "alignment: off",
    "fringes": "fringes: move the array left, right until both halves' bright bars meet",
    "fringes up": "fringes: move the array down, up until both halves' bright bars meet",
    "pitch": "pitch: hold a bank card against the panel; k, i change the pixel pitch",
    "separation": "separation: change it (j, l) until the lines of both eyes are one",
}


def _nudge(session: Session, press: Press) -> Session:
    what, steps = press.key.action, press.key.amount
    after = attempted(session, lambda rig: nudged(rig, what, steps, fine=press.fine))
    return replace(after, message=f"{what.removeprefix('align_')}: {alignment_words(after.rig)}")


_ACTIONS: Mapping[str, Callable[[Session, Press], Session]] = {
    "choose_left": _choose("left"),
    "choose_right": _choose("right"),
    "choose_both": _choose("both"),
    "type": lambda session, _: replace(session, is_typing=True),
    "copy": _copy,
    "reset": _reset,
    "undo": _undo,
    "redo": _redo,
    "method": _cycle("prefilter", "method", METHODS),
    "array": _cycle("array", "kind", ARRAYS),
    "barriers": _cycle("array", "barriers", BARRIERS),
    "brightness": _brightness,
    **{f"view_{view}": _show(view) for view in VIEWS},
    "eyes": _eyes,
    "zoom": _zoom_all_or_one,
    "zoom_in": _zoom_by(1),
    "zoom_out": _zoom_by(-1),
    "loupe": _toggle("has_loupe"),
    "panels": _toggle("has_panels"),
    "timing": _toggle("has_timing"),
    "phone": _toggle("has_phone"),
    "help": _toggle("has_help"),
    "play": _toggle("is_playing"),
    "alignment": _align,
    **dict.fromkeys(NUDGES, _nudge),
    "home": _home,
}
# What the window itself does: it takes files, the clock, the screen or keys that are held.
WINDOW_ACTIONS = frozenset(
    {
        "walk_ahead", "walk_left", "walk_back", "walk_right",
        "seek", "rewind", "shaders", "fullscreen", "monitor", "screenshot", "screenshot_all",
        "save", "reload", "leave",
    }
)  # fmt: skip
SESSION_ACTIONS = frozenset(_ACTIONS) | (frozenset(STEPS) - {"brightness"})


def looked(session: Session, right_deg: float, up_deg: float) -> Session:
    """The head turned; straight up and down is where it ends."""
    head = session.head
    pitch = min(max(head.pitch_deg + up_deg, -90.0), 90.0)
    yaw = (head.yaw_deg + right_deg + 180.0) % 360.0 - 180.0
    return replace(session, head=replace(head, yaw_deg=yaw, pitch_deg=pitch))


_WALK_M_A_S = 1.2
# To the right, ahead.
_STEPS_OF = {
    "walk_ahead": (0.0, 1.0),
    "walk_back": (0.0, -1.0),
    "walk_left": (-1.0, 0.0),
    "walk_right": (1.0, 0.0),
}


def strolled(session: Session, held: Iterable[str], seconds: float) -> Session:
    """The head after walking for a while, at a walker's pace, the way it looks."""
    stride_m = _WALK_M_A_S * min(seconds, 0.1)
    steps = [_STEPS_OF[action] for action in held]
    right_m, ahead_m = (stride_m * sum(step[axis] for step in steps) for axis in (0, 1))
    return replace(session, head=walked(session.head, right_m, ahead_m))
