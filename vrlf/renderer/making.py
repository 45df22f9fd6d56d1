"""Tables of another prescription, made a piece at a time while frames run.

What a prescription needs falls into parts, each with the key that it depends on: a part whose
key stays is taken over, the others are made anew. Making is a generator that rests after each
bounded piece of work; closed half-way it gives back what it had made.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, Protocol


class Releasable(Protocol):
    """Whatever owns something on the GPU."""

    def release(self) -> None:
        """Give it back."""


# Rests between pieces; returns what was made.
Pieces = Generator[None, None, Any]


@dataclass(frozen=True)
class Part:
    """One thing that a prescription needs.

    Attributes
    ----------
    name : str
    key : hashable or comparable
        What it depends on; equal keys make equal parts.
    pieces : callable
        Begins to make it.
    """

    name: str
    key: Any
    pieces: Callable[[], Pieces]


@dataclass(frozen=True)
class Made:
    """A part that is there, and its key."""

    key: Any
    item: Any


def at_once(make: Callable[[], Any]) -> Callable[[], Pieces]:
    """A part that is one piece of work."""

    def pieces() -> Pieces:
        return make()
        yield

    return pieces


def making(parts: Iterable[Part], present: Mapping[str, Made]) -> Generator[None, None, Parts]:
    """Make what ``present`` lacks; the rest is named, to be taken over at the swap."""
    with ExitStack() as undo:
        made: dict[str, Made] = {}
        taken: list[str] = []
        for part in parts:
            if part.name in present and present[part.name].key == part.key:
                taken.append(part.name)
                continue
            item = yield from part.pieces()
            if item is not None:
                undo.callback(item.release)
            made[part.name] = Made(part.key, item)
            yield
        undo.pop_all()
        return Parts(made, tuple(taken))


@dataclass(frozen=True)
class Parts:
    """What was made, and the names of what is taken over from before."""

    made: Mapping[str, Made]
    taken: tuple[str, ...]

    def replacing(self, present: Mapping[str, Made]) -> dict[str, Made]:
        """The new whole; what it does not take over is given back."""
        for name, old in present.items():
            if name not in self.taken and old.item is not None:
                old.item.release()
        return {**{name: present[name] for name in self.taken}, **self.made}

    def release(self) -> None:
        """Give back what was made, if it is not wanted after all."""
        for each in self.made.values():
            if each.item is not None:
                each.item.release()


def advanced(work: Generator[None, None, Any], budget_ms: float) -> Any:
    """Do pieces of ``work`` until the time is used up; its result, or None if some is left.

    At least one piece is done, so that it ends however small the budget is.
    """
    started = time.perf_counter()
    while True:
        try:
            next(work)
        except StopIteration as done:
            return done.value
        if 1e3 * (time.perf_counter() - started) >= budget_ms:
            return None
