"""Making items one after another; one that fails stops no other."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

from rich import box
from rich.table import Table

from vrlf import __version__
from vrlf.errors import InputError
from vrlf.studies.reproduce.item import Item, Number, Workbench

Make = Callable[[Workbench], Item]
_HERE: Final = "vrlf.studies.reproduce"


def _late(module: str, function: str = "make") -> Make:
    """The item of a module that is imported when the item is made."""

    def make(bench: Workbench) -> Item:
        item: Item = getattr(importlib.import_module(f"{_HERE}.{module}"), function)(bench)
        return item

    return make


# In the thesis's order; each with what it is about.
ITEMS: Final = MappingProxyType[str, tuple[str, Make]](
    {
        "fig-3-2": ("accommodation against age, clear zones", _late("accommodation")),
        "fig-3-4": ("Zernike polynomials up to the 6th order", _late("zernike")),
        "fig-3-6": ("wavefronts and point spreads of three corrected eyes", _late("aberrations")),
        "limits-4-3": ("limits of the array; gratings about its Nyquist", _late("array_limits")),
        "fringes-5-3": ("colour fringes with 1, 3, 9 and 27 samples a pixel", _late("fringes")),
        "fig-6-2": ("pre-sharpening, with its detection map", _late("sharpening")),
        "pinhole-7-1": ("the best pinhole, simulated with diffraction", _late("pinhole")),
        "table-8-1": ("the prototype's distances and what follows", _late("table_8_1")),
        "fig-8-4": ("desired, shown, uncorrected, corrected: one eye", _late("stereo", "make_8_4")),
        "fig-8-5": ("the same as a stereo pair", _late("stereo", "make_8_5")),
        "rays-9-1": ("one, nine and many rays a pixel", _late("rays")),
        "methods": ("forward and optimal, holes and lenslets, brightness", _late("methods")),
    }
)


@dataclass(frozen=True)
class Report:
    """What was made and what failed.

    Attributes
    ----------
    device : str or None
        What drew; None where nothing needed it.
    items : tuple of Item
    seconds : dict
        Of each item that was tried, by its name.
    failed : dict
        One line for each item that could not be made.
    """

    device: str | None
    items: tuple[Item, ...]
    seconds: dict[str, float]
    failed: dict[str, str]

    def to_json(self) -> dict[str, Any]:
        """For ``reproduce.json``."""
        return {
            "vrlf": __version__,
            "device": self.device,
            "items": [
                {**each.to_json(), "seconds": round(self.seconds[each.name], 1)}
                for each in self.items
            ],
            "failed": self.failed,
        }


def chosen(names: Sequence[str]) -> tuple[str, ...]:
    """The items of these names, each once, in the thesis's order; all of them if none is named.

    Raises
    ------
    InputError
        For a name that is none; the message lists those that are.
    """
    for name in names:
        if name not in ITEMS:
            raise InputError(
                f"--only: found {name[:40]!r}, wanted one of {', '.join(ITEMS)} "
                "('vrlf reproduce --list' says what each is)"
            )
    return tuple(name for name in ITEMS if not names or name in names)


def run_reproduce(
    bench: Workbench, names: Sequence[str], finished: Callable[[Item], None] | None = None
) -> Report:
    """Make items; ``finished`` is told each one as soon as it is there.

    Whatever goes wrong with one is a line of ``failed``, but for what ``finished`` raises.
    """
    items, seconds, failed = [], {}, {}
    for number, name in enumerate(names, 1):
        bench.say(f"{name} ({number} of {len(names)}): {ITEMS[name][0]}")
        began = time.perf_counter()
        try:
            item = ITEMS[name][1](bench)
        except Exception as error:  # the others do not depend on it
            failed[name] = _one_line(error)
            bench.say(f"{name}: failed: {failed[name]}")
            continue
        finally:
            seconds[name] = time.perf_counter() - began
        if finished is not None:
            finished(item)
        items.append(item)
    return Report(bench.device_name, tuple(items), seconds, failed)


def _one_line(error: Exception) -> str:
    text = " ".join(str(error).split())
    return text or type(error).__name__


def reproduce_table(report: Report) -> Table:
    """A row for each quantity that the thesis states otherwise, and how many stand beside them."""
    table = Table(box=box.SIMPLE_HEAD, show_edge=False)
    table.add_column("item", no_wrap=True)
    table.add_column("quantity")
    for heading in ("ours", "thesis", "difference"):
        table.add_column(heading, justify="right", no_wrap=True)
    for item in report.items:
        differ = [each for each in item.numbers if _differs(each)]
        for each in differ:
            what = f"{each.what}, {each.unit}" if each.unit else each.what
            table.add_row(item.name, what, *cells(each))
        others = len(item.numbers) - len(differ)
        if others:
            table.add_row(item.name, f"{others} {'others' if differ else 'numbers'} on the page")
    for name in report.failed:
        table.add_row(name, "failed")
    return table


def _differs(number: Number) -> bool:
    """Whether the thesis states it and a reader would see another number."""
    ours, thesis, _ = cells(number)
    return bool(number.difference) and ours != thesis


def cells(number: Number) -> tuple[str, str, str]:
    """Ours, the thesis's and the difference as text."""
    thesis = number.thesis
    ends = thesis if isinstance(thesis, tuple) else (thesis,)
    theirs = " to ".join(_text(each) for each in ends)
    difference = number.difference
    return _text(number.ours), theirs, "-" if difference is None else f"{difference:+.3g}"


def _text(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"
