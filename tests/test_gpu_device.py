"""The device, its textures, buffers and timers: what they refuse, and that nothing leaks."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pass_rigs
import pytest

from vrlf.errors import DeviceError, InputError, VrlfError
from vrlf.gpu import Block, Buffer, ComputePass, Device, Field, GpuTimer, Texture, compute
from vrlf.passes.perceive import Perceive, PerceiveTables

_TELL = """
from vrlf.errors import DeviceError
from vrlf.gpu import Device
try:
    Device.headless()
except DeviceError as error:
    print(error)
"""


def told(repo_root: Path, **environment: str) -> str:
    """What a process of its own says on making a device."""
    done = subprocess.run(
        [sys.executable, "-c", _TELL],
        env=os.environ | environment,
        cwd=repo_root,
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    assert done.stderr == ""
    return done.stdout


def test_no_egl_is_one_line_that_helps(repo_root: Path) -> None:
    line = told(repo_root, __EGL_VENDOR_LIBRARY_FILENAMES="/nonexistent.json")
    assert line.count("\n") == 1
    assert "found no usable OpenGL context" in line
    assert "wanted OpenGL 4.3" in line
    assert "apt-get install" in line


def test_an_old_opengl_is_one_line_that_names_both_versions(
    repo_root: Path, device: Device
) -> None:
    if "Mesa" not in device.info.version:
        pytest.skip(f"only Mesa can be told to be older; this is {device.info.version}")
    line = told(repo_root, MESA_GL_VERSION_OVERRIDE="3.3")
    assert line.count("\n") == 1
    assert "found OpenGL 3.3, wanted OpenGL 4.3" in line


def test_the_device_says_what_it_is(device: Device) -> None:
    info = device.info
    assert info.renderer
    assert info.gl_version >= 430
    assert info.max_texture_px >= 4096
    assert info.max_storage_bytes >= 1 << 24  # what OpenGL 4.3 promises


def in_another_thread(call: Callable[[], object]) -> BaseException | None:
    """What a call raises on a thread of its own."""
    raised: list[BaseException] = []

    def run() -> None:
        try:
            call()
        except BaseException as error:
            raised.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    return raised[0] if raised else None


_PIXELS = np.arange(24, dtype=np.float32).reshape(2, 3, 4)


@pytest.mark.parametrize(
    "call",
    [
        lambda device, _: device.finish(),
        lambda device, _: device.check("asking"),
        lambda device, _: Texture(device, (2, 2)),
        lambda device, _: Buffer(device, _PIXELS, label="b"),
        lambda _, texture: texture.read(),
        lambda _, texture: texture.read_into(np.zeros_like(_PIXELS)),
        lambda _, texture: texture.write(_PIXELS),
    ],
)
def test_a_foreign_thread_is_refused(
    device: Device, call: Callable[[Device, Texture], object]
) -> None:
    texture = Texture.from_array(device, _PIXELS, label="texture")
    error = in_another_thread(lambda: call(device, texture))
    assert isinstance(error, DeviceError)
    assert "another thread" in str(error)
    texture.release()


def test_each_thread_can_have_its_own_device(device: Device) -> None:
    texture = Texture.from_array(device, _PIXELS, label="texture")
    read: list[Any] = []

    def work() -> None:
        with Device.headless() as own:
            other = Texture.from_array(own, 2 * _PIXELS, label="other")
            read.append(other.read())
            other.release()

    assert in_another_thread(work) is None
    np.testing.assert_array_equal(read[0], 2 * _PIXELS)
    np.testing.assert_array_equal(texture.read(), _PIXELS)
    texture.release()


def test_a_released_device_is_refused() -> None:
    device = Device.headless()
    texture = Texture(device, (2, 2))
    device.release()
    device.release()
    for call in (device.finish, texture.read, lambda: Texture(device, (2, 2))):
        with pytest.raises(DeviceError, match="released already"):
            call()
    texture.release()
    assert device.live_objects == ()


def test_two_devices_take_turns_on_one_thread(device: Device) -> None:
    first = Texture.from_array(device, _PIXELS, label="first")
    with Device.headless() as other:
        second = Texture.from_array(other, _PIXELS + 100, label="second")
        device.make_current()
        np.testing.assert_array_equal(first.read(), _PIXELS)
        first.write(_PIXELS + 1)
        other.make_current()
        np.testing.assert_array_equal(second.read(), _PIXELS + 100)
        second.release()
    device.make_current()
    np.testing.assert_array_equal(first.read(), _PIXELS + 1)
    first.release()


def test_live_objects_are_named_and_weighed(device: Device) -> None:
    before, nbytes = device.live_objects, device.live_bytes
    texture = Texture(device, (5, 3), components=2, kind="f2", label="half floats")
    buffer = Buffer(device, np.zeros(7, np.int32), label="seven")
    assert device.live_objects == (*before, "texture half floats 5x3", "buffer seven")
    assert device.live_bytes - nbytes == 5 * 3 * 2 * 2 + 7 * 4
    texture.release()
    texture.release()
    assert device.live_objects == (*before, "buffer seven")
    buffer.release()
    buffer.release()
    assert (device.live_objects, device.live_bytes) == (before, nbytes)


@pytest.mark.parametrize("size", [(1, 0), (0, 1)])
def test_a_texture_too_large_names_the_limit(device: Device, size: tuple[int, int]) -> None:
    limit = device.info.max_texture_px
    width, height = (limit + 1 if side else 4 for side in size)
    with pytest.raises(InputError) as caught:
        Texture(device, (width, height), label="panel image")
    assert str(caught.value).startswith(f"panel image: found {width}x{height} pixels")
    assert f"wanted at most {limit} a side" in str(caught.value)


def test_a_buffer_too_large_names_the_limit(device: Device) -> None:
    # Never touched, so its pages are never there.
    huge = np.broadcast_to(np.zeros(1, np.uint8), (device.info.max_storage_bytes + 1,))
    with pytest.raises(VrlfError, match=f"wanted at most {device.info.max_storage_bytes}"):
        Buffer(device, huge, label="rays")


def array_of(kind: str, channels: int) -> Any:
    """Numbers, no two alike where the kind has that many, (2, 3, channels)."""
    count = 6 * channels
    dtype = {"f4": np.float32, "f2": np.float16, "f1": np.uint8, "u1": np.uint8, "nu2": np.uint16}
    step = {"f4": 0.37, "f2": 0.25, "f1": 10, "u1": 10, "nu2": 2700}[kind]
    return (np.arange(count) * step).astype(dtype[kind]).reshape(2, 3, channels)


@pytest.mark.parametrize("kind", ["f4", "f2", "f1", "u1", "nu2"])
@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_a_texture_gives_back_what_it_got(device: Device, kind: str, channels: int) -> None:
    pixels = array_of(kind, channels)
    components = 4 if channels == 3 else channels
    texture = Texture(device, (3, 2), components=components, kind=kind)
    texture.write(pixels)
    read = texture.read()
    assert (read.shape, read.dtype) == ((2, 3, components), pixels.dtype)
    np.testing.assert_array_equal(read[..., :channels], pixels)
    if channels == 3:
        assert np.all(read[..., 3] == {"f1": 255, "u1": 255, "nu2": 65535}.get(kind, 1))
    kept = np.zeros_like(read)
    texture.read_into(kept)
    np.testing.assert_array_equal(kept, read)
    texture.release()


@pytest.mark.parametrize("kind", ["f4", "f2", "f1", "nu2"])
def test_a_texture_takes_its_kind_from_an_array(device: Device, kind: str) -> None:
    for channels in (1, 2, 3, 4):
        pixels = array_of(kind, channels)
        texture = Texture.from_array(device, pixels, label="picture")
        assert (texture.kind, texture.size_px) == (kind, (3, 2))
        assert texture.components == (4 if channels == 3 else channels)
        np.testing.assert_array_equal(texture.read()[..., :channels], pixels)
        texture.release()


def test_a_plane_and_a_turned_array_upload(device: Device) -> None:
    plane = array_of("f4", 1)[..., 0]
    texture = Texture.from_array(device, plane.T[::-1], label="plane")
    np.testing.assert_array_equal(texture.read()[..., 0], plane.T[::-1])
    texture.release()


@pytest.mark.parametrize(
    "wrong",
    [
        np.zeros((3, 2, 4), np.float32),
        np.zeros((2, 3, 4), np.float64),
        np.zeros((2, 3, 4), np.uint8),
    ],
)
def test_an_upload_of_the_wrong_size_or_type_is_refused(device: Device, wrong: Any) -> None:
    texture = Texture.from_array(device, _PIXELS, label="panel image")
    with pytest.raises(ValueError, match=r"panel image: found .*, wanted 3x2 float32"):
        texture.write(wrong)
    np.testing.assert_array_equal(texture.read(), _PIXELS)
    texture.release()


def test_a_buffer_is_filled_a_part_at_a_time(device: Device) -> None:
    buffer = Buffer.reserved(device, 40, label="parts")
    buffer.write_part(np.arange(6, 10, dtype=np.int32), 24)
    buffer.write_part(np.arange(6, dtype=np.int32), 0)
    np.testing.assert_array_equal(buffer.read(np.int32), np.arange(10))
    with pytest.raises(ValueError, match="parts: found 8 bytes from 36 on, wanted them within 40"):
        buffer.write_part(np.zeros(2, np.int32), 36)
    np.testing.assert_array_equal(buffer.read(np.int32), np.arange(10))
    buffer.release()


def test_an_upload_of_too_few_channels_is_refused(device: Device) -> None:
    texture = Texture.from_array(device, _PIXELS, label="panel image")
    with pytest.raises(Exception, match=r"mismatch|found"):
        texture.write(_PIXELS[..., :2])
    np.testing.assert_array_equal(texture.read(), _PIXELS)
    texture.release()


_COPY = """
#include "block/B"
layout(local_size_x = GROUP_PX, local_size_y = GROUP_PX) in;
layout(binding = 0) uniform sampler2D from;
layout(binding = 0, rgba32f) writeonly uniform image2D to;
layout(std430, binding = 0) readonly buffer Gains { float gains[]; };
void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= size.x || at.y >= size.y) return;
    imageStore(to, at, gains[at.y] * texelFetch(from, at, 0));
}
"""
_SIZE = Block("B", (Field("ivec2", "size", ""),))


@pytest.fixture
def copies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Name of a shader that copies, each row with its gain."""
    monkeypatch.setattr(compute, "shaders_dir", lambda: tmp_path)
    (tmp_path / "copy.comp").write_text(_COPY, encoding="utf-8")
    return "copy.comp"


