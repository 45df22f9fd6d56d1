"""Make the shipped glTF scene anew: an orrery whose planets go round a lamp, on a wooden board.

    .venv/bin/python scripts/make_scene.py [FILE]

The same bytes each time. Every part is made here; nothing is taken from elsewhere.
"""

from __future__ import annotations

import io
import json
import struct
import sys
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image
from trimesh.visual.material import PBRMaterial
from trimesh.visual.texture import TextureVisuals

PERIOD_S = 24.0
KEYS = 33
# Name: radius of the orbit and the ball in metres, turns in a period, height, colours.
PLANETS = {
    "ember": (0.10, 0.022, 6, 0.02, ((150, 60, 40), (235, 150, 90))),
    "cloud": (0.17, 0.034, 3, 0.05, ((230, 222, 200), (190, 160, 120))),
    "blue": (0.25, 0.040, 2, 0.00, ((30, 80, 160), (70, 150, 80))),
    "giant": (0.36, 0.062, 1, 0.03, ((200, 160, 120), (150, 100, 70))),
}


def main() -> None:
    """Write the file."""
    default = Path(__file__).resolve().parent.parent / "assets" / "scenes" / "orrery.glb"
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else default
    target.parent.mkdir(parents=True, exist_ok=True)
    scene = trimesh.Scene()
    # Tilted toward whoever stands before it.
    tilt = trimesh.transformations.rotation_matrix(np.radians(28.0), (1, 0, 0))
    scene.graph.update(frame_to="stand", frame_from="world", matrix=tilt)
    _add(scene, "board", _board(), "stand")
    _add(scene, "lamp", _ball(0.05, _lamp_picture()), "stand")
    for number, (name, (orbit_m, radius_m, _, up_m, colours)) in enumerate(PLANETS.items()):
        scene.graph.update(frame_to=f"{name} arm", frame_from="stand", matrix=np.eye(4))
        place = np.eye(4)
        place[:3, 3] = (orbit_m, up_m, 0.0)
        _add(scene, name, _ball(radius_m, _bands(colours, number)), f"{name} arm", place)
        rod = trimesh.creation.cylinder(0.003, orbit_m, sections=12)
        rod.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (0, 1, 0)))
        rod.apply_translation((orbit_m / 2, up_m - 0.001, 0.0))
        _add(scene, f"{name} rod", _plain(rod, (190, 150, 80), metallic=1.0), f"{name} arm")
    target.write_bytes(_animated(scene.export(file_type="glb")))
    print(f"{target}: {target.stat().st_size} bytes")


def _add(scene: Any, name: str, mesh: Any, parent: str, place: Any = None) -> None:
    matrix = np.eye(4) if place is None else place
    scene.add_geometry(
        mesh, geom_name=name, node_name=name, parent_node_name=parent, transform=matrix
    )


def _plain(mesh: Any, colour: tuple[int, int, int], *, metallic: float = 0.0) -> Any:
    material = PBRMaterial(
        baseColorFactor=[*colour, 255], metallicFactor=metallic, roughnessFactor=0.4
    )
    mesh.visual = TextureVisuals(uv=np.zeros((len(mesh.vertices), 2)), material=material)
    return mesh


def _textured(mesh: Any, uv: NDArray[Any], picture: NDArray[Any], roughness: float) -> Any:
    material = PBRMaterial(
        baseColorTexture=Image.fromarray(picture), metallicFactor=0.0, roughnessFactor=roughness
    )
    mesh.visual = TextureVisuals(uv=uv, material=material)
    return mesh


def _ball(radius_m: float, picture: NDArray[Any]) -> Any:
    """A sphere by longitude and latitude, its seam doubled so that a picture goes round it."""
    across, down = 32, 16
    longitude, latitude = np.meshgrid(
        np.linspace(-np.pi, np.pi, across + 1), np.linspace(np.pi / 2, -np.pi / 2, down + 1)
    )
    points = np.stack(
        [
            np.cos(latitude) * np.sin(longitude),
            np.sin(latitude),
            np.cos(latitude) * np.cos(longitude),
        ],
        axis=-1,
    ).reshape(-1, 3)
    corner = (np.arange(down)[:, None] * (across + 1) + np.arange(across)).ravel()
    below = corner + across + 1
    faces = np.concatenate(
        [np.stack([corner, below, below + 1], 1), np.stack([corner, below + 1, corner + 1], 1)]
    )
    uv = np.stack([longitude / (2 * np.pi) + 0.5, latitude / np.pi + 0.5], -1).reshape(-1, 2)
    mesh = trimesh.Trimesh(radius_m * points, faces, vertex_normals=points, process=False)
    return _textured(mesh, uv, picture, 0.5)


