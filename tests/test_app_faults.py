"""What goes wrong, by the user's hand or the machine's: one clear line, nothing half-written."""

from __future__ import annotations

import os
import signal
import struct
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_runs import (
    BARE,
    DATA,
    LENSLETS,
    Outcome,
    call,
    exr_file,
    left_in,
    light,
    png_file,
    require_done,
    require_one_line,
    require_refused,
    spawn,
    start,
)
from files_by_hand import asymmetric, bmp_header, pfm, png

import vrlf.files
from vrlf.gpu import Device

RIG_TEXT = (DATA / "lenslets-turned.toml").read_text()


@pytest.fixture(scope="module")
def panel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A picture of the small rigs' panel size."""
    return exr_file(tmp_path_factory.mktemp("given") / "panel.exr", light())


def with_rig(command: str, panel: Path, folder: Path) -> tuple[str, ...]:
    """A good command line of every command that takes a rig, but for the rig itself."""
    return {
        "inspect": ("inspect",),
        "eye": ("eye", "-o", str(folder / "out.png")),
        "chart": ("chart", "grid", "-o", str(folder / "out.png")),
        "prefilter": ("prefilter", str(panel), "-o", str(folder / "out.png")),
        "perceive": ("perceive", str(panel), "-o", str(folder / "out.png")),
        "demo": ("demo", "-o", str(folder / "out")),
        "evaluate": ("evaluate", str(panel), "-o", str(folder / "out"), *EVALUATE_QUICKLY),
    }[command]


RIG_COMMANDS = ("inspect", "eye", "chart", "prefilter", "perceive", "demo", "evaluate")
EVALUATE_QUICKLY = ("--method", "none", "--metric", "rmse")
# Those that make files; each makes one called out or out.png.
WRITERS = RIG_COMMANDS[1:]
# Those that make pictures of the panel's size.
PANEL_WRITERS = RIG_COMMANDS[2:]


# Wrong command lines


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        (("nonsense",), ("'nonsense'", "vrlf --help")),
        (("--nonsense",), ("--nonsense", "vrlf --help")),
        (("inspect", "--frobnicate"), ("--frobnicate", "vrlf inspect --help")),
        (("inspect", "extra"), ("extra", "vrlf inspect --help")),
        (("inspect", "--set"), ("--set",)),
        (("inspect", "--js"), ("--js",)),
        (("rigs", "extra"), ("extra",)),
        (("rigs", "--rig", "x"), ("--rig",)),
        (("rigs", "--json=1"), ("--json",)),
        (("doctor", "extra"), ("extra",)),
        (("doctor", "--fast"), ("--fast",)),
        (("doctor", "--json=1"), ("--json",)),
        (("chart",), ("NAME",)),
        (("chart", "grid"), ("--output",)),
        (("chart", "eiffel", "-o", "a.png"), ("eiffel", "logmar")),
        (("prefilter",), ("SOURCE",)),
        (("prefilter", "a.png"), ("--output",)),
        (("prefilter", "a.png", "-o", "b.png", "--layout", "diagonal"), ("diagonal", "mono")),
        (("prefilter", "a.png", "-o", "b.png", "--fit", "stretch"), ("stretch", "cover")),
        (("prefilter", "a.png", "-o", "b.png", "--bits", "12"), ("12", "16")),
        (("prefilter", "a.png", "-o", "b.png", "--device", "abacus"), ("abacus", "reference")),
        (("prefilter", "a.png", "-o", "b.png", "--encoding", "gamma"), ("gamma", "srgb")),
        (("perceive", "a.png", "b.png", "-o", "c.png"), ("b.png",)),
        (("perceive", "a.png", "-o", "b.png", "--exposure", "long"), ("long", "auto")),
        *(
            (("perceive", "a.png", "-o", "b.png", "--rays", rays), ("--rays", rays, "1048576"))
            for rays in ("0", "-3", "nan", "inf", "1.5", "1e3", "1048577", "", "many", "9" * 30)
        ),
        (("demo", "--rays", "0"), ("--rays", "1048576")),
        (("demo", "--rays", "1048577"), ("--rays", "1048576")),
        (("demo", "extra"), ("extra",)),
        (("bench", "--runs", "2"), ("--runs", "from 3 to 1000")),
        (("bench", "--runs", "nan"), ("--runs", "from 3 to 1000")),
        (("bench", "--rays", "0"), ("--rays",)),
        (("bench", "--rig", "nope"), ("nope", "matched-microlens")),
    ],
)
def test_a_wrong_command_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
    names: tuple[str, ...],
) -> None:
    monkeypatch.chdir(tmp_path)
    require_one_line(call(*arguments), 2, *names)
    assert left_in(tmp_path) == []


