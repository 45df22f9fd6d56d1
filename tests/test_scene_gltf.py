"""glTF scenes: where surfaces stand for each eye, pictures upright, motion, and damage."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from vrlf.errors import InputError
from vrlf.gpu import Device, Texture
from vrlf.model import load_rig
from vrlf.optics.bench import bench_of
from vrlf.optics.viewport import SIDES, axis_in_viewport_px, pitch_mm, viewport
from vrlf.resources import assets_dir
from vrlf.scene import HeadPose, ModelScene
from vrlf.scene.gltf import load_model, transforms
from vrlf.scene.model import placement

_SIZE = ["panel.width_px=241", "panel.height_px=131", "panel.pixel_pitch_um=450"]
RIG = load_rig(
    "bare", overrides=[*_SIZE, "headset.lens_separation_mm=50", "headset.lens_height_mm=2"]
)
CORNERS = ((0, 1, 2), (0, 2, 3))


def png(codes: NDArray[np.uint8]) -> bytes:
    import io

    file = io.BytesIO()
    Image.fromarray(codes).save(file, "PNG")
    return file.getvalue()


def quadrants() -> NDArray[np.uint8]:
    """Red at the upper left, green at the upper right, blue and white below."""
    codes = np.zeros((128, 128, 3), np.uint8)
    codes[:64, :64], codes[:64, 64:] = (255, 0, 0), (0, 255, 0)
    codes[64:, :64], codes[64:, 64:] = (0, 0, 255), (255, 255, 255)
    return codes


class Builder:
    """A glTF file by hand: a quad a metre wide and 0.6 high, its middle in the origin."""

    def __init__(self) -> None:
        self.binary = b""
        self.header: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "name": "same"}],
            "meshes": [{"primitives": [{"attributes": {}, "material": 0}]}],
            "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0.0}}],
            "accessors": [],
            "bufferViews": [],
        }
        points = np.array([(-0.5, -0.3, 0), (0.5, -0.3, 0), (0.5, 0.3, 0), (-0.5, 0.3, 0)])
        primitive = self.header["meshes"][0]["primitives"][0]
        primitive["attributes"]["POSITION"] = self.accessor(points.astype("f4"), "VEC3")
        uv = np.array([(0, 1), (1, 1), (1, 0), (0, 0)], "f4")
        primitive["attributes"]["TEXCOORD_0"] = self.accessor(uv, "VEC2")
        primitive["indices"] = self.accessor(np.array(CORNERS, "u4").reshape(-1, 1), "SCALAR")

    def view(self, raw: bytes) -> int:
        self.binary += b"\0" * (-len(self.binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(raw)}
        self.header["bufferViews"].append(view)
        self.binary += raw
        return len(self.header["bufferViews"]) - 1

    def accessor(self, values: NDArray[Any], kind: str) -> int:
        kinds = {"f4": 5126, "u4": 5125}
        self.header["accessors"].append(
            {
                "bufferView": self.view(values.tobytes()),
                "componentType": kinds[values.dtype.str[1:]],
                "count": len(values),
                "type": kind,
                "min": values.min(axis=0).tolist(),
                "max": values.max(axis=0).tolist(),
            }
        )
        return len(self.header["accessors"]) - 1

    def picture(self, codes: NDArray[np.uint8]) -> None:
        image = {"bufferView": self.view(png(codes)), "mimeType": "image/png"}
        self.header["images"], self.header["textures"] = [image], [{"source": 0}]
        material = self.header["materials"][0]["pbrMetallicRoughness"]
        material["baseColorTexture"] = {"index": 0}

    def moving(self, what: str, times: list[float], values: Any, how: str = "LINEAR") -> None:
        given = np.asarray(values, "f4")
        sampler = {
            "input": self.accessor(np.asarray(times, "f4")[:, None], "SCALAR"),
            "output": self.accessor(given, f"VEC{given.shape[1]}"),
            "interpolation": how,
        }
        animation = self.header.setdefault("animations", [{"samplers": [], "channels": []}])[0]
        target = {"node": 0, "path": what}
        animation["channels"].append({"sampler": len(animation["samplers"]), "target": target})
        animation["samplers"].append(sampler)

    def glb(self, path: Path) -> Path:
        self.binary += b"\0" * (-len(self.binary) % 4)
        self.header["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.header).encode()
        text += b" " * (-len(text) % 4)
        body = struct.pack("<II", len(text), 0x4E4F534A) + text
        body += struct.pack("<I4s", len(self.binary), b"BIN\0") + self.binary
        path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)
        return path

    def gltf(self, path: Path) -> Path:
        path.with_suffix(".bin").write_bytes(self.binary)
        buffer = {"byteLength": len(self.binary), "uri": path.with_suffix(".bin").name}
        path.write_text(json.dumps({**self.header, "buffers": [buffer]}))
        return path


def drawn(device: Device, path: Path, **how: Any) -> dict[str, NDArray[Any]]:
    """Both eyes' views."""
    scene = ModelScene(device, path)
    size = (RIG.panel.width_px, RIG.panel.height_px)
    target = Texture(device, size, label="target")
    scene.draw(target, RIG, **how)
    light = np.asarray(target.read()[..., :3])
    scene.release()
    target.release()
    assert not light[:, 120].any()
    return {side: light[:, viewport(RIG, side).columns] for side in SIDES}