def test_a_pass_reads_textures_and_buffers_and_writes_row_by_row(
    device: Device, copies: str
) -> None:
    # 19 x 13 fills no whole number of groups.
    pixels = np.random.default_rng(3).random((13, 19, 4), dtype=np.float32)
    gains = np.arange(13, dtype=np.float32)
    program = ComputePass(device, copies, _SIZE)
    source = Texture.from_array(device, pixels, label="source")
    shown, buffer = Texture(device, (19, 13)), Buffer(device, np.ones_like(gains), label="gains")
    buffer.write(gains)
    program.set({"size": (19, 13)})
    source.bind_sampler(0)
    shown.bind_image(0, read=False, write=True)
    buffer.bind(0)
    program.run(19, 13)
    np.testing.assert_array_equal(shown.read(), pixels * gains[:, None, None])
    for each in (program, source, shown, buffer):
        each.release()
        each.release()


def test_a_fault_of_the_gpu_is_one_line(device: Device, copies: str) -> None:
    program = ComputePass(device, copies, _SIZE)
    program.run(8, 8 * 65536)  # more groups, one below the other, than any GPU takes
    with pytest.raises(DeviceError, match="found GL_INVALID_VALUE while running, wanted no error"):
        device.check("running")
    device.check("going on")
    program.release()


