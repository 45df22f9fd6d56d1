"""Cameras: the frustum of each eye and where the head puts it. The only place that knows pyrr.

The world is in metres, x right, y up, and a head that was not turned looks along -z. Of
pyrr's ways these are held by the tests:

- ``Matrix44 * Matrix44`` has the order of mathematics, ``@`` the opposite one.
- Its arrays hold GLSL's columns as rows, so their bytes are a ``mat4`` as they are, and a
  point is mapped by ``point @ matrix``.
- ``perspective_projection_bounds`` calls its third parameter ``top`` and passes it on as the
  bottom: by position, (left, right, bottom, top), it is right; by name it is upside down.
- ``Matrix44.from_x_rotation`` and its like turn the other way than a quaternion does: only
  quaternions turn anything here.
- Whole numbers give integer matrices: everything goes in as a float.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from pyrr import Matrix44, Quaternion, Vector3

from vrlf.model import Rig
from vrlf.optics.bench import bench_of
from vrlf.optics.distortion import coefficients_of, seen_slopes
from vrlf.optics.viewport import Side, pitch_mm, viewport
from vrlf.units import MM_PER_M

Float = NDArray[np.float64]

NEAR_M = 0.1
FAR_M = 80.0

_STEPS = 65  # places along a viewport's side at which the lens's distortion is asked for


@dataclass(frozen=True)
class HeadPose:
    """Where the head is and how it is turned: rolled, then pitched, then turned.

    Attributes
    ----------
    yaw_deg : float
        Positive looks to the right.
    pitch_deg : float
        Positive looks up.
    roll_deg : float
        Positive leans to the right shoulder.
    position_m : (x, y, z)
        The middle between the eyes.
    """

    yaw_deg: float = 0.0
    pitch_deg: float = 0.0
    roll_deg: float = 0.0
    position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)


AT_REST = HeadPose()


@dataclass(frozen=True)
class Frustum:
    """Slopes that bound what an eye sees, relative to its optical axis; right and up."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def size(self) -> tuple[float, float]:
        """Width and height."""
        return self.right - self.left, self.top - self.bottom


def panel_frustum(rig: Rig, side: Side) -> Frustum:
    """Slopes X / m of the borders of an eye's viewport, as the panel has them."""
    view, pitch = viewport(rig, side), pitch_mm(rig)
    m = bench_of(rig).panel_per_slope_mm
    left_mm = (view.first_column - rig.panel.width_px / 2.0) * pitch - view.axis_mm[0]
    top_mm = rig.panel.height_px / 2.0 * pitch - view.axis_mm[1]
    return Frustum(
        left=left_mm / m,
        right=(left_mm + view.width_px * pitch) / m,
        bottom=(top_mm - view.height_px * pitch) / m,
        top=top_mm / m,
    )


def seen_frustum(rig: Rig, side: Side) -> Frustum:
    """The frustum that holds every slope at which the lens shows the viewport.

    The lens shows the panel slope r at r (1 + k1 r^2 + k2 r^4). Outward from the axis that
    may turn back for a negative k, so the viewport's inside is asked too.
    """
    plain = panel_frustum(rig, side)
    if rig.headset.distortion is None:
        return plain
    x = np.linspace(plain.left, plain.right, _STEPS)
    y = np.linspace(plain.bottom, plain.top, _STEPS)
    seen = seen_slopes(np.stack(np.meshgrid(x, y), axis=-1), coefficients_of(rig))
    right, up = seen[..., 0], seen[..., 1]
    bounds = (right.min(), right.max(), up.min(), up.max())
    return Frustum(*(float(bound) for bound in bounds))


def head_axes(head: HeadPose) -> Float:
    """The head's own right, up and back in the world, as rows; shape (3, 3)."""
    turn = _turn(head)
    return np.asarray([turn * Vector3(axis) for axis in np.eye(3)], np.float64)


def walked(head: HeadPose, right_m: float, ahead_m: float) -> HeadPose:
    """The head after steps to its right and ahead, level: nobody walks into the ground."""
    right, _, back = head_axes(HeadPose(yaw_deg=head.yaw_deg))
    place = np.asarray(head.position_m) + right_m * right - ahead_m * back
    return replace(head, position_m=(float(place[0]), float(place[1]), float(place[2])))


def eye_position_m(rig: Rig, side: Side, head: HeadPose) -> Float:
    """Where an eye is: half the separation of the lenses beside the head's middle."""
    half_m = rig.headset.lens_separation_mm / 2.0 / MM_PER_M
    sign = -1.0 if side == "left" else 1.0
    middle = np.asarray(head.position_m, np.float64)
    return np.asarray(middle + sign * half_m * head_axes(head)[0])


def clip_from_world(rig: Rig, side: Side, head: HeadPose) -> Float:
    """World to clip space for one eye, shape (4, 4): ``clip = (x, y, z, 1) @ matrix``.

    The eyes of a head look parallel, so a far point has the same slope in both; the frustum
    is off the axis as the viewport is. The bytes, as float32, are a GLSL ``mat4``.
    """
    f = seen_frustum(rig, side)
    projection = Matrix44.perspective_projection_bounds(
        *(slope * NEAR_M for slope in (f.left, f.right, f.bottom, f.top)), NEAR_M, FAR_M
    )
    to_eye = Matrix44.from_translation(-eye_position_m(rig, side, head))
    turn_back = Matrix44.identity(dtype=np.float64)
    turn_back[:3, :3] = head_axes(head).T
    return np.asarray(projection * turn_back * to_eye, np.float64)


def _turn(head: HeadPose) -> Quaternion:
    """The head's rotation; a positive angle of pyrr's is anticlockwise about its axis."""
    yaw, pitch, roll = (
        float(np.radians(deg)) for deg in (-head.yaw_deg, head.pitch_deg, -head.roll_deg)
    )
    return (
        Quaternion.from_y_rotation(yaw)
        * Quaternion.from_x_rotation(pitch)
        * Quaternion.from_z_rotation(roll)
    )
