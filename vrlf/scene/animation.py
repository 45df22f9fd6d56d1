"""How the nodes of a glTF scene move (glTF 2.0 specification, 3.6.2, 3.11 and appendix C)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]

_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
# Component type: numpy's, and what a normalised integer is divided by.
_TYPES = {
    5120: (np.int8, 127.0),
    5121: (np.uint8, 255.0),
    5122: (np.int16, 32767.0),
    5123: (np.uint16, 65535.0),
    5126: (np.float32, 1.0),
}
_MOVED = ("translation", "rotation", "scale")


@dataclass(frozen=True)
class Channel:
    """One property of a node over time.

    Attributes
    ----------
    node : str
    what : str
        ``translation``, ``rotation`` (x, y, z, w) or ``scale``.
    times_s : ndarray, shape (K,)
    values : ndarray, shape (K, 3 or 4)
    is_stepped : bool
        Each value stays until the next; else they are interpolated.
    """

    node: str
    what: str
    times_s: Float
    values: Float
    is_stepped: bool


def channels_of(header: dict[str, Any], buffer: Callable[[int], bytes]) -> tuple[Channel, ...]:
    """The first animation's channels that move nodes.

    Raises
    ------
    ValueError, KeyError, IndexError
        If the file contradicts itself.
    """
    if not header.get("animations"):
        return ()
    animation = header["animations"][0]
    found = []
    for each in animation["channels"]:
        target = each["target"]
        if target.get("path") not in _MOVED or "node" not in target:
            continue
        sampler = animation["samplers"][each["sampler"]]
        times = _accessor(header, buffer, sampler["input"])[:, 0]
        values = _accessor(header, buffer, sampler["output"])
        how = sampler.get("interpolation", "LINEAR")
        if how == "CUBICSPLINE":  # tangent, value, tangent: the values alone are met
            values = values[1::3]
        if len(values) != len(times) or not len(times) or (np.diff(times) <= 0.0).any():
            raise ValueError("an animation whose times and values don't match")
        if not (np.isfinite(values).all() and np.isfinite(times).all()):
            raise ValueError("an animation that is no numbers")
        node = header["nodes"][target["node"]]["name"]
        found.append(Channel(node, target["path"], times, values, how == "STEP"))
    return tuple(found)


def _accessor(header: dict[str, Any], buffer: Callable[[int], bytes], number: int) -> Float:
    """An accessor's numbers, shape (count, components)."""
    accessor = header["accessors"][number]
    view = header["bufferViews"][accessor["bufferView"]]
    kind, divisor = _TYPES[accessor["componentType"]]
    components = _COMPONENTS[accessor["type"]]
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    row_bytes = components * np.dtype(kind).itemsize
    stride = view.get("byteStride", row_bytes)
    raw, count = buffer(view.get("buffer", 0)), int(accessor["count"])
    if count < 1 or start + stride * (count - 1) + row_bytes > len(raw):
        raise ValueError("an animation beyond the end of its buffer")
    rows = [np.frombuffer(raw, kind, components, start + stride * index) for index in range(count)]
    values = np.asarray(rows, np.float64)
    return values / divisor if accessor.get("normalized") else values


def pose_of(rest: dict[str, Any], channels: Sequence[Channel], time_s: float) -> Float:
    """A node's matrix at a time: translation times rotation times scale; shape (4, 4)."""
    parts = {
        "translation": np.asarray(rest.get("translation", (0.0, 0.0, 0.0)), np.float64),
        "rotation": np.asarray(rest.get("rotation", (0.0, 0.0, 0.0, 1.0)), np.float64),
        "scale": np.asarray(rest.get("scale", (1.0, 1.0, 1.0)), np.float64),
    }
    for channel in channels:
        parts[channel.what] = value_at(channel, time_s)
    matrix = np.eye(4)
    matrix[:3, :3] = _rotation(parts["rotation"]) * parts["scale"]
    matrix[:3, 3] = parts["translation"]
    return matrix


def value_at(channel: Channel, time_s: float) -> Float:
    """A channel's value; before its first time and after its last one it stands still."""
    times = channel.times_s
    after = int(np.searchsorted(times, time_s, side="right"))
    if after == 0 or after == len(times) or channel.is_stepped:
        return np.asarray(channel.values[max(after - 1, 0)])
    before = after - 1
    part = float((time_s - times[before]) / (times[after] - times[before]))
    first, second = channel.values[before], channel.values[after]
    if channel.what != "rotation":
        return np.asarray(first + part * (second - first))
    return _slerp(first, second, part)


def _slerp(first: Float, second: Float, part: float) -> Float:
    """Shoemake 1985: along the shorter arc at an even pace."""
    cosine = float(first @ second)
    if cosine < 0.0:
        second, cosine = -second, -cosine
    if cosine > 0.9995:  # nearly parallel: the chord is the arc
        mixed = first + part * (second - first)
        return np.asarray(mixed / np.linalg.norm(mixed))
    angle = np.arccos(min(cosine, 1.0))
    return np.asarray(
        (np.sin((1.0 - part) * angle) * first + np.sin(part * angle) * second) / np.sin(angle)
    )


def _rotation(quaternion: Float) -> Float:
    """The matrix of a unit quaternion (x, y, z, w)."""
    x, y, z, w = quaternion / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
