"""A file of JSON lines that only grows: a line is whole or, after a crash, taken off again.

What is written survives the end of this process at once, and a loss of power after a second
at most: that often the disk is made to hold it.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from vrlf.errors import OutputError, OutputPathError
from vrlf.files import shown

_SYNC_S: Final = 1.0


class Journal:
    """The file, held by one process alone while it is open."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._synced = time.monotonic()
        flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0)
        try:
            self._file = os.open(path, flags, 0o666)
        except OSError as error:
            raise OutputPathError(
                f"{shown(path)}: found '{error.strerror}', wanted a file to write"
            ) from None
        if not _locked(self._file):
            os.close(self._file)
            raise OutputPathError(
                f"{shown(path.parent)}: found another sweep at work in it, wanted it for this "
                "one alone; wait for its end"
            )
        self._end = self._whole_lines()

    def _whole_lines(self) -> int:
        """Where the last whole line ends; what a crash left behind it goes."""
        data = self._path.read_bytes()
        end = data.rfind(b"\n") + 1
        if end < len(data):
            os.ftruncate(self._file, end)
        return end

    def lines(self) -> Iterator[Any]:
        """Each line's value; None for one that is no JSON."""
        with self._path.open("rb") as file:
            for line in file:
                try:
                    yield json.loads(line)
                except ValueError:
                    yield None

    def add(self, value: Any) -> None:
        """Write a line.

        Raises
        ------
        OutputError
            A full disk; the line is not there, those before it are.
        """
        line = json.dumps(value, ensure_ascii=True, separators=(",", ":")).encode() + b"\n"
        try:
            os.lseek(self._file, self._end, os.SEEK_SET)
            rest = memoryview(line)
            while rest:
                rest = rest[os.write(self._file, rest) :]
            self._end += len(line)
            if time.monotonic() - self._synced > _SYNC_S:
                self.sync()
        except OSError as error:
            os.ftruncate(self._file, self._end)
            raise OutputError(
                f"{shown(self._path)}: found '{error.strerror}' while writing, wanted room for "
                "more rows"
            ) from None

    def sync(self) -> None:
        """Have the disk hold all of it."""
        os.fsync(self._file)
        self._synced = time.monotonic()

    def clear(self) -> None:
        """Begin anew, empty."""
        os.ftruncate(self._file, 0)
        self._end = 0
        self.sync()

    def close(self) -> None:
        """Let others have it."""
        os.close(self._file)


def _locked(file: int) -> bool:
    """Take the file for this process alone; the system frees it however the process ends."""
    try:
        import fcntl
    except ImportError:  # Windows: nothing to hold it with that frees itself
        return True
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True