def test_the_timer_times_what_it_encloses(device: Device, copies: str) -> None:
    program, timer = ComputePass(device, copies, _SIZE), GpuTimer(device)
    small, large = Texture(device, (8, 8)), Texture(device, (1024, 1024))
    rows = Buffer(device, np.ones(1024, np.float32), label="gains")
    rows.bind(0)
    milliseconds = []
    for texture in (small, small, large):  # the first run compiles the rest
        texture.bind_sampler(0)
        texture.bind_image(0, read=True, write=True)
        program.set({"size": texture.size_px})
        with timer.measure():
            program.run(*texture.size_px)
        milliseconds.append(timer.milliseconds)
    assert 0.0 < milliseconds[1] < milliseconds[2]  # 64 pixels and a million
    for each in (program, small, large, rows):
        each.release()


def resident_bytes() -> int:
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def test_making_and_releasing_leaks_nothing(device: Device) -> None:
    rig = pass_rigs.rig(16, 10, array=pass_rigs.HOLES | {"aperture_um": 200.0})
    program, before = Perceive(device), None
    for cycle in range(300):
        tables = PerceiveTables(device, rig, 8)
        panel = Texture.from_array(device, pass_rigs.picture(rig), label="panel")
        seen = Texture(device, panel.size_px, label="seen")
        # 256 kB a cycle, so that a leak of even this one alone would show: 50 MB.
        large = Texture(device, (128, 128), label="large")
        program.run(tables, panel, seen)
        seen.read()
        for each in (tables, panel, seen, large):
            each.release()
        if cycle == 100:  # allocators have settled
            before = (device.live_objects, resident_bytes())
    assert before is not None
    assert device.live_objects == before[0]
    # Measured: 0.3 MB in 800 cycles.
    assert resident_bytes() - before[1] < 2_000_000
    program.release()


def test_devices_leak_nothing() -> None:
    before = 0
    for cycle in range(30):
        with Device.headless() as made:
            Texture(made, (64, 64)).release()
        if cycle == 10:
            before = resident_bytes()
    # An unreleased context takes 2.4 MB: 45 MB for the 19 after the tenth.
    assert resident_bytes() - before < 5_000_000
