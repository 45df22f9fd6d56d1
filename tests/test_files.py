"""Files are whole or not there, whatever the disk does."""

from __future__ import annotations

import errno
import os
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from vrlf.errors import OutputError, OutputPathError, VrlfError
from vrlf.files import atomic_write_bytes, atomic_write_text, check_target, make_folder, shown


def refusal(path: str | os.PathLike[str], kind: type[VrlfError] = OutputPathError) -> str:
    with pytest.raises(kind) as caught:
        atomic_write_bytes(path, b"new")
    message = str(caught.value)
    assert "\n" not in message
    assert "wanted" in message
    return message


def test_a_new_file_and_a_replaced_one(tmp_path: Path) -> None:
    target = tmp_path / "a.bin"
    atomic_write_bytes(target, b"first")
    atomic_write_bytes(str(target), b"")
    assert target.read_bytes() == b""
    atomic_write_text(target, "µ\r\nlast")
    assert target.read_bytes() == "µ\r\nlast".encode()
    assert os.listdir(tmp_path) == ["a.bin"]


def test_the_umask_decides_on_the_rights(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        atomic_write_bytes(tmp_path / "a.bin", b"x")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a.bin").stat().st_mode) == 0o640


def test_a_link_stays_and_its_file_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "real.bin").write_bytes(b"old")
    (tmp_path / "link.bin").symlink_to("real.bin")
    atomic_write_bytes(tmp_path / "link.bin", b"new")
    assert (tmp_path / "link.bin").is_symlink()
    assert (tmp_path / "real.bin").read_bytes() == b"new"


def test_places_that_hold_no_file(tmp_path: Path) -> None:
    assert "found no folder" in refusal(tmp_path / "no" / "a.bin")
    assert "found a folder of that name" in refusal(tmp_path)
    (tmp_path / "f").write_bytes(b"")
    assert "is a file, wanted a folder" in refusal(tmp_path / "f" / "a.bin")
    os.mkfifo(tmp_path / "pipe")
    assert "device or pipe" in refusal(tmp_path / "pipe")
    assert "NUL" in refusal(f"{tmp_path}/a\0b")
    assert "too long" in refusal(tmp_path / ("a" * 300))
    assert sorted(os.listdir(tmp_path)) == ["f", "pipe"]


def test_a_longest_name_leaves_room_for_the_temporary_file(tmp_path: Path) -> None:
    name = "a" * 251 + ".bin"  # 255 bytes, the most that a folder takes
    atomic_write_bytes(tmp_path / name, b"x")
    assert os.listdir(tmp_path) == [name]


@pytest.mark.parametrize("protected", ["folder", "file"])
def test_no_right_to_write(tmp_path: Path, protected: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Asked of the system, whose answer is replaced here: root may write everywhere."""
    target = tmp_path / "a.bin"
    target.write_bytes(b"old")
    forbidden = target if protected == "file" else tmp_path
    honest = os.access
    monkeypatch.setattr(
        os, "access", lambda path, mode: Path(path) != forbidden and honest(path, mode)
    )
    refusal(target)
    assert target.read_bytes() == b"old"


def fail_with(number: int) -> Callable[..., int]:
    def fail(*_: object) -> int:
        raise OSError(number, os.strerror(number))

    return fail


@pytest.mark.parametrize("call", ["write", "fsync", "replace"])
@pytest.mark.parametrize(
    ("number", "kind"),
    [(errno.ENOSPC, OutputError), (errno.EIO, OutputError), (errno.EROFS, OutputPathError)],
)
def test_a_failing_disk_leaves_the_old_file(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    call: str,
    number: int,
    kind: type[VrlfError],
) -> None:
    target = tmp_path / "a.bin"
    target.write_bytes(b"old")
    monkeypatch.setattr(os, call, fail_with(number))
    assert os.strerror(number) in refusal(target, kind)
    assert target.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["a.bin"]


def test_an_interrupt_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(_: int) -> None:
        raise KeyboardInterrupt

    target = tmp_path / "a.bin"
    target.write_bytes(b"old")
    monkeypatch.setattr(os, "fsync", interrupt)
    with pytest.raises(KeyboardInterrupt):
        atomic_write_bytes(target, b"new")
    assert target.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["a.bin"]


def test_a_short_write_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    honest = os.write
    monkeypatch.setattr(os, "write", lambda fd, data: honest(fd, bytes(data[:3])))
    atomic_write_bytes(tmp_path / "a.bin", b"0123456789")
    assert (tmp_path / "a.bin").read_bytes() == b"0123456789"


def test_a_disk_that_really_is_full(tmp_path: Path) -> None:
    """By a limit on file sizes in a process of its own, which needs no rights to set up."""
    target = tmp_path / "a.bin"
    target.write_bytes(b"old")
    script = (
        "import resource, sys\n"
        "from vrlf.errors import OutputError\n"
        "from vrlf.files import atomic_write_bytes\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))\n"
        "try:\n"
        "    atomic_write_bytes(sys.argv[1], b'x' * 10000)\n"
        "except OutputError as error:\n"
        "    print(error)\n"
    )
    root = Path(__file__).parent.parent
    done = subprocess.run(
        [sys.executable, "-c", script, target], cwd=root, capture_output=True, text=True, check=True
    )
    assert "File too large" in done.stdout
    assert target.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["a.bin"]


def test_the_check_before_the_work(tmp_path: Path) -> None:
    assert check_target(tmp_path / "a.bin") == tmp_path.resolve() / "a.bin"
    assert os.listdir(tmp_path) == []
    with pytest.raises(OutputPathError):
        check_target(tmp_path / "no" / "a.bin")


def test_folders_for_results(tmp_path: Path) -> None:
    folder = make_folder(tmp_path / "a" / "b")
    assert folder.is_dir()
    assert make_folder(folder) == folder
    (folder / "f").write_bytes(b"")
    for bad in (folder / "f", folder / "f" / "g", f"{folder}/a\0b"):
        with pytest.raises(OutputPathError, match="wanted"):
            make_folder(bad)


def test_a_path_is_shown_on_one_line() -> None:
    assert shown("plain ä.png") == "plain ä.png"
    assert shown("a\nb") == r"'a\nb'"
