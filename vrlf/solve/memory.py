"""What one stream's next frame starts from."""

from __future__ import annotations

from vrlf.gpu import Device, Texture
from vrlf.solve.tables import OptimalTables

# A product reads and writes eight bytes a pixel. What it reads is from 0 to 1 and needs 16 bits
# evenly spread: with half floats, of which the last bit is 5e-4 near 1, a still picture never came
# to rest (200 frames, matched-microlens: 1.3 % of the codes changed in each, now 0.3 %).
_KINDS = {
    "stepped": "f4",
    "ahead": "f4",
    "begun": "f4",
    "before": "f4",
    "sought": "nu2",
    "product": "f2",
}
_TOLERANT_KINDS = {"varied": "f2"}


class Memory:
    """Owns the pictures that the solver keeps from frame to frame; made when first needed."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._pictures: dict[str, Texture] = {}
        self._tables: OptimalTables | None = None

    def forget(self) -> None:
        """Start the next frame cold."""
        self._tables = None

    def turn(self, tables: OptimalTables) -> bool:
        """Get ready for a frame: whether the last one had these tables, so that it counts."""
        size = tables.operator.size_px
        if self._pictures and self.product.size_px != size:
            self._give_back()
        kinds = _KINDS | (_TOLERANT_KINDS if tables.operator.is_tolerant else {})
        for name, kind in kinds.items():
            if name not in self._pictures:
                label = f"optimal {name}"
                self._pictures[name] = Texture(self._device, size, kind=kind, label=label)
        is_warm, self._tables = self._tables is tables, tables
        pictures = self._pictures
        pictures["begun"], pictures["before"] = pictures["before"], pictures["begun"]
        return is_warm

    @property
    def stepped(self) -> Texture:
        """The plain step w from the last picture; POGM's theta in its alpha."""
        return self._pictures["stepped"]

    @property
    def ahead(self) -> Texture:
        """The last picture before it was bounded, z; POGM's gamma in its alpha."""
        return self._pictures["ahead"]

    @property
    def sought(self) -> Texture:
        """The last picture, to be read by a product."""
        return self._pictures["sought"]

    @property
    def product(self) -> Texture:
        """Scratch: a product's result."""
        return self._pictures["product"]

    @property
    def varied(self) -> Texture:
        """Scratch: what a tolerance adds to the slope."""
        return self._pictures["varied"]

    @property
    def begun(self) -> Texture:
        """This frame's normalised backprojection."""
        return self._pictures["begun"]

    @property
    def before(self) -> Texture:
        """The last frame's."""
        return self._pictures["before"]

    def _give_back(self) -> None:
        for picture in self._pictures.values():
            picture.release()
        self._pictures.clear()
        self._tables = None

    def release(self) -> None:
        """Give the pictures back; the memory can be used again and is then empty."""
        self._give_back()
