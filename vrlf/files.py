"""Writing files whole or not at all, with one clear line where that cannot be done."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import stat
from pathlib import Path

from vrlf.errors import OutputError, OutputPathError

# The user named a place that cannot hold the file; all other failures are the machine's.
_PLACE_IS_WRONG = frozenset(
    {
        errno.EACCES,
        errno.EPERM,
        errno.EROFS,
        errno.ENOENT,
        errno.ENOTDIR,
        errno.EISDIR,
        errno.ENAMETOOLONG,
        errno.ELOOP,
        errno.EINVAL,
    }
)


def shown(path: str | os.PathLike[str]) -> str:
    """A path as a message may show it: quoted where it holds unprintable characters."""
    text = os.fspath(path)
    return text if text.isprintable() else ascii(text)


def check_target(path: str | os.PathLike[str]) -> Path:
    """Make sure that a file can be put at ``path``, before any work is done for it.

    Parameters
    ----------
    path : path
        Where the result is to go. A symbolic link stands for what it points to.

    Returns
    -------
    Path
        The file that would be replaced or made, links followed.

    Raises
    ------
    OutputPathError
        No such folder, a folder or device in the file's place, or no right to write.
    """
    name = shown(path)
    if "\0" in os.fspath(path):
        raise OutputPathError(f"{name}: found a NUL character in the path, wanted a file name")
    try:
        target = Path(os.path.realpath(path))
        _check_folder(target.parent, name)
        if target.exists():
            _check_replaceable(target, name)
    except OSError as error:
        raise _as_output_error(error, name) from error
    return target


def _check_folder(folder: Path, name: str) -> None:
    if not folder.exists():
        raise OutputPathError(
            f"{name}: found no folder {shown(folder)}, wanted one that exists; make it first"
        )
    if not folder.is_dir():
        raise OutputPathError(f"{name}: found that {shown(folder)} is a file, wanted a folder")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputPathError(
            f"{name}: found no right to write into {shown(folder)}, wanted a writable folder"
        )


def _check_replaceable(target: Path, name: str) -> None:
    mode = target.stat().st_mode
    if stat.S_ISDIR(mode):
        raise OutputPathError(f"{name}: found a folder of that name, wanted a file's name")
    if not stat.S_ISREG(mode):
        raise OutputPathError(f"{name}: found a device or pipe, wanted a file's name")
    if not os.access(target, os.W_OK):
        raise OutputPathError(f"{name}: found a write-protected file, wanted a writable one")


def _as_output_error(error: OSError, name: str) -> OutputError | OutputPathError:
    reason = error.strerror or type(error).__name__
    if error.errno in _PLACE_IS_WRONG:
        return OutputPathError(f"{name}: found '{reason}', wanted a place that can be written")
    return OutputError(f"{name}: found '{reason}' while writing, wanted room for the whole file")


def atomic_write_bytes(path: str | os.PathLike[str], data: bytes) -> None:
    """Write a file so that it is whole or not there; an older one stays until the last moment.

    The bytes go to a file of the same ending beside the target, are forced to
    the disk, and take the target's place in one step.

    Parameters
    ----------
    path : path
        The file to make or to replace.
    data : bytes
        All of its content.

    Raises
    ------
    OutputPathError
        The place cannot hold a file (see `check_target`).
    OutputError
        The disk is full or failed. The target is as it was.
    """
    name = shown(path)
    target = check_target(path)
    temporary = target.with_name(f".vrlf-{secrets.token_hex(8)}{target.suffix}")
    try:
        _write_through(temporary, data)
        os.replace(temporary, target)
    except OSError as error:
        _remove(temporary)
        raise _as_output_error(error, name) from error
    except BaseException:  # an interrupt must not leave the temporary file either
        _remove(temporary)
        raise
    _sync_folder(target.parent)


def atomic_write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write text as UTF-8, line ends as given; otherwise like `atomic_write_bytes`."""
    atomic_write_bytes(path, text.encode("utf-8"))


def make_folder(path: str | os.PathLike[str]) -> Path:
    """Make a folder for results, parents and all, unless it is there already.

    Raises
    ------
    OutputPathError
        A file stands in the way, or there is no right to make it.
    OutputError
        The disk failed.
    """
    name = shown(path)
    if "\0" in os.fspath(path):
        raise OutputPathError(f"{name}: found a NUL character in the path, wanted a folder name")
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError as error:
        raise OutputPathError(f"{name}: found a file of that name, wanted a folder") from error
    except OSError as error:
        raise _as_output_error(error, name) from error
    return folder


def _write_through(path: Path, data: bytes) -> None:
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
    descriptor = os.open(path, flags, 0o666)  # the umask decides, as for any new file
    try:
        rest = memoryview(data)
        while rest:
            rest = rest[os.write(descriptor, rest) :]
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _remove(path: Path) -> None:
    with contextlib.suppress(OSError):
        path.unlink()


def _sync_folder(folder: Path) -> None:
    """Force the new name to the disk; where a system cannot, the file itself is still whole."""
    if os.name != "posix":
        return
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