# Wrong rigs


@pytest.mark.parametrize("command", RIG_COMMANDS)
@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        (("-r", "no-such-rig"), ("no-such-rig", "matched-microlens")),
        (("-r", "matched-microlans"), ("did you mean", "matched-microlens")),
        (("-r", "missing.toml"), ("missing.toml", "no such file")),
        (("-r", "/"), ("/", "folder")),
        (("-r", ""), ('""',)),
        ((*LENSLETS, "--set", "panel.pixel_pitch_um=-78"), ("panel.pixel_pitch_um", "-78")),
        ((*LENSLETS, "--set", "left.pupil_mm=0"), ("left.pupil_mm", "found 0", "above 0")),
        ((*LENSLETS, "--set", "right.axis_deg=999"), ("right.axis_deg", "999", "180")),
        ((*LENSLETS, "--set", "array.gap_mm=47"), ("array.gap_mm", "47", "lens_to_panel_mm")),
        ((*LENSLETS, "--set", "array.focal_mm=0"), ("array.focal_mm", "found 0")),
        ((*LENSLETS, "--set", "left.sphere_d=nan"), ("left.sphere_d", "nan")),
        ((*LENSLETS, "--set", "left.sphere_d=-inf"), ("left.sphere_d", "-inf")),
        ((*LENSLETS, "--set", "left.pupil_mm=wide"), ("left.pupil_mm", '"wide"')),
        ((*LENSLETS, "--set", "left.pupil_mm=true"), ("left.pupil_mm", "true")),
        ((*LENSLETS, "--set", "panel.width_px=96.5"), ("panel.width_px", "96.5")),
        ((*LENSLETS, "--set", "panel.subpixels=diamond"), ("panel.subpixels", "rgb-stripe")),
        ((*LENSLETS, "--set", "left.spere_d=-1"), ("left.spere_d", '"sphere_d"')),
        ((*LENSLETS, "--set", "goggles.tint=1"), ("goggles", "headset")),
        ((*LENSLETS, "--set", "left=1"), ("left", "table [left]")),
        ((*LENSLETS, "--set", "left.pupil_mm"), ("--set", "left.pupil_mm", "table.key=value")),
        ((*LENSLETS, "--set", "schema=2"), ("schema", "2")),
        ((*LENSLETS, "--left", "-5 / -1"), ("--left", "axis")),
        ((*LENSLETS, "--both", "blurry"), ("--both", "blurry", "plano")),
        ((*LENSLETS, "--right", "-5 / -1 x 270"), ("--right", "270", "180")),
    ],
)
def test_a_wrong_rig_is_one_line_and_nothing_is_made(
    tmp_path: Path, panel: Path, command: str, arguments: tuple[str, ...], names: tuple[str, ...]
) -> None:
    require_one_line(call(*with_rig(command, panel, tmp_path), *arguments), 2, *names)
    assert left_in(tmp_path) == []


@pytest.mark.parametrize(
    ("text", "names"),
    [
        (b"", ("panel", "headset", "left", "right", "table [left]")),
        (b"[panel", ("syntax error",)),
        (b"\xff\xfe", ("not UTF-8", "line 1")),
        (b"\0" * 2**21, ("1 MiB",)),
        (b"x = " + b"[" * 10_000, ("TOML",)),
        (b'extends = "rig.toml"', ("extends", "lead back")),
        (b'extends = "nope"', ("extends", "nope")),
        (RIG_TEXT[: RIG_TEXT.index("[left]")].encode(), ("left", "right", "table")),
        (RIG_TEXT.replace("[right]", "[rihgt]").encode(), ("right", "rihgt")),
    ],
)
def test_a_wrong_rig_file(tmp_path: Path, text: bytes, names: tuple[str, ...]) -> None:
    file = tmp_path / "rig.toml"
    file.write_bytes(text)
    require_one_line(call("inspect", "-r", file), 2, "rig.toml", *names)


