"""Writing: what is read back is what was meant, or the target is as it was."""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import files_by_hand as by_hand
import numpy as np
import pytest

from vrlf.errors import OutputError, OutputPathError, VrlfError
from vrlf.images import (
    PICTURE_ENDINGS,
    check_picture_target,
    read_channels,
    read_picture,
    srgb_decode,
    write_channels,
    write_encoded,
    write_picture,
)

PICTURE = by_hand.asymmetric()
LIGHT = srgb_decode(PICTURE / 255).astype(np.float32)
ROOT = Path(__file__).parent.parent

LOSSLESS = [".png", ".tif", ".tiff", ".webp", ".bmp"]
INTEGER_ENDINGS = [*LOSSLESS, ".jpg", ".jpeg"]


def refusal(path: Path, light: np.ndarray = LIGHT, kind: type[VrlfError] = OutputPathError) -> str:
    with pytest.raises(kind) as caught:
        write_picture(path, light)
    message = str(caught.value)
    assert "\n" not in message
    assert path.name in message
    return message


# --- there and back -----------------------------------------------------------------


def test_every_ending_is_tested_here() -> None:
    assert set(PICTURE_ENDINGS) == {".exr", *INTEGER_ENDINGS}


@pytest.mark.parametrize("ending", LOSSLESS)
def test_codes_come_back_exact_and_upright(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"a{ending}"
    write_picture(path, LIGHT)
    assert np.array_equal(read_picture(path), LIGHT)
    write_encoded(path, PICTURE[::-1])
    assert np.array_equal(read_picture(path), LIGHT[::-1])
    assert os.listdir(tmp_path) == [path.name]


@pytest.mark.parametrize("ending", [".jpg", ".jpeg", ".JPG"])
def test_jpeg_comes_back_close_and_upright(tmp_path: Path, ending: str) -> None:
    blocks = LIGHT.repeat(8, axis=0).repeat(8, axis=1)
    write_picture(tmp_path / f"a{ending}", blocks)
    # 0.02: a few codes of 255 of JPEG's quantisation; neighbouring blocks differ by far more.
    assert np.allclose(read_picture(tmp_path / f"a{ending}"), blocks, rtol=0, atol=0.02)


def test_exr_keeps_every_float(tmp_path: Path) -> None:
    light = (LIGHT - np.float32(0.3)) * np.float32(1234.5678)
    write_picture(tmp_path / "a.exr", light)
    assert np.array_equal(read_picture(tmp_path / "a.exr"), light)
    write_picture(tmp_path / "b.exr", light.astype(np.float64)[:, ::-1])  # not contiguous
    assert np.array_equal(read_picture(tmp_path / "b.exr"), light[:, ::-1])


@pytest.mark.parametrize("ending", [".png", ".tif"])
def test_16_bits(tmp_path: Path, ending: str) -> None:
    codes = np.arange(65536, dtype=np.uint16).reshape(128, 512)
    light = srgb_decode(np.stack([codes, codes[::-1], codes[:, ::-1]], axis=2) / 65535)
    write_picture(tmp_path / f"a{ending}", light, bits=16)
    assert np.array_equal(read_picture(tmp_path / f"a{ending}"), light.astype(np.float32))


def test_light_is_clamped_for_integers(tmp_path: Path) -> None:
    light = np.array([[[-0.5, 0.0, 2.0], [1.0, 1e30, -1e30]]])
    write_picture(tmp_path / "a.png", light)
    assert read_picture(tmp_path / "a.png").tolist() == [[[0, 0, 1], [1, 1, 0]]]


@pytest.mark.parametrize("shape", [(1, 1, 3), (1, 33, 3), (750, 1, 3)])
@pytest.mark.parametrize("ending", PICTURE_ENDINGS)
def test_thin_pictures(tmp_path: Path, ending: str, shape: tuple[int, int, int]) -> None:
    write_picture(tmp_path / f"a{ending}", np.full(shape, 1.0, np.float32))
    # 0.01: JPEG may lose a code or two, the others nothing.
    assert np.allclose(read_picture(tmp_path / f"a{ending}"), 1.0, atol=0.01)


def test_named_channels(tmp_path: Path) -> None:
    channels = {"P": LIGHT[..., 0], "S": LIGHT[..., 1] * 1000, "A b": -LIGHT[..., 2]}
    write_channels(tmp_path / "a.exr", channels)
    back = read_channels(tmp_path / "a.exr")
    assert set(back) == set(channels)
    for name, plane in channels.items():
        assert np.array_equal(back[name], plane)


# --- what else is in the file -------------------------------------------------------


def test_the_same_input_gives_the_same_bytes_at_another_time(tmp_path: Path) -> None:
    first = {}
    for ending in PICTURE_ENDINGS:
        write_picture(tmp_path / f"a{ending}", LIGHT, metadata={"rig": "x"})
        first[ending] = (tmp_path / f"a{ending}").read_bytes()
    time.sleep(1.1)  # the formats count time in seconds
    for ending, data in first.items():
        write_picture(tmp_path / f"b{ending}", LIGHT, metadata={"rig": "x"})
        assert (tmp_path / f"b{ending}").read_bytes() == data, ending


@pytest.mark.parametrize("ending", [".exr", ".png", ".tif", ".jpg"])
def test_metadata_is_in_the_file(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"a{ending}"
    # A name that would steer OpenImageIO, did it not stand behind "vrlf:".
    write_picture(path, LIGHT, metadata={"rig": "matched", "Orientation": "6"})
    data = path.read_bytes()
    for word in (b"vrlf:rig", b"matched", b"vrlf:Orientation"):
        assert word in data
    assert read_picture(path).shape == LIGHT.shape


# --- refusals -----------------------------------------------------------------------


@pytest.mark.parametrize("name", ["a.gif", "a.hdr", "a", "a.png.txt", ".png", "a.null"])
def test_unknown_endings(tmp_path: Path, name: str) -> None:
    assert ".exr" in refusal(tmp_path / name)
    with pytest.raises(OutputPathError):
        check_picture_target(tmp_path / name)
    assert os.listdir(tmp_path) == []


def test_places_that_hold_no_file(tmp_path: Path) -> None:
    assert "found no folder" in refusal(tmp_path / "no" / "a.png")
    (tmp_path / "folder.png").mkdir()
    assert "found a folder of that name" in refusal(tmp_path / "folder.png")
    with pytest.raises(OutputPathError, match="no folder"):
        check_picture_target(tmp_path / "no" / "a.png")


def test_numbers_that_the_format_has_not(tmp_path: Path) -> None:
    with pytest.raises(OutputPathError, match="wanted one for uint16"):
        write_picture(tmp_path / "a.jpg", LIGHT, bits=16)
    with pytest.raises(OutputPathError, match="wanted one for uint8"):
        write_encoded(tmp_path / "a.exr", PICTURE)
    with pytest.raises(OutputPathError, match=r"wanted \.exr"):
        write_channels(tmp_path / "a.png", {"P": LIGHT[..., 0]})
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("name", ["a.exr", "a.png"])
def test_light_that_is_not_finite(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(b"old")
    light = LIGHT.astype(np.float64)
    light[0, 0, 0], light[1, 2, 1], light[4, 6, 2] = np.nan, np.inf, 1e300
    message = refusal(tmp_path / name, light, OutputError)
    assert "3 of 105 values" in message
    assert (tmp_path / name).read_bytes() == b"old"


def test_pictures_of_no_size_or_too_large(tmp_path: Path) -> None:
    refusal(tmp_path / "a.png", np.zeros((0, 5, 3)), OutputError)
    refusal(tmp_path / "a.png", np.zeros((16385, 1, 3)), OutputError)
    # One more than WebP itself can do: the encoder's own refusal.
    refusal(tmp_path / "a.webp", np.zeros((16384, 1, 3)), OutputError)
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    "array", [PICTURE, LIGHT[..., 0], LIGHT[..., :2], PICTURE.astype(np.int64)]
)
def test_arrays_that_are_no_light(tmp_path: Path, array: np.ndarray) -> None:
    with pytest.raises(ValueError, match="wanted floats"):
        write_picture(tmp_path / "a.png", array)


def test_arrays_that_are_no_codes(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="wanted uint8 or 16"):
        write_encoded(tmp_path / "a.png", LIGHT)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="wanted floats"):
        write_channels(tmp_path / "a.exr", {"P": PICTURE[..., 0]})  # type: ignore[dict-item]


# --- a full disk --------------------------------------------------------------------

NOISE = np.random.default_rng(3).random((200, 300, 3)).astype(np.float32)  # 180 kB and more


@pytest.mark.parametrize("ending", PICTURE_ENDINGS)
def test_a_full_disk(tmp_path: Path, ending: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    path = tmp_path / f"a{ending}"
    path.write_bytes(b"old")
    monkeypatch.setattr(os, "write", full)
    assert "No space left" in refusal(path, NOISE, OutputError)
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == [path.name]


@contextlib.contextmanager
def small_disk(folder: Path) -> Iterator[str]:
    """A disk of 64 kB, where this process may mount one; else the folder as it is."""
    command = ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(folder)]
    try:
        mounted = subprocess.run(command, capture_output=True, text=True, check=False)
        reason = mounted.stderr.strip() if mounted.returncode else ""
    except FileNotFoundError as error:
        reason = str(error)
    try:
        yield reason
    finally:
        if not reason:
            subprocess.run(["umount", str(folder)], check=True)


def test_a_disk_that_really_is_full(tmp_path: Path) -> None:
    """On a tiny disk; where none can be mounted, by a limit on file sizes."""
    script = (
        "import sys, numpy, resource\n"
        "from vrlf.errors import OutputError\n"
        "from vrlf.images import write_picture\n"
        "noise = numpy.random.default_rng(3).random((200, 300, 3))\n"
        "if sys.argv[2]:\n"
        "    resource.setrlimit(resource.RLIMIT_FSIZE, (65536, 65536))\n"
        "for name in sys.argv[3:]:\n"
        "    try:\n"
        "        write_picture(f'{sys.argv[1]}/{name}', noise)\n"
        "    except OutputError as error:\n"
        "        print(error)\n"
    )
    names = [f"a{ending}" for ending in PICTURE_ENDINGS]
    with small_disk(tmp_path) as reason:
        print("a disk of 64 kB" if not reason else f"a limit on file sizes, since {reason}")
        (tmp_path / names[0]).write_bytes(b"old")
        for limited in {"", "limited"} if not reason else {"limited"}:
            done = subprocess.run(
                [sys.executable, "-c", script, tmp_path, limited, *names],
                cwd=ROOT,
                capture_output=True,
                text=True,
                timeout=60,  # OpenImageIO's WebP would hang
                check=True,
            )
            lines = done.stdout.splitlines()
            assert len(lines) == len(names)
            for name, line in zip(names, lines, strict=True):
                assert name in line
                assert ("No space left" in line) or ("ulimit -f" in line)
            assert (tmp_path / names[0]).read_bytes() == b"old"
            assert os.listdir(tmp_path) == [names[0]]


# --- where a system has no files in memory -------------------------------------------


def test_a_temporary_folder_serves_as_well(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_picture(tmp_path / "memory.png", LIGHT)
    (tmp_path / "scratch").mkdir()
    monkeypatch.delattr(os, "memfd_create", raising=False)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "scratch"))
    write_picture(tmp_path / "disk.png", LIGHT)
    assert (tmp_path / "disk.png").read_bytes() == (tmp_path / "memory.png").read_bytes()
    assert os.listdir(tmp_path / "scratch") == []

    usage = shutil.disk_usage(tmp_path)._replace(free=1000)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage)
    assert "1000 bytes free" in refusal(tmp_path / "no.png", LIGHT, OutputError)
    assert not (tmp_path / "no.png").exists()
