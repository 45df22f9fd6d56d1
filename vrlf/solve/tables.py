"""What the solver needs of one prescription: the operator, and the metric that follows from it."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import ExitStack
from typing import Self

import numpy as np

from vrlf.gpu import Device, Texture
from vrlf.model import Prefilter, Rig
from vrlf.passes.operator import OperatorTables
from vrlf.passes.tabulate import RowBuilder
from vrlf.solve.heap import give_back_freed
from vrlf.solve.products import Levels, Products, Which


class TableBuilder:
    """Owns the programs that tables are made with."""

    def __init__(self, device: Device) -> None:
        self.rows = RowBuilder(device)
        self.products = Products(device)

    def release(self) -> None:
        """Give the programs back."""
        self.rows.release()
        self.products.release()


class OptimalTables:
    """The operator of one rig, made for a prescription, and what is asked of the solver.

    Owns the operator's tables, P'1 (``reached``) and P'P1 (``curvature``; with a tolerance what V
    can add to it at most is in it): a swap leaves nothing to be worked out at the frame's border.
    """

    operator: OperatorTables
    reached: Texture
    curvature: Texture

    def __init__(self, device: Device, rig: Rig, builder: TableBuilder) -> None:
        for _ in self._pieces(device, rig, builder):
            pass

    @classmethod
    def building(
        cls, device: Device, rig: Rig, builder: TableBuilder
    ) -> Generator[None, None, Self]:
        """The same tables, byte for byte, a piece of some milliseconds at a time.

        Rests after each piece; closed half-way it gives back what it had made. All pieces
        are for the thread that the device belongs to.

        Returns
        -------
        OptimalTables
            As the generator's own return value (``yield from``, or ``StopIteration.value``).
        """
        tables = cls.__new__(cls)
        yield from tables._pieces(device, rig, builder)
        return tables

    def _pieces(
        self, device: Device, rig: Rig, builder: TableBuilder
    ) -> Generator[None, None, None]:
        self.ask(rig.prefilter)
        with ExitStack() as undo:
            self.operator = yield from OperatorTables.building(device, rig, builder.rows)
            undo.callback(self.operator.release)
            self.reached = self._texture(device, "P'1", undo)
            self.curvature = self._texture(device, "P'P1", undo)
            yield
            yield from self._measure(device, builder.products)
            device.check("making the optimal prefilter's tables")
            undo.pop_all()

    def _measure(self, device: Device, products: Products) -> Generator[None, None, None]:
        """P'1 and P'P1, a product a piece."""
        with ExitStack() as undo:
            ones, seen = (self._texture(device, name, undo) for name in ("ones", "P1"))
            width, height = ones.size_px
            yield
            ones.write(np.ones((height, width, 4), np.float16))
            yield
            work: tuple[tuple[Which, Texture, Texture], ...] = (
                ("adjoint", ones, self.reached),
                ("forward", ones, seen),
                ("adjoint", seen, self.curvature),
            )
            for which, light, result in work:
                products.apply(self.operator, which, light, result)
                yield
            if self.operator.is_tolerant:
                # Row by row the sizes of V's entries bound it as P'P1 bounds P'P.
                products.varied(self.operator, sizes=True).run("variance", ones, ones, seen)
                yield
                summed = self.curvature.read().astype(np.float32) + seen.read().astype(np.float32)
                self.curvature.write(summed.astype(np.float16))
                yield

    def _texture(self, device: Device, label: str, undo: ExitStack) -> Texture:
        texture = Texture(device, self.operator.size_px, kind="f2", label=f"optimal {label}")
        undo.callback(texture.release)
        return texture

    def ask(self, given: Prefilter) -> None:
        """Take other light levels and limits; the operator does not depend on them."""
        self.levels = Levels(given.black_level, given.brightness)
        self.iterations = given.iterations
        self.budget_ms = given.budget_ms

    def release(self) -> None:
        """Give everything back."""
        self.operator.release()
        self.reached.release()
        self.curvature.release()
        # What making the tables that replace these took and freed, too.
        give_back_freed()
