"""Where a head goes: key poses in a file, and the pose at any time between."""

from __future__ import annotations

import json
from bisect import bisect_right
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vrlf.errors import InputError
from vrlf.files import shown
from vrlf.resources import assets_dir
from vrlf.scene.camera import HeadPose

_LARGEST_BYTES = 2**22
_LARGEST = 1e6  # seconds, degrees, metres
_ANGLES = ("yaw_deg", "pitch_deg", "roll_deg")
_KNOWN = frozenset({"time_s", "position_m", *_ANGLES})


@dataclass(frozen=True)
class HeadPath:
    """Key poses in the order of their times.

    Attributes
    ----------
    times_s : tuple of float
        Rising.
    poses : tuple of HeadPose
    """

    times_s: tuple[float, ...]
    poses: tuple[HeadPose, ...]


def head_at(path: HeadPath, time_s: float) -> HeadPose:
    """The pose at a time; before the first key and after the last one it stands still.

    Between keys each angle and coordinate is a cubic through both with the slopes of Catmull &
    Rom 1974, for keys that need not be equally far apart: no jerk at a key. Angles run as they
    are given: from 350 to 370 goes on, from 350 to 10 goes back.
    """
    times = path.times_s
    after = bisect_right(times, time_s)
    if after == 0:
        return path.poses[0]
    if after == len(times):
        return path.poses[-1]
    keys = [min(max(k, 0), len(times) - 1) for k in range(after - 2, after + 2)]
    values = [_numbers(path.poses[k]) for k in keys]
    t = [times[k] for k in keys]
    return _pose([_cubic(t, four, time_s) for four in zip(*values, strict=True)])


def _cubic(t: list[float], v: tuple[float, ...], at: float) -> float:
    """Hermite's cubic from (t1, v1) to (t2, v2), slopes by the neighbours' secants."""
    length = t[2] - t[1]
    # At an end, where a neighbour is the key itself, the secant is one-sided.
    slopes = (v[2] - v[0]) / (t[2] - t[0]), (v[3] - v[1]) / (t[3] - t[1])
    s = (at - t[1]) / length
    h00, h10 = (1 + 2 * s) * (1 - s) ** 2, s * (1 - s) ** 2
    h01, h11 = s * s * (3 - 2 * s), s * s * (s - 1)
    return h00 * v[1] + h10 * length * slopes[0] + h01 * v[2] + h11 * length * slopes[1]


def _numbers(pose: HeadPose) -> tuple[float, ...]:
    return pose.yaw_deg, pose.pitch_deg, pose.roll_deg, *pose.position_m


def _pose(numbers: list[float]) -> HeadPose:
    yaw_deg, pitch_deg, roll_deg, x, y, z = numbers
    return HeadPose(yaw_deg, pitch_deg, roll_deg, (x, y, z))


def load_path(name: str) -> HeadPath:
    """Read a path: a shipped one by name, or a ``.json`` file.

    The file: ``{"keys": [{"time_s": 0, "yaw_deg": 0, "pitch_deg": 0, "roll_deg": 0,
    "position_m": [0, 0, 0]}, ...]}``; what a key leaves out is as in the key before it, 0 in the
    first.

    Raises
    ------
    InputError
        In one line: the file, the key, what was found and what is wanted.
    """
    path = Path(name)
    if path.suffix != ".json" and "/" not in name and "\\" not in name:
        shipped = {each.stem: each for each in (assets_dir() / "paths").glob("*.json")}
        if name not in shipped:
            known = ", ".join(sorted(shipped))
            raise InputError(
                f"--path: found {shown(name)[:60]}, wanted a .json file or one of {known}"
            )
        path = shipped[name]
    return _path_of(_read(path), shown(name))


def _read(path: Path) -> Any:
    name = shown(path)
    try:
        raw = path.read_bytes()
        if len(raw) > _LARGEST_BYTES:
            raise InputError(f"{name}: found more than 4 MiB, wanted a head's path")
        return json.loads(raw.decode("utf-8-sig"))
    except OSError as error:
        raise InputError(f"{name}: found '{error.strerror}', wanted a head's path") from None
    except (ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())[:120]
        raise InputError(f"{name}: found no JSON ({reason}), wanted a head's path") from None


def _path_of(found: Any, name: str) -> HeadPath:
    if not isinstance(found, dict) or set(found) != {"keys"}:
        keys = sorted(found) if isinstance(found, dict) else type(found).__name__
        raise InputError(f'{name}: found {keys}, wanted an object with "keys" alone')
    keys = found["keys"]
    if not isinstance(keys, list) or not keys:
        raise InputError(f"{name}: found no keys, wanted at least one")
    times: list[float] = []
    poses: list[HeadPose] = []
    for index, key in enumerate(keys):
        where = f"{name}: keys[{index}]"
        before = poses[-1] if poses else HeadPose()
        time_s, pose = _key_of(key, before, where)
        if times and time_s <= times[-1]:
            raise InputError(f"{where}.time_s: found {time_s:g}, wanted more than {times[-1]:g}")
        times.append(time_s)
        poses.append(pose)
    return HeadPath(tuple(times), tuple(poses))


def _key_of(key: Any, before: HeadPose, where: str) -> tuple[float, HeadPose]:
    if not isinstance(key, dict):
        raise InputError(f"{where}: found {type(key).__name__}, wanted an object")
    if unknown := sorted(set(key) - _KNOWN):
        raise InputError(
            f"{where}: found the key {unknown[0]!r}, wanted {', '.join(sorted(_KNOWN))}"
        )
    if "time_s" not in key:
        raise InputError(f"{where}: found no time_s, wanted one")
    angles = [_number(key.get(a, getattr(before, a)), f"{where}.{a}") for a in _ANGLES]
    position = key.get("position_m", list(before.position_m))
    if not isinstance(position, list) or len(position) != 3:
        raise InputError(f"{where}.position_m: found {position!r:.60}, wanted [x, y, z]")
    place = [_number(each, f"{where}.position_m") for each in position]
    return _number(key["time_s"], f"{where}.time_s"), _pose([*angles, *place])


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{where}: found {value!r:.60}, wanted a number")
    if not -_LARGEST <= value <= _LARGEST:  # NaN lies nowhere
        found = (
            f"{value:g}"
            if isinstance(value, float)
            else f"a number of {len(str(abs(value)))} digits"
        )
        raise InputError(f"{where}: found {found}, wanted at most {_LARGEST:g} either way")
    return float(value)
