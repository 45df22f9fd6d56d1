"""3D scenes from glTF files: their surfaces, how these hang together and how they move.

trimesh reads surfaces, materials and pictures; what it leaves out, the nodes' animations, is read
here (glTF 2.0 specification, 3.11 and appendix C). Nodes are named by their number first, so that
both sides mean the same one.
"""

from __future__ import annotations

import base64
import io
import json
import logging
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import trimesh
from numpy.typing import NDArray

from vrlf.errors import ImageReadError, InputError
from vrlf.files import shown
from vrlf.scene.animation import Channel, channels_of, pose_of

Float = NDArray[np.float64]

MODEL_ENDINGS = (".glb", ".gltf")
_LARGEST_BYTES = 2**30
_JSON_CHUNK, _MAGIC = 0x4E4F534A, b"glTF"
VERTEX = np.dtype(
    [("in_position", "f4", 3), ("in_normal", "f4", 3), ("in_uv", "f4", 2), ("in_colour", "f4", 4)]
)


@dataclass(frozen=True)
class Surface:
    """Triangles of one material.

    Attributes
    ----------
    node : str
        That it hangs on.
    vertices : structured array of ``VERTEX``
        In the node's own frame, metres.
    triangles : ndarray, shape (T, 3)
    picture : ndarray of uint8, shape (H, W, 4), or None
        sRGB codes and coverage, row 0 at the top.
    colour : (red, green, blue, alpha)
        Linear factors.
    roughness, metallic : float
    cutoff : float
        Coverage below which there is nothing; 0 without holes.
    """

    node: str
    vertices: NDArray[np.void]
    triangles: NDArray[np.int64]
    picture: NDArray[np.uint8] | None
    colour: tuple[float, float, float, float]
    roughness: float
    metallic: float
    cutoff: float


@dataclass(frozen=True)
class Model:
    """A scene as its file has it.

    Attributes
    ----------
    surfaces : tuple of Surface
    graph : trimesh's scene graph
    channels : tuple of Channel
        Of the first animation; none for what stands still.
    duration_s : float or None
        Where the animation begins again.
    notes : tuple of str
        What is in the file and not shown.
    """

    surfaces: tuple[Surface, ...]
    graph: Any
    channels: tuple[Channel, ...]
    rest: dict[str, dict[str, Any]]
    parents: dict[str, str]
    duration_s: float | None
    notes: tuple[str, ...]


def load_model(path: str | Path) -> Model:
    """Read a .glb or .gltf file.

    Raises
    ------
    InputError
        In one line: what is missing, cut off or senseless.
    """
    path = Path(path)
    name = shown(path)
    with _one_line(name):
        header, binary = _read(path)
        _check_files(header, path)
        for index, node in enumerate(header.get("nodes", [])):
            node["name"] = f"n{index}"
        channels = channels_of(header, lambda number: _buffer(header, binary, path, number))
        loaded = _loaded(header, binary, path)
        surfaces = tuple(_surfaces(loaded))
        _check(surfaces)
        duration_s = max((float(each.times_s[-1]) for each in channels), default=0.0)
    nodes = header.get("nodes", [])
    return Model(
        surfaces=surfaces,
        graph=loaded.graph,
        channels=channels,
        rest={node["name"]: node for node in nodes},
        parents={f"n{c}": node["name"] for node in nodes for c in node.get("children", [])},
        duration_s=duration_s or None,
        notes=tuple(_notes(header)),
    )


def transforms(model: Model, time_s: float) -> dict[str, Float]:
    """World from node, for each node with a surface, at a time; shape (4, 4)."""
    time_s = time_s % model.duration_s if model.duration_s else 0.0
    moved: dict[str, list[Channel]] = {}
    for channel in model.channels:
        moved.setdefault(channel.node, []).append(channel)
    for node, channels in moved.items():
        matrix = pose_of(model.rest[node], channels, time_s)
        parent = model.parents.get(node, model.graph.base_frame)
        model.graph.update(frame_to=node, frame_from=parent, matrix=matrix)
    return {each.node: np.asarray(model.graph.get(each.node)[0]) for each in model.surfaces}


@contextmanager
def _one_line(name: str) -> Iterator[None]:
    """Whatever a reader says of a broken file, in one line."""
    try:
        yield
    except InputError:
        raise
    except MemoryError:
        raise
    except Exception as error:
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise ImageReadError(f"{name}: found {reason!r}, wanted a whole glTF scene") from None


def _read(path: Path) -> tuple[dict[str, Any], bytes]:
    """The header and the binary chunk (glTF 2.0, 4.4)."""
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise ImageReadError(f"{shown(path)}: found '{error.strerror}', wanted a scene") from None
    if len(raw) > _LARGEST_BYTES:
        raise ImageReadError(f"{shown(path)}: found more than 1 GiB, wanted a smaller scene")
    if raw[:4] != _MAGIC:
        return _object(json.loads(raw.decode("utf-8-sig"))), b""
    _, version, length = struct.unpack("<4sII", raw[:12])
    if version != 2 or length != len(raw):
        raise ValueError(f"a GLB of version {version} that claims {length} of {len(raw)} bytes")
    size, kind = struct.unpack("<II", raw[12:20])
    if kind != _JSON_CHUNK or 20 + size > len(raw):
        raise ValueError("a GLB without its header")
    rest = raw[20 + size :]
    return _object(json.loads(raw[20 : 20 + size])), rest[8:]


