"""What is made of one result of the thesis: both sides in words and numbers, and a picture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from types import TracebackType
from typing import Any, Self

from vrlf.model import Rig
from vrlf.renderer import GpuRenderer, Image

Draw = Callable[[str, Rig, GpuRenderer], Image]


@dataclass(frozen=True)
class Number:
    """One quantity, ours beside the thesis's.

    Attributes
    ----------
    what, unit : str
    ours : float or None
        None where there is no such thing.
    thesis : float, (least, most) or None
        What it states, or what its formula gives with its own numbers; None where it is silent.
    sentence : str
        Why they differ, or what to make of it.
    """

    what: str
    unit: str
    ours: float | None
    thesis: float | tuple[float, float] | None = None
    sentence: str = ""

    @property
    def difference(self) -> float | None:
        """Ours less the thesis's; 0 within a range that it gives."""
        if self.ours is None or self.thesis is None:
            return None
        least, most = self.thesis if isinstance(self.thesis, tuple) else (self.thesis, self.thesis)
        return self.ours - min(max(self.ours, least), most)

    def to_json(self) -> dict[str, Any]:
        """One of an item's ``numbers``; null where JSON has no such number."""
        thesis = list(self.thesis) if isinstance(self.thesis, tuple) else self.thesis
        apart = self.difference
        return {
            "what": self.what,
            "unit": self.unit,
            "ours": self.ours if self.ours is not None and isfinite(self.ours) else None,
            "thesis": thesis,
            "difference": apart if apart is not None and isfinite(apart) else None,
            "sentence": self.sentence,
        }


@dataclass(frozen=True)
class Picture:
    """A PNG by its file name, and what it shows."""

    name: str
    caption: str
    png: bytes


@dataclass(frozen=True)
class Item:
    """One result of the thesis and this project's counterpart.

    Attributes
    ----------
    name : str
        As the command knows it.
    title : str
    thesis_says, we_find : str
        Sentences.
    numbers : tuple of Number
    pictures : tuple of Picture
    """

    name: str
    title: str
    thesis_says: str
    we_find: str
    numbers: tuple[Number, ...]
    pictures: tuple[Picture, ...]

    def to_json(self) -> dict[str, Any]:
        """One of the report's ``items``."""
        return {
            "name": self.name,
            "title": self.title,
            "thesis_says": self.thesis_says,
            "we_find": self.we_find,
            "numbers": [each.to_json() for each in self.numbers],
            "pictures": [{"file": each.name, "caption": each.caption} for each in self.pictures],
        }


class Workbench:
    """What items are made with. Owns the renderer, which is made when one first asks for it.

    Parameters
    ----------
    draw : callable
        Gives the target that a source's name stands for, (H, W, 3) linear light.
    say : callable, optional
        Told what is being done.
    """

    def __init__(self, draw: Draw, say: Callable[[str], None] | None = None) -> None:
        self._draw = draw
        self._renderer: GpuRenderer | None = None
        self.say = say or (lambda _: None)

    @property
    def renderer(self) -> GpuRenderer:
        """Raises ``DeviceError`` where there is no GPU; items that need none then still serve."""
        if self._renderer is None:
            self._renderer = GpuRenderer()
        return self._renderer

    @property
    def device_name(self) -> str | None:
        """What did the work; None if nothing asked for it."""
        return None if self._renderer is None else self._renderer.device.info.renderer

    def target(self, source: str, rig: Rig) -> Image:
        """What both eyes should perceive of a source, (H, W, 3) linear light."""
        return self._draw(source, rig, self.renderer)

    def release(self) -> None:
        """Give the renderer back."""
        if self._renderer is not None:
            self._renderer.release()
            self._renderer = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.release()
