"""P l and P'r on pictures: the tabulated operator and its adjoint, applied."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from vrlf.gpu import Block, ComputeVariants, Device, Field, Texture
from vrlf.passes.operator import TABLE_FIELDS, OperatorTables

APPLY = Block(
    "Apply",
    (
        *TABLE_FIELDS,
        Field("float", "subtracted", "1 to take the target off, 0 to apply the table alone"),
        Field("float", "brightness", "what full drive of the target becomes"),
        Field("float", "black_level", "what black becomes"),
    ),
)
Which = Literal["forward", "adjoint"]


@dataclass(frozen=True)
class Levels:
    """What black and full drive of a target become."""

    black_level: float
    brightness: float


class Products:
    """Owns the programs that apply a table, one for each kind met so far."""

    def __init__(self, device: Device) -> None:
        self._programs = ComputeVariants(device, "operator_apply.comp", APPLY)

    def apply(
        self,
        operator: OperatorTables,
        which: Which,
        light: Texture,
        result: Texture,
        *,
        target: Texture | None = None,
        levels: Levels | None = None,
    ) -> None:
        """Write P light, or P' light; less what ``target`` means at ``levels``, if given."""
        light.bind_sampler(0)
        (target or light).bind_sampler(1)
        result.bind_image(0, read=False, write=True)
        operator.bind(which)
        values: dict[str, Any] = {
            **operator.values,
            "subtracted": 0.0 if target is None else 1.0,
            "brightness": 1.0 if levels is None else levels.brightness,
            "black_level": 0.0 if levels is None else levels.black_level,
        }
        program = self._programs.get(operator.defines)
        program.set(values)
        program.run(*operator.size_px)

    def release(self) -> None:
        """Give the programs back."""
        self._programs.release()
