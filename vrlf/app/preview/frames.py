"""From a session to what the window shows, frame by frame; only what has changed is computed."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any

from vrlf.app.preview.layout import Placed, needed
from vrlf.app.preview.likening import Likening
from vrlf.app.preview.pacing import Effort
from vrlf.errors import VrlfError
from vrlf.gpu import Device, FrameTimers, Texture
from vrlf.model import Rig
from vrlf.optics.alignment import AlignmentScreen
from vrlf.optics.tile import Tile
from vrlf.optics.viewport import viewport
from vrlf.passes.alignment import Alignment
from vrlf.passes.perceive import Patch
from vrlf.passes.show import Show, Shown
from vrlf.renderer import Stream
from vrlf.renderer.live import Live
from vrlf.renderer.refining import Refining
from vrlf.renderer.steps import operator_key
from vrlf.scene import HeadPose

# What a frame on software GL gives to the solver and to looking, so that a key is answered
# within a quarter of a second.
_SOLVING_MS, _LOOKING_MS = 60.0, 20.0
# A still picture is solved further in the frames that follow, until so many were shown.
_SETTLING_FRAMES = 24
_LEAST_RAYS = 8
LOOKS = ("perceived", "uncorrected")
# The alignment screen that is a target: its lines are to be seen sharp. The others go straight onto
# the panel.
_SEEN_SHARP: AlignmentScreen = "separation"


@dataclass(frozen=True)
class Moment:
    """What a frame depends on, beside the rig.

    Attributes
    ----------
    time_s : float
    head : HeadPose
    screen : str or None
        The alignment screen that takes the panel image's place.
    """

    time_s: float = 0.0
    head: HeadPose = field(default_factory=HeadPose)
    screen: AlignmentScreen | None = None


class Frames:
    """Owns all that stands between a rig and the window's pixels.

    Parameters
    ----------
    device : Device
    rig : Rig
        Shown first; ``want`` another one.
    live : Live
        What is shown; stays its owner's.
    rays : int
        For each retinal pixel.
    """

    def __init__(self, device: Device, rig: Rig, live: Live, *, rays: int) -> None:
        self._device, self._live, self._rays = device, live, rays
        self._effort = Effort()
        self._given = rig
        self._wanted = first = self._streamed(rig)
        self._canvas: Texture | None = None
        self._back: Texture | None = None
        self._drawn: Any = None
        self._panel_of: Any = None
        self._aligned: Texture | None = None
        self._settled = 0
        # Counts what was computed; what was shown of it last is not shown again.
        self._version = 0
        self._put: Any = None
        self._failure: VrlfError | None = None
        self._looks = {name: Refining() for name in LOOKS}
        self._owned = ExitStack()
        try:
            self.timers = FrameTimers(device)
            self.stream: Stream = self._own(
                Stream(device, self._quick(first), rays=rays, uncorrected=True)
            )
            self._show: Show = self._own(Show(device))
            self._alignment: Alignment = self._own(Alignment(device))
            self.likening: Likening = self._own(Likening(device))
        except BaseException:
            self.release()
            raise

    def _own(self, item: Any) -> Any:
        self._owned.callback(item.release)
        return item

    @property
    def is_software(self) -> bool:
        """Whether the CPU does the drawing, and costly pictures come in pieces."""
        return self._device.info.is_software

    @property
    def rig(self) -> Rig:
        """What the last frame belonged to; its steps may be fewer than were asked for."""
        return self.stream.rig

    @property
    def is_standing_in(self) -> bool:
        """Whether ``forward`` is shown until what was asked for is made."""
        return self.stream.rig.prefilter.method != self._wanted.prefilter.method

    @property
    def is_sampled_coarsely(self) -> bool:
        """Whether ``forward`` takes fewer samples of each sub-pixel than it will."""
        there, wanted = self.stream.rig.prefilter, self._wanted.prefilter
        return there.method == "forward" and there.subpixel_grid < wanted.subpixel_grid

    @property
    def canvas(self) -> Texture:
        """What the window shows (kind f1, row 0 the lowest)."""
        assert self._canvas is not None
        return self._canvas

    @property
    def last_canvas(self) -> Texture | None:
        """What was shown last, whole; None before anything was."""
        return self._canvas

    def stride_of(self, name: str) -> int:
        """The stride at which a perceived picture is whole: 1 when all of it is there."""
        return self._looks[name].stride

    def take_failure(self) -> VrlfError | None:
        """Why the last rig could not be made, once."""
        failure, self._failure = self._failure, None
        return failure

    def show_instead(self, live: Live) -> None:
        """Another target from the next frame on."""
        self._live, self._drawn = live, None

    def ease(self, effort: Effort) -> None:
        """Rays and steps for a share of the cost from now on."""
        if effort != self._effort:
            self._effort = effort
            self._change(self._given, rays=effort.of(self._rays, _LEAST_RAYS))

    def want(self, rig: Rig) -> None:
        """Show this rig from the next frame on.

        The tables of ``optimal`` take longer than a frame: until they are there ``forward``
        stands in for it, with the same prescription.
        """
        if rig != self._given:
            self._change(rig)

    def _change(self, rig: Rig, rays: int | None = None) -> None:
        self._given, self._wanted = rig, self._streamed(rig)
        there = self.stream.rig
        has_tables = there.prefilter.method == "optimal" and (
            operator_key(there) == operator_key(self._wanted)
        )
        first = self._wanted if has_tables else self._quick(self._wanted)
        self.stream.change(first, rays=rays, at_once=True)

    def _quick(self, rig: Rig) -> Rig:
        """The rig with a prefilter whose tables are there at once."""
        given = rig.prefilter
        change: dict[str, Any] = {}
        if given.method == "optimal":
            change["method"] = "forward"
        if self.is_software and given.method != "none" and rig.array.kind != "none":
            # A sample for each sub-pixel: what is finer comes with the next frames.
            change["subpixel_grid"] = 1
        return rig.model_copy(update={"prefilter": given.model_copy(update=change)})

    def _streamed(self, rig: Rig) -> Rig:
        """The rig with as many steps, or as much time for them, as a frame has."""
        given = rig.prefilter
        change: dict[str, Any] = {"iterations": self._effort.of(given.iterations)}
        if self.is_software:
            change["budget_ms"] = min(given.budget_ms or _SOLVING_MS, _SOLVING_MS)
        return rig.model_copy(update={"prefilter": given.model_copy(update=change)})

    def draw(
        self,
        tiles: tuple[Placed, ...],
        window_px: tuple[int, int],
        moment: Moment,
        *,
        fade: float = 0.0,
    ) -> bool:
        """Compute a frame into ``canvas``; whether the next one would differ by itself."""
        rig = self._begun()
        wanted = needed(tiles)
        with self.timers.measure("target"):
            is_new = self._target(rig, moment)
        with self.timers.measure("prefilter"):
            on_panel = None if moment.screen == _SEEN_SHARP else moment.screen
            self._panel(rig, is_new, on_panel)
        with self.timers.measure("perceive"):
            self._look(sorted(wanted & self._looks.keys()))
        with self.timers.measure("measure"):
            self._liken("perceived" in wanted)
        shown = (tiles, window_px, fade, self._version)
        if shown != self._put:
            with self.timers.measure("show"):
                self.put(tiles, window_px, fade=fade)
            self._put = shown
        self.timers.end_frame()
        is_coarse = any(not self._looks[name].is_done for name in wanted & self._looks.keys())
        is_coming = is_coarse or self.likening.is_waiting
        return self.stream.is_changing or is_coming or self._is_settling(rig)

    def _begun(self) -> Rig:
        """The frame's rig; once a stand-in is there, what it stands in for is wanted."""
        try:
            rig = self.stream.begin()
        except VrlfError as error:
            # What cannot be made is wanted no more; what was there stays.
            self._failure, self._wanted = error, self.stream.rig
            rig = self.stream.begin()
        if rig != self._wanted and not self.stream.is_changing:
            self.stream.change(self._wanted)
        return rig

    def _target(self, rig: Rig, moment: Moment) -> bool:
        """Draw the target if it is another one; whether it is."""
        # A prescription alone changes nothing of what is meant to be seen.
        time_s = moment.time_s if self._live.has_time else None
        head = moment.head if self._live.has_head else None
        is_screen = moment.screen == _SEEN_SHARP
        given = (rig.panel, rig.headset, rig.array, is_screen or (time_s, head))
        if given == self._drawn:
            return False
        target = self.stream.target
        if is_screen:
            self._alignment.run(rig, _SEEN_SHARP, target)
        else:
            self._live.draw(target, rig, time_s=moment.time_s, head=moment.head)
        self._drawn = given
        self._version += 1
        return True

    def _panel(self, rig: Rig, is_new_target: bool, screen: AlignmentScreen | None) -> None:
        """Prefilter what is new; solve on where a still picture can still gain."""
        if not is_new_target and (rig, screen) == self._panel_of:
            if screen is not None or not self._is_settling(rig):
                return
            self._settled += 1
        else:
            self._settled = 0
        if screen is None:
            self._drop_aligned()
            self.stream.show()
        else:
            self._align(rig, screen)
        self._version += 1
        self._panel_of = (rig, screen)
        view = viewport(rig, "left")
        for look in self._looks.values():
            look.restart((view.width_px, view.height_px))

    def _align(self, rig: Rig, screen: AlignmentScreen) -> None:
        """The alignment screen as the panel image, past every prefilter."""
        size = self.stream.panel.size_px
        if self._aligned is None or self._aligned.size_px != size:
            self._drop_aligned()
            self._aligned = Texture(self._device, size, label="alignment screen")
        self._alignment.run(rig, screen, self._aligned)

    def _drop_aligned(self) -> None:
        _release(self._aligned)
        self._aligned = None

    def _is_settling(self, rig: Rig) -> bool:
        return (
            rig.prefilter.method == "optimal"
            and self._aligned is None
            and self._settled < _SETTLING_FRAMES
        )

    def _look(self, names: list[str]) -> None:
        """Look at what is wanted: whole on a GPU, else for a while; anew only the coarsest."""
        coming = [name for name in names if not self._looks[name].is_done]
        is_new = any(self._looks[name].stride == 0 for name in coming)
        for name in coming:
            run: Callable[[Patch], None] = (
                self._look_at_panel if name == "perceived" else self.stream.look_uncorrected
            )
            self._version += 1
            if not self.is_software:
                self._looks[name].whole(run)
            else:
                budget_ms = 0.0 if is_new else _LOOKING_MS / len(coming)
                self._looks[name].advance(run, budget_ms)

    def _look_at_panel(self, patch: Patch) -> None:
        self.stream.look(patch=patch, panel=self._aligned)

    def _liken(self, is_wanted: bool) -> None:
        """Measure what is perceived, where all of it is there and meant to be the target."""
        if is_wanted and self._looks["perceived"].is_done and self._aligned is None:
            stream = self.stream
            self.likening.update(self._version, stream.rig, stream.seen, stream.target)
        else:
            self.likening.forget()

    def put(
        self, tiles: tuple[Placed, ...], window_px: tuple[int, int], *, fade: float = 0.0
    ) -> None:
        """Show the pictures as they are in ``canvas``, faded to grey if that is asked for."""
        canvas = self._back
        if canvas is None or canvas.size_px != window_px:
            _release(canvas)
            self._back = None
            self._back = canvas = Texture(self._device, window_px, kind="f1", label="window")
        rig, panel = self.stream.rig, (0, 0, 0, 0)
        background = Tile((0, 0, *window_px), panel, (0.0, 0.0), 1.0)
        if len(tiles) != 1:
            self._show.run(rig, background, self._shown("target"), canvas, fade=fade)
        for each in tiles:
            self._show.run(
                rig,
                each.tile,
                self._shown(each.first),
                canvas,
                second=self._shown(each.second) if each.second else None,
                divider_px=each.divider_px,
                subpixels=each.has_subpixels,
                fade=fade,
            )
        # The last whole picture stays until the next one is whole.
        self._canvas, self._back = canvas, self._canvas

    def _shown(self, name: str) -> Shown:
        """A picture as far as it is there."""
        if name in self._looks:
            light = self.stream.seen if name == "perceived" else self.stream.seen_uncorrected
            return Shown(light, max(self._looks[name].stride, 1))
        if name == "panel":
            return Shown(self._aligned or self.stream.panel)
        return Shown(self.stream.target)

    def release(self) -> None:
        """Give everything back but device and live; the second call does nothing."""
        for canvas in (self._canvas, self._back):
            _release(canvas)
        self._canvas = self._back = None
        self._drop_aligned()
        self._owned.close()


def _release(canvas: Texture | None) -> None:
    if canvas is not None:
        canvas.release()
