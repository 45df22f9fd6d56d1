"""The files of a window: the rig it came from, the screenshots it leaves."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from vrlf.app.options import RigChoice
from vrlf.app.preview.session import Session
from vrlf.files import shown
from vrlf.images import write_encoded
from vrlf.model import Rig
from vrlf.model.saving import new_rig_file, read_text, rig_text, save_rig


class Files:
    """Where a window reads and writes.

    Parameters
    ----------
    choice : RigChoice
        The rig as the command line named it; what it changes stays changed until saved.
    folder : Path
        For screenshots, and for a new rig file.
    """

    def __init__(self, choice: RigChoice, folder: Path) -> None:
        self._choice, self._folder = choice, folder
        self._path = Path(choice.name) if _is_path(choice.name) else None
        self._text = read_text(self._path) if self._path else ""
        self._stamp = self._stamped()
        self._has_told = False

    @property
    def name(self) -> str:
        """The rig's name or file, as it was given."""
        return self._choice.name

    def load(self) -> Rig:
        """Read the rig again, as it lies in its file now."""
        rig = self._choice.load()
        if self._path:
            self._take(read_text(self._path))
        return rig

    def save(self, rig: Rig) -> str:
        """Save it: into its file, or beside it all as a new file that extends a shipped rig."""
        if self._path:
            self._take(save_rig(self._path, rig, self._text))
        else:
            path = self._unused(f"{self._choice.name}-mine", ".toml")
            text = new_rig_file(path, rig, self._choice.name)
            self._path = path
            self._take(text)
        # From now on the file itself says what the command line had changed.
        self._choice = RigChoice(str(self._path), (), None, None, None)
        return shown(self._choice.name)

    def has_changed(self) -> bool:
        """Whether another program wrote the rig since it was read; says so once."""
        if self._path is None or self._has_told or self._stamped() == self._stamp:
            return False
        self._has_told = True
        return True

    def shoot(self, codes: NDArray[Any], session: Session) -> str:
        """Write a screenshot, lossless, the whole rig in its metadata; its name."""
        path = self._unused(f"vrlf-{datetime.now():%Y%m%d-%H%M%S}", ".png")
        metadata = {"rig": rig_text(session.rig), "view": session.view, "eyes": session.eyes}
        write_encoded(path, codes, metadata=metadata)
        return shown(path)

    def _take(self, text: str) -> None:
        self._text, self._stamp, self._has_told = text, self._stamped(), False

    def _stamped(self) -> tuple[int, int] | None:
        """What changes when a file is written."""
        try:
            found = self._path.stat() if self._path else None
        except OSError:
            return None
        return (found.st_mtime_ns, found.st_size) if found else None

    def _unused(self, stem: str, ending: str) -> Path:
        path, number = self._folder / f"{stem}{ending}", 1
        while path.exists():
            number += 1
            path = self._folder / f"{stem}-{number}{ending}"
        return path


def _is_path(name: str) -> bool:
    return name.endswith(".toml") or "/" in name or "\\" in name


def as_loaded(session: Session, rig: Rig) -> Session:
    """The session with the rig as its file has it now, and undo back to what it was."""
    past = session.past if rig == session.rig else (*session.past, session.rig)
    return replace(session, rig=rig, loaded=rig, past=past, future=(), holding="")