def test_all_wrong_keys_are_named_at_once(tmp_path: Path) -> None:
    file = tmp_path / "rig.toml"
    wrong = {
        "pixel_pitch_um = 78.0": "pixel_pitch_um = -78.0",
        "rotation_deg = 7.0": "rotation_deg = nan\ncolour = 3",
        "lens_to_panel_mm = 46.0": 'lens_to_panel_mm = "far"',
        "pupil_mm = 5.0": "pupil_mm = 0",
        "axis_deg = 35.0": "axis_deg = 999",
    }
    text = RIG_TEXT
    for good, bad in wrong.items():
        assert text.count(good) == 1
        text = text.replace(good, bad)
    file.write_text(text)
    keys = ("panel.pixel_pitch_um", "array.rotation_deg", "array.colour")
    keys += ("headset.lens_to_panel_mm", "right.pupil_mm", "right.axis_deg", "left.sphere_d")
    require_one_line(call("inspect", "-r", file, "--set", "left.sphere_d=1e9"), 2, *keys)


@pytest.mark.parametrize("command", PANEL_WRITERS)
@pytest.mark.parametrize("size", [(20000, 64), (96, 20000), (16384, 16384)])
def test_a_panel_too_large(
    tmp_path: Path, panel: Path, command: str, size: tuple[int, int]
) -> None:
    sides = ("--set", f"panel.width_px={size[0]}", "--set", f"panel.height_px={size[1]}")
    outcome = call(*with_rig(command, panel, tmp_path), *LENSLETS, *sides)
    require_one_line(outcome, 2, f"{size[0]}x{size[1]}", "16384")
    assert left_in(tmp_path) == []