def _object(found: Any) -> dict[str, Any]:
    if not isinstance(found, dict) or str(found.get("asset", {}).get("version", ""))[:1] != "2":
        raise ValueError("no glTF of version 2")
    return found


def _check_files(header: dict[str, Any], path: Path) -> None:
    """trimesh goes on without a picture that is missing; nobody would know why it is grey."""
    for kind in ("buffers", "images"):
        for index, item in enumerate(header.get(kind, [])):
            uri = item.get("uri")
            if uri and not uri.startswith("data:") and not _beside(path, uri).is_file():
                raise ImageReadError(
                    f"{shown(path)}: {kind}[{index}]: found no file {uri[:80]!r}, wanted one"
                )


def _beside(path: Path, uri: str) -> Path:
    return path.parent / unquote(uri)


def _buffer(header: dict[str, Any], binary: bytes, path: Path, number: int) -> bytes:
    """A buffer's bytes: in the file, beside it, or in the header itself."""
    uri = header["buffers"][number].get("uri")
    if uri is None:
        return binary
    if uri.startswith("data:"):
        return base64.b64decode(uri.split(",", 1)[1])
    return _beside(path, uri).read_bytes()


def _loaded(header: dict[str, Any], binary: bytes, path: Path) -> Any:
    """trimesh's scene of the file with its nodes renamed; its warnings are no news to a user."""
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    if binary:
        chunks = struct.pack("<II", len(text), _JSON_CHUNK) + text
        chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
        file, kind = struct.pack("<4sII", _MAGIC, 2, 12 + len(chunks)) + chunks, "glb"
    else:
        file, kind = text, "gltf"
    logging.getLogger("trimesh").setLevel(logging.CRITICAL)
    return trimesh.load_scene(
        io.BytesIO(file),
        file_type=kind,
        resolver=trimesh.resolvers.FilePathResolver(str(path)),
        process=False,
    )


def _surfaces(loaded: Any) -> Iterator[Surface]:
    for node in loaded.graph.nodes_geometry:
        mesh = loaded.geometry[loaded.graph[node][1]]
        if not hasattr(mesh, "faces") or len(mesh.faces) == 0:
            continue
        yield _surface(node, mesh)


def _surface(node: str, mesh: Any) -> Surface:
    vertices = np.zeros(len(mesh.vertices), VERTEX)
    vertices["in_position"] = mesh.vertices
    vertices["in_normal"] = mesh.vertex_normals
    vertices["in_colour"] = 1.0
    triangles = np.asarray(mesh.faces, np.int64)
    material = getattr(mesh.visual, "material", None)
    uv = getattr(mesh.visual, "uv", None)
    if uv is not None and len(uv) == len(vertices):
        # trimesh turns glTF's v, which runs down from the picture's top, upside down.
        vertices["in_uv"] = np.asarray(uv) * [1.0, -1.0] + [0.0, 1.0]
    colours = getattr(mesh.visual, "vertex_colors", None)
    if colours is None:
        colours = getattr(mesh.visual, "vertex_attributes", {}).get("color")
    if colours is not None and len(colours) == len(vertices):
        # Vertex colours are linear (glTF 2.0, 3.7.2.1).
        tint = np.asarray(colours)
        vertices["in_colour"][:, : tint.shape[1]] = tint / 255.0 if tint.dtype.kind == "u" else tint
    return Surface(node, vertices, triangles, **_material(material))


def _material(material: Any) -> dict[str, Any]:
    """What a surface is made of; glTF's own defaults where a file says nothing."""

    def given(name: str, default: Any) -> Any:
        value = getattr(material, name, None)
        return default if value is None else value

    factor = np.asarray(given("baseColorFactor", (255, 255, 255, 255)), np.float64)
    if factor.max(initial=0.0) > 1.0:  # trimesh keeps eight bits
        factor = factor / 255.0
    picture = given("baseColorTexture", None)
    mode = given("alphaMode", "OPAQUE")
    cutoff = {"MASK": float(given("alphaCutoff", 0.5)), "BLEND": 0.5}.get(mode, 0.0)
    return {
        "picture": None if picture is None else np.asarray(picture.convert("RGBA"), np.uint8),
        "colour": tuple(float(part) for part in (*factor, 1.0)[:4]),
        "roughness": float(given("roughnessFactor", 1.0)),
        "metallic": float(given("metallicFactor", 1.0 if material is not None else 0.0)),
        "cutoff": cutoff,
    }


def _check(surfaces: tuple[Surface, ...]) -> None:
    if not surfaces:
        raise ValueError("no surface at all")
    for each in surfaces:
        if not np.isfinite(each.vertices["in_position"]).all():
            raise ValueError("positions that are no numbers")
        if each.triangles.min() < 0 or each.triangles.max() >= len(each.vertices):
            raise ValueError("triangles of vertices that are not there")


def _notes(header: dict[str, Any]) -> Iterator[str]:
    if header.get("skins"):
        yield "skinned surfaces are shown at rest"
    meshes = header.get("meshes", [])
    if any("targets" in p for mesh in meshes for p in mesh.get("primitives", [])):
        yield "morphed surfaces are shown at rest"
    if len(header.get("animations", [])) > 1:
        yield "only the first animation is shown"
    if any(m.get("alphaMode") == "BLEND" for m in header.get("materials", [])):
        yield "what is half transparent is shown as solid or not at all"
