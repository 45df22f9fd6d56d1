"""vrlf corrects a person's vision inside a VR headset by computation alone."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

try:
    __version__ = version("vrlf")
except PackageNotFoundError:  # a checkout on the path that nobody installed
    __version__ = "0+unknown"