def test_a_panel_too_large_for_this_gpu(
    tmp_path: Path, panel: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def small(device: Device, width_px: int, height_px: int, what: str) -> None:
        object.__setattr__(device.info, "max_texture_px", 90)
        require(device, width_px, height_px, what)

    require = Device.require_texture_size
    monkeypatch.setattr(Device, "require_texture_size", small)
    for command in ("prefilter", "perceive", "demo"):
        source = ("--source", str(panel)) if command == "demo" else ()
        outcome = call(*with_rig(command, panel, tmp_path), *LENSLETS, *source)
        require_refused(outcome, 2, "96x64", "at most 90 a side")
    assert left_in(tmp_path) == []


# Wrong pictures


def _truncated_png(path: Path) -> None:
    data = png(asymmetric(64, 96))
    path.write_bytes(data[: len(data) // 2])


def _nan_pfm(path: Path) -> None:
    pixels = light()
    pixels[3, 4, 1] = np.nan
    path.write_bytes(pfm(pixels, big_endian=False))


def _uncompressed_exr(value: bytes) -> bytes:
    """One pixel R, G, B of 1, 1 and ``value``, after the OpenEXR file layout."""

    def attribute(name: str, kind: str, data: bytes) -> bytes:
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data

    def channel(name: str) -> bytes:
        return name.encode() + b"\0" + struct.pack("<iiii", 2, 0, 1, 1)

    box = struct.pack("<iiii", 0, 0, 0, 0)
    header = b"".join(
        [
            b"\x76\x2f\x31\x01" + struct.pack("<i", 2),
            attribute("channels", "chlist", channel("B") + channel("G") + channel("R") + b"\0"),
            attribute("compression", "compression", b"\0"),
            attribute("dataWindow", "box2i", box),
            attribute("displayWindow", "box2i", box),
            attribute("lineOrder", "lineOrder", b"\0"),
            attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
            attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0.0, 0.0)),
            attribute("screenWindowWidth", "float", struct.pack("<f", 1.0)),
            b"\0",
        ]
    )
    one = struct.pack("<f", 1.0)
    chunk = struct.pack("<ii", 0, 12) + one + one + value
    return header + struct.pack("<Q", len(header) + 8) + chunk


PICTURES: dict[str, tuple[Callable[[Path], Any], str]] = {
    "missing.png": (lambda _: None, "no such file"),
    "folder.png": (lambda path: path.mkdir(), "folder"),
    "empty.png": (lambda path: path.touch(), "empty.png"),
    "text.png": (lambda path: path.write_text("not a picture"), "text.png"),
    "cut.png": (_truncated_png, "cut.png"),
    "hostile.bmp": (lambda path: path.write_bytes(bmp_header(65535, 65535)), "65535"),
    "nan.pfm": (_nan_pfm, "nan.pfm"),
    "nan.exr": (
        lambda path: path.write_bytes(_uncompressed_exr(np.float32(np.nan).tobytes())),
        "nan.exr",
    ),
    "pipe.png": (lambda path: os.mkfifo(path), "pipe.png"),
}


@pytest.mark.parametrize("name", PICTURES)
@pytest.mark.parametrize("command", ["prefilter", "right", "perceive", "demo"])
def test_a_wrong_picture(tmp_path: Path, panel: Path, command: str, name: str) -> None:
    make, wanted = PICTURES[name]
    folder = tmp_path / "out"
    folder.mkdir()
    given = tmp_path / name
    make(given)
    out = ("-o", str(folder / "out.png"))
    outcome = {
        "prefilter": lambda: call("prefilter", given, *LENSLETS, *out),
        "right": lambda: call("prefilter", panel, "--right-source", given, *LENSLETS, *out),
        "perceive": lambda: call("perceive", given, *LENSLETS, *out),
        "demo": lambda: call("demo", "--source", given, *LENSLETS, "-o", folder / "demo"),
    }[command]()
    require_refused(outcome, 2, name, wanted)
    assert left_in(folder) == []


def test_the_hostile_picture_has_74_bytes_and_costs_no_time(tmp_path: Path) -> None:
    given = tmp_path / "hostile.bmp"
    given.write_bytes(bmp_header(65535, 65535))
    assert given.stat().st_size == 74
    require_refused(spawn("prefilter", given, *LENSLETS, "-o", tmp_path / "a.png", timeout_s=20), 2)


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        (("prefilter", "{panel}", "--right-source", "{small}"), ("small.png", "7x5", "96x64")),
        (
            ("prefilter", "{panel}", "--right-source", "{panel}", "--layout", "over-under"),
            ("over-under", "mono"),
        ),
        (("perceive", "{small}"), ("small.png", "7x5", "96x64")),
        (("prefilter", "grid"), ("grid", "chart:grid")),
        (("prefilter", "chart:eiffel"), ("eiffel", "logmar")),
        (("prefilter", "a" * 5000), ("aaa",)),
        (("prefilter", "nul\0byte.png"), ("NUL",)),
        (("prefilter", ""), ("wanted",)),
        (("perceive", ""), ("wanted",)),
    ],
)
def test_a_picture_that_does_not_fit(
    tmp_path: Path, panel: Path, arguments: tuple[str, ...], names: tuple[str, ...]
) -> None:
    small = png_file(tmp_path / "small.png", asymmetric())
    filled = [text.format(panel=panel, small=small) for text in arguments]
    require_refused(call(*filled, *LENSLETS, "-o", tmp_path / "out.png"), 2, *names)
    assert left_in(tmp_path) == ["small.png"]


# Wrong places


def target_of(command: str, place: str) -> tuple[str, ...]:
    return {
        "chart": ("chart", "grid", *LENSLETS, "-o", place),
        "prefilter": ("prefilter", "chart:grid", *LENSLETS, "-o", place),
        "target": ("prefilter", "chart:grid", *LENSLETS, "-o", "ok.png", "--target", place),
        "perceive": ("perceive", "panel.exr", *LENSLETS, "-o", place),
    }[command]


