"""Finished cases of an evaluation on the disk, so that a stopped one goes on.

A case's folder is named after its key, a hash of all that its result depends on: a folder with
another key is another case's, and what it holds is never taken for this one. ``case.json`` is
written last and names every other file with its checksum, so that a case is finished or not
there.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from vrlf.files import atomic_write_text, make_folder
from vrlf.images import write_encoded

CASES: Final = "cases"
_RECORD: Final = "case.json"
_KEY_LETTERS: Final = 12
_LONGEST_NAME: Final = 40


@dataclass(frozen=True)
class EyeFound:
    """What one eye perceives with one method, in numbers.

    Attributes
    ----------
    values
        By metric; a number, several by name, or None where it isn't defined.
    reasons
        Why not, for those.
    failed
        Metrics that gave no answer, each with the reason in one line.
    maps
        The file of each map, by ``metric`` or ``metric/map``.
    """

    values: dict[str, Any]
    reasons: dict[str, str] = field(default_factory=dict)
    failed: dict[str, str] = field(default_factory=dict)
    maps: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class CaseFound:
    """One source, rig and method: numbers and pictures of both eyes.

    Attributes
    ----------
    key : str
        Of the case.
    left, right : EyeFound
    files : mapping of str to str
        Names of the pictures and the checksums of what is in them.
    """

    key: str
    source: str
    rig: str
    method: str
    left: EyeFound
    right: EyeFound
    files: dict[str, str]

    def eye(self, side: str) -> EyeFound:
        """The left one's or the right one's."""
        return self.left if side == "left" else self.right


def key_of(parts: Mapping[str, Any]) -> str:
    """A hash of all that a result depends on."""
    text = json.dumps(parts, sort_keys=True, ensure_ascii=True)
    return hashlib.sha256(text.encode()).hexdigest()


def picture_digest(picture: NDArray[np.float32]) -> str:
    """A hash of a picture's numbers."""
    whole = np.ascontiguousarray(picture)
    return hashlib.sha256(str(whole.shape).encode() + whole.tobytes()).hexdigest()


def slug(name: str) -> str:
    """A name as part of a file's: letters, digits, dots, dashes."""
    stem = re.split(r"[/\\]", name)[-1] or name
    return re.sub(r"[^A-Za-z0-9._-]+", "-", stem).strip("-.")[:_LONGEST_NAME] or "unnamed"


def case_folder(folder: Path, source: str, rig: str, method: str, key: str) -> Path:
    """Where a case's files lie."""
    return folder / CASES / f"{slug(source)}--{slug(rig)}--{method}--{key[:_KEY_LETTERS]}"


def target_folder(folder: Path, source: str, rig: str, digest: str) -> Path:
    """Where the pictures of what should be perceived lie."""
    return folder / CASES / f"{slug(source)}--{slug(rig)}--target--{digest[:_KEY_LETTERS]}"


def load_case(place: Path, key: str) -> CaseFound | None:
    """A finished case; None if it isn't there, is another's, or any of its files is damaged."""
    try:
        record = json.loads((place / _RECORD).read_text(encoding="utf-8"))
        left, right = (EyeFound(**record.pop(side)) for side in ("left", "right"))
        found = CaseFound(left=left, right=right, **record)
        whole = all(_digest((place / n).read_bytes()) == d for n, d in found.files.items())
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return None
    return found if whole and found.key == key else None


def store_case(
    place: Path, found: CaseFound, pictures: Mapping[str, NDArray[np.uint8]]
) -> CaseFound:
    """Write a case, its record last; the case with its files' checksums.

    Parameters
    ----------
    pictures : mapping
        Encoded sRGB, (H, W, 3), by file name.

    Raises
    ------
    OutputError, OutputPathError
        The disk is full, or the place cannot be written.
    """
    make_folder(place)
    for name, codes in pictures.items():
        write_encoded(place / name, np.ascontiguousarray(codes))
    files = {name: _digest((place / name).read_bytes()) for name in pictures}
    whole = CaseFound(**{**_fields(found), "files": files})
    text = json.dumps(asdict(whole), indent=2, allow_nan=False)
    atomic_write_text(place / _RECORD, text + "\n")
    return whole


def _fields(found: CaseFound) -> dict[str, Any]:
    return {name: getattr(found, name) for name in found.__dataclass_fields__}


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
