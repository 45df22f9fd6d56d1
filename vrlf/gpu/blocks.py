"""Uniform blocks: one declaration gives the numpy dtype and the GLSL text.

std140 pads in ways that are easy to get wrong, so only types without surprises are
allowed: float, int, vec2, ivec2, vec4, ivec4, mat4, arrays of the 16-byte ones, and arrays
of structs. The compute pass checks the size against the compiled program.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

# GLSL type: (bytes, alignment, numpy base type, numpy shape)
_TYPES: dict[str, tuple[int, int, str, tuple[int, ...]]] = {
    "float": (4, 4, "<f4", ()),
    "int": (4, 4, "<i4", ()),
    "vec2": (8, 8, "<f4", (2,)),
    "ivec2": (8, 8, "<i4", (2,)),
    "vec4": (16, 16, "<f4", (4,)),
    "ivec4": (16, 16, "<i4", (4,)),
    "mat4": (64, 16, "<f4", (4, 4)),
}


@dataclass(frozen=True)
class Field:
    """One member: its GLSL type (or a ``Struct``), how many, and what it means."""

    kind: str | Struct
    name: str
    meaning: str
    count: int = 0  # 0: no array


@dataclass(frozen=True)
class Struct:
    """A named group of members that can stand in a block as an array."""

    name: str
    fields: tuple[Field, ...]

    @property
    def dtype(self) -> np.dtype[Any]:
        """std140 layout; the size is a multiple of 16."""
        return _layout(self.fields)

    @property
    def glsl(self) -> str:
        """``struct Name { ... };``"""
        return f"struct {self.name} {{\n{_members(self.fields)}}};\n"


@dataclass(frozen=True)
class Block:
    """A uniform block: known to Python by ``pack`` and to GLSL by ``glsl``."""

    name: str
    fields: tuple[Field, ...]
    binding: int = 0

    @property
    def dtype(self) -> np.dtype[Any]:
        """std140 layout of the whole block."""
        return _layout(self.fields)

    @property
    def glsl(self) -> str:
        """The structs it needs and the block, without an instance name."""
        kinds = (f.kind for f in self.fields)
        structs = dict.fromkeys(kind for kind in kinds if isinstance(kind, Struct))
        head = "".join(struct.glsl for struct in structs)
        opening = f"layout(std140, binding = {self.binding}) uniform {self.name} {{\n"
        return f"{head}{opening}{_members(self.fields)}}};\n"

    def pack(self, values: Mapping[str, Any]) -> NDArray[np.void]:
        """The block's bytes for these values; every member must be given, and no other.

        Struct arrays are given as sequences of mappings.
        """
        data = np.zeros((), self.dtype)
        _fill(data, self.name, self.fields, values)
        return data


def _fill(
    data: NDArray[np.void], owner: str, fields: tuple[Field, ...], values: Mapping[str, Any]
) -> None:
    names = {field.name for field in fields}
    if names != set(values):
        missing, extra = sorted(names - set(values)), sorted(set(values) - names)
        raise ValueError(f"block {owner}: missing {missing}, unknown {extra}")
    for field in fields:
        if isinstance(field.kind, Struct):
            for index in range(field.count):
                item = values[field.name][index]
                _fill(data[field.name][index], field.kind.name, field.kind.fields, item)
        else:
            data[field.name] = values[field.name]


def _layout(fields: tuple[Field, ...]) -> np.dtype[Any]:
    names: list[str] = []
    formats: list[Any] = []
    offsets: list[int] = []
    end = 0
    for field in fields:
        size, align, form = _one(field)
        end = -(-end // align) * align
        names.append(field.name)
        formats.append(form)
        offsets.append(end)
        end += size
    itemsize = -(-end // 16) * 16
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": itemsize})


def _one(field: Field) -> tuple[int, int, Any]:
    """Bytes, alignment and numpy format of a member."""
    if isinstance(field.kind, Struct):
        if not field.count:
            raise ValueError(f"{field.name}: a struct stands in a block as an array only")
        item = field.kind.dtype
        return item.itemsize * field.count, 16, (item, (field.count,))
    size, align, base, shape = _TYPES[field.kind]
    if not field.count:
        return size, align, (base, shape)
    if align != 16:
        raise ValueError(f"{field.name}: std140 pads arrays of {field.kind}; use vec4 or ivec4")
    return size * field.count, 16, (base, (field.count, *shape))


def _members(fields: tuple[Field, ...]) -> str:
    lines = []
    for field in fields:
        kind = field.kind.name if isinstance(field.kind, Struct) else field.kind
        array = f"[{field.count}]" if field.count else ""
        lines.append(f"    {kind} {field.name}{array};  // {field.meaning}\n")
    return "".join(lines)
