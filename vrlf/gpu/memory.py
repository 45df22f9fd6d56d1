"""Textures and buffers: each registered with its device, checked on allocation, released once."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.errors import DeviceError
from vrlf.gpu.device import Device

# numpy kind -> moderngl's name of the component type.
_COMPONENT = {"float32": "f4", "float16": "f2", "uint8": "f1", "uint16": "nu2"}
_NUMPY = {"f4": np.float32, "f2": np.float16, "f1": np.uint8, "u1": np.uint8, "nu2": np.uint16}

_SRGB8_ALPHA8 = 0x8C43


class Texture:
    """A 2-D texture. Row 0 of the array is row 0 of ``texelFetch`` and ``imageStore``.

    Parameters
    ----------
    device : Device
    size_px : (width, height)
    components : int
        1, 2 or 4.
    kind : str
        ``f4`` and ``f2`` floats, ``f1`` 8-bit normalised, ``u1`` 8-bit integers,
        ``nu2`` 16-bit normalised.
    label : str
        What it holds, for error messages.
    """

    def __init__(
        self,
        device: Device,
        size_px: tuple[int, int],
        *,
        components: int = 4,
        kind: str = "f4",
        label: str = "texture",
    ) -> None:
        device.require_texture_size(*size_px, label)
        self._device, self.size_px, self.components, self.kind = device, size_px, components, kind
        self._dtype = np.dtype(_NUMPY[kind])
        self._label = label
        try:
            self._texture = device.context.texture(size_px, components, dtype=kind, alignment=1)
        except Exception as error:
            raise DeviceError(f"{label}: the GPU gave no {size_px} texture ({error})") from error
        nbytes = size_px[0] * size_px[1] * components * self._dtype.itemsize
        self._ticket = device.enlist(f"texture {label} {size_px[0]}x{size_px[1]}", nbytes)
        try:
            device.check(f"allocating {label}")
        except DeviceError:
            self.release()
            raise
        self.filter(linear=False)
        self._texture.repeat_x = self._texture.repeat_y = False

    @classmethod
    def from_array(cls, device: Device, pixels: NDArray[np.generic], *, label: str) -> Texture:
        """A texture that holds an (H, W) or (H, W, C) array; three channels become four."""
        pixels = pixels[..., None] if pixels.ndim == 2 else pixels
        kind = _COMPONENT[str(pixels.dtype)]
        components = 4 if pixels.shape[2] == 3 else pixels.shape[2]
        height, width = pixels.shape[:2]
        texture = cls(device, (width, height), components=components, kind=kind, label=label)
        texture.write(pixels)
        return texture

    @classmethod
    def photograph(cls, device: Device, codes: NDArray[np.uint8], *, label: str) -> Texture:
        """A picture for surfaces: sRGB codes (H, W, 4).

        The sampler decodes, repeats and shrinks it. Row 0 is the picture's top, v = 0.
        """
        height, width = codes.shape[:2]
        device.require_texture_size(width, height, label)
        made = cls.__new__(cls)
        made._device, made.size_px, made.components = device, (width, height), 4
        made.kind, made._dtype, made._label = "f1", np.dtype(np.uint8), label
        data = np.ascontiguousarray(codes).tobytes()
        try:
            made._texture = device.context.texture(
                (width, height), 4, data, alignment=1, internal_format=_SRGB8_ALPHA8
            )
        except Exception as error:
            raise DeviceError(
                f"{label}: the GPU gave no {made.size_px} texture ({error})"
            ) from error
        # With its smaller versions it takes a third more.
        nbytes = width * height * 16 // 3
        made._ticket = device.enlist(f"texture {label} {width}x{height}", nbytes)
        made._texture.build_mipmaps()
        made._texture.filter = (0x2703, 0x2601)  # GL_LINEAR_MIPMAP_LINEAR, GL_LINEAR
        made._texture.repeat_x = made._texture.repeat_y = True
        try:
            device.check(f"allocating {label}")
        except DeviceError:
            made.release()
            raise
        return made

    def write(self, pixels: NDArray[np.generic]) -> None:
        """Upload an (H, W, C) array; a missing fourth channel is filled with ones."""
        height, width = pixels.shape[:2]
        if (width, height) != self.size_px or str(pixels.dtype) != str(self._dtype):
            raise ValueError(
                f"{self._label}: found {width}x{height} {pixels.dtype}, "
                f"wanted {self.size_px[0]}x{self.size_px[1]} {self._dtype}"
            )
        if pixels.shape[2] == 3 and self.components == 4:
            full = 2 ** (8 * self._dtype.itemsize) - 1 if self._dtype.kind == "u" else 1
            alpha = np.full((height, width, 1), full, self._dtype)
            pixels = np.concatenate([pixels, alpha], axis=2)
        self._texture.write(np.ascontiguousarray(pixels).tobytes())
        self._device.check(f"uploading {self._label}")

    def read(self) -> NDArray[np.generic]:
        """Download as an (H, W, components) array of its own."""
        raw = self._texture.read(alignment=1)
        self._device.check(f"reading {self._label}")
        width, height = self.size_px
        return np.frombuffer(raw, self._dtype).reshape(height, width, self.components).copy()

    def read_into(self, buffer: NDArray[np.generic]) -> None:
        """Download into a kept array, without a new one a frame."""
        self._texture.read_into(buffer, alignment=1)
        self._device.check(f"reading {self._label}")

    def filter(self, *, linear: bool) -> None:
        """Nearest or bilinear reads through a sampler."""
        mode = 0x2601 if linear else 0x2600  # GL_LINEAR, GL_NEAREST
        self._texture.filter = (mode, mode)

    def bind_sampler(self, unit: int) -> None:
        """For ``layout(binding = unit) uniform sampler2D``."""
        self._texture.use(unit)

    def bind_image(self, unit: int, *, read: bool, write: bool) -> None:
        """For ``layout(binding = unit) uniform image2D``."""
        self._texture.bind_to_image(unit, read=read, write=write)

    def as_framebuffer(self, depth: Any) -> Any:
        """A framebuffer that draws into this texture; its maker releases it."""
        return self._device.context.framebuffer([self._texture], depth)

    @property
    def handle(self) -> int:
        """OpenGL's own number, for a window that shows it."""
        return int(self._texture.glo)

    def release(self) -> None:
        """Give the memory back; the second call does nothing."""
        if self._ticket:
            self._texture.release()
            self._device.strike(self._ticket)
            self._ticket = 0


