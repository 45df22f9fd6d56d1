"""Frame after frame of one wearer: pictures and tables stay on the GPU.

    with Stream(device, rig) as stream:
        while True:
            rig = stream.begin()      # the frame belongs to this rig, wholly
            draw(stream.target, rig)
            stream.show()             # target -> panel
            stream.look()             # panel -> seen, if rays were asked for
            stream.look_uncorrected() # target -> seen without correction, if that was asked for

A new prescription (``change``) is made a piece at a time at the frames' beginnings and takes
over, whole, at the beginning of the frame after its last piece: no frame waits for it, and
each belongs to the old one or the new.
"""

from __future__ import annotations

import time
from collections.abc import Generator, Iterator
from contextlib import ExitStack
from functools import partial
from math import inf
from types import TracebackType
from typing import Any, Self

from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.optics.lateral import forward_changes
from vrlf.passes import Forward, Perceive, PerceiveTables, Sharpen, forward_tables
from vrlf.passes.perceive import WHOLE, Patch
from vrlf.renderer.making import Made, Part, Parts, advanced, at_once, making
from vrlf.renderer.steps import Exposure, bare_rig, check_rays, exposure_factor, operator_key
from vrlf.solve import Memory, Optimal, OptimalTables
from vrlf.solve.wiener import sharpen_pieces

# A third of a frame at 90 Hz: what is left serves the frame.
_LEAST_MAKING_MS = 4.0
# A frame slower than this holds no display's rate; then waiting long for what comes is worse
# than frames that are half as slow again.
_SLOW_FRAME_MS = 50.0