def _board() -> Any:
    """A round board of planks under it all."""
    mesh = trimesh.creation.cylinder(0.46, 0.02, sections=64)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, (1, 0, 0)))
    mesh.apply_translation((0.0, -0.11, 0.0))
    mesh.unmerge_vertices()
    uv = mesh.vertices[:, [0, 2]] * [1.0, -1.0] + 0.5
    x, y = np.meshgrid(np.arange(256), np.arange(256))
    noise = np.random.default_rng(11).random((256, 8))
    grain = 0.5 + 0.5 * np.sin(x * 0.9 + 6.0 * noise[y, x // 32] + 1.5 * np.sin(y * 0.05))
    shade = 0.75 + 0.25 * grain - 0.35 * (x % 32 < 2)
    picture = np.clip(shade[..., None] * (168, 116, 72), 0, 255).astype(np.uint8)
    return _textured(mesh, uv, picture, 0.8)


def _bands(colours: Any, seed: int) -> NDArray[Any]:
    """Bands of two colours with wavy edges, and one mark that shows the turning."""
    x, y = np.meshgrid(np.arange(128), np.arange(64))
    random = np.random.default_rng(seed)
    wave = sum(
        a * np.sin(2 * np.pi * k * x / 128 + p)
        for k, a, p in zip((1, 2, 3), random.random(3), 6 * random.random(3), strict=True)
    )
    share = 0.5 + 0.5 * np.tanh(2.0 * np.sin(y / 64 * np.pi * (4 + 2 * seed) + wave))
    picture = share[..., None] * colours[0] + (1 - share[..., None]) * np.asarray(colours[1])
    picture[(np.hypot((x - 40) * 0.8, y - 26) < 5)] = (245, 240, 230)
    return picture.astype(np.uint8)


def _lamp_picture() -> NDArray[Any]:
    return np.full((4, 8, 3), (255, 236, 180), np.uint8)


def _animated(raw: bytes) -> bytes:
    """Turn each arm about the vertical; balls turn with their arms."""
    size = struct.unpack("<I", raw[12:16])[0]
    header, binary = json.loads(raw[20 : 20 + size]), raw[20 + size + 8 :]
    times = np.linspace(0.0, PERIOD_S, KEYS, dtype=np.float32)
    names = [node.get("name") for node in header["nodes"]]
    samplers, channels = [], []
    time_accessor, binary = _appended(header, binary, times[:, None], "SCALAR")
    for name, (_, _, turns, _, _) in PLANETS.items():
        half = np.pi * turns * np.linspace(0.0, 1.0, KEYS)
        turned = np.stack([0 * half, np.sin(half), 0 * half, np.cos(half)], -1).astype(np.float32)
        accessor, binary = _appended(header, binary, turned, "VEC4")
        node = names.index(f"{name} arm")
        rest = header["nodes"][node]
        rest.pop("matrix", None)  # what is animated has its parts apart (glTF 2.0, 3.11)
        channels.append({"sampler": len(samplers), "target": {"node": node, "path": "rotation"}})
        samplers.append({"input": time_accessor, "output": accessor, "interpolation": "LINEAR"})
    header["animations"] = [{"name": "turning", "samplers": samplers, "channels": channels}]
    header["buffers"][0]["byteLength"] = len(binary)
    header["asset"] = {"version": "2.0", "generator": "vrlf scripts/make_scene.py"}
    text = json.dumps(header, separators=(",", ":"), sort_keys=True).encode()
    text += b" " * (-len(text) % 4)
    out = io.BytesIO()
    out.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + len(binary)))
    out.write(struct.pack("<II", len(text), 0x4E4F534A) + text)
    out.write(struct.pack("<I4s", len(binary), b"BIN\0") + binary)
    return out.getvalue()


def _appended(
    header: dict[str, Any], binary: bytes, values: NDArray[Any], kind: str
) -> tuple[int, bytes]:
    binary += b"\0" * (-len(binary) % 4)
    view = {"buffer": 0, "byteOffset": len(binary), "byteLength": values.nbytes}
    header["bufferViews"].append(view)
    header["accessors"].append(
        {
            "bufferView": len(header["bufferViews"]) - 1,
            "componentType": 5126,
            "count": len(values),
            "type": kind,
            "min": values.min(axis=0).tolist(),
            "max": values.max(axis=0).tolist(),
        }
    )
    return len(header["accessors"]) - 1, binary + values.tobytes()


if __name__ == "__main__":
    main()