def middle_of(mask: NDArray[np.bool_]) -> NDArray[np.float64]:
    rows, columns = np.nonzero(mask)
    return np.array([columns.mean(), rows.mean()]) + 0.5


@pytest.mark.parametrize("form", ["glb", "gltf"])
@pytest.mark.parametrize("side", SIDES)
def test_a_picture_stands_upright_where_each_eye_sees_it(
    device: Device, tmp_path: Path, form: str, side: Any
) -> None:
    """A quad of 1 x 0.6 m, as far away as it is large; each quarter has its colour and place."""
    built = Builder()
    built.picture(quadrants())
    make = built.glb if form == "glb" else built.gltf
    view = drawn(device, make(tmp_path / f"quad.{form}"))[side]
    red, green, blue = view[..., 0], view[..., 1], view[..., 2]
    light = 0.15
    quarters = {
        (-0.25, 0.15): (red > light) & (green < red / 4) & (blue < red / 4),
        (0.25, 0.15): (green > light) & (red < green / 4) & (blue < green / 4),
        (-0.25, -0.15): (blue > light) & (red < blue / 4) & (green < blue / 4),
        (0.25, -0.15): (red > light) & (green > light) & (blue > light),
    }
    away_m = np.hypot(1.0, 0.6)
    eye_m = (-0.025 if side == "left" else 0.025, 0.0)
    px_per_slope = bench_of(RIG).panel_per_slope_mm / pitch_mm(RIG)
    axis = axis_in_viewport_px(RIG, viewport(RIG, side))
    for (x, y), mask in quarters.items():
        slope = np.array([(x - eye_m[0]) / away_m, -(y - eye_m[1]) / away_m])
        np.testing.assert_allclose(middle_of(mask), axis + slope * px_per_slope, atol=0.6)


def test_walking_and_looking(device: Device, tmp_path: Path) -> None:
    """A step to the right moves the quad left, a turn too; a step ahead enlarges it."""
    path = Builder().glb(tmp_path / "quad.glb")
    background = drawn(device, path)["left"][0, 0]

    def seen(head: HeadPose) -> tuple[float, int]:
        mask = np.abs(drawn(device, path, head=head)["left"] - background).max(axis=2) > 0.05
        return float(middle_of(mask)[0]), int(mask.sum())

    (rest, area), (right, _), (turned, _), (_, nearer) = (
        seen(head)
        for head in (
            HeadPose(),
            HeadPose(position_m=(0.1, 0.0, 0.0)),
            HeadPose(yaw_deg=4.0),
            HeadPose(position_m=(0.0, 0.0, -0.15)),
        )
    )
    px_per_slope = bench_of(RIG).panel_per_slope_mm / pitch_mm(RIG)
    away_m = np.hypot(1.0, 0.6)
    assert rest - right == pytest.approx(0.1 / away_m * px_per_slope, abs=0.5)
    # Each edge is turned by its own angle, and the near side is seen higher: half a pixel more.
    edges = np.arctan(np.array([-0.5, 0.5]) / away_m) - np.radians(4.0)
    assert rest - turned == pytest.approx(-np.tan(edges).mean() * px_per_slope, abs=0.8)
    assert nearer / area == pytest.approx((away_m / (away_m - 0.15)) ** 2, rel=0.03)


def test_nodes_move_as_their_file_says(tmp_path: Path) -> None:
    built = Builder()
    built.header["nodes"] = [
        {"name": "same", "translation": [0.0, 1.0, 0.0], "children": [1], "scale": [2.0, 2.0, 2.0]},
        {"name": "same", "mesh": 0, "translation": [0.5, 0.0, 0.0]},
    ]
    half = np.sqrt(0.5)
    built.moving("rotation", [0.0, 2.0], [[0, 0, 0, 1], [0, 0, half, half]])
    built.moving("translation", [0.5, 1.0, 4.0], [[0, 1, 0], [0, 1, 6], [3, 1, 0]], "STEP")
    model = load_model(built.glb(tmp_path / "moving.glb"))
    assert model.duration_s == 4.0

    def place(time_s: float) -> NDArray[Any]:
        matrix = transforms(model, time_s)["n1"]
        return np.asarray(matrix @ [0.0, 0.0, 0.0, 1.0])[:3]

    np.testing.assert_allclose(place(0.0), [1.0, 1.0, 0.0], atol=1e-6)
    # A quarter turn in two seconds, at an even pace; the child's arm is a metre long.
    turned = np.radians(45.0)
    np.testing.assert_allclose(place(1.0), [np.cos(turned), 1 + np.sin(turned), 6.0], atol=1e-6)
    np.testing.assert_allclose(place(3.0), [0.0, 2.0, 6.0], atol=1e-6)
    np.testing.assert_allclose(place(4.25), place(0.25), atol=1e-6)
    np.testing.assert_allclose(place(0.25)[2], 0.0)