@pytest.mark.parametrize("command", ["chart", "prefilter", "target", "perceive"])
@pytest.mark.parametrize(
    ("place", "names"),
    [
        ("nowhere/out.png", ("nowhere/out.png", "no folder", "make it first")),
        ("file/out.png", ("file/out.png", "folder")),
        ("folder.png", ("folder.png", "folder")),
        ("pipe.png", ("pipe.png", "pipe")),
        ("out.xyz", ("out.xyz", "'.xyz'", ".png")),
        ("out", ("out", ".png")),
        ("", (".png",)),
        ("n" * 300 + ".png", ("name",)),
        ("nul\0.png", ("NUL",)),
        ("link.png", ("link.png",)),
    ],
)
def test_a_wrong_place_is_refused_before_any_work(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: str,
    place: str,
    names: tuple[str, ...],
) -> None:
    monkeypatch.chdir(tmp_path)
    exr_file(tmp_path / "panel.exr", light())
    (tmp_path / "file").touch()
    (tmp_path / "folder.png").mkdir()
    os.mkfifo("pipe.png")
    Path("link.png").symlink_to(tmp_path / "nowhere" / "out.png")
    before = left_in(tmp_path)
    require_one_line(call(*target_of(command, place)), 2, *names)
    assert left_in(tmp_path) == before


def test_demo_refuses_a_wrong_folder_before_any_work(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "taken" / "overview.png").mkdir(parents=True)
    for place, name in (("file", "file"), ("file/sub", "file"), ("taken", "overview.png")):
        require_one_line(call("demo", *LENSLETS, "-o", tmp_path / place), 2, name)
    assert left_in(tmp_path) == ["file", "taken"]


def test_demo_takes_away_the_folder_that_it_made_in_vain(tmp_path: Path) -> None:
    outcome = call("demo", *LENSLETS, "--source", "missing.png", "-o", tmp_path / "new")
    require_refused(outcome, 2, "missing.png")
    (tmp_path / "old").mkdir()
    outcome = call("demo", *LENSLETS, "--source", "missing.png", "-o", tmp_path / "old")
    require_refused(outcome, 2, "missing.png")
    assert left_in(tmp_path) == ["old"]


def test_two_results_in_one_file_are_refused(tmp_path: Path, panel: Path) -> None:
    (tmp_path / "link.png").symlink_to("out.png")
    for second in ("out.png", "link.png"):
        outcome = call(
            *("prefilter", panel, *LENSLETS, "-o", tmp_path / "out.png"),
            *("--target", tmp_path / second),
        )
        require_one_line(outcome, 2, "--target", second, "same file")
    assert left_in(tmp_path) == ["link.png"]


def test_a_ten_bit_panel_needs_an_ending_for_it(tmp_path: Path, panel: Path) -> None:
    deep = (*LENSLETS, "--set", "panel.bits=10")
    outcome = call("prefilter", panel, *deep, "-o", tmp_path / "out.bmp")
    require_one_line(outcome, 2, "panel.bits", "10", ".bmp", "--bits 8", ".png")


@pytest.mark.parametrize("ending", ["jpg", "webp", "bmp"])
def test_sixteen_bits_where_there_are_none(tmp_path: Path, panel: Path, ending: str) -> None:
    for command in ("prefilter", "perceive"):
        outcome = call(command, panel, *LENSLETS, "-o", tmp_path / f"out.{ending}", "--bits", "16")
        require_one_line(outcome, 2, "--bits", "16", f".{ending}", ".png")


# Disks


def mounted(folder: Path, *options: str) -> Path | None:
    """A file system in memory; None, and why, where none can be mounted."""
    command = ["mount", "-t", "tmpfs", *options, "tmpfs", str(folder)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        print("no mount program: the limit on file sizes stands in for the full disk")
        return None
    if done.returncode:
        print(f"{done.stderr.strip()}: the limit on file sizes stands in for the full disk")
        return None
    return folder


@pytest.fixture(scope="module")
def small_disk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path | None]:
    """A disk of two pages, where the right to mount one is given."""
    folder = mounted(tmp_path_factory.mktemp("disk"), "-o", "size=8k")
    yield folder
    if folder is not None:
        subprocess.run(["umount", str(folder)], check=True)


def limit_file_sizes() -> None:
    """Of the process to come: no file may grow beyond 1000 bytes."""
    import resource

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))