class Buffer:
    """A storage buffer that holds a numpy array."""

    def __init__(self, device: Device, data: NDArray[np.generic], *, label: str) -> None:
        self._take(device, int(data.nbytes), label)
        try:
            self.write(data)
            device.check(f"uploading {label}")
        except DeviceError:
            self.release()
            raise

    @classmethod
    def reserved(cls, device: Device, nbytes: int, *, label: str) -> Buffer:
        """Room for data that is written a part at a time."""
        buffer = cls.__new__(cls)
        buffer._take(device, nbytes, label)
        return buffer

    def _take(self, device: Device, nbytes: int, label: str) -> None:
        self._device, self._label, self.nbytes = device, label, nbytes
        if nbytes > device.info.max_storage_bytes:
            raise DeviceError(
                f"{label}: found {nbytes} bytes, wanted at most "
                f"{device.info.max_storage_bytes} (the limit of {device.info.renderer})"
            )
        self._buffer = device.context.buffer(reserve=nbytes)
        self._ticket = device.enlist(f"buffer {label}", nbytes)
        try:
            device.check(f"allocating {label}")
        except DeviceError:
            self.release()
            raise

    def bind(self, binding: int) -> None:
        """For ``layout(std430, binding = binding) buffer``."""
        self._buffer.bind_to_storage_buffer(binding)

    def read(self, dtype: Any) -> NDArray[np.generic]:
        """The contents as a flat array of its own."""
        raw = self._buffer.read()
        self._device.check(f"reading {self._label}")
        return np.frombuffer(raw, dtype).copy()

    def write(self, data: NDArray[np.generic]) -> None:
        """Replace the contents; the size stays."""
        if data.nbytes != self.nbytes:
            raise ValueError(f"{self._label}: found {data.nbytes} bytes, wanted {self.nbytes}")
        self._buffer.write(np.ascontiguousarray(data))

    def write_part(self, data: NDArray[np.generic], start_byte: int) -> None:
        """Replace the contents from a byte on."""
        if start_byte + data.nbytes > self.nbytes:
            raise ValueError(
                f"{self._label}: found {data.nbytes} bytes from {start_byte} on, "
                f"wanted them within {self.nbytes}"
            )
        self._buffer.write(np.ascontiguousarray(data), offset=start_byte)

    def release(self) -> None:
        """Give the memory back; the second call does nothing."""
        if self._ticket:
            self._buffer.release()
            self._device.strike(self._ticket)
            self._ticket = 0