def test_sizes_stay_but_for_specks_and_planets(tmp_path: Path) -> None:
    for scale, wanted_scale, ahead in (
        (1.0, 1.0, True),
        (0.001, 1.0 / (0.001 * np.hypot(1.0, 0.6)), True),
        (10.0, 1.0, False),
    ):
        built = Builder()
        built.header["nodes"][0]["scale"] = [scale] * 3
        model = load_model(built.glb(tmp_path / "sized.glb"))
        matrix = placement(model.surfaces, transforms(model, 0.0))
        assert matrix[0, 0] == pytest.approx(wanted_scale, rel=1e-5)
        # A room is stood in, its floor 1.6 m below the eyes.
        if ahead:
            assert matrix[2, 3] == pytest.approx(-np.hypot(1.0, 0.6) if scale == 1.0 else -1.0)
        else:
            assert matrix[1, 3] == pytest.approx(3.0 - 1.6)


def test_holes_and_factors(device: Device, tmp_path: Path) -> None:
    built = Builder()
    codes = np.full((16, 16, 4), 255, np.uint8)
    codes[:, 8:, 3] = 0
    built.picture(codes)
    built.header["materials"][0]["alphaMode"] = "MASK"
    built.header["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = [0.2, 0.6, 0.2, 1.0]
    view = drawn(device, built.glb(tmp_path / "holes.glb"))["right"]
    axis = axis_in_viewport_px(RIG, viewport(RIG, "right"))
    left, right = view[int(axis[1]), int(axis[0]) - 15], view[int(axis[1]), int(axis[0]) + 10]
    assert left[1] > 2.0 * left[0]
    np.testing.assert_allclose(right, view[0, 0], atol=1e-3)


def test_the_shipped_scene_moves_and_comes_back(device: Device) -> None:
    path = assets_dir() / "scenes" / "orrery.glb"
    assert path.stat().st_size < 300_000
    first, later, again = (drawn(device, path, time_s=t)["left"] for t in (0.0, 3.0, 24.0))
    assert (first != later).any()
    np.testing.assert_allclose(first, again, atol=0.02)
    assert load_model(path).notes == ()


def _without(key: str) -> Callable[[Builder], None]:
    return lambda built: built.header.pop(key)


def _beyond(built: Builder) -> None:
    built.header["accessors"][2]["bufferView"] = 7


def _wild(built: Builder) -> None:
    indices = np.array([0, 1, 99, 0, 2, 3], "u4").reshape(-1, 1)
    primitive = built.header["meshes"][0]["primitives"][0]
    primitive["indices"] = built.accessor(indices, "SCALAR")


def _nowhere(built: Builder) -> None:
    points = np.full((4, 3), np.nan, "f4")
    points[1:] = 0.0
    built.header["accessors"][0]["bufferView"] = built.view(points.tobytes())


def _short(built: Builder) -> None:
    built.moving("translation", [0.0, 1.0], [[0, 0, 0]])


def _back(built: Builder) -> None:
    built.moving("translation", [1.0, 0.0], [[0, 0, 0], [0, 0, 1]])


def _old(built: Builder) -> None:
    built.header["asset"] = {"version": "1.0"}


@pytest.mark.parametrize(
    "harm", [_without("meshes"), _without("asset"), _beyond, _wild, _nowhere, _short, _back, _old]
)
def test_a_senseless_scene_is_one_line(tmp_path: Path, harm: Callable[[Builder], None]) -> None:
    built = Builder()
    harm(built)
    with pytest.raises(InputError, match=r"harmed\.glb: found") as caught:
        load_model(built.glb(tmp_path / "harmed.glb"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kept", [0, 3, 15, 30, 400, -5])
def test_a_truncated_scene_is_one_line(tmp_path: Path, kept: int) -> None:
    path = Builder().glb(tmp_path / "cut.glb")
    path.write_bytes(path.read_bytes()[:kept])
    with pytest.raises(InputError, match=r"cut\.glb: found") as caught:
        load_model(path)
    assert "\n" not in str(caught.value)


def test_missing_files_are_named(tmp_path: Path) -> None:
    built = Builder()
    path = built.gltf(tmp_path / "quad.gltf")
    built.header["images"] = [{"uri": "lost%20picture.png"}]
    built.gltf(path)
    with pytest.raises(InputError, match=r"images\[0\]: found no file 'lost%20picture.png'"):
        load_model(path)
    del built.header["images"]
    built.gltf(path)
    path.with_suffix(".bin").unlink()
    with pytest.raises(InputError, match=r"buffers\[0\]: found no file 'quad.bin'"):
        load_model(path)
    with pytest.raises(InputError, match="No such file"):
        load_model(tmp_path / "none.glb")
