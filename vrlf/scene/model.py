"""A glTF scene on the GPU, seen by both eyes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrlf.gpu import Block, Device, DrawPass, Field, Mesh, Texture
from vrlf.model import Rig
from vrlf.optics.viewport import SIDES
from vrlf.scene.camera import HeadPose, clip_from_world, eye_position_m
from vrlf.scene.garden import TO_SUN
from vrlf.scene.gltf import Surface, load_model, transforms
from vrlf.scene.stereo import SAMPLES, StereoCanvas

Float = NDArray[np.float64]

MODEL = Block(
    "Model",
    (
        Field("mat4", "clip_from_world", "view and projection of the eye"),
        Field("mat4", "world_from_node", "where the surface is"),
        Field("mat4", "normal_from_node", "the same for normals"),
        Field("vec4", "eye", "where it is, metres"),
        Field("vec4", "to_sun", "unit vector"),
        Field("vec4", "colour", "linear factors of the base colour, and coverage"),
        Field("float", "roughness", "of the surface"),
        Field("float", "metallic", "of the surface"),
        Field("float", "cutoff", "coverage below which there is nothing"),
    ),
)
EXPOSURE = 0.8
_BACKGROUND = (0.10, 0.11, 0.13, 1.0)
# Smaller and larger things are scaled: a ring would be a speck, a planet a wall.
_SMALLEST_M, _ROOM_M, _LARGEST_M = 0.05, 4.0, 400.0
_EYES_ABOVE_FLOOR_M = 1.6


class ModelScene:
    """Owns a scene's surfaces, pictures and program.

    The scene stands before a head at rest so that all of it is seen: its middle straight ahead,
    as far away as it is large. A scene larger than 4 m is a room: the head stands in its
    middle, 1.6 m above its floor. Sizes stay as they are between 5 cm and 400 m.

    Parameters
    ----------
    device : Device
    path : path
        A .glb or .gltf file.

    Attributes
    ----------
    moves : bool
        Whether it is animated.
    duration_s : float or None
        Where its animation begins again.
    notes : tuple of str
        What is in the file and not shown.
    """

    def __init__(self, device: Device, path: str | Path, *, samples: int = SAMPLES) -> None:
        self._model = load_model(path)
        self.duration_s, self.notes = self._model.duration_s, self._model.notes
        self.moves = self.duration_s is not None
        self._owned: list[Any] = []
        self._device = device
        try:
            self.canvas: StereoCanvas = self._own(StereoCanvas(device, samples))
            self._program: DrawPass = self._own(
                DrawPass(device, "scene/model.vert", "scene/model.frag", MODEL)
            )
            white = np.full((1, 1, 4), 255, np.uint8)
            self._white: Texture = self._own(Texture.photograph(device, white, label="white"))
            self._parts = [self._upload(surface) for surface in self._model.surfaces]
        except BaseException:
            self.release()
            raise
        self._placement = placement(self._model.surfaces, transforms(self._model, 0.0))

    def _own(self, item: Any) -> Any:
        self._owned.append(item)
        return item

    def _upload(self, surface: Surface) -> tuple[Surface, Mesh, Texture]:
        mesh = self._own(Mesh(self._device, surface.vertices, surface.triangles, label="model"))
        if surface.picture is None:
            return surface, mesh, self._white
        picture = Texture.photograph(self._device, surface.picture, label="model's picture")
        return surface, mesh, self._own(picture)

    def draw(
        self, target: Texture, rig: Rig, *, time_s: float = 0.0, head: HeadPose | None = None
    ) -> None:
        """Draw what both eyes see into all of ``target`` (rgba32f, the panel's size)."""
        head = head or HeadPose()
        world_from_node = transforms(self._model, time_s)
        for side in SIDES:
            self.canvas.begin(rig, _BACKGROUND)
            common = {
                "clip_from_world": clip_from_world(rig, side, head),
                "eye": (*eye_position_m(rig, side, head), 1.0),
                "to_sun": (*(np.asarray(TO_SUN) / np.linalg.norm(TO_SUN)), 0.0),
            }
            for surface, mesh, picture in self._parts:
                matrix = self._placement @ world_from_node[surface.node]
                self._program.set({**common, **_surface_values(surface, matrix)})
                picture.bind_sampler(0)
                self._program.draw(mesh)
            self.canvas.resolve(rig, side, target, EXPOSURE)
        self._device.check("drawing the model")

    def release(self) -> None:
        """Give all of it back; the second call does nothing."""
        while self._owned:
            self._owned.pop().release()


def _surface_values(surface: Surface, matrix: Float) -> dict[str, Any]:
    normal = np.eye(4)
    # A node that is squeezed flat has no inverse; its normals stay as they are.
    if abs(np.linalg.det(matrix[:3, :3])) > 1e-12:
        normal[:3, :3] = np.linalg.inv(matrix[:3, :3]).T
    return {
        # GLSL's columns are numpy's rows.
        "world_from_node": matrix.T,
        "normal_from_node": normal.T,
        "colour": surface.colour,
        "roughness": surface.roughness,
        "metallic": surface.metallic,
        "cutoff": surface.cutoff,
    }


def placement(surfaces: tuple[Surface, ...], world_from_node: dict[str, Float]) -> Float:
    """The matrix that puts a scene before a head at rest, shape (4, 4)."""
    corners = []
    for surface in surfaces:
        points = surface.vertices["in_position"].astype(np.float64)
        matrix = world_from_node[surface.node]
        placed = points @ matrix[:3, :3].T + matrix[:3, 3]
        corners += [placed.min(axis=0), placed.max(axis=0)]
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    extent_m = float(np.linalg.norm(high - low))
    scale = 1.0
    if not _SMALLEST_M <= extent_m <= _LARGEST_M:
        scale = 1.0 / max(extent_m, 1e-9)
    middle, size_m = (low + high) / 2.0, extent_m * scale
    matrix = np.diag([scale, scale, scale, 1.0])
    if size_m > _ROOM_M:
        floor = np.array([middle[0], low[1] + _EYES_ABOVE_FLOOR_M / scale, middle[2]])
        matrix[:3, 3] = -scale * floor
    else:
        matrix[:3, 3] = -scale * middle - [0.0, 0.0, max(size_m, 0.3)]
    return matrix
