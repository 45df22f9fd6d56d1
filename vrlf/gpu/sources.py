"""Shader sources: nested ``#include``, defines, and errors that name file and line.

``#include "name"`` takes ``name`` from the shaders folder, each file once. Blocks that are
declared in Python come as virtual files ``block/NAME``. Each stretch of text carries
``#line`` with the number of its file, which every driver accepts; ``explain`` puts the
file's name back into what the compiler says.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from vrlf.errors import ShaderError

_INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"\s*$')
# Mesa: "2:17(5): error", NVIDIA: "2(17) : error", others: "ERROR: 2:17:".
_MESA = re.compile(r"\b(\d+):(\d+)\((\d+)\)")
_NVIDIA = re.compile(r"^(\d+)\((\d+)\)\s*:", re.MULTILINE)
_OTHER = re.compile(r"\b(ERROR|WARNING): (\d+):(\d+):")
GLSL_VERSION = "430"


@dataclass(frozen=True)
class Source:
    """Assembled GLSL and the files that it came from, in the order of their numbers."""

    text: str
    files: tuple[str, ...]

    def explain(self, message: str) -> str:
        """A compiler's message with file names in place of source numbers."""

        def named(match: re.Match[str], file: int, line: int) -> str:
            number = int(match.group(file))
            name = self.files[number] if number < len(self.files) else match.group(file)
            return f"{name}:{match.group(line)}"

        message = _MESA.sub(lambda m: named(m, 1, 2), message)
        message = _NVIDIA.sub(lambda m: named(m, 1, 2) + ":", message)
        return _OTHER.sub(lambda m: f"{m.group(1)}: {named(m, 2, 3)}:", message)


def assemble(
    name: str,
    folder: Path,
    *,
    defines: Mapping[str, int | float | str] | None = None,
    virtual: Mapping[str, str] | None = None,
) -> Source:
    """A shader with its includes.

    Parameters
    ----------
    name : str
        File below ``folder``.
    defines : mapping, optional
        ``#define``s that stand before everything.
    virtual : mapping, optional
        Files that are not on disk, by name.

    Raises
    ------
    ShaderError
        If a file is missing or includes itself.
    """
    head = [f"#version {GLSL_VERSION}"]
    head += [f"#define {key} {value}" for key, value in (defines or {}).items()]
    assembler = _Assembler(folder, dict(virtual or {}))
    body = assembler.expand(name, ())
    return Source("\n".join([*head, *body]) + "\n", tuple(assembler.files))


class _Assembler:
    def __init__(self, folder: Path, virtual: dict[str, str]) -> None:
        self._folder, self._virtual = folder, virtual
        self.files: list[str] = []

    def expand(self, name: str, chain: tuple[str, ...]) -> list[str]:
        if name in chain:
            raise ShaderError(f"{name}: includes itself ({' > '.join([*chain, name])})")
        if name in self.files:
            return []
        number = len(self.files)
        self.files.append(name)
        lines = [f"#line 1 {number}"]
        for line_number, line in enumerate(self._text(name, chain).splitlines(), start=1):
            match = _INCLUDE.match(line)
            if match:
                lines += self.expand(match.group(1), (*chain, name))
                lines.append(f"#line {line_number + 1} {number}")
            else:
                lines.append(line)
        return lines

    def _text(self, name: str, chain: tuple[str, ...]) -> str:
        if name in self._virtual:
            return self._virtual[name]
        try:
            return (self._folder / name).read_text(encoding="utf-8")
        except OSError as error:
            by = f", included by {chain[-1]}" if chain else ""
            raise ShaderError(f"shader {name}{by}: cannot be read ({error.strerror})") from error