class Stream:
    """Owns one wearer's pictures, tables and programs on a device.

    Parameters
    ----------
    device : Device
        Stays its owner's.
    rig : Rig
        The first prescription; its tables are made at once.
    rays : int, optional
        For each retinal pixel; without them ``look`` is refused and costs nothing.
    uncorrected : bool
        Whether ``look_uncorrected`` will be asked for.
    making_ms : float, optional
        Time that a frame gives to the making of another prescription's tables; a piece of
        work that has begun is finished. Without it 4 ms, or half of a frame's own time where
        that is over 50 ms.
    """

    def __init__(
        self,
        device: Device,
        rig: Rig,
        *,
        rays: int | None = None,
        uncorrected: bool = False,
        making_ms: float | None = None,
    ) -> None:
        if rays is not None:
            check_rays(rays)
        self.device, self._rays, self._making_ms = device, rays, making_ms
        self._uncorrected, self._is_hurried = uncorrected, False
        self._owned = ExitStack()
        self._present: dict[str, Made] = {}
        self._making: Generator[None, None, Parts] | None = None
        self._coming: Rig | None = None
        self._wanted: Rig | None = None
        self._began: float | None = None
        self.frames = 0
        self.rig = rig
        device.make_current()
        try:
            self._forward = self._own(Forward(device))
            self._perceive = self._own(Perceive(device))
            self._optimal = self._own(Optimal(device))
            self._memory = self._own(Memory(device))
            self._sharpen = self._own(Sharpen(device))
            for _ in self._first(rig):
                pass
        except BaseException:
            self.release()
            raise

    def _own(self, item: Any) -> Any:
        self._owned.callback(item.release)
        return item

    def _first(self, rig: Rig) -> Iterator[None]:
        parts = yield from making(self._parts(rig), {})
        self._present = parts.replacing({})

    @property
    def target(self) -> Texture:
        """What both eyes should perceive, for the caller to write (rgba32f, linear light)."""
        return self._texture("target")

    @property
    def panel(self) -> Texture:
        """The panel image of the last ``show``; the target itself where nothing prefilters it."""
        return self._wanted_light if self._shows_target else self._texture("panel image")

    @property
    def seen(self) -> Texture:
        """What both eyes saw in the last ``look``."""
        return self._texture("perceived image")

    @property
    def seen_uncorrected(self) -> Texture:
        """What both eyes saw in the last ``look_uncorrected``."""
        return self._texture("uncorrected image")

    @property
    def is_changing(self) -> bool:
        """Whether another prescription is wanted that no frame belongs to yet."""
        return self._making is not None or self._wanted is not None

    def change(self, rig: Rig, *, rays: int | None = None, at_once: bool = False) -> None:
        """Want another prescription, headset or panel.

        One that is being made already is finished and shown first, so that a key held down is
        followed and not put off; of several wants the last one counts.

        Parameters
        ----------
        rig : Rig
        rays : int, optional
            Another number of rays from then on.
        at_once : bool
            Drop what is being made; the next frame waits until this is there.
        """
        self.device.require_texture_size(rig.panel.width_px, rig.panel.height_px, "panel")
        if rays is not None:
            check_rays(rays)
            self._rays = rays
        self._wanted, self._is_hurried = rig, at_once
        if at_once:
            self._drop_making()

    def begin(self) -> Rig:
        """Begin a frame: work on what comes, or swap it in; the rig that the frame belongs to.

        Raises
        ------
        VrlfError
            If what was wanted cannot be made; it is forgotten, and the old one stays.
        """
        self.device.make_current()
        if self._making is None and self._wanted is not None:
            self._coming, self._wanted = self._wanted, None
            self._making = making(self._parts(self._coming), self._present)
        budget_ms = inf if self._is_hurried else self._budget_ms()
        self._is_hurried = False
        if self._making is not None:
            self._advance(budget_ms)
        # Counted from here, the next interval is the frame's own, without what it gave away.
        self._began = time.perf_counter()
        self.frames += 1
        return self.rig

    def _budget_ms(self) -> float:
        """What this frame gives to the making, by how long the last one took."""
        if self._making_ms is not None:
            return self._making_ms
        own_ms = 0.0 if self._began is None else 1e3 * (time.perf_counter() - self._began)
        return own_ms / 2.0 if own_ms > _SLOW_FRAME_MS else _LEAST_MAKING_MS

    def _advance(self, budget_ms: float) -> None:
        making, coming = self._making, self._coming
        assert making is not None
        assert coming is not None
        # What fails is dropped before its error goes up.
        self._making = None
        parts = advanced(making, budget_ms)
        if parts is None:
            self._making = making
            return
        self._present, self.rig = parts.replacing(self._present), coming

    def forget(self) -> None:
        """Let the next frame depend on its target alone: ``optimal`` starts it cold."""
        self._memory.forget()

    def show(self) -> None:
        """Compute the panel image for the target."""
        sharpening = self._present["sharpening"].item
        if sharpening is not None:
            self._sharpen.run(sharpening, self.target, self._wanted_light)
        tables = self._present["prefilter"].item
        if self.rig.prefilter.method == "optimal":
            tables.ask(self.rig.prefilter)
            given = self.rig.prefilter
            self._optimal.frame(
                self._memory,
                tables,
                self.target,
                self.panel,
                steps=given.iterations,
                budget_ms=given.budget_ms,
            )
        elif not self._shows_target:
            self._forward.run(tables, self._wanted_light, self.panel)

    def look(
        self,
        exposure: Exposure = "auto",
        patch: Patch = WHOLE,
        panel: Texture | None = None,
    ) -> None:
        """Compute what both eyes see of the panel image, or of another one that it shows."""
        factor = exposure_factor(self.rig, exposure)
        tables = self._present["rays"].item
        if tables is None:
            raise ValueError("stream: found a look without rays, wanted Stream(..., rays=N)")
        shown = self.panel if panel is None else panel
        self._perceive.run(tables, shown, self.seen, exposure=factor, patch=patch)

    def look_uncorrected(self, patch: Patch = WHOLE) -> None:
        """Compute what both eyes see of the target itself on a panel without an array."""
        tables = self._present["bare rays"].item
        if tables is None:
            raise ValueError(
                "stream: found no rays without an array, wanted Stream(..., uncorrected=True)"
            )
        self._perceive.run(tables, self.target, self.seen_uncorrected, patch=patch)

    @property
    def _wanted_light(self) -> Texture:
        """The target, sharpened where the rig wants it."""
        sharpened = self._present["sharpened target"].item
        return self.target if sharpened is None else self._texture("sharpened target")

    @property
    def _shows_target(self) -> bool:
        return self._present["prefilter"].item is None

    def _texture(self, name: str) -> Texture:
        texture = self._present[name].item
        assert isinstance(texture, Texture)
        return texture

    def _parts(self, rig: Rig) -> Iterator[Part]:
        """What a rig needs, the long work first."""
        device, size = self.device, (rig.panel.width_px, rig.panel.height_px)
        yield self._prefilter_part(rig)
        yield from self._sharpening_parts(rig)
        yield self._rays_part("rays", rig)
        yield self._rays_part("bare rays", bare_rig(rig) if self._uncorrected else None)
        for name in ("target", "panel image", "perceived image"):
            yield Part(name, size, at_once(partial(Texture, device, size, label=name)))
        if self._uncorrected:
            name = "uncorrected image"
            yield Part(name, size, at_once(partial(Texture, device, size, label=name)))

    def _rays_part(self, name: str, rig: Rig | None) -> Part:
        rays = self._rays
        if rig is None or rays is None:
            return Part(name, None, at_once(lambda: None))
        return Part(
            name,
            (operator_key(rig), rays),
            at_once(partial(PerceiveTables, self.device, rig, rays)),
        )

    def _prefilter_part(self, rig: Rig) -> Part:
        method = rig.prefilter.method
        if method == "optimal":
            key: Any = (method, operator_key(rig))
            begin = partial(OptimalTables.building, self.device, rig, self._optimal.builder)
            return Part("prefilter", key, begin)
        if method == "none" or not forward_changes(rig):
            return Part("prefilter", "target itself", at_once(lambda: None))
        return Part("prefilter", (method, rig), partial(self._forward_pieces, rig))

    def _forward_pieces(self, rig: Rig) -> Generator[None, None, Any]:
        with ExitStack() as undo:
            tables = forward_tables(self.device, rig)
            undo.callback(tables.release)
            yield
            self._forward.complete(tables)
            undo.pop_all()
        return tables

    def _sharpening_parts(self, rig: Rig) -> Iterator[Part]:
        nothing = at_once(lambda: None)
        if rig.prefilter.method != "forward" or not rig.prefilter.wiener:
            yield Part("sharpening", None, nothing)
            yield Part("sharpened target", None, nothing)
            return
        device, size = self.device, (rig.panel.width_px, rig.panel.height_px)
        begin = partial(sharpen_pieces, device, rig, self._forward, self._perceive)
        yield Part("sharpening", rig, begin)
        texture = partial(Texture, device, size, label="sharpened target")
        yield Part("sharpened target", size, at_once(texture))

    def _drop_making(self) -> None:
        if self._making is not None:
            self._making.close()
            self._making = None

    def release(self) -> None:
        """Give everything back but the device; the second call does nothing."""
        self._drop_making()
        for each in self._present.values():
            if each.item is not None:
                each.item.release()
        self._present = {}
        self._owned.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.release()
