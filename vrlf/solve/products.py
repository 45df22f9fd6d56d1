"""P l and P'r on pictures: the tabulated operator and its adjoint, applied."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from vrlf.gpu import Block, ComputePass, ComputeVariants, Device, Field, Texture
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
Which = Literal["forward", "adjoint", "variance"]
# Of a table's entries: none has a sign; they have; their sizes alone.
_PLAIN, _SIGNED, _SIZES = range(3)


@dataclass(frozen=True)
class Levels:
    """What black and full drive of a target become."""

    black_level: float
    brightness: float


class Products:
    """Owns the programs that apply a table, one for each kind met so far."""

    def __init__(self, device: Device) -> None:
        self._programs = ComputeVariants(device, "operator_apply.comp", APPLY)

    def ready(self, operator: OperatorTables, *, levels: Levels | None = None) -> Product:
        """A product of this operator, to be run as often as is wanted until the next is made.

        With ``levels`` what the target means there is taken off.
        """
        return self._ready(operator, _PLAIN, levels)

    def varied(self, operator: OperatorTables, *, sizes: bool = False) -> Product:
        """The product with V of a tolerant operator, or with the sizes of its entries."""
        return self._ready(operator, _SIZES if sizes else _SIGNED, None)

    def _ready(self, operator: OperatorTables, signs: int, levels: Levels | None) -> Product:
        program = self._programs.get({**operator.defines, "SIGNED": signs})
        values: dict[str, Any] = {
            **(operator.values if signs == _PLAIN else operator.variance_values),
            "subtracted": 0.0 if levels is None else 1.0,
            "brightness": 1.0 if levels is None else levels.brightness,
            "black_level": 0.0 if levels is None else levels.black_level,
        }
        program.set(values)
        return Product(program, operator)

    def apply(
        self, operator: OperatorTables, which: Which, light: Texture, result: Texture
    ) -> None:
        """Write P light, or P' light, once."""
        self.ready(operator).run(which, light, light, result)

    def release(self) -> None:
        """Give the programs back."""
        self._programs.release()


@dataclass(frozen=True)
class Product:
    """A program with its numbers set: nothing is left to do but to bind and to run."""

    program: ComputePass
    operator: OperatorTables

    def run(self, which: Which, light: Texture, target: Texture, result: Texture) -> None:
        """Write P light, or P' light; less what the target means, if levels were given."""
        light.bind_sampler(0)
        target.bind_sampler(1)
        result.bind_image(0, read=False, write=True)
        self.operator.bind(which)
        self.program.run(*self.operator.size_px)
