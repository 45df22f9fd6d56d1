"""Where a Cardboard viewer profile's bytes come from: an address, its text, or a file.

Nothing is fetched: an address holds its profile, or stands for the first Cardboard.
"""

from __future__ import annotations

import base64
import re
from pathlib import Path
from typing import Final
from urllib.parse import SplitResult, unquote, urlsplit

from vrlf.errors import InputError
from vrlf.model.wording import quoted

# CARDBOARD_DEVICE_PARAMS_STREAM_SENTINEL of Google's CardboardParamsUtils.java, big-endian; the
# number of bytes follows likewise.
_MARK: Final = bytes.fromhex("35587a2b")
_HEADER_BYTES: Final = 8
# Google's are of some 80 bytes, most of them names.
MOST_BYTES: Final = 1024
_MOST_FILE_BYTES: Final = 4096

# The code of the first Cardboard names no profile, this one is meant: Google's
# sdk/qrcode/cardboard_v1/cardboard_v1.cc.
CARDBOARD_V1: Final = bytes.fromhex(
    "0a0c476f6f676c652c20496e632e120c43617264626f6172642076311d31082c3d258fc2753d2a10"
    "0000204200002042000020420000204235295c0f3d3a08c1cae13e77be1f3e58006001"
)
_WANTED: Final = (
    "an address such as https://google.com/cardboard/cfg?p=... (the text of the viewer's code), "
    "the letters behind its p=, or a file that holds either or the profile's bytes"
)
_BASE64: Final = re.compile(r"[A-Za-z0-9_-]+")


def profile_bytes(source: str, folder: Path) -> bytes:
    """The bytes of the profile that a source names; a path counts from ``folder``.

    Raises
    ------
    InputError
    """
    text = source.strip()
    address = _address(text)
    if address is not None:
        return _of_address(address, text)
    raw = _file_bytes(folder / source, source)
    return _of_text(text) if raw is None else _of_file(raw, source)


def _address(text: str) -> SplitResult | None:
    """A web address, its scheme left out or not; None for anything else."""
    if not text.isprintable():
        return None
    known = re.match(r"(?:[a-z][a-z0-9+.-]*://|(?:www\.)?google\.com/|g\.co/)", text, re.IGNORECASE)
    if known is None:
        return None
    try:
        return urlsplit(text if "://" in known[0] else f"https://{text}")
    except ValueError:
        return None


def _of_address(address: SplitResult, text: str) -> bytes:
    host, path = address.netloc.lower().removeprefix("www."), address.path.rstrip("/")
    if address.scheme not in {"http", "https"}:
        raise _no_profile(text)
    if (host, path) in {("g.co", "/cardboard"), ("google.com", "/cardboard")}:
        return CARDBOARD_V1
    if (host, path) != ("google.com", "/cardboard/cfg"):
        raise _no_profile(text)
    # No plus sign stands for a blank here: base64 may hold one.
    pairs = (unquote(part).partition("=") for part in address.query.split("&"))
    given = [value for name, _, value in pairs if name == "p"]
    if not given or not given[0]:
        raise InputError(f"profile: found no p= in {quoted(text)}, wanted {_WANTED}")
    return _decoded(given[0])


def _of_text(text: str) -> bytes:
    """An address, or a profile's base64 by itself."""
    address = _address(text)
    if address is not None:
        return _of_address(address, text)
    if _BASE64.fullmatch(_url_safe(text)) is None or len(text) < _HEADER_BYTES:
        raise _no_profile(text)
    return _decoded(text)


def _url_safe(text: str) -> str:
    return text.rstrip("=").replace("+", "-").replace("/", "_")


def _decoded(text: str) -> bytes:
    letters = _url_safe(text)
    if len(letters) * 3 > MOST_BYTES * 4:
        raise _too_long(f"{len(letters)} letters")
    if _BASE64.fullmatch(letters) is None:
        raise InputError(f"profile: found {quoted(text)}, wanted letters of base64")
    if len(letters) % 4 == 1:
        raise InputError(
            f"profile: found {len(letters)} letters of base64, which make no whole bytes, "
            "wanted all of the code's text"
        )
    return base64.urlsafe_b64decode(letters + "=" * (-len(letters) % 4))


def _file_bytes(path: Path, source: str) -> bytes | None:
    """What a file holds; None where there is none of that name."""
    try:
        with path.open("rb") as file:
            raw = file.read(_MOST_FILE_BYTES + 1)
    except IsADirectoryError:
        raise InputError(f"profile: found the folder {quoted(source)}, wanted {_WANTED}") from None
    except PermissionError as error:
        raise InputError(
            f"profile: found {error.strerror} for {quoted(source)}, wanted a readable file"
        ) from None
    except (OSError, ValueError):  # a name that no file can have is the profile's text, or nothing
        return None
    if len(raw) > _MOST_FILE_BYTES:
        raise _too_long(f"more than {_MOST_FILE_BYTES} bytes in {quoted(source)}")
    return raw


def _of_file(raw: bytes, source: str) -> bytes:
    if raw.startswith(_MARK):
        return _behind_header(raw, source)
    text = raw.decode("ascii", "replace").strip()
    if text and text.isprintable():
        return _of_text(text)
    if len(raw) > MOST_BYTES:
        raise _too_long(f"{len(raw)} bytes in {quoted(source)}")
    if not raw.strip():
        raise InputError(f"profile: found nothing in {quoted(source)}, wanted {_WANTED}")
    return raw


def _behind_header(raw: bytes, source: str) -> bytes:
    length = int.from_bytes(raw[len(_MARK) : _HEADER_BYTES], "big")
    if len(raw) != _HEADER_BYTES + length:
        raise InputError(
            f"profile: found {max(0, len(raw) - _HEADER_BYTES)} bytes in {quoted(source)} where "
            f"its header says {length}, wanted the whole file"
        )
    if length > MOST_BYTES:
        raise _too_long(f"{length} bytes in {quoted(source)}")
    return raw[_HEADER_BYTES:]


def _no_profile(text: str) -> InputError:
    return InputError(f"profile: found {quoted(text)}, wanted {_WANTED}")


def _too_long(found: str) -> InputError:
    return InputError(f"profile: found {found}, wanted a profile of at most {MOST_BYTES} bytes")