@pytest.mark.parametrize("command", ["chart", "prefilter", "perceive"])
@pytest.mark.parametrize("ending", ["png", "exr", "jpg", "webp"])
def test_a_full_disk(
    tmp_path: Path, panel: Path, small_disk: Path | None, command: str, ending: str
) -> None:
    if small_disk is None:
        folder, how = tmp_path, {"preexec_fn": limit_file_sizes}
        run: Callable[..., Outcome] = lambda *words: spawn(*words, **how)  # noqa: E731
    else:
        folder, run = small_disk, call
    out, more = folder / f"out.{ending}", folder / "ballast"
    out.write_bytes(b"the old one")
    more.write_bytes(b"\0" * 4096)
    try:
        words = {
            "chart": ("chart", "usaf1951"),
            "prefilter": ("prefilter", str(panel)),
            "perceive": ("perceive", str(panel), "--rays", "4"),
        }[command]
        outcome = run(*words, *LENSLETS, "-o", out)
        require_refused(outcome, 1, f"out.{ending}", "wanted")
        assert out.read_bytes() == b"the old one"
        assert left_in(folder) == ["ballast", out.name]
    finally:
        out.unlink()
        more.unlink()


def test_a_limit_on_file_sizes_is_one_line(tmp_path: Path, panel: Path) -> None:
    out = tmp_path / "out.png"
    outcome = spawn("prefilter", panel, *LENSLETS, "-o", out, preexec_fn=limit_file_sizes)
    require_refused(outcome, 1, "out.png", "1000 bytes")
    assert left_in(tmp_path) == []


