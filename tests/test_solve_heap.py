"""Freed memory goes back to the system when tables are given back."""

from __future__ import annotations

from typing import Any

import pass_rigs
import pytest

from vrlf.gpu import Device
from vrlf.passes import phases
from vrlf.solve import OptimalTables, TableBuilder, tables
from vrlf.solve.heap import give_back_freed


def test_it_goes_back_once_for_each_prescription(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(phases, "_RAYS_AN_EYE", 1 << 18)
    given_back: list[int] = []
    monkeypatch.setattr(tables, "give_back_freed", lambda: given_back.append(1))
    builder = TableBuilder(device)
    for count in (1, 2):
        OptimalTables(device, pass_rigs.SMALL["bgr-walls"], builder).release()
        assert len(given_back) == count
    builder.release()


@pytest.mark.parametrize(("platform", "wanted"), [("linux", [0]), ("win32", [])])
def test_where_the_library_can(
    monkeypatch: pytest.MonkeyPatch, platform: str, wanted: list[int]
) -> None:
    give_back_freed()
    trimmed: list[int] = []

    class Library:
        """A C library, with or without what glibc has."""

        def __init__(self, **functions: Any) -> None:
            self.__dict__.update(functions)

    monkeypatch.setattr("sys.platform", platform)
    monkeypatch.setattr("ctypes.CDLL", lambda _: Library(malloc_trim=trimmed.append))
    give_back_freed()
    monkeypatch.setattr("ctypes.CDLL", lambda _: Library())
    give_back_freed()
    assert trimmed == wanted
