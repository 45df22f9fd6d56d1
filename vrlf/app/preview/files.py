"""The files of a window: the rig it came from, the screenshots it leaves."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from vrlf.app.options import RigChoice
from vrlf.app.preview.session import Session
from vrlf.images import write_encoded
from vrlf.model import Rig


@dataclass
class Files:
    """Where the window reads and writes.

    Attributes
    ----------
    choice : RigChoice
        The rig as the command line named it.
    folder : Path
        For screenshots.
    """

    choice: RigChoice
    folder: Path

    @property
    def name(self) -> str:
        """The rig's name or file."""
        return self.choice.name

    def load(self) -> Rig:
        """Read the rig again."""
        return self.choice.load()

    def save(self, rig: Rig) -> str:
        """Save it."""
        raise NotImplementedError

    def has_changed(self) -> bool:
        """Whether another program wrote the rig since it was read; says so once."""
        return False

    def shoot(self, codes: NDArray[Any], session: Session) -> Path:
        """Write a screenshot, the rig in it."""
        stamp = datetime.now().strftime("%Y%m%d-%H%M%S")
        path = self.folder / f"vrlf-{stamp}.png"
        number = 1
        while path.exists():
            number += 1
            path = self.folder / f"vrlf-{stamp}-{number}.png"
        metadata = {"rig": session.rig.model_dump_json(by_alias=True), "view": session.view}
        write_encoded(path, codes, metadata=metadata)
        return path