def test_a_disk_that_fills_up_during_the_demo(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written: list[int] = []

    def full_after_two(descriptor: int, data: Any) -> int:
        written.append(descriptor)
        if len(written) > 2:
            raise OSError(28, "No space left on device")
        return write(descriptor, data)

    write = os.write
    monkeypatch.setattr(vrlf.files.os, "write", full_after_two)
    rays = ("--rays", "2", "--source", "chart:marks")
    outcome = call("demo", *LENSLETS, *rays, "-o", tmp_path / "out")
    require_refused(outcome, 1, "perceived-without.png", "No space left")
    # The first two are whole; of the third there is nothing.
    assert left_in(tmp_path / "out") == ["panel.png", "target.png"]


@pytest.fixture
def read_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder in which nothing can be made; root may write anywhere but on such a disk."""
    folder = tmp_path / "read-only"
    folder.mkdir()
    if os.geteuid() != 0:
        folder.chmod(0o555)
        yield folder
        folder.chmod(0o755)
    elif mounted(folder, "-o", "ro") is not None:
        yield folder
        subprocess.run(["umount", str(folder)], check=True)
    else:
        monkeypatch.setattr(vrlf.files.os, "access", lambda *_: False)
        yield folder


@pytest.mark.parametrize("command", WRITERS)
def test_a_folder_that_cannot_be_written(read_only: Path, panel: Path, command: str) -> None:
    outcome = call(*with_rig(command, panel, read_only), *LENSLETS)
    require_one_line(outcome, 2, "read-only", "wanted")
    assert left_in(read_only) == []


# Standard output and standard error


def test_standard_output_on_a_full_disk() -> None:
    for command in (("inspect", "--json"), ("--help",)):
        with Path("/dev/full").open("w") as full:
            outcome = spawn(*command, stdout=full)
        require_one_line(outcome, 1, "standard output", "No space left")


def test_a_closed_standard_output() -> None:
    outcome = spawn("inspect", "--json", preexec_fn=lambda: os.close(1))
    require_one_line(outcome, 1, "standard output", "closed")


def test_a_reader_that_leaves_early() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    try:
        outcome = spawn("inspect", "--json", stdout=writing)
    finally:
        os.close(writing)
    # That is its right; head says nothing either.
    assert (outcome.status, outcome.err) == (1, "")


def test_standard_error_that_takes_nothing(tmp_path: Path, panel: Path) -> None:
    out = tmp_path / "out.png"
    with Path("/dev/full").open("w") as full:
        outcome = spawn("prefilter", panel, *LENSLETS, "-o", out, "--json", stderr=full)
        assert outcome.status == 0
        assert outcome.json()["output"] == str(out)
        assert spawn("inspect", "-r", "nope", stderr=full).status == 2
    outcome = spawn("inspect", "-r", "nope", preexec_fn=lambda: os.close(2))
    assert (outcome.status, outcome.out) == (2, "")


# GPUs

NO_EGL = {"__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent.json"}
OLD_GL = {"MESA_GL_VERSION_OVERRIDE": "3.3"}


def test_no_egl(tmp_path: Path, panel: Path) -> None:
    environment = os.environ | NO_EGL
    outcome = spawn(*with_rig("prefilter", panel, tmp_path), *LENSLETS, env=environment)
    require_refused(outcome, 1, "GPU", "OpenGL 4.3", "apt-get install", "vrlf doctor")
    assert left_in(tmp_path) == []
    report = spawn("doctor", env=environment)
    assert (report.status, report.err) == (1, "")
    for wanted in ("Problem", "apt-get install", "--device reference", "llvmpipe"):
        assert wanted in report.out
    assert "'vrlf doctor' tells more" not in report.out  # it is what tells more
    slow = spawn(
        *with_rig("perceive", panel, tmp_path),
        *(*LENSLETS, "--device", "reference", "--rays", "1"),
        env=environment,
    )
    require_done(slow)


def test_an_opengl_too_old(tmp_path: Path, panel: Path) -> None:
    environment = os.environ | OLD_GL
    outcome = spawn(*with_rig("perceive", panel, tmp_path), *LENSLETS, env=environment)
    require_one_line(outcome, 1, "GPU", "found OpenGL 3.3", "wanted OpenGL 4.3", "driver")
    assert left_in(tmp_path) == []
    report = spawn("doctor", "--json", env=environment)
    assert (report.status, report.err) == (1, "")
    assert report.json()["ok"] is False
    assert "found OpenGL 3.3" in report.json()["problem"]


@pytest.mark.parametrize("command", ["demo", "bench"])
def test_no_gpu_for_those_that_need_one(
    tmp_path: Path, panel: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    def none(**_: Any) -> None:
        raise Exception("no devices")  # as glcontext does

    monkeypatch.setattr("moderngl.create_context", none)
    words = with_rig("demo", panel, tmp_path) if command == "demo" else ("bench",)
    require_one_line(call(*words), 1, "GPU", "no devices", "OpenGL 4.3")
    assert left_in(tmp_path) == []


# Interrupts and surprises


def test_an_interrupt_leaves_nothing_half_written(tmp_path: Path, panel: Path) -> None:
    words = [*LENSLETS, "--device", "reference", "--set", "prefilter.subpixel_grid=16"]
    words += ["--set", "panel.width_px=960", "--set", "panel.height_px=640"]  # takes seconds
    with start("prefilter", panel, *words, "-o", tmp_path / "out.png") as process:
        assert process.stderr is not None
        assert "taken as mono" in process.stderr.readline()  # the work begins
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 1
    assert out == ""
    assert err.split("\n") == ["", "vrlf: interrupted", ""]  # after the terminal's ^C
    assert left_in(tmp_path) == []


def test_an_interrupt_while_a_file_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(vrlf.files.os, "fsync", interrupted)
    outcome = call("chart", "grid", *LENSLETS, "-o", tmp_path / "out.png")
    assert (outcome.status, outcome.out) == (1, "")
    assert outcome.lines[-1] == "vrlf: interrupted"
    assert left_in(tmp_path) == []


def test_a_fault_of_ours_is_one_line_too(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(_: Any) -> None:
        raise ZeroDivisionError("division\nby zero")

    monkeypatch.setattr("vrlf.app.facts.inspect_rig", fails)
    outcome = call("inspect", *BARE)
    assert (outcome.status, outcome.out) == (1, "")
    assert outcome.lines == [
        "vrlf: unexpected ZeroDivisionError: division by zero "
        "(set VRLF_DEBUG=1 for the details, and please report it)"
    ]
    monkeypatch.setenv("VRLF_DEBUG", "1")
    with pytest.raises(ZeroDivisionError):
        call("inspect", *BARE)


def test_too_little_memory_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(_: Any) -> None:
        raise MemoryError

    monkeypatch.setattr("vrlf.app.facts.inspect_rig", fails)
    require_one_line(call("inspect", *BARE), 1, "memory")
